//! A map onto a convex polygon where solving for it fails.

use glam::DVec2;

use super::start::{Disk, start_within};
use super::{DistortionEnergy, filled_disk};
use crate::flatten::{BoundaryPositions, FlattenError, FlipCount, Patch};
use crate::mesh::{Element, PerVertex};
use crate::watch::Watch;

/// Lays a patch onto a convex polygon without a flip, however deep it is: from a coarse mesh to the
/// fine one, as [`injective_map`](super::injective_map), with the boundary in its places throughout.
/// What a linear system would lay into one point for want of digits has room here.
///
/// Every vertex of the outer loop has a place; no edge inside may join two vertices on one side of the
/// polygon. Holes are closed. Cost: as [`injective_map`](super::injective_map).
///
/// # Errors
/// [`FlattenError::NoRoom`] where double precision has no place left, as where the rules above are
/// broken.
pub fn convex_map(
    patch: &Patch,
    boundary: &BoundaryPositions,
    watch: &Watch,
) -> Result<PerVertex<DVec2>, FlattenError> {
    let _stage = watch.stage("map onto a polygon");
    let mut disk = filled_disk(patch)?;
    let mut outline = vec![DVec2::ZERO; disk.points.len()];
    for &(vertex, place) in boundary.places() {
        outline[vertex.index()] = place;
    }
    let [low, high] = crate::measure::box_around(boundary.places().iter().map(|&(_, p)| p));
    let extent = (high - low).max_element();
    let middle = low.midpoint(high);
    for place in &mut outline {
        *place = (*place - middle) / extent;
    }
    to_unit_area(&mut disk, patch.unit_area());
    let mut places = start_within(&disk, outline, DistortionEnergy::default(), watch)?;
    places.truncate(patch.mesh().vertex_count());
    let mut uv = PerVertex::new(places).map(|&place| middle + place * extent);
    for &(vertex, place) in boundary.places() {
        uv[vertex] = place;
    }
    let flips = FlipCount::of(patch.mesh(), &uv);
    if flips.is_zero() {
        return Ok(uv);
    }
    let vertices = patch.mesh().vertex_count();
    Err(FlattenError::NoRoom { vertices })
}

/// Scales the disk to about the size of the polygon.
fn to_unit_area(disk: &mut Disk, area: f64) {
    let factor = 1.0 / area.sqrt();
    for point in &mut disk.points {
        *point *= factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{BoundaryCurve, FixedOptions, Weights, boundary_on_curve, fixed_map};
    use crate::mesh::Surface;
    use graticule_fixtures::cylinder_patch;

    /// A tube with a lid, `depth` times as deep as it is wide.
    fn finger(depth: u32) -> Patch {
        let around = 8;
        let tube = cylinder_patch(1.0, 2.0 * f64::from(depth), around, 4 * depth);
        let lid = tube.positions.len() as u32;
        let mut triangles = tube.triangles.clone();
        let mut positions = tube.positions.clone();
        let open = Surface::from_triangles(positions.clone(), &triangles).unwrap();
        let mesh = open.mesh();
        let upper = mesh.boundary_loops().find(|&l| {
            let vertex = mesh.origin(mesh.boundary_loop(l)[0]);
            open.position(vertex).z > f64::from(depth)
        });
        for &side in mesh.boundary_loop(upper.unwrap()) {
            triangles.push([mesh.destination(side).0, mesh.origin(side).0, lid]);
        }
        positions.push(glam::DVec3::Z * (2.0 * f64::from(depth) + 0.5));
        let closed = Surface::from_triangles(positions, &triangles).unwrap();
        Patch::new(closed, &Watch::new()).unwrap()
    }

    #[test]
    fn a_finger_too_deep_for_a_linear_system_is_laid_onto_a_square() {
        let watch = Watch::new();
        let patch = finger(30);
        let curve = BoundaryCurve::Circle;
        let boundary = boundary_on_curve(&patch, &curve, &watch).unwrap();
        let options = FixedOptions {
            weights: Weights::MeanValue,
            ..FixedOptions::default()
        };
        let linear = fixed_map(&patch, &boundary, &options, &watch).unwrap();
        assert!(!linear.flips.is_zero());
        let uv = convex_map(&patch, &boundary, &watch).unwrap();
        assert!(FlipCount::of(patch.mesh(), &uv).is_zero());
        for (vertex, place) in boundary.places() {
            assert_eq!(uv[*vertex], *place);
        }
    }
}
