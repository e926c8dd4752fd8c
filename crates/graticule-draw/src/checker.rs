use glam::DVec2;
use graticule::mesh::{FaceId, PerCorner, Surface};
use rayon::prelude::*;

use crate::error::check_count;
use crate::{Checker, Color, DrawError};

/// Squares along the diagonal of the surface, unless their side is given.
const SQUARES: f64 = 40.0;

/// Squares beyond this many from the origin of the checker are not told apart; they are far too
/// small to be seen, and `f32` holds their coordinates to a hundredth.
const FARTHEST_SQUARE: f64 = 131_072.0;

/// A checker of squares in texture space.
#[derive(Clone, Copy, Debug)]
pub struct CheckerStyle<'a> {
    /// Texture coordinates.
    pub uvs: &'a PerCorner<DVec2>,
    /// Their size.
    pub squares: Squares,
}

/// The size of the squares of a checker.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Squares {
    /// Some 20 to 40 across the surface, see [`fitting_checker_side`].
    #[default]
    Fitting,
    /// Of this side in texture space.
    OfSide(f64),
}

impl<'a> CheckerStyle<'a> {
    /// Squares of a fitting side.
    #[must_use]
    pub fn fitting(uvs: &'a PerCorner<DVec2>) -> Self {
        let squares = Squares::Fitting;
        Self { uvs, squares }
    }

    pub(crate) fn checker(&self, surface: &Surface) -> Result<Checker, DrawError> {
        let side = match self.squares {
            Squares::OfSide(side) if side > 0.0 && side.is_finite() => side,
            Squares::OfSide(side) => return Err(DrawError::CheckerSide { side }),
            Squares::Fitting => fitting_checker_side(surface, self.uvs)?,
        };
        let [low, _] = layout_box(surface, self.uvs)?;
        // Moving by whole pairs of squares keeps the colours and brings the numbers near zero.
        let start = (low / side / 2.0).floor() * 2.0;
        let place = |corner| {
            let square = self.uvs[corner] / side - start;
            if square.is_finite() && start.is_finite() {
                let square = square.min(DVec2::splat(FARTHEST_SQUARE));
                [square.x as f32, square.y as f32]
            } else {
                [f32::NAN; 2]
            }
        };
        Ok(Checker {
            corners: surface
                .mesh()
                .faces()
                .map(|face| face.halfedges().map(place))
                .collect(),
            dark: Color::CHECKER,
        })
    }
}

/// The side of a checker square in texture space that, on the median of the surface, is a fortieth
/// of the diagonal of its bounding box: on half of its area the squares are larger.
///
/// Cost: sorting the triangles by their scale.
///
/// # Errors
/// [`DrawError::ValueCount`], [`DrawError::NoCoordinates`], [`DrawError::ZeroExtent`] or
/// [`DrawError::ExtentOverflow`] where the coordinates make no layout.
pub fn fitting_checker_side(surface: &Surface, uvs: &PerCorner<DVec2>) -> Result<f64, DrawError> {
    let [low, high] = layout_box(surface, uvs)?;
    let layout_extent = (high - low).max_element();
    let [bottom, top] = surface.bounding_box();
    let extent = (top - bottom).max_element();
    let diagonal = ((top - bottom) / extent).length();
    let area_and_scale = |face: FaceId| {
        let [a, b, c] = surface
            .corner_positions(face)
            .map(|p| (p - bottom) / extent);
        let [p, q, r] = face
            .halfedges()
            .map(|corner| (uvs[corner] - low) / layout_extent);
        let area = (b - a).cross(c - a).length();
        (area, ((q - p).perp_dot(r - p).abs() / area).sqrt())
    };
    let scale = weighted_median(finite_faces(surface, uvs).map(area_and_scale));
    let side = scale.map_or(1.0 / SQUARES, |scale| scale * diagonal / SQUARES);
    Ok((side * layout_extent).max(f64::MIN_POSITIVE))
}

/// The positive value below which half of the weight lies.
fn weighted_median(weighted: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let mut weighted: Vec<(f64, f64)> = weighted
        .filter(|&(weight, value)| weight > 0.0 && value > 0.0 && value.is_finite())
        .collect();
    weighted.par_sort_by(|a, b| a.1.total_cmp(&b.1));
    let total: f64 = weighted.iter().map(|&(weight, _)| weight).sum();
    let mut below = 0.0;
    weighted
        .into_iter()
        .find(|&(weight, _)| {
            below += weight;
            2.0 * below >= total
        })
        .map(|(_, value)| value)
}

