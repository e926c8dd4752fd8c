//! What must hold between the parts of `graticule::geometry`, on surfaces with known answers.

mod degenerate;
mod flips;
mod identities;
mod invariance;
mod space;

use std::f64::consts::TAU;

use glam::DVec3;
use graticule::geometry::{
    DelaunayReport, IntrinsicTriangulation, corner_angles, intrinsic_delaunay,
};
use graticule::mesh::{PerVertex, Surface, VertexId};
use graticule::watch::Watch;
use graticule_fixtures as fixtures;
use graticule_fixtures::Fixture;

fn surface(fixture: &Fixture) -> Surface {
    Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap()
}

/// Name, mesh, Euler characteristic.
fn all_fixtures() -> Vec<(&'static str, Fixture, f64)> {
    let two = fixtures::cube().joined(&fixtures::torus(3.0, 1.0, 12, 7));
    let pancake = fixtures::ellipsoid(DVec3::new(1.0, 10.0, 0.1), 3);
    vec![
        ("cube", fixtures::cube(), 2.0),
        ("sphere", fixtures::icosphere(3), 2.0),
        ("ellipsoid", pancake, 2.0),
        ("torus", fixtures::torus(2.0, 0.7, 30, 17), 0.0),
        ("thin torus", fixtures::torus(2.0, 0.01, 100, 5), 0.0),
        ("cylinder", fixtures::cylinder_closed(1.0, 40.0, 24, 3), 2.0),
        ("closed cone", fixtures::cone_closed(5.0, 16, 9), 2.0),
        ("genus 2", fixtures::block_with_holes(2).subdivided(), -2.0),
        ("genus 5", fixtures::block_with_holes(5), -8.0),
        ("two parts", two, 2.0),
        ("grid", fixtures::grid(2.0, 1.0, 8, 5), 1.0),
        ("disk", fixtures::irregular_disk(12, 5), 1.0),
        ("bumps", fixtures::bumpy_patch(14, 3), 1.0),
        ("cap", fixtures::spherical_cap(1.2, 10), 1.0),
        ("cone", fixtures::cone_patch(2.0, 10), 1.0),
        ("saddle", fixtures::saddle_patch(9), 1.0),
        ("annulus", fixtures::annulus(0.3, 1.0, 40, 6), 0.0),
        ("hyperboloid", fixtures::hyperboloid(40, 5), 0.0),
        (
            "open cylinder",
            fixtures::cylinder_patch(1.0, 3.0, 60, 2),
            0.0,
        ),
        ("needles", fixtures::needles(10, 1e6, 8), 1.0),
        (
            "flat triangles",
            fixtures::grid_with_flat_triangles(6, 4),
            1.0,
        ),
        ("sheared", fixtures::sheared_strip(40), 1.0),
    ]
}

fn delaunay(surface: &Surface) -> (IntrinsicTriangulation, DelaunayReport) {
    intrinsic_delaunay(surface, &Watch::new()).unwrap()
}

fn unflipped(surface: &Surface) -> IntrinsicTriangulation {
    IntrinsicTriangulation::of(surface).unwrap()
}

fn function(surface: &Surface, of_position: impl Fn(DVec3) -> f64) -> PerVertex<f64> {
    surface.positions().map(|&p| of_position(p))
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().map(f64::abs).fold(0.0, f64::max)
}

fn inner_vertices(surface: &Surface) -> Vec<VertexId> {
    let mesh = surface.mesh();
    let vertices = mesh.vertices();
    vertices.filter(|&v| !mesh.is_boundary_vertex(v)).collect()
}

/// The sum of the angles at each vertex, taken from the triangles as they are now.
fn angle_sums(triangulation: &IntrinsicTriangulation) -> PerVertex<f64> {
    let mut sums = PerVertex::filled(triangulation.vertex_count(), 0.0);
    for (halfedge, angle) in corner_angles(triangulation.shapes()).enumerate() {
        sums[triangulation.origin(halfedge)] += angle;
    }
    sums
}

/// Difference of two angles up to whole turns.
fn turn_between(a: f64, b: f64) -> f64 {
    let difference = (a - b) / TAU;
    (difference - difference.round()).abs() * TAU
}

/// Twins, edges, fans, side lengths and directions fit together.
fn assert_sound(t: &IntrinsicTriangulation, name: &str) {
    for halfedge in t.halfedges() {
        let shape = t.shape(halfedge.face());
        let length = t.edge_length(t.edge(halfedge));
        assert_eq!(
            shape.length(halfedge.side()).to_bits(),
            length.to_bits(),
            "{name}"
        );
        if let Some(twin) = t.twin(halfedge) {
            assert_eq!(t.twin(twin), Some(halfedge), "{name}");
            assert_eq!(t.edge(twin), t.edge(halfedge), "{name}");
            assert_eq!(t.origin(twin), t.destination(halfedge), "{name}");
        }
        if let Some(left) = t.turn_left(halfedge) {
            let angle = shape.angle(halfedge.side()) * t.angle_scale(t.origin(halfedge));
            let error = turn_between(t.direction(left), t.direction(halfedge) + angle);
            assert!(error < 1e-9, "{name} {halfedge}: {error:e}");
        }
    }
    for edge in t.edges() {
        assert_eq!(t.edge(t.edge_halfedge(edge)), edge, "{name}");
    }
    let corners: usize = t.vertices().map(|v| t.outgoing(v).count()).sum();
    assert_eq!(corners, t.halfedge_count(), "{name}");
    for vertex in t.vertices() {
        assert!(t.outgoing(vertex).all(|h| t.origin(h) == vertex), "{name}");
    }
}
