//! [`cross_field`] as a whole.
#![allow(clippy::float_cmp, reason = "exactness is what is tested")]

use glam::{DMat3, DVec2, DVec3};
use graticule_fixtures::{
    Fixture, block_with_holes, bumpy_patch, cube, cylinder_closed, cylinder_patch, disk, grid,
    grid_with_flat_triangles, icosphere, needles, torus, vase,
};

use super::*;
use crate::mesh::{Element, FaceId, Surface, VertexId};
use crate::watch::{Stopped, Watch};

const ALL: [Symmetry; 3] = [Symmetry::Vector, Symmetry::Line, Symmetry::Cross];

fn surface(fixture: Fixture) -> Surface {
    Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
}

fn of_symmetry(symmetry: Symmetry) -> FieldOptions {
    FieldOptions {
        symmetry,
        ..FieldOptions::default()
    }
}

fn field(surface: &Surface, options: &FieldOptions) -> FieldResult {
    cross_field(surface, options, &Watch::new()).unwrap()
}

/// The angle between two crosses at a vertex, in radians.
fn off(symmetry: Symmetry, a: DVec3, b: DVec3, normal: DVec3) -> f64 {
    let angle = libm::atan2(normal.dot(a.cross(b)), a.dot(b));
    symmetry.reduce(angle).0.abs()
}

#[test]
fn every_surface_has_a_field_whose_indices_sum_to_its_euler_characteristic() {
    let cases = [
        (icosphere(2), 2),
        (cube(), 2),
        (cylinder_closed(1.0, 2.0, 16, 4), 2),
        (torus(2.0, 0.7, 24, 10), 0),
        (block_with_holes(2).subdivided(), -2),
        (grid(1.0, 1.0, 1, 1), 1),
        (grid(3.0, 2.0, 9, 6), 1),
        (bumpy_patch(8, 3), 1),
        (cylinder_patch(1.0, 2.0, 12, 5), 0),
        (needles(6, 1e5, 1), 1),
        (grid_with_flat_triangles(5, 4), 1),
    ];
    for (number, (fixture, euler_characteristic)) in cases.into_iter().enumerate() {
        let surface = surface(fixture);
        for symmetry in ALL {
            let mut options = of_symmetry(symmetry);
            options.curl_correction = Some(CurlOptions::default());
            let found = field(&surface, &options);
            assert_eq!(found.report.euler_characteristic, euler_characteristic);
            let sum = found.report.index_sum;
            assert!(
                (sum - euler_characteristic as f64).abs() < 1e-6,
                "case {number}: {sum}"
            );
            assert!(
                found
                    .directions
                    .iter()
                    .all(|d| (d.length() - 1.0).abs() < 1e-9)
            );
            let scale = found.scale.unwrap();
            assert!(
                scale.iter().all(|v| (0.25..=4.0).contains(v)),
                "case {number}"
            );
        }
    }
}

#[test]
fn a_plane_a_box_and_a_cylinder_have_only_the_singularities_they_must() {
    for (fixture, count) in [
        (grid(3.0, 2.0, 12, 8), 0),
        (cube().subdivided().subdivided().subdivided(), 8),
        (cylinder_patch(1.0, 3.0, 24, 12), 0),
        (torus(2.0, 0.7, 40, 16), 0),
    ] {
        let found = field(&surface(fixture), &FieldOptions::default());
        assert_eq!(found.report.singularities, count, "{:?}", found.report);
    }
}

#[test]
fn a_thousand_components_have_a_field_each() {
    let mut many = icosphere(0);
    for number in 1..1000_u32 {
        let place = DVec3::new(f64::from(number % 32), f64::from(number / 32), 0.0) * 3.0;
        many = many.joined(&icosphere(0).map(|p| p + place));
    }
    let found = field(&surface(many), &FieldOptions::default());
    assert_eq!(found.report.euler_characteristic, 2000);
}

