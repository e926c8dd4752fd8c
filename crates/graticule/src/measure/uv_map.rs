use glam::{DVec2, DVec3};
use rayon::prelude::*;
use robust::{Coord, orient2d};

use super::MeasureError;
use crate::mesh::{Element, FaceId, HalfedgeId, PerCorner, Surface};
use crate::tolerance::MEASURABLE_EXTENTS;

/// Which side of the line from `a` to `b` the point `c` lies on: 1 left, -1 right, 0 on it.
///
/// Exact ([`SHE97`]) unless products of coordinate differences underflow.
///
/// [`SHE97`]: crate::papers::SHE97
#[inline]
pub(crate) fn orientation(a: DVec2, b: DVec2, c: DVec2) -> i8 {
    let coordinate = |p: DVec2| Coord { x: p.x, y: p.y };
    let determinant = orient2d(coordinate(a), coordinate(b), coordinate(c));
    i8::from(determinant > 0.0) - i8::from(determinant < 0.0)
}

/// Whether the images of a triangle's corners are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Corners {
    /// A corner has no coordinates.
    Missing,
    /// A coordinate is not a finite number.
    NonFinite,
    /// All are known; the exact sign of the area of the image.
    Known { sign: i8 },
}

/// A map with both sides scaled by powers of two to an extent near 1, which changes no digit.
pub(super) struct UvMap<'a> {
    pub(super) surface: &'a Surface,
    /// The scaled images of the corners; zero where not known.
    pub(super) uvs: PerCorner<DVec2>,
    pub(super) corners: Vec<Corners>,
    /// Scaled coordinates over given ones.
    pub(super) uv_scale: f64,
    /// Scaled positions over given ones.
    pub(super) surface_scale: f64,
    /// The halfedge on the other side where the map continues across it, else `NONE`.
    continuations: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl<'a> UvMap<'a> {
    pub(super) fn new(
        surface: &'a Surface,
        uv: impl Fn(HalfedgeId) -> Option<DVec2> + Sync,
    ) -> Result<Self, MeasureError> {
        let count = surface.mesh().halfedge_count();
        let uv = &uv;
        let [low, high] = box_around((0..count).filter_map(|h| uv(HalfedgeId::from_index(h))));
        let [bottom, top] = surface.bounding_box();
        let uv_scale = scale_to_unit("map", (high - low).max_element().max(0.0))?;
        let surface_scale = scale_to_unit("surface", (top - bottom).max_element())?;
        let corners: Vec<_> = (0..surface.mesh().face_count())
            .into_par_iter()
            .map(|face| known_corners(FaceId::from_index(face), uv, uv_scale))
            .collect();
        let scaled = |corner: usize| match corners[corner / 3] {
            Corners::Known { .. } => {
                uv(HalfedgeId::from_index(corner)).map_or(DVec2::ZERO, |p| p * uv_scale)
            }
            _ => DVec2::ZERO,
        };
        let uvs = PerCorner::new((0..count).into_par_iter().map(scaled).collect());
        let mut map = Self {
            surface,
            uvs,
            corners,
            uv_scale,
            surface_scale,
            continuations: Vec::new(),
        };
        map.continuations = (0..count)
            .into_par_iter()
            .map(|h| map.find_continuation(HalfedgeId::from_index(h)))
            .collect();
        Ok(map)
    }

    fn find_continuation(&self, halfedge: HalfedgeId) -> u32 {
        let continues = |twin: &HalfedgeId| {
            self.is_known(halfedge.face())
                && self.is_known(twin.face())
                && self.uvs[halfedge] == self.uvs[twin.next()]
                && self.uvs[halfedge.next()] == self.uvs[*twin]
        };
        let twin = self.surface.mesh().twin(halfedge).filter(continues);
        twin.map_or(NONE, |twin| twin.0)
    }

    pub(super) fn face_count(&self) -> usize {
        self.corners.len()
    }

    pub(super) fn is_known(&self, face: FaceId) -> bool {
        matches!(self.corners[face.index()], Corners::Known { .. })
    }

    /// The exact sign of the area of the image; 0 too where it is not known.
    #[inline]
    pub(super) fn sign(&self, face: FaceId) -> i8 {
        match self.corners[face.index()] {
            Corners::Known { sign } => sign,
            _ => 0,
        }
    }

    /// Whether no triangle with known coordinates has an image without area.
    pub(super) fn has_area_everywhere(&self) -> bool {
        !self.corners.contains(&Corners::Known { sign: 0 })
    }

    /// The halfedge of the neighbouring triangle, where the map continues across the edge: both
    /// triangles have the same coordinates at both ends.
    #[inline]
    pub(super) fn continuation(&self, halfedge: HalfedgeId) -> Option<HalfedgeId> {
        let twin = self.continuations[halfedge.index()];
        (twin != NONE).then_some(HalfedgeId(twin))
    }

    /// Whether the halfedge lies on the boundary of an island.
    #[inline]
    pub(super) fn is_border(&self, halfedge: HalfedgeId) -> bool {
        self.continuations[halfedge.index()] == NONE && self.is_known(halfedge.face())
    }

    /// The halfedges along the boundaries of all islands, in order.
    pub(super) fn border(&self) -> impl Iterator<Item = HalfedgeId> + '_ {
        let halfedges = self.surface.mesh().halfedges();
        halfedges.filter(|&halfedge| self.is_border(halfedge))
    }

    /// The halfedge after this one along the boundary of its island, the island to the left.
    pub(super) fn next_on_border(&self, halfedge: HalfedgeId) -> HalfedgeId {
        let mut next = halfedge.next();
        while let Some(twin) = self.continuation(next) {
            next = twin.next();
        }
        next
    }

    /// The images of the corners of a triangle.
    #[inline]
    pub(super) fn images(&self, face: FaceId) -> [DVec2; 3] {
        face.halfedges().map(|corner| self.uvs[corner])
    }

    /// The images of the ends of a halfedge.
    #[inline]
    pub(super) fn image_of_side(&self, halfedge: HalfedgeId) -> [DVec2; 2] {
        [self.uvs[halfedge], self.uvs[halfedge.next()]]
    }

    /// The scaled positions of the corners of a triangle.
    #[inline]
    pub(super) fn positions(&self, face: FaceId) -> [DVec3; 3] {
        self.surface
            .corner_positions(face)
            .map(|p| p * self.surface_scale)
    }

    /// The scaled length of a side in space.
    pub(super) fn length_in_space(&self, halfedge: HalfedgeId) -> f64 {
        (self.surface.halfedge_vector(halfedge) * self.surface_scale).length()
    }
}

