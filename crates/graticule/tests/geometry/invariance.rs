#![allow(clippy::float_cmp, reason = "exactness is what is tested")]

use glam::{DMat3, DVec3};
use graticule::geometry::{
    GeometryError, IntrinsicTriangulation, angle_defects, authalic_weights, corner_angles,
    cotangent_weights, dihedral_angles, face_normals, face_shapes, normalized, transport_angles,
    vertex_areas, vertex_normals,
};
use graticule::mesh::{Surface, VertexId};
use graticule_fixtures::{Fixture, Noise};

use super::{delaunay, fixtures, surface, turn_between};

/// Everything intrinsic that has no unit.
fn intrinsic(surface: &Surface) -> Vec<f64> {
    let (triangulation, report) = delaunay(surface);
    let mut all = cotangent_weights(&triangulation).unwrap().weights;
    all.extend(angle_defects(&triangulation).iter());
    all.extend(
        triangulation
            .halfedges()
            .map(|h| triangulation.direction(h)),
    );
    all.extend(transport_angles(&triangulation).iter());
    all.extend(corner_angles(&face_shapes(surface)).iter());
    all.extend(dihedral_angles(surface).iter());
    all.push(report.flips as f64);
    all
}

/// That and the normals.
fn dimensionless(surface: &Surface) -> Vec<f64> {
    let mut all = intrinsic(surface);
    all.extend(vertex_normals(surface).iter().flat_map(DVec3::to_array));
    all.extend(face_normals(surface).iter().flat_map(DVec3::to_array));
    all
}

fn moved(fixture: &Fixture, change: impl Fn(DVec3) -> DVec3) -> Surface {
    surface(&fixture.clone().map(change))
}

fn assert_near(expected: &[f64], found: &[f64], tolerance: f64) {
    assert_eq!(expected.len(), found.len());
    for (index, (&a, &b)) in expected.iter().zip(found).enumerate() {
        let error = (a - b).abs().min(turn_between(a, b));
        assert!(error < tolerance, "{index}: {a} {b}");
    }
}

#[test]
fn scaling_by_powers_of_two_changes_no_bit() {
    for fixture in [fixtures::bumpy_patch(8, 1), fixtures::needles(8, 1e6, 1)] {
        let expected = dimensionless(&surface(&fixture));
        for exponent in [-200, -40, 40, 200] {
            let scale = 2.0_f64.powi(exponent);
            let scaled = dimensionless(&moved(&fixture, |p| p * scale));
            assert!(expected == scaled, "2^{exponent}");
        }
    }
}

#[test]
fn scale_rotation_and_place_change_nothing_beyond_rounding() {
    let fixture = fixtures::bumpy_patch(8, 1);
    let expected = dimensionless(&surface(&fixture));
    for scale in [1e-30, 1e-9, 1e9, 1e30] {
        let scaled = moved(&fixture, |p| p * scale);
        assert_near(&expected, &dimensionless(&scaled), 1e-9);
    }
    // Two units long and 1e7 away: the coordinates are good to 1e-9.
    let far = moved(&fixture, |p| p + DVec3::splat(1e7));
    assert_near(&expected, &dimensionless(&far), 1e-6);
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.1);
    let turned = moved(&fixture, |p| turn * p);
    assert_near(&intrinsic(&surface(&fixture)), &intrinsic(&turned), 1e-9);
    let [first, second] = [&surface(&fixture), &turned].map(vertex_normals);
    for (first, second) in first.iter().zip(&second) {
        assert!((turn * *first).distance(*second) < 1e-12);
    }
}

#[test]
fn an_exact_change_of_place_changes_no_bit() {
    let grain = 2.0_f64.powi(-20);
    let fixture = fixtures::bumpy_patch(8, 1).map(|p| (p / grain).round() * grain);
    let far = moved(&fixture, |p| p + DVec3::splat(2.0_f64.powi(23)));
    assert!(dimensionless(&surface(&fixture)) == dimensionless(&far));
}

#[test]
fn renumbering_changes_nothing_beyond_rounding() {
    let fixture = fixtures::bumpy_patch(10, 6);
    let (renumbered, new_of_old) = fixture.renumbered(3);
    let [old, new] = [&fixture, &renumbered].map(|fixture| delaunay(&surface(fixture)).0);
    let renamed = |vertex: VertexId| VertexId(new_of_old[vertex.0 as usize]);
    let [cotangents, renamed_cotangents] = [&old, &new].map(|t| cotangent_weights(t).unwrap());
    for (ends, weight) in cotangents.ends.iter().zip(&cotangents.weights) {
        let mut ends = ends.map(renamed);
        ends.sort_unstable();
        let place = renamed_cotangents.ends.binary_search(&ends).unwrap();
        assert!((renamed_cotangents.weights[place] - weight).abs() < 1e-10);
    }
    let [areas, renamed_areas] = [&old, &new].map(vertex_areas);
    let [authalic, renamed_authalic] = [&old, &new].map(|t| authalic_weights(t).unwrap());
    for vertex in old.vertices() {
        let other = renamed(vertex);
        assert!((areas[vertex] - renamed_areas[other]).abs() < 1e-12);
        let row = authalic.neighbors(vertex).iter();
        for (&neighbor, weight) in row.zip(authalic.weights(vertex)) {
            let row = renamed_authalic.neighbors(other);
            let place = row.binary_search(&renamed(neighbor)).unwrap();
            let error = renamed_authalic.weights(other)[place] - weight;
            assert!(error.abs() < 1e-9 * weight.abs().max(1.0));
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let surface = surface(&fixtures::bumpy_patch(30, 2));
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| dimensionless(&surface))
    };
    assert!(with_threads(1) == with_threads(4));
}

fn extent(surface: &Surface) -> f64 {
    let [low, high] = surface.bounding_box();
    (high - low).max_element()
}

#[test]
fn extreme_scales_are_refused_by_name_and_normalized_without_rounding() {
    let fixture = fixtures::bumpy_patch(6, 1);
    for scale in [1e-200, 1e-30, 1.0, 1e30, 1e150] {
        let extreme = moved(&fixture, |p| p * scale);
        if !(1e-70..1e70).contains(&scale) {
            let refusal = IntrinsicTriangulation::of(&extreme).unwrap_err();
            assert!(matches!(refusal, GeometryError::Scale { .. }));
        }
        let (normal, similarity) = normalized(&extreme);
        assert!(cotangent_weights(&delaunay(&normal).0).is_ok());
        assert!((1.0..2.0).contains(&extent(&normal)));
        assert_eq!(similarity.invert_length(extent(&normal)), extent(&extreme));
        for vertex in extreme.mesh().vertices() {
            let back = similarity.invert(normal.position(vertex));
            assert_eq!(back, extreme.position(vertex));
        }
    }
}

#[test]
fn normalizing_brings_far_surfaces_near_without_rounding() {
    let mut noise = Noise::new(4);
    for _ in 0..300 {
        let offset = DVec3::new(
            noise.signed() * 1e7,
            noise.signed() * 1e3,
            noise.signed() * 3.0,
        );
        let scale = 10.0_f64.powf(3.0 * noise.signed());
        let far = moved(&fixtures::bumpy_patch(3, 1), |p| p * scale + offset);
        let (near, similarity) = normalized(&far);
        for vertex in far.mesh().vertices() {
            let position = near.position(vertex);
            assert!(position.abs().max_element() <= 4.0);
            assert_eq!(similarity.invert(position), far.position(vertex));
            assert_eq!(similarity.apply(far.position(vertex)), position);
        }
    }
}