#[test]
fn neither_scale_nor_place_changes_a_digit() {
    let patch = bumpy_patch(8, 3);
    let reference = field(&surface(patch.clone()), &FieldOptions::default());
    for exponent in [-40, 40] {
        let scaled = patch.clone().map(|p| p * 2.0_f64.powi(exponent));
        let found = field(&surface(scaled), &FieldOptions::default());
        assert_eq!(found.directions, reference.directions);
        assert_eq!(found.report, reference.report);
        let curvature = |found: &FieldResult| found.curvatures.as_ref().unwrap().as_slice()[5].max;
        assert_eq!(
            curvature(&found) * 2.0_f64.powi(exponent),
            curvature(&reference)
        );
    }
    for scale in [1e-30, 1e30] {
        let found = field(
            &surface(patch.clone().map(|p| p * scale)),
            &FieldOptions::default(),
        );
        assert_eq!(found.report.singularities, reference.report.singularities);
    }
}

#[test]
fn a_turned_surface_has_the_turned_field() {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.8);
    let patch = bumpy_patch(8, 3);
    let straight = field(&surface(patch.clone()), &FieldOptions::default());
    let turned = field(&surface(patch.map(|p| turn * p)), &FieldOptions::default());
    for (vertex, &direction) in straight.directions.enumerate() {
        let normal = turned.normals[vertex];
        let angle = off(
            Symmetry::Cross,
            turned.directions[vertex],
            turn * direction,
            normal,
        );
        assert!(angle < 1e-6, "{vertex}: {angle}");
    }
}

/// A bump over a square, its triangles mirrored at x = 0.
fn mirrored_bump(cells: u32) -> Fixture {
    let half = grid(1.0, 2.0, cells, 2 * cells);
    let lift = |p: DVec3| {
        let (x, y) = (p.x, p.y - 1.0);
        p + DVec3::Z * (0.4 * (-3.0 * (x * x + y * y)).exp() + 0.1 * x * x * y)
    };
    let half = half.map(lift);
    let columns = cells + 1;
    let mut whole = half.clone();
    // The vertices of the column x = 0 are common, the others get a copy.
    let mut copies = Vec::new();
    for (number, &p) in half.positions.iter().enumerate() {
        if (number as u32).is_multiple_of(columns) {
            copies.push(number as u32);
        } else {
            copies.push(whole.positions.len() as u32);
            whole.positions.push(DVec3::new(-p.x, p.y, p.z));
        }
    }
    let flipped = half.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|vertex| copies[vertex as usize]);
        [a, c, b]
    });
    whole.triangles.extend(flipped);
    whole
}

#[test]
fn a_mirrored_surface_has_a_mirrored_field() {
    // Few enough vertices to be solved as a whole; and from coarse to fine, where the sweeps end before
    // the field is at rest to the last digit.
    for (cells, levels, limit) in [(10, 1, 1e-9), (36, 2, 1e-2)] {
        let surface = surface(mirrored_bump(cells));
        for cancel_distance in [0.0, FieldOptions::default().cancel_distance] {
            let options = FieldOptions {
                cancel_distance,
                ..FieldOptions::default()
            };
            let found = field(&surface, &options);
            assert!(found.report.smoothing.levels >= levels);
            let off = asymmetry(&surface, &found);
            assert!(off < limit, "{cells}, {cancel_distance}: {off}");
        }
    }
}

#[test]
fn a_smooth_surface_gains_no_singularities_when_sampled_more_finely() {
    let count = |fixture| {
        let found = field(&surface(fixture), &FieldOptions::default());
        found.report.singularities
    };
    for levels in [3, 5, 6] {
        assert_eq!(count(icosphere(levels)), 8, "{levels}");
    }
    let axes = DVec3::new(1.0, 1.4, 2.0);
    for levels in [3, 5] {
        assert_eq!(count(icosphere(levels).map(|p| p * axes)), 8, "{levels}");
    }
    for around in [60, 240] {
        assert_eq!(count(torus(2.0, 0.7, around, around / 3)), 0, "{around}");
    }
}

#[test]
fn a_surface_without_area_is_refused() {
    let flat = surface(torus(2.0, 0.7, 24, 10).map(|p| DVec3::new(p.x, 0.0, 0.0)));
    let found = cross_field(&flat, &FieldOptions::default(), &Watch::new());
    let error = found.map(|found| found.report).unwrap_err();
    assert!(matches!(error, FieldError::IndexSum { .. }), "{error}");
}