/// The smallest box around the points that are finite; upside down without any.
pub(crate) fn box_around(points: impl Iterator<Item = DVec2>) -> [DVec2; 2] {
    points
        .filter(|p| p.is_finite())
        .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| {
            [low.min(p), high.max(p)]
        })
}

/// The power of two that brings an extent into `0.5..=1.0`; 1 for an extent of 0.
pub(super) fn scale_to_unit(what: &'static str, extent: f64) -> Result<f64, MeasureError> {
    if extent == 0.0 {
        return Ok(1.0);
    }
    if !MEASURABLE_EXTENTS.contains(&extent) {
        return Err(MeasureError::ExtentOutOfRange { what, extent });
    }
    Ok(libm::ldexp(1.0, -1 - libm::ilogb(extent)))
}

fn known_corners(
    face: FaceId,
    uv: &impl Fn(HalfedgeId) -> Option<DVec2>,
    uv_scale: f64,
) -> Corners {
    let [Some(a), Some(b), Some(c)] = face.halfedges().map(uv) else {
        return Corners::Missing;
    };
    if ![a, b, c].iter().all(|p| p.is_finite()) {
        return Corners::NonFinite;
    }
    let sign = orientation(a * uv_scale, b * uv_scale, c * uv_scale);
    Corners::Known { sign }
}
