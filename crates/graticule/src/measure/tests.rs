//! Tests of whole maps. Identities first, then closed forms, invariance, faults, brute force.

use std::f64::consts::{PI, TAU};

use glam::{DMat2, DVec2, DVec3};
use graticule_fixtures as fixtures;
use graticule_fixtures::{Fixture, Noise};

use super::*;
use crate::mesh::{FaceId, HalfedgeId, Surface, VertexId};
use crate::watch::Watch;

fn surface(fixture: &Fixture) -> Surface {
    Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap()
}

fn measured(surface: &Surface, uvs: &PerCorner<DVec2>) -> MapMeasure {
    measure_map(surface, uvs, &Watch::new()).unwrap()
}

/// The map that takes each vertex to `image` of its position.
fn map_by(surface: &Surface, image: impl Fn(DVec3) -> DVec2) -> PerCorner<DVec2> {
    let mesh = surface.mesh();
    PerCorner::from_fn(mesh.halfedge_count(), |corner| {
        image(surface.position(mesh.origin(corner)))
    })
}

fn flat(p: DVec3) -> DVec2 {
    p.truncate()
}

fn linear_measure(fixture: &Fixture, matrix: DMat2) -> MapMeasure {
    let surface = surface(fixture);
    measured(&surface, &map_by(&surface, |p| matrix * flat(p)))
}

#[track_caller]
fn assert_close(value: f64, expected: f64, tolerance: f64) {
    let error = (value - expected).abs();
    assert!(
        error <= tolerance * expected.abs().max(1.0),
        "{value} instead of {expected}"
    );
}

#[track_caller]
fn assert_isometric(measure: &MapMeasure, tolerance: f64) {
    let distortion = measure.distortion.unwrap();
    let ratio = distortion.quasi_conformal_error;
    for value in [ratio.mean, ratio.median, ratio.p95, ratio.p99, ratio.max] {
        assert_close(value, 1.0, tolerance);
    }
    assert_close(distortion.mips_mean, 2.0, tolerance);
    assert_close(distortion.angle_change_mean, 0.0, 60.0 * tolerance);
    let area = distortion.area_scale;
    for value in [area.log_mean, area.log_p95, area.log_max] {
        assert_close(value, 0.0, tolerance);
    }
    assert_close(area.min, 1.0, tolerance);
    assert_close(area.max, 1.0, tolerance);
    assert_close(distortion.l2_stretch, 1.0, tolerance);
    assert_close(distortion.linf_stretch, 1.0, tolerance);
    assert_close(distortion.symmetric_dirichlet.unwrap(), 4.0, tolerance);
    assert_close(distortion.dirichlet_energy, 1.0, tolerance);
    assert_close(distortion.edge_length_error, 0.0, tolerance);
    assert_close(distortion.shear_mean, 0.0, tolerance);
    assert_eq!(measure.faces.left_out, 0);
    assert_eq!(measure.faces.flipped, 0);
}

fn flat_patches() -> Vec<Fixture> {
    vec![
        fixtures::grid(2.0, 3.0, 7, 5),
        fixtures::disk(9),
        fixtures::irregular_disk(12, 5),
        fixtures::annulus(0.4, 1.0, 30, 5),
        fixtures::grid(1.0, 1.0, 1, 1),
    ]
}

#[test]
fn a_flat_patch_maps_to_itself_with_all_figures_ideal() {
    for patch in flat_patches() {
        let surface = surface(&patch);
        let measure = measured(&surface, &map_by(&surface, flat));
        assert_isometric(&measure, 1e-12);
        assert!(measure.bijective);
        assert_eq!(measure.islands.count, 1);
        assert_eq!(
            measure.islands.boundary_loops,
            surface.mesh().boundary_loop_count()
        );
        assert_eq!(measure.overlap.boundary_crossings, 0);
        assert!(measure.overlap.area_share.abs() <= 0.0);
        assert!(measure.islands.seam_length.abs() <= 0.0);
        assert_close(measure.faces.uv_area, measure.faces.surface_area, 1e-12);
    }
}

