use std::f64::consts::PI;

use glam::DVec3;
use graticule::geometry::{
    area_vector, dihedral_angles, face_axes, face_normals, gradients, gradients_in_space,
    vertex_frames, vertex_normals,
};
use graticule::mesh::Surface;

use super::{all_fixtures, fixtures, function, surface, turn_between, unflipped};

#[test]
fn gradients_of_linear_functions_are_exact_and_lie_in_the_surface() {
    let surface = surface(&fixtures::bumpy_patch(10, 1));
    let triangulation = unflipped(&surface);
    let slope = DVec3::new(0.3, -2.0, 0.7);
    let values = function(&surface, |p| slope.dot(p) + 4.0);
    let normals = face_normals(&surface);
    let flat = gradients(&triangulation, &values).unwrap();
    let spatial = gradients_in_space(&surface, &values).unwrap();
    for face in surface.mesh().faces() {
        let expected = slope - normals[face] * normals[face].dot(slope);
        let [x, y] = face_axes(&surface, face);
        let lifted = x * flat[face].x + y * flat[face].y;
        assert!(spatial[face].distance(expected) < 1e-12);
        assert!(lifted.distance(expected) < 1e-12);
    }
}

#[test]
fn the_normals_of_a_sphere_approach_its_radii() {
    let worst = |levels| {
        let sphere = surface(&fixtures::icosphere(levels));
        let normals = vertex_normals(&sphere);
        let errors = normals
            .enumerate()
            .map(|(v, n)| n.distance(sphere.position(v)));
        errors.fold(0.0, f64::max)
    };
    let [coarse, fine] = [worst(3), worst(5)];
    assert!(fine < coarse / 3.0 && fine < 5e-3, "{coarse} {fine}");
}

#[test]
fn the_area_vector_of_a_closed_surface_vanishes() {
    for (name, fixture, _) in all_fixtures() {
        let surface = surface(&fixture);
        let length = area_vector(&surface).length();
        if surface.mesh().boundary_loop_count() == 0 {
            assert!(length < 1e-11, "{name}: {length}");
        }
        if name == "grid" {
            assert!((length - 2.0).abs() < 1e-12);
        }
    }
}

#[test]
fn a_cube_has_twelve_right_dihedral_angles() {
    let cube = surface(&fixtures::cube());
    let angles = dihedral_angles(&cube);
    let is_right = |angle: f64| (angle - PI / 2.0).abs() < 1e-12;
    assert_eq!(angles.iter().filter(|&&angle| is_right(angle)).count(), 12);
    assert_eq!(angles.iter().filter(|angle| angle.abs() < 1e-12).count(), 6);
    let inside_out = Surface::new(cube.mesh().reversed(), cube.positions().clone()).unwrap();
    let grooves = dihedral_angles(&inside_out);
    assert_eq!(
        grooves.iter().filter(|&&angle| is_right(-angle)).count(),
        12
    );
}

#[test]
fn frames_point_where_directions_are_counted_from() {
    let surface = surface(&fixtures::bumpy_patch(8, 4));
    let triangulation = unflipped(&surface);
    for (vertex, frame) in vertex_frames(&surface).enumerate() {
        assert!(frame.x.cross(frame.y).distance(frame.normal) < 1e-12);
        for halfedge in surface.mesh().outgoing(vertex) {
            let seen = frame.project(surface.halfedge_vector(halfedge)).to_angle();
            let error = turn_between(seen, triangulation.direction(halfedge));
            assert!(error < 0.4, "{vertex} {halfedge}: {error}");
        }
        let zero = surface.mesh().vertex_halfedge(vertex);
        let seen = frame.project(surface.halfedge_vector(zero));
        assert!(seen.x > 0.0 && seen.y.abs() < 1e-12);
        assert!(frame.lift(seen).dot(frame.normal).abs() < 1e-12);
    }
}

#[test]
fn surfaces_without_area_have_frames_all_the_same() {
    let line = surface(&fixtures::grid(1.0, 1.0, 2, 2).map(|p| DVec3::Z * p.x));
    for frame in &vertex_frames(&line) {
        assert!((frame.x.length() - 1.0).abs() < 1e-12 && frame.y.is_finite());
    }
    assert!(
        face_normals(&line)
            .iter()
            .all(|&normal| normal == DVec3::ZERO)
    );
    assert!(dihedral_angles(&line).iter().all(|&angle| angle == 0.0));
}
