//! Fields that are smooth where lengths count differently from place to place.
//!
//! Lines that come closer together bend: a net whose lines lie `exp u` times as dense is regular in
//! the metric `exp(2u)` times that of the surface, and its field is parallel there, not here. Carried
//! along a curve, a direction turns by `∫ ∂u/∂n` more in that metric, `n` to the left: as light
//! bends to where it is slower. Round a region, counter-clockwise, that adds up to `-∫ Δu`, the
//! curvature that the change of lengths brings, so that singularities settle where lines have to
//! begin or end.

use crate::geometry::IntrinsicTriangulation;
use crate::mesh::{HalfedgeId, PerCorner, PerVertex};
use crate::tolerance::WIDEST_GRADED_TURN;

/// For each halfedge the angle by which a direction carried along it turns more to the left in the
/// metric `exp(2u)` times that of the triangulation, `u` given at the vertices. The twin has minus
/// that angle.
///
/// The flux of the gradient over an edge is the mean of those in the two triangles. Where triangles
/// are so large, or so thin, that an edge would turn by more than [`WIDEST_GRADED_TURN`], it turns by
/// that.
pub(super) fn graded_turns(
    triangulation: &IntrinsicTriangulation,
    logarithm: &PerVertex<f64>,
) -> PerCorner<f64> {
    PerCorner::from_fn(triangulation.halfedge_count(), |halfedge: HalfedgeId| {
        let left = flux_to_the_left(triangulation, logarithm, halfedge);
        let turn = match triangulation.twin(halfedge) {
            Some(twin) => 0.5 * (left - flux_to_the_left(triangulation, logarithm, twin)),
            None => left,
        };
        turn.clamp(-WIDEST_GRADED_TURN, WIDEST_GRADED_TURN)
    })
}

/// `∫ ∂u/∂n` along a halfedge, by the gradient in its triangle; 0 in a triangle without area.
fn flux_to_the_left(
    triangulation: &IntrinsicTriangulation,
    logarithm: &PerVertex<f64>,
    halfedge: HalfedgeId,
) -> f64 {
    let shape = triangulation.shape(halfedge.face());
    let corners = [halfedge, halfedge.next(), halfedge.previous()];
    let [from, to, apex] = corners.map(|corner| logarithm[triangulation.origin(corner)]);
    let [Some(at_from), Some(at_to)] =
        [corners[0], corners[1]].map(|corner| shape.cotangent(corner.side()))
    else {
        return 0.0;
    };
    at_to * (apex - from) + at_from * (apex - to)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use glam::DVec3;
    use graticule_fixtures::{disk, grid, icosphere};

    use super::*;
    use crate::field::{FieldOptions, FieldResult, cross_field};
    use crate::mesh::{FaceId, Surface};
    use crate::watch::Watch;

    fn surface_of(fixture: graticule_fixtures::Fixture) -> Surface {
        Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
    }

    fn with_sizes(surface: &Surface, size: impl Fn(DVec3) -> f64, guided: bool) -> FieldResult {
        let sizes = surface.positions().iter().map(|&p| size(p)).collect();
        let mut options = FieldOptions {
            sizes: Some(PerVertex::new(sizes)),
            ..FieldOptions::default()
        };
        if !guided {
            options.curvature = None;
            options.boundary = None;
        }
        cross_field(surface, &options, &Watch::new()).unwrap()
    }

    #[test]
    fn turns_are_the_flux_of_the_gradient_and_sum_to_its_divergence() {
        let surface = surface_of(disk(10));
        let triangulation = IntrinsicTriangulation::of(&surface).unwrap();
        let mesh = surface.mesh();
        let positions = surface.positions();
        let linear = |p: DVec3| 0.3 * p.x - 0.2 * p.y;
        let logarithm = PerVertex::from_fn(mesh.vertex_count(), |v| linear(positions[v]));
        let turns = graded_turns(&triangulation, &logarithm);
        for halfedge in mesh.halfedges() {
            let along = surface.halfedge_vector(halfedge);
            // The gradient times the normal to the left, (-y, x).
            let expected = 0.3 * -along.y - 0.2 * along.x;
            assert!((turns[halfedge] - expected).abs() < 1e-12);
        }
        // u = |p|² / 8 has the Laplacian 1/2: what enters round the middle is minus half the area.
        let logarithm =
            PerVertex::from_fn(mesh.vertex_count(), |v| positions[v].length_squared() / 8.0);
        let turns = graded_turns(&triangulation, &logarithm);
        let is_inner = |face: &FaceId| {
            let corners = mesh.triangle(*face);
            corners.iter().all(|&v| positions[v].length() < 0.75)
        };
        let inner: Vec<FaceId> = mesh.faces().filter(is_inner).collect();
        let halfedges = inner.iter().flat_map(|face| face.halfedges());
        let sum: f64 = halfedges.map(|halfedge| turns[halfedge]).sum();
        let area: f64 = (inner.iter())
            .map(|&face| triangulation.shape(face).area())
            .sum();
        assert!((sum + 0.5 * area).abs() < 0.01 * area, "{sum} {area}");
    }

    #[test]
    fn a_ramp_of_sizes_on_a_plane_makes_the_field_of_the_exponential() {
        // Sizes exp(-c x) are those of the map exp(c z), whose lines turn by c for each unit of y.
        let surface = surface_of(grid(1.0, 1.0, 24, 24));
        let steepness = 1.2;
        let made = with_sizes(&surface, |p| libm::exp(-steepness * p.x), false);
        assert_eq!(made.singularities.count(), 0);
        let angle = |v| {
            let direction: DVec3 = made.directions[v];
            libm::atan2(direction.y, direction.x)
        };
        let positions = surface.positions();
        let first = surface.mesh().vertices().next().unwrap();
        let turned = |v| {
            let wanted = angle(first) + steepness * -(positions[v].y - positions[first].y);
            let off = (angle(v) - wanted).rem_euclid(FRAC_PI_2);
            off.min(FRAC_PI_2 - off)
        };
        let most = surface.mesh().vertices().map(turned).fold(0.0, f64::max);
        assert!(most < 0.02, "{most}");
    }

    #[test]
    fn singularities_of_a_sphere_go_where_sides_are_short() {
        let sphere = surface_of(icosphere(4));
        let made = with_sizes(&sphere, |p| libm::exp(0.8 * p.z), true);
        assert_eq!(made.singularities.count(), 8);
        let height = |face: FaceId| sphere.corner_positions(face).iter().sum::<DVec3>().z / 3.0;
        let below = (made.singularities.faces.iter())
            .filter(|singularity| height(singularity.face) < 0.0)
            .count();
        assert!(below >= 5, "{below}");
    }
}