#[test]
fn a_similarity_changes_nothing() {
    let patch = fixtures::bumpy_patch(10, 3);
    let surface = surface(&patch);
    let plain = measured(&surface, &map_by(&surface, flat));
    for (scale, shift) in [
        (2_f64.powi(40), 0.0),
        (1e-30, 0.0),
        (1e30, 1e30),
        (1.0, 1e7),
    ] {
        let turn = DMat2::from_angle(0.7);
        let uvs = map_by(&surface, |p| turn * flat(p) * scale + DVec2::splat(shift));
        let moved = measured(&surface, &uvs);
        // A shift by 1e7 leaves nine digits of the coordinates.
        let tolerance = if shift > scale { 1e-7 } else { 1e-12 };
        assert_same_figures(&plain, &moved, tolerance, false);
    }
    for scale in [1e-30, 1e30] {
        let large = Surface::new(
            surface.shared_mesh(),
            surface.positions().map(|&p| p * scale),
        );
        let moved = measured(&large.unwrap(), &map_by(&surface, flat));
        assert_same_figures(&plain, &moved, 1e-12, true);
        assert_close(
            moved.faces.surface_area / scale / scale,
            plain.faces.surface_area,
            1e-12,
        );
    }
}

/// Shear depends on the direction of the coordinates, unlike all other figures.
#[track_caller]
fn assert_same_figures(a: &MapMeasure, b: &MapMeasure, tolerance: f64, shear: bool) {
    assert_eq!(a.bijective, b.bijective);
    assert_eq!(a.islands.count, b.islands.count);
    assert_eq!(a.islands.folded_vertices, b.islands.folded_vertices);
    assert_eq!(a.islands.boundary_edges, b.islands.boundary_edges);
    assert_eq!(a.faces.flipped, b.faces.flipped);
    assert_eq!(a.faces.degenerate, b.faces.degenerate);
    assert_eq!(a.overlap.any, b.overlap.any);
    assert_eq!(a.overlap.boundary_crossings, b.overlap.boundary_crossings);
    assert_close(a.islands.seam_length, b.islands.seam_length, tolerance);
    let [a, b] = [a, b].map(|measure| serde_json::to_value(measure.distortion).unwrap());
    compare_numbers(&a, &b, tolerance, shear);
}

fn compare_numbers(a: &serde_json::Value, b: &serde_json::Value, tolerance: f64, shear: bool) {
    for (key, value) in a.as_object().unwrap() {
        if let (Some(a), Some(b)) = (value.as_f64(), b[key].as_f64()) {
            if shear || key != "shear_mean" {
                assert_close(a, b, tolerance);
            }
        } else {
            compare_numbers(value, &b[key], tolerance, shear);
        }
    }
}

#[test]
fn a_stretch_along_u_has_the_figures_of_its_singular_values() {
    let k = 4.0;
    for patch in [
        fixtures::grid(1.0, 2.0, 6, 6),
        fixtures::irregular_disk(8, 1),
    ] {
        let measure = linear_measure(&patch, DMat2::from_diagonal(DVec2::new(k, 1.0)));
        let distortion = measure.distortion.unwrap();
        // At equal area the singular values are √k and 1/√k.
        assert_close(distortion.quasi_conformal_error.mean, k, 1e-12);
        assert_close(distortion.quasi_conformal_error.max, k, 1e-12);
        assert_close(distortion.mips_mean, k + 1.0 / k, 1e-12);
        assert_close(
            distortion.l2_stretch,
            f64::midpoint(k, 1.0 / k).sqrt(),
            1e-12,
        );
        assert_close(distortion.linf_stretch, k.sqrt(), 1e-12);
        assert_close(
            distortion.symmetric_dirichlet.unwrap(),
            2.0 * (k + 1.0 / k),
            1e-12,
        );
        assert_close(
            distortion.dirichlet_energy,
            f64::midpoint(k, 1.0 / k),
            1e-12,
        );
        assert_close(distortion.area_scale.log_mean, 0.0, 1e-12);
        assert_close(distortion.shear_mean, 0.0, 1e-12);
        for face in &measure.elements.distortion {
            assert_close(face.singular_values[0], k, 1e-12);
            assert_close(face.singular_values[1], 1.0, 1e-12);
            assert_close(face.area_scale().unwrap(), k, 1e-12);
        }
    }
}