/// The largest angle between the field of a surface and its mirror image.
fn asymmetry(surface: &Surface, found: &FieldResult) -> f64 {
    let mirror = |p: DVec3| DVec3::new(-p.x, p.y, p.z);
    let angles = surface.mesh().vertices().map(|vertex| {
        let image = mirror(surface.position(vertex));
        let other = surface
            .mesh()
            .vertices()
            .find(|&v| surface.position(v) == image)
            .unwrap();
        let direction = mirror(found.directions[vertex]);
        off(
            Symmetry::Cross,
            found.directions[other],
            direction,
            found.normals[other],
        )
    });
    angles.fold(0.0, f64::max)
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let sphere = surface(icosphere(3).map(|p| p * DVec3::new(1.0, 1.3, 1.9)));
    let options = FieldOptions {
        curl_correction: Some(CurlOptions::default()),
        ..FieldOptions::default()
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| field(&sphere, &options))
    };
    let (one, two) = (with(1), with(2));
    let bits = |found: &FieldResult| -> Vec<u64> {
        let directions = found.directions.iter().flat_map(DVec3::to_array);
        let scale = found.scale.iter().flatten().copied();
        directions.chain(scale).map(f64::to_bits).collect()
    };
    assert_eq!(bits(&one), bits(&two));
    assert_eq!(one, two);
}

#[test]
fn the_seed_decides_where_nothing_guides() {
    let sphere = surface(icosphere(3));
    let with = |seed: u64| {
        let mut options = of_symmetry(Symmetry::Cross);
        options.curvature = None;
        options.smoothing.seed = seed;
        field(&sphere, &options)
    };
    assert_eq!(with(7), with(7));
    assert_ne!(with(7).field, with(8).field);
    assert_eq!(with(8).report.index_sum.round() as i64, 2);
}

#[test]
fn hard_edges_are_followed_to_rounding_and_corners_left_free() {
    let surface = surface(cube().subdivided().subdivided());
    let found = field(&surface, &FieldOptions::default());
    let inside = |x: f64| x > 0.0 && x < 1.0;
    let mut on_edges = 0;
    for vertex in surface.mesh().vertices() {
        let p = surface.position(vertex);
        let between = p.to_array().iter().filter(|x| inside(**x)).count();
        if between == 1 {
            let along = [DVec3::X, DVec3::Y, DVec3::Z]
                [p.to_array().map(inside).iter().position(|x| *x).unwrap()];
            let angle = off(
                Symmetry::Cross,
                found.directions[vertex],
                along,
                found.normals[vertex],
            );
            assert!(angle < 1e-9, "{p}: {angle}");
            on_edges += 1;
        }
    }
    assert_eq!(on_edges, 12 * 3);
    // Three edges at right angles agree on no cross.
    assert_eq!(found.report.fixed_vertices, on_edges);
}

#[test]
fn guides_are_followed_at_vertices_and_in_triangles() {
    let surface = surface(disk(12));
    let direction = DVec3::new(2.0, 1.0, 5.0);
    let flat = direction.truncate().extend(0.0).normalize();
    for place in [GuidePlace::Vertex(VertexId(0)), GuidePlace::Face(FaceId(3))] {
        for strength in [Strength::Hard, Strength::Soft(100.0)] {
            let mut options = FieldOptions {
                boundary: None,
                ..FieldOptions::default()
            };
            options.guides = vec![Guide {
                place,
                direction: direction * 1e200,
                strength,
            }];
            let found = field(&surface, &options);
            assert_eq!(found.report.singularities, 0);
            for (vertex, &found_direction) in found.directions.enumerate() {
                let angle = off(Symmetry::Cross, found_direction, flat, DVec3::Z);
                assert!(angle < 0.01, "{place:?} {vertex}: {angle}");
            }
        }
    }
}

