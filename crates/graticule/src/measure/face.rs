use rayon::prelude::*;
use serde::Serialize;

use super::islands::Islands;
use super::jacobian::SourceTriangle;
use super::statistics;
use super::uv_map::{Corners, UvMap};
use crate::mesh::{Element, FaceId, PerFace};
use crate::tolerance;

/// Whether distortion can be told for a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FaceState {
    /// Its singular values are known; it takes part in the distortion figures.
    Measured,
    /// A corner has no texture coordinates.
    WithoutUv,
    /// A texture coordinate is not a finite number.
    NonFiniteUv,
    /// It has no measurable shape in space: see [`tolerance::FLAT_TRIANGLE`].
    FlatInSpace,
    /// It has a shape in space and none in the map: see [`tolerance::DEGENERATE_MAP_AREA`].
    Degenerate,
}

/// The distortion of one triangle by the linear map from its plane to texture coordinates.
///
/// All numbers are 0 unless said otherwise where the state is not [`FaceState::Measured`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FaceDistortion {
    /// Whether the figures are known.
    pub state: FaceState,
    /// The exact sign of the area in the map: 1, 0 or −1; 0 too without coordinates.
    pub sign: i8,
    /// Whether the triangle is oriented against most triangles of its island.
    pub flipped: bool,
    /// Greatest and least factor by which the map changes lengths, in units of the map per unit of
    /// the surface; also known for a degenerate triangle.
    pub singular_values: [f64; 2],
    /// |cos| of the angle between the gradients of the two coordinates, in `0.0..=1.0`.
    pub shear: f64,
    /// Mean change of the three angles, in radians.
    pub angle_change: f64,
    /// Area in space, in squared units of the surface, whatever the state; 0 where flat.
    pub area: f64,
    /// Area in the map, at least 0, in squared units of the map, known wherever coordinates are.
    pub uv_area: f64,
}

impl FaceDistortion {
    /// The quasi-conformal error σ₁/σ₂: 1 where the map keeps angles; `None` unless measured.
    #[must_use]
    pub fn quasi_conformal_error(&self) -> Option<f64> {
        let [larger, smaller] = self.singular_values;
        self.measured().then_some(larger / smaller)
    }

    /// The factor σ₁σ₂ by which the map changes the area, at least 0; `None` unless measured.
    #[must_use]
    pub fn area_scale(&self) -> Option<f64> {
        let [larger, smaller] = self.singular_values;
        self.measured().then_some(larger * smaller)
    }

    pub(super) fn measured(&self) -> bool {
        self.state == FaceState::Measured
    }
}

/// The distortion of all triangles, in the scaled units of the map.
pub(super) fn measure_faces(map: &UvMap<'_>, islands: &Islands) -> Vec<FaceDistortion> {
    let mut faces: Vec<_> = (0..map.face_count())
        .into_par_iter()
        .map(|face| measure_face(map, islands, FaceId::from_index(face)))
        .collect();
    let total = |figure: fn(&FaceDistortion) -> f64| {
        statistics::sum(
            &faces,
            |face| if face.measured() { figure(face) } else { 0.0 },
        )
    };
    let usual_scale = total(|face| face.uv_area) / total(|face| face.area);
    faces.par_iter_mut().for_each(|face| {
        let share = tolerance::DEGENERATE_MAP_AREA * usual_scale;
        if face.measured() && is_degenerate(face, share * face.area) {
            *face = FaceDistortion {
                state: FaceState::Degenerate,
                shear: 0.0,
                angle_change: 0.0,
                ..*face
            };
        }
    });
    faces
}

/// The same in the units that the caller gave.
pub(super) fn in_given_units(
    map: &UvMap<'_>,
    faces: Vec<FaceDistortion>,
) -> PerFace<FaceDistortion> {
    let [space, uv] = [map.surface_scale, map.uv_scale];
    let rescaled = |face: FaceDistortion| FaceDistortion {
        singular_values: face.singular_values.map(|value| value / uv * space),
        area: face.area / space / space,
        uv_area: face.uv_area / uv / uv,
        ..face
    };
    PerFace::new(faces.into_iter().map(rescaled).collect())
}

fn is_degenerate(face: &FaceDistortion, least_area: f64) -> bool {
    let [larger, smaller] = face.singular_values;
    // The sums of squares in the figures must stay finite.
    let finite = (larger / smaller).powi(2).is_finite() && smaller.powi(-2).is_finite();
    face.sign == 0 || face.uv_area < least_area || !finite
}

fn measure_face(map: &UvMap<'_>, islands: &Islands, face: FaceId) -> FaceDistortion {
    let source = SourceTriangle::from_positions(map.positions(face));
    let state = match (map.corners[face.index()], &source) {
        (Corners::Missing, _) => FaceState::WithoutUv,
        (Corners::NonFinite, _) => FaceState::NonFiniteUv,
        (_, None) => FaceState::FlatInSpace,
        (_, Some(_)) => FaceState::Measured,
    };
    let images = map.images(face);
    let double_uv_area =
        super::jacobian::accurate_perp_dot(images[1] - images[0], images[2] - images[0]);
    let mut distortion = FaceDistortion {
        state,
        sign: map.sign(face),
        flipped: islands.is_flipped(map, face),
        singular_values: [0.0; 2],
        shear: 0.0,
        angle_change: 0.0,
        area: source.map_or(0.0, |source| source.area()),
        uv_area: 0.5 * double_uv_area.abs(),
    };
    if let Some(source) = source.filter(|_| distortion.measured()) {
        let jacobian = source.jacobian(images);
        distortion.singular_values = jacobian.singular_values();
        distortion.shear = jacobian.shear();
        distortion.angle_change = source.angle_change(images);
    }
    distortion
}