#[test]
fn a_shear_has_the_figures_of_its_gradients() {
    // u = x + y, v = y: gradients (1, 1) and (0, 1); singular values φ and 1/φ.
    let golden = f64::midpoint(1.0, 5_f64.sqrt());
    let matrix = DMat2::from_cols(DVec2::X, DVec2::ONE);
    let distortion = linear_measure(&fixtures::irregular_disk(9, 2), matrix)
        .distortion
        .unwrap();
    assert_close(distortion.shear_mean, 0.5_f64.sqrt(), 1e-12);
    assert_close(
        distortion.quasi_conformal_error.mean,
        golden * golden,
        1e-12,
    );
    assert_close(distortion.symmetric_dirichlet.unwrap(), 6.0, 1e-12);
    assert_close(distortion.area_scale.log_max, 0.0, 1e-12);
}

#[test]
fn two_densities_are_told_from_one_by_the_area_scale() {
    // The half beyond x = 1/2 is twice as long in u.
    let surface = surface(&fixtures::grid(1.0, 1.0, 8, 8));
    let uvs = map_by(&surface, |p| DVec2::new(p.x + (p.x - 0.5).max(0.0), p.y));
    let distortion = measured(&surface, &uvs).distortion.unwrap();
    assert_close(distortion.area_scale.log_mean, 2_f64.ln() / 2.0, 1e-12);
    assert_close(distortion.area_scale.log_max, 2_f64.ln(), 1e-12);
    assert_close(distortion.area_scale.min, 1.0 / 1.5, 1e-12);
    assert_close(distortion.area_scale.max, 2.0 / 1.5, 1e-12);
    assert_close(distortion.quasi_conformal_error.mean, 1.5, 1e-12);
}

#[test]
fn a_cylinder_unrolled_along_a_seam_is_isometric() {
    let around = 24;
    let fixture = fixtures::cylinder_patch(1.0, 2.0, around, 6);
    let surface = surface(&fixture);
    let step = 2.0 * (PI / f64::from(around)).sin();
    let mesh = surface.mesh();
    let uvs = PerCorner::from_fn(mesh.halfedge_count(), |corner: HalfedgeId| {
        let column = |vertex: VertexId| f64::from(vertex.0 % around);
        let [a, b, c] = mesh.triangle(corner.face()).map(column);
        let wraps = a.max(b).max(c) > f64::from(around) - 1.5 && a.min(b).min(c) < 0.5;
        let vertex = mesh.origin(corner);
        let turn = if wraps && column(vertex) < 0.5 {
            f64::from(around)
        } else {
            0.0
        };
        DVec2::new((column(vertex) + turn) * step, surface.position(vertex).z)
    });
    let measure = measured(&surface, &uvs);
    assert_isometric(&measure, 1e-12);
    assert!(measure.bijective);
    assert_eq!([measure.islands.count, measure.islands.disks], [1, 1]);
    let area = measure.faces.surface_area;
    assert_close(measure.islands.seam_length, 2.0 / area.sqrt(), 1e-12);
    assert_eq!(measure.islands.boundary_edges, 2 * (around as usize + 6));
    let border = &measure.elements.boundary_loops[0];
    assert_close(border.turning, TAU, 1e-12);
    assert_close(
        border.uv_length,
        2.0 * (f64::from(around) * step + 2.0),
        1e-12,
    );
    assert_close(border.surface_length, border.uv_length, 1e-12);
    assert_close(border.largest_turn, PI / 2.0, 1e-12);
}

#[test]
fn boundary_loops_turn_by_the_euler_characteristic() {
    let surface = surface(&fixtures::annulus(0.3, 1.0, 40, 4));
    let measure = measured(
        &surface,
        &map_by(&surface, |p| flat(p) * DVec2::new(3.0, 1.0)),
    );
    let mut turning: Vec<f64> = measure
        .elements
        .boundary_loops
        .iter()
        .map(|border| border.turning)
        .collect();
    turning.sort_by(f64::total_cmp);
    assert_close(turning[0], -TAU, 1e-12);
    assert_close(turning[1], TAU, 1e-12);
    assert_eq!(measure.elements.islands[0].euler_characteristic, 0);
    assert_eq!(measure.islands.disks, 0);
}