#[test]
fn guides_that_make_no_sense_are_refused_by_number() {
    let surface = surface(disk(3));
    let sound = Guide {
        place: GuidePlace::Vertex(VertexId(0)),
        direction: DVec3::X,
        strength: Strength::Hard,
    };
    let refused = |guide: Guide| {
        let options = FieldOptions {
            guides: vec![sound, guide],
            ..FieldOptions::default()
        };
        cross_field(&surface, &options, &Watch::new()).unwrap_err()
    };
    for direction in [DVec3::ZERO, DVec3::Z, DVec3::NAN, DVec3::INFINITY] {
        let error = refused(Guide { direction, ..sound });
        assert!(
            matches!(error, FieldError::Guide { guide: 1, .. }),
            "{error}"
        );
    }
    for weight in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let strength = Strength::Soft(weight);
        let error = refused(Guide { strength, ..sound });
        assert!(
            matches!(error, FieldError::Guide { guide: 1, .. }),
            "{error}"
        );
    }
    for place in [
        GuidePlace::Vertex(VertexId::from_index(surface.mesh().vertex_count())),
        GuidePlace::Face(FaceId::from_index(surface.mesh().face_count())),
    ] {
        let error = refused(Guide { place, ..sound });
        assert!(
            matches!(error, FieldError::NoSuchElement { guide: 1, .. }),
            "{error}"
        );
    }
}

#[test]
fn options_out_of_range_are_refused() {
    let surface = surface(disk(3));
    let refused = |change: &dyn Fn(&mut FieldOptions)| {
        let mut options = FieldOptions::default();
        change(&mut options);
        let error = cross_field(&surface, &options, &Watch::new()).unwrap_err();
        assert!(matches!(error, FieldError::Option { .. }), "{error}");
    };
    let disks = CurvatureOptions::default();
    let radius = 0.0;
    refused(&|o| o.curvature = Some(CurvatureOptions { radius, ..disks }));
    let share = 1.5;
    refused(&|o| o.curvature = Some(CurvatureOptions { share, ..disks }));
    refused(&|o| o.cancel_distance = f64::NAN);
    refused(&|o| o.cancel_length = f64::INFINITY);
    refused(&|o| o.features.dihedral = Some(-0.1));
    refused(&|o| o.boundary = Some(Strength::Soft(0.0)));
    refused(&|o| o.smoothing.smoothing = 1.0);
    refused(&|o| o.curl_correction = Some(CurlOptions { range: Some(0.5) }));
}

#[test]
fn vectors_follow_the_boundary_onward() {
    let surface = surface(disk(10));
    let mut options = of_symmetry(Symmetry::Vector);
    options.boundary = Some(Strength::Hard);
    let found = field(&surface, &options);
    for vertex in surface.mesh().vertices() {
        let p = surface.position(vertex);
        if surface.mesh().is_boundary_vertex(vertex) {
            let onward = DVec2::new(-p.y, p.x).normalize().extend(0.0);
            assert!(found.directions[vertex].dot(onward) > 0.99, "{vertex}");
        }
    }
    assert_eq!(
        found.report.singularities_by_index,
        [IndexCount {
            index: 1.0,
            count: 1
        }]
    );
}

#[test]
fn a_stopped_watch_stops_it() {
    let watch = Watch::new();
    watch.cancel_handle().cancel();
    let stopped = cross_field(&surface(icosphere(2)), &FieldOptions::default(), &watch);
    assert_eq!(
        stopped.unwrap_err(),
        FieldError::Stopped(Stopped::Cancelled)
    );
}

#[test]
fn curl_of_a_surface_of_revolution_goes_by_one_over_its_radius() {
    // [PGP06] Fig. 7: circles and meridians, denser at the waists unless scaled.
    let surface = surface(vase(0.45, 72, 72));
    let options = FieldOptions {
        curl_correction: Some(CurlOptions::default()),
        ..FieldOptions::default()
    };
    let found = field(&surface, &options);
    assert_eq!(found.report.singularities, 0);
    let curl = found.report.curl.unwrap();
    assert!(curl.curl_after < 0.15 * curl.curl_before, "{curl:?}");
    assert_eq!(curl.clamped_share, 0.0);
    let scale = found.scale.unwrap();
    let products = surface.mesh().vertices().map(|vertex| {
        let radius = surface.position(vertex).truncate().length();
        radius * scale[vertex]
    });
    let [low, high] = products.fold([f64::INFINITY, 0.0], |[low, high], product: f64| {
        [low.min(product), high.max(product)]
    });
    assert!(high / low < 1.1, "{low} {high}");
}

