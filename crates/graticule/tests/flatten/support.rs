//! What several tests need.

use faer::c64;
use glam::{DVec2, DVec3};
use graticule::flatten::{BoundaryPositions, Patch};
use graticule::mesh::{PerVertex, Surface, VertexId};
use graticule::watch::Watch;
use graticule_fixtures::Fixture;

pub(crate) fn patch(fixture: &Fixture) -> Patch {
    let surface = Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap();
    Patch::new(surface, &Watch::new()).unwrap()
}

/// The boundary where a flat patch has it, holes included.
pub(crate) fn own_boundary(patch: &Patch) -> BoundaryPositions {
    let own = |vertex| (vertex, patch.surface().position(vertex).truncate());
    BoundaryPositions::new(patch, patch.boundary_vertices().map(own)).unwrap()
}

/// The positions of a flat patch as a map.
pub(crate) fn plane(patch: &Patch) -> PerVertex<DVec2> {
    patch.surface().positions().map(|p| p.truncate())
}

fn complex(map: &PerVertex<DVec2>) -> Vec<c64> {
    map.iter().map(|p| c64::new(p.x, p.y)).collect()
}

/// How far `map` is from `expected` at each vertex once the best similarity that keeps orientation
/// is applied, relative to the extent of `expected`.
fn distances_up_to_similarity(map: &PerVertex<DVec2>, expected: &PerVertex<DVec2>) -> Vec<f64> {
    let (z, w) = (complex(map), complex(expected));
    let count = z.len() as f64;
    let centre = |v: &[c64]| v.iter().sum::<c64>() / count;
    let (z0, w0) = (centre(&z), centre(&w));
    let spread: f64 = z.iter().map(|z| (z - z0).norm_sqr()).sum();
    let turn = z.iter().zip(&w).map(|(z, w)| (z - z0).conj() * (w - w0));
    let turn = turn.sum::<c64>() / spread;
    let extent = w.iter().map(|w| (w - w0).norm()).fold(0.0, f64::max);
    let pairs = z.iter().zip(&w);
    pairs
        .map(|(z, w)| ((z - z0) * turn + w0 - w).norm() / extent)
        .collect()
}

/// The largest distance.
pub(crate) fn distance_up_to_similarity(
    map: &PerVertex<DVec2>,
    expected: &PerVertex<DVec2>,
) -> f64 {
    let distances = distances_up_to_similarity(map, expected);
    distances.into_iter().fold(0.0, f64::max)
}

/// The root of the mean square distance.
pub(crate) fn mean_distance_up_to_similarity(
    map: &PerVertex<DVec2>,
    expected: &PerVertex<DVec2>,
) -> f64 {
    let distances = distances_up_to_similarity(map, expected);
    (distances.iter().map(|d| d * d).sum::<f64>() / distances.len() as f64).sqrt()
}

/// The largest difference of two maps relative to the extent of the second.
pub(crate) fn distance(map: &PerVertex<DVec2>, expected: &PerVertex<DVec2>) -> f64 {
    let extent = expected.iter().map(|p| p.length()).fold(0.0, f64::max);
    let errors = map.iter().zip(expected).map(|(a, b)| a.distance(*b));
    errors.fold(0.0, f64::max) / extent
}

/// A rotation without special directions.
pub(crate) fn rotated(p: DVec3) -> DVec3 {
    glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.7, -1.1, 2.3) * p
}

/// The map of a renumbered mesh in the numbering of the original.
pub(crate) fn in_old_numbers(map: &PerVertex<DVec2>, new_of_old: &[u32]) -> PerVertex<DVec2> {
    PerVertex::new(new_of_old.iter().map(|&new| map[VertexId(new)]).collect())
}