#[test]
fn a_vertex_pulled_across_its_neighbours_flips_triangles_and_folds() {
    let surface = surface(&fixtures::grid(1.0, 1.0, 10, 10));
    let centre = VertexId(60);
    let mesh = surface.mesh();
    let uvs = PerCorner::from_fn(mesh.halfedge_count(), |corner: HalfedgeId| {
        let vertex = mesh.origin(corner);
        let shift = if vertex == centre { 0.15 } else { 0.0 };
        flat(surface.position(vertex)) + DVec2::X * shift
    });
    let measure = measured(&surface, &uvs);
    let flipped: Vec<FaceId> = mesh
        .faces()
        .filter(|&face| {
            let [a, b, c] = face.halfedges().map(|corner| uvs[corner]);
            (b - a).perp_dot(c - a) < 0.0
        })
        .collect();
    assert!(!flipped.is_empty());
    assert_eq!(measure.faces.flipped, flipped.len());
    assert!(
        flipped
            .iter()
            .all(|&face| measure.elements.distortion[face].flipped)
    );
    assert!(measure.islands.folded_vertices > 0);
    assert!(measure.overlap.any && !measure.bijective);
    assert!(measure.overlap.area_share > 0.0);
    assert_eq!(measure.overlap.boundary_crossings, 0);
}

#[test]
fn a_mirrored_island_is_told_apart_from_flipped_triangles() {
    let surface = surface(&fixtures::bumpy_patch(8, 4));
    let plain = measured(&surface, &map_by(&surface, flat));
    let mirrored = measured(&surface, &map_by(&surface, |p| DVec2::new(-p.x, p.y)));
    assert_same_figures(&plain, &mirrored, 1e-13, true);
    assert_eq!([plain.islands.mirrored, mirrored.islands.mirrored], [0, 1]);
    assert_eq!(mirrored.faces.flipped, 0);
    assert!(mirrored.bijective);
}

#[test]
fn renumbering_changes_figures_by_rounding_only() {
    let fixture = fixtures::bumpy_patch(9, 6);
    let fold = |p: DVec3| DVec2::new(p.x * p.x + 0.3 * p.x, p.y + 0.2 * p.x);
    let original = surface(&fixture);
    let renumbered = surface(&fixture.renumbered(11).0);
    let a = measured(&original, &map_by(&original, fold));
    let b = measured(&renumbered, &map_by(&renumbered, fold));
    assert!(a.faces.flipped > 0);
    assert_same_figures(&a, &b, 1e-9, true);
    assert_close(a.overlap.area_share, b.overlap.area_share, 1e-12);
}

/// z ↦ z² on a ring: no triangle flipped, no vertex folded, everything covered twice.
#[test]
fn a_ring_wound_twice_overlaps_without_any_flip() {
    for (around, expected_crossings) in [(64, 0), (65, 1)] {
        let surface = surface(&fixtures::annulus(0.5, 1.0, around, 6));
        let square = |p: DVec3| DVec2::new(p.x * p.x - p.y * p.y, 2.0 * p.x * p.y);
        let measure = measured(&surface, &map_by(&surface, square));
        assert_eq!(
            [measure.faces.flipped, measure.islands.folded_vertices],
            [0, 0]
        );
        assert!(measure.overlap.any && !measure.bijective);
        assert!(measure.overlap.boundary_crossings >= expected_crossings);
        assert!(
            measure.overlap.area_share > 0.98,
            "{}",
            measure.overlap.area_share
        );
        assert!(measure.elements.overlapping_faces.is_some());
    }
}

/// z ↦ z² on a disk: the middle vertex, and it alone, is wound around twice.
#[test]
fn a_disk_wound_twice_is_folded_at_its_middle() {
    let surface = surface(&fixtures::disk(6));
    let square = |p: DVec3| DVec2::new(p.x * p.x - p.y * p.y, 2.0 * p.x * p.y);
    let measure = measured(&surface, &map_by(&surface, square));
    assert_eq!(measure.faces.flipped, 0);
    assert_eq!(measure.elements.folded_vertices, [VertexId(0)]);
    assert!(measure.overlap.any && !measure.bijective);
}