#[test]
fn strokes_are_followed_where_they_run() {
    let surface = surface(grid(4.0, 4.0, 24, 24));
    let stroke = |strength| Stroke {
        points: vec![DVec3::new(1.0, 1.0, 0.1), DVec3::new(3.0, 2.0, -0.1)],
        strength,
    };
    let along = DVec3::new(2.0, 1.0, 0.0).normalize();
    for strength in [Strength::Hard, Strength::Soft(100.0)] {
        for boundary in [None, Some(Strength::Soft(1.0))] {
            let mut options = FieldOptions {
                boundary,
                ..FieldOptions::default()
            };
            options.strokes = vec![stroke(strength)];
            let found = field(&surface, &options);
            for (vertex, &direction) in found.directions.enumerate() {
                let p = surface.position(vertex);
                let off_line = (p - DVec3::new(1.0, 1.0, 0.0)).reject_from_normalized(along);
                if off_line.length() < 0.05 && (1.1..2.9).contains(&p.x) {
                    let angle = off(Symmetry::Cross, direction, along, DVec3::Z);
                    assert!(angle < 0.02, "{strength:?} {p}: {angle}");
                }
            }
        }
    }
}

#[test]
fn strokes_that_make_no_sense_are_refused_by_number() {
    let surface = surface(disk(3));
    let sound = Stroke {
        points: vec![DVec3::ZERO, DVec3::X],
        strength: Strength::Hard,
    };
    let refused = |points: Vec<DVec3>, strength| {
        let options = FieldOptions {
            strokes: vec![sound.clone(), Stroke { points, strength }],
            ..FieldOptions::default()
        };
        let error = cross_field(&surface, &options, &Watch::new()).unwrap_err();
        assert!(
            matches!(error, FieldError::Stroke { number: 1, .. }),
            "{error}"
        );
    };
    refused(vec![DVec3::X], Strength::Hard);
    refused(vec![DVec3::X, DVec3::NAN], Strength::Hard);
    refused(vec![DVec3::X * 90.0, DVec3::X * 99.0], Strength::Hard);
    refused(vec![DVec3::ZERO, DVec3::Z], Strength::Hard);
    refused(vec![DVec3::ZERO, DVec3::X], Strength::Soft(-1.0));
    refused(vec![DVec3::X * 1e300, DVec3::X * 2e300], Strength::Hard);
}

#[test]
fn a_cancel_length_counts_in_the_unit_of_the_positions() {
    for scale in [1.0, 1024.0] {
        let surface = surface(bumpy_patch(16, 3).map(|p| p * scale));
        let count = |cancel_length: f64| {
            let options = FieldOptions {
                cancel_distance: 0.0,
                cancel_length,
                ..FieldOptions::default()
            };
            field(&surface, &options).report.singularities
        };
        let [none, all] = [0.0, scale].map(count);
        assert!(all < none, "{none} {all}");
    }
}

#[test]
fn needles_and_extreme_scales_give_fields_with_sound_figures() {
    for fixture in [
        needles(6, 1e5, 1),
        grid_with_flat_triangles(5, 4),
        icosphere(2).map(|p| p * 1e9),
        icosphere(2).map(|p| p * 1e-9),
        cube().subdivided().map(|p| p * DVec3::new(1e9, 1.0, 1.0)),
    ] {
        let surface = surface(fixture);
        let found = field(&surface, &FieldOptions::default());
        assert!(
            found
                .directions
                .iter()
                .all(|d| (d.length() - 1.0).abs() < 1e-9)
        );
        let deviation = found.report.mean_deviation.unwrap_or_default();
        assert!((0.0..=45.0).contains(&deviation), "{deviation}");
    }
}
