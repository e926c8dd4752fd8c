use rayon::prelude::*;

use super::Carry;
use crate::geometry::slide_towards;
use crate::mesh::{FaceId, NO_VALUE, PerFace, PolygonLabels, SurfacePoint};

/// Where the new polygons lie on the surface.
pub(super) struct Faces {
    /// For each polygon the point below its middle, and the triangles below the middle and halfway
    /// to each corner. `None` for a polygon without corners.
    places: Vec<Option<(SurfacePoint, Vec<FaceId>)>>,
}

impl Faces {
    pub(super) fn find(carry: &Carry<'_>) -> Self {
        let polygons = (0..carry.polygons.len()).into_par_iter();
        Self {
            places: polygons.map(|polygon| place(carry, polygon)).collect(),
        }
    }

    /// The point of the surface below the middle of a polygon.
    pub(super) fn middle(&self, polygon: usize) -> Option<SurfacePoint> {
        self.places[polygon].as_ref().map(|(middle, _)| *middle)
    }

    /// For each polygon the label of most of the triangles below it; of several the one that is
    /// nearest to its middle.
    pub(super) fn majority(
        &self,
        labels: &PolygonLabels,
        face_polygons: &PerFace<u32>,
    ) -> PolygonLabels {
        let name = |face: FaceId| {
            let name = labels.polygon_names.get(face_polygons[face] as usize);
            name.copied().unwrap_or(NO_VALUE)
        };
        let of_place = |place: &Option<(SurfacePoint, Vec<FaceId>)>| {
            let Some((_, faces)) = place else {
                return NO_VALUE;
            };
            let names: Vec<u32> = faces.iter().map(|&face| name(face)).collect();
            let count = |name: u32| names.iter().filter(|&&other| other == name).count();
            let most = names.iter().map(|&name| count(name)).max().unwrap_or(0);
            let winner = names.iter().copied().find(|&name| count(name) == most);
            winner.unwrap_or(NO_VALUE)
        };
        PolygonLabels {
            names: labels.names.clone(),
            polygon_names: self.places.iter().map(of_place).collect(),
        }
    }
}

fn place(carry: &Carry<'_>, polygon: usize) -> Option<(SurfacePoint, Vec<FaceId>)> {
    let surface = &carry.repaired.surface;
    let target = carry.middle(polygon)?;
    let vertices = carry.polygons.vertices(polygon);
    // Each corner sees the middle in its own way; the nearest view is below it.
    let views = vertices.iter().map(|&vertex| {
        let point = slide_towards(surface, carry.origins[vertex as usize], target);
        (point, point.position(surface).distance_squared(target))
    });
    let (middle, _) = views.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let halfway = vertices.iter().map(|&vertex| {
        let between = target.midpoint(carry.position(vertex));
        slide_towards(surface, middle, between).face
    });
    Some((
        middle,
        std::iter::once(middle.face).chain(halfway).collect(),
    ))
}