/// A strip rolled up past a full turn: the ends overlap, nothing else is wrong.
#[test]
fn a_strip_rolled_onto_itself_overlaps_and_its_boundary_crosses() {
    let surface = surface(&fixtures::grid(7.5, 0.4, 60, 3));
    let roll = |p: DVec3| {
        let (sin, cos) = p.x.sin_cos();
        DVec2::new(cos, sin) * (1.4 - p.y) + DVec2::X * 0.02 * p.x
    };
    let measure = measured(&surface, &map_by(&surface, roll));
    assert_eq!(
        [measure.faces.flipped, measure.islands.folded_vertices],
        [0, 0]
    );
    assert!(measure.overlap.boundary_crossings > 0);
    assert!(measure.overlap.any && !measure.bijective);
    // 1.22 of the turn lies twice, the second time 0.13 further out by the drift.
    assert!((0.1..0.19).contains(&measure.overlap.area_share));
    let covered = measure.packing.unwrap().covered_area;
    assert_close(
        measure.overlap.excess,
        measure.faces.uv_area / covered - 1.0,
        1e-4,
    );
    assert_close(measure.overlap.excess, measure.overlap.area_share, 1e-12);
}

/// Two unit squares of `n` × `n` cells, the second one's coordinates shifted.
fn two_squares(shift: DVec2) -> MapMeasure {
    let square = fixtures::grid(1.0, 1.0, 5, 5);
    let beside = square.clone().map(|p| p + DVec3::X * 10.0);
    let surface = surface(&square.joined(&beside));
    let place = |p: DVec3| {
        if p.x > 5.0 {
            flat(p) - DVec2::X * 10.0 + shift
        } else {
            flat(p)
        }
    };
    measured(&surface, &map_by(&surface, place))
}

#[test]
fn islands_that_overlap_are_found_and_their_share_is_measured() {
    let measure = two_squares(DVec2::new(0.5, 0.0));
    assert_eq!(measure.islands.count, 2);
    assert!(measure.overlap.any && !measure.bijective);
    assert_close(measure.overlap.area_share, 1.0 / 3.0, 1e-12);
    assert_close(measure.overlap.excess, 1.0 / 3.0, 1e-12);
    assert_close(measure.packing.unwrap().covered_area, 1.5, 1e-12);
    // One inside the other: no boundary edges cross.
    let stacked = two_squares(DVec2::ZERO);
    assert!(stacked.overlap.any && !stacked.bijective);
    assert_eq!(stacked.overlap.boundary_crossings, 0);
    assert_close(stacked.overlap.area_share, 1.0, 1e-12);
}

#[test]
fn islands_that_touch_do_not_overlap() {
    for shift in [
        DVec2::X,
        DVec2::ONE,
        DVec2::new(1.0, 0.3),
        DVec2::new(0.25, -1.0),
    ] {
        let measure = two_squares(shift);
        assert!(measure.bijective && !measure.overlap.any);
        assert!(measure.overlap.area_share.abs() <= 0.0);
        assert_eq!(measure.overlap.boundary_crossings, 0);
    }
    let almost = two_squares(DVec2::new(1.0_f64.next_down(), 0.0));
    assert!(almost.overlap.any && !almost.bijective);
    let packed = two_squares(DVec2::X).packing.unwrap();
    assert_close(packed.box_share, 1.0, 1e-12);
    assert_close(packed.square_share, 0.5, 1e-12);
    assert!(!packed.in_unit_square);
}

#[test]
fn an_island_inside_a_hole_of_another_does_not_overlap() {
    let ring = fixtures::annulus(0.5, 1.0, 32, 2);
    let inner = fixtures::disk(3).map(|p| p * 0.45 + DVec3::Z);
    let surface = surface(&ring.joined(&inner));
    let measure = measured(&surface, &map_by(&surface, flat));
    assert!(measure.bijective);
    let grown = map_by(&surface, |p| flat(p) * if p.z > 0.5 { 1.2 } else { 1.0 });
    let measure = measured(&surface, &grown);
    assert!(!measure.bijective && measure.overlap.any);
}