/// The triangles with finite coordinates at their three corners.
pub(crate) fn finite_faces(
    surface: &Surface,
    uvs: &PerCorner<DVec2>,
) -> impl Iterator<Item = FaceId> {
    surface.mesh().faces().filter(|face| {
        face.halfedges()
            .iter()
            .all(|&corner| uvs[corner].is_finite())
    })
}

/// The box around the triangles with finite coordinates: lowest, highest. Its extent is positive
/// and finite.
pub(crate) fn layout_box(
    surface: &Surface,
    uvs: &PerCorner<DVec2>,
) -> Result<[DVec2; 2], DrawError> {
    let mesh = surface.mesh();
    check_count("texture coordinates", mesh.halfedge_count(), uvs.len())?;
    let [low, high] = finite_faces(surface, uvs)
        .flat_map(FaceId::halfedges)
        .map(|corner| uvs[corner])
        .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| {
            [low.min(p), high.max(p)]
        });
    let extent = (high - low).max_element();
    if low.x > high.x {
        let faces = mesh.face_count();
        return Err(DrawError::NoCoordinates { faces });
    }
    if extent == 0.0 {
        return Err(DrawError::ZeroExtent { at: low.to_array() });
    }
    if !extent.is_finite() {
        let coordinate = low.abs().max(high.abs()).max_element();
        return Err(DrawError::ExtentOverflow { coordinate });
    }
    Ok([low, high])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn grid() -> (Surface, PerCorner<DVec2>) {
        let fixture = graticule_fixtures::grid(1.0, 1.0, 4, 4);
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let mesh = surface.mesh();
        let uvs = PerCorner::from_fn(mesh.halfedge_count(), |corner| {
            surface.position(mesh.origin(corner)).truncate()
        });
        (surface, uvs)
    }

    #[test]
    fn the_fitting_side_scales_with_the_layout_and_not_with_the_surface() {
        let (surface, uvs) = grid();
        let side = fitting_checker_side(&surface, &uvs).unwrap();
        assert!((side - 2.0_f64.sqrt() / SQUARES).abs() < 1e-12);
        for scale in [1e-30, 1e-300, 1e30] {
            let scaled = uvs.map(|&uv| uv * scale);
            let ratio = fitting_checker_side(&surface, &scaled).unwrap() / side;
            assert!((ratio / scale - 1.0).abs() < 1e-9);
            let positions: Vec<DVec3> = surface.positions().iter().map(|&p| p * scale).collect();
            let large = Surface::new(
                surface.shared_mesh(),
                graticule::mesh::PerVertex::new(positions),
            );
            let same = fitting_checker_side(&large.unwrap(), &uvs).unwrap();
            assert!((same / side - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_far_origin_keeps_the_squares() {
        let (surface, uvs) = grid();
        let checker = |uvs: &PerCorner<DVec2>| {
            let style = CheckerStyle {
                uvs,
                squares: Squares::OfSide(0.125),
            };
            style.checker(&surface).unwrap().corners
        };
        assert_eq!(checker(&uvs), checker(&uvs.map(|&uv| uv + 1e7)));
    }

    #[test]
    fn coordinates_that_make_no_layout_are_refused() {
        let (surface, uvs) = grid();
        let refusal = |change: &dyn Fn(DVec2) -> DVec2| {
            layout_box(&surface, &uvs.map(|&uv| change(uv))).unwrap_err()
        };
        assert!(matches!(
            refusal(&|_| DVec2::NAN),
            DrawError::NoCoordinates { faces: 32 }
        ));
        assert!(matches!(
            refusal(&|_| DVec2::ONE),
            DrawError::ZeroExtent { .. }
        ));
        assert!(matches!(
            refusal(&|uv| (uv - 0.5) * f64::MAX * 4.0),
            DrawError::NoCoordinates { .. } | DrawError::ExtentOverflow { .. }
        ));
        let short = PerCorner::new(vec![DVec2::ZERO; 5]);
        assert!(matches!(
            layout_box(&surface, &short),
            Err(DrawError::ValueCount { given: 5, .. })
        ));
        let negative = CheckerStyle {
            uvs: &uvs,
            squares: Squares::OfSide(-1.0),
        };
        assert!(matches!(
            negative.checker(&surface),
            Err(DrawError::CheckerSide { .. })
        ));
    }
}
