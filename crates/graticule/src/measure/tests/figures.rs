//! Identities, closed forms, invariance, what is left out and refused.

use std::f64::consts::{PI, TAU};

use glam::DMat2;

use super::*;
use crate::mesh::{FaceId, HalfedgeId, VertexId};

fn linear_measure(fixture: &Fixture, matrix: DMat2) -> MapMeasure {
    let surface = surface(fixture);
    measured(&surface, &map_by(&surface, |p| matrix * flat(p)))
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