#[test]
fn collapsed_triangles_are_counted_and_left_out() {
    let surface = surface(&fixtures::grid(1.0, 1.0, 4, 4));
    let mesh = surface.mesh();
    let collapse = |depth: f64| {
        PerCorner::from_fn(mesh.halfedge_count(), |corner: HalfedgeId| {
            let vertex = mesh.origin(corner);
            let p = flat(surface.position(vertex));
            // The vertex (1/4, 1/4) moves to its neighbour (0, 1/4), up to `depth`.
            if vertex == VertexId(6) {
                DVec2::new(depth, p.y)
            } else {
                p
            }
        })
    };
    let onto = measured(&surface, &collapse(0.0));
    assert!(onto.faces.zero_uv_area > 0);
    assert_eq!(onto.faces.degenerate, onto.faces.zero_uv_area);
    assert_eq!(onto.faces.left_out, onto.faces.degenerate);
    assert_close(
        onto.faces.left_out_area_share,
        onto.faces.left_out as f64 / 32.0,
        1e-12,
    );
    assert!(!onto.bijective);
    // Next to nothing, of the right sign: left out of the figures, and still one to one.
    let near = measured(&surface, &collapse(1e-14));
    assert_eq!(near.faces.degenerate, onto.faces.degenerate);
    assert_eq!(near.faces.zero_uv_area, 0);
    assert!(near.bijective);
    assert!(near.distortion.unwrap().linf_stretch < 10.0);
}

#[test]
fn triangles_flat_in_space_are_counted_and_left_out() {
    let mut grid = fixtures::grid(1.0, 1.0, 4, 4);
    grid.positions[6] = grid.positions[5];
    let plain = surface(&fixtures::grid(1.0, 1.0, 4, 4));
    let surface = surface(&grid);
    let measure = measured(&surface, &map_by(&plain, flat));
    assert!(measure.faces.flat_in_space > 0);
    assert_eq!(measure.faces.left_out, measure.faces.flat_in_space);
    assert_eq!(measure.faces.degenerate, 0);
    assert!(measure.bijective);
    assert!(
        measure
            .distortion
            .unwrap()
            .symmetric_dirichlet
            .unwrap()
            .is_finite()
    );
}

#[test]
fn faces_without_usable_coordinates_are_counted_apart() {
    let surface = surface(&fixtures::grid(1.0, 1.0, 4, 4));
    let all = map_by(&surface, flat);
    let mut partial = PerCorner::new(all.iter().copied().map(Some).collect());
    partial[HalfedgeId(3)] = None;
    partial[HalfedgeId(7)] = Some(DVec2::new(f64::NAN, 0.0));
    partial[HalfedgeId(8)] = Some(DVec2::new(f64::INFINITY, 0.0));
    let measure = measure_partial_map(&surface, &partial, &Watch::new()).unwrap();
    assert_eq!(
        [measure.faces.without_uv, measure.faces.non_finite_uv],
        [1, 1]
    );
    assert_eq!(measure.faces.left_out, 2);
    assert_close(measure.faces.left_out_area_share, 2.0 / 32.0, 1e-12);
    assert!(!measure.bijective && !measure.overlap.any);
    assert_close(measure.distortion.unwrap().l2_stretch, 1.0, 1e-12);
    assert_eq!(measure.elements.face_islands[FaceId(1)], None);
    assert!(measure.islands.seam_length.abs() <= 0.0);
}

#[test]
fn maps_with_nothing_to_measure_have_no_figures_and_no_nan() {
    let surface = surface(&fixtures::disk(3));
    let count = surface.mesh().halfedge_count();
    for value in [DVec2::ZERO, DVec2::splat(f64::NAN), DVec2::splat(1e300)] {
        let measure = measured(&surface, &PerCorner::filled(count, value));
        assert!(!measure.bijective);
        assert_eq!(
            [measure.distortion.is_none(), measure.packing.is_none()],
            [true; 2]
        );
        assert!(!measure.to_string().contains("NaN"));
    }
    let none = PerCorner::filled(count, None);
    let measure = measure_partial_map(&surface, &none, &Watch::new()).unwrap();
    assert_eq!([measure.faces.without_uv, measure.islands.count], [54, 0]);
}

#[test]
fn what_cannot_be_measured_is_refused_by_name() {
    let surface = surface(&fixtures::disk(2));
    let short = PerCorner::filled(5, DVec2::ZERO);
    let refusal = measure_map(&surface, &short, &Watch::new()).unwrap_err();
    assert_eq!(
        refusal,
        MeasureError::CornerCount {
            uvs: 5,
            corners: 72
        }
    );
    let huge = map_by(&surface, |p| flat(p) * 1e200);
    let refusal = measure_map(&surface, &huge, &Watch::new()).unwrap_err();
    assert!(matches!(
        refusal,
        MeasureError::ExtentOutOfRange { what: "map", .. }
    ));
    let watch = Watch::new();
    watch.cancel_handle().cancel();
    let refusal = measure_map(&surface, &map_by(&surface, flat), &watch).unwrap_err();
    assert!(matches!(refusal, MeasureError::Stopped(_)));
}

#[test]
fn needles_keep_their_figures_at_any_scale() {
    for scale in [1e-30, 1.0, 1e30] {
        let surface = surface(&fixtures::grid(1.0, 1e-6, 5, 4).map(|p| p * scale));
        let measure = measured(&surface, &map_by(&surface, |p| DVec2::new(2.0 * p.x, p.y)));
        assert_close(
            measure.distortion.unwrap().quasi_conformal_error.max,
            2.0,
            1e-9,
        );
        assert!(measure.bijective);
        assert_eq!(measure.faces.left_out, 0);
    }
}

#[test]
fn every_triangle_an_island_of_its_own_is_bijective_if_none_overlap() {
    let fixture = fixtures::disk(8);
    let surface = surface(&fixture);
    // Each triangle shrunk to its middle by an exact factor.
    let mesh = surface.mesh();
    let uvs = PerCorner::from_fn(mesh.halfedge_count(), |corner: HalfedgeId| {
        let [a, b, c] = surface.corner_positions(corner.face()).map(flat);
        let own = flat(surface.position(mesh.origin(corner)));
        0.5 * own + 0.5 * (a + b + c) / 3.0
    });
    let measure = measured(&surface, &uvs);
    assert!(measure.bijective);
    assert_eq!(measure.islands.count, mesh.face_count());
    assert_eq!(measure.islands.disks, mesh.face_count());
    assert_isometric(&measure, 1e-12);
}

fn random_map(seed: u64, noise_size: f64) -> (Surface, PerCorner<DVec2>) {
    let mut noise = Noise::new(seed);
    let surface = surface(&fixtures::irregular_disk(3, seed));
    let uvs: PerVertex<DVec2> = surface.positions().map(|&p| {
        let shift = DVec2::new(noise.signed(), noise.signed()) * noise_size;
        let uv = flat(p) + shift;
        // Few digits, so that coincidences are frequent.
        if seed.is_multiple_of(2) {
            (uv * 8.0).round() / 8.0
        } else {
            uv
        }
    });
    let uvs = corner_uvs(surface.mesh(), &uvs);
    (surface, uvs)
}

/// The area that two triangles share, by clipping one with the sides of the other.
fn common_area(first: [DVec2; 3], second: [DVec2; 3]) -> f64 {
    let area = |polygon: &[DVec2]| {
        let next = polygon.iter().cycle().skip(1);
        polygon
            .iter()
            .zip(next)
            .map(|(a, b)| a.perp_dot(*b))
            .sum::<f64>()
            / 2.0
    };
    let turned = |[a, b, c]: [DVec2; 3]| {
        if area(&[a, b, c]) < 0.0 {
            [a, c, b]
        } else {
            [a, b, c]
        }
    };
    let mut polygon = turned(first).to_vec();
    let clip = turned(second);
    for side in 0..3 {
        let (from, to) = (clip[side], clip[(side + 1) % 3]);
        let height = |p: DVec2| (to - from).perp_dot(p - from);
        let mut clipped = Vec::new();
        for (index, &a) in polygon.iter().enumerate() {
            let b = polygon[(index + 1) % polygon.len()];
            if height(a) >= 0.0 {
                clipped.push(a);
            }
            if height(a) * height(b) < 0.0 {
                clipped.push(a + (b - a) * height(a) / (height(a) - height(b)));
            }
        }
        polygon = clipped;
    }
    area(&polygon)
}

#[test]
fn decisions_on_random_maps_agree_with_brute_force() {
    let mut bijective = 0;
    for seed in 0..300 {
        let (surface, uvs) = random_map(seed, 0.3 * (seed % 10) as f64 / 10.0);
        let measure = measured(&surface, &uvs);
        let faces: Vec<FaceId> = surface.mesh().faces().collect();
        let images = |face: FaceId| face.halfedges().map(|corner| uvs[corner]);
        let doubled = |face: FaceId| {
            let [a, b, c] = images(face);
            (b - a).perp_dot(c - a)
        };
        let overlap = faces.iter().any(|&a| {
            let others = faces.iter().filter(|&&b| b > a);
            others
                .copied()
                .any(|b| common_area(images(a), images(b)) > 1e-13)
        });
        assert_eq!(measure.overlap.any, overlap, "seed {seed}");
        let sound = faces.iter().all(|&face| doubled(face) > 1e-15);
        assert_eq!(measure.bijective, sound && !overlap, "seed {seed}");
        if let Some([a, b]) = measure.elements.overlapping_faces {
            assert!(common_area(images(a), images(b)) > 0.0);
        }
        bijective += usize::from(measure.bijective);
    }
    assert!(
        (30..270).contains(&bijective),
        "{bijective} of 300 are bijective"
    );
}

#[test]
fn crossings_on_random_maps_agree_with_brute_force() {
    for seed in 0..60 {
        let (surface, uvs) = random_map(seed, 0.6);
        let mesh = surface.mesh();
        let border: Vec<[DVec2; 2]> = mesh
            .halfedges()
            .filter(|&halfedge| mesh.twin(halfedge).is_none())
            .map(|halfedge| [uvs[halfedge], uvs[halfedge.next()]])
            .collect();
        let side = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
        let strictly = |x: f64, y: f64| x.abs() > 1e-14 && y.abs() > 1e-14 && x * y < 0.0;
        let mut count = 0;
        for (index, &[a, b]) in border.iter().enumerate() {
            for &[c, d] in &border[index + 1..] {
                let cross = strictly(side(a, b, c), side(a, b, d))
                    && strictly(side(c, d, a), side(c, d, b));
                count += u64::from(cross);
            }
        }
        let measure = measured(&surface, &uvs);
        assert_eq!(measure.overlap.boundary_crossings, count, "seed {seed}");
    }
}

#[test]
fn the_overlapping_area_of_two_islands_agrees_with_clipping() {
    let mut noise = Noise::new(9);
    for _ in 0..20 {
        let mut corner = || DVec2::new(noise.unit(), noise.unit());
        let [first, second] = [
            [corner(), corner(), corner()],
            [corner(), corner(), corner()],
        ];
        let positions = (0..6).map(|k| DVec3::new(f64::from(k % 3), f64::from(k / 2), 0.0));
        let surface = Surface::from_triangles(positions.collect(), &[[0, 1, 2], [3, 4, 5]]);
        let uvs = PerCorner::new([first, second].concat());
        let measure = measured(&surface.unwrap(), &uvs);
        let common = common_area(first, second);
        let covered = measure.faces.uv_area - common;
        assert!((measure.overlap.area_share - common / covered).abs() < 1e-4);
        assert_close(measure.packing.unwrap().covered_area, covered, 1e-4);
    }
}

#[test]
fn the_same_bytes_come_out_for_any_number_of_threads() {
    let (surface, uvs) = {
        let surface = surface(&fixtures::bumpy_patch(60, 2));
        let uvs = map_by(&surface, |p| {
            DVec2::new(p.x * p.x + 0.8 * p.x, p.y + 0.2 * p.x * p.z)
        });
        (surface, uvs)
    };
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| measured(&surface, &uvs))
    };
    let [one, many] = [1, 5].map(with_threads);
    assert!(one.faces.flipped > 0);
    assert_eq!(one, many);
}

#[test]
fn the_report_has_stable_keys_and_the_table_a_line_for_each_group() {
    let surface = surface(&fixtures::disk(3));
    let measure = measured(&surface, &map_by(&surface, flat));
    let report = serde_json::to_value(&measure).unwrap();
    let keys: Vec<_> = report.as_object().unwrap().keys().collect();
    let expected = [
        "bijective",
        "faces",
        "islands",
        "overlap",
        "packing",
        "distortion",
    ];
    assert_eq!(keys, expected);
    assert!(report["distortion"]["quasi_conformal_error"]["p95"].is_number());
    let table = measure.to_string();
    assert!(table.starts_with("one to one           yes\n"));
    assert_eq!(table.lines().count(), 10);
}

#[test]
fn an_exactly_halved_scale_changes_no_digit() {
    let (surface, uvs) = random_map(5, 0.2);
    let halved = measured(&surface, &uvs.map(|&uv| uv * 2_f64.powi(-40)));
    let plain = measured(&surface, &uvs);
    assert_eq!(plain.distortion, halved.distortion);
    assert_eq!(plain.overlap, halved.overlap);
    assert_eq!(plain.islands, halved.islands);
}
