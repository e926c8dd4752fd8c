//! Maps with a fixed boundary.

use std::f64::consts::PI;

use faer::Mat;
use faer::linalg::solvers::Solve;
use glam::{DVec2, DVec3};
use graticule::Hint;
use graticule::flatten::{
    BoundaryCurve, BoundaryPositions, Corners, FixedOptions, FixedSystem, FlatMap, FlattenError,
    Holes, Method, Patch, Weights, boundary_on_curve, fixed_map,
};
use graticule::geometry::{corner_cotangents, face_shapes};
use graticule::mesh::{PerVertex, Surface, VertexId};
use graticule::watch::Watch;
use graticule_fixtures::{
    Fixture, annulus, bumpy_patch, cone_patch, cylinder_patch, disk, grid, irregular_disk,
    saddle_patch, spherical_cap,
};

use crate::support::{
    distance, distance_up_to_similarity, in_old_numbers, mean_distance_up_to_similarity,
    own_boundary, patch, plane, rotated,
};

const ALL_WEIGHTS: [Weights; 4] = [
    Weights::Cotangent,
    Weights::DelaunayCotangent,
    Weights::MeanValue,
    Weights::Uniform,
];
/// Those for which a flat patch is its own map.
const PRECISE_WEIGHTS: [Weights; 3] = [
    Weights::Cotangent,
    Weights::DelaunayCotangent,
    Weights::MeanValue,
];

fn with(weights: Weights) -> FixedOptions {
    FixedOptions {
        weights,
        ..FixedOptions::default()
    }
}

fn on_curve(patch: &Patch, curve: BoundaryCurve, options: FixedOptions) -> FlatMap {
    let watch = Watch::new();
    let boundary = boundary_on_curve(patch, &curve, &watch).unwrap();
    fixed_map(patch, &boundary, &options, &watch).unwrap()
}

fn on_circle(patch: &Patch, weights: Weights) -> FlatMap {
    on_curve(patch, BoundaryCurve::Circle, with(weights))
}

/// A disk with two holes, irregular.
fn with_holes() -> Fixture {
    let mut fixture = bumpy_patch(10, 6);
    let inside = |p: DVec3| {
        let from = |x: f64, y: f64, r: f64| (p.x - x).hypot(p.y - y) < r;
        from(0.4, 0.1, 0.22) || from(-0.4, -0.2, 0.17)
    };
    let corners = |triangle: &[u32; 3]| triangle.map(|v| fixture.positions[v as usize]);
    let kept = |triangle: &&[u32; 3]| !corners(triangle).into_iter().any(inside);
    fixture.triangles = fixture.triangles.iter().filter(kept).copied().collect();
    let mut used = vec![false; fixture.positions.len()];
    for &vertex in fixture.triangles.iter().flatten() {
        used[vertex as usize] = true;
    }
    let mut new_of_old = vec![u32::MAX; used.len()];
    let mut positions = Vec::new();
    for (old, _) in used.iter().enumerate().filter(|(_, used)| **used) {
        new_of_old[old] = positions.len() as u32;
        positions.push(fixture.positions[old]);
    }
    for vertex in fixture.triangles.iter_mut().flatten() {
        *vertex = new_of_old[*vertex as usize];
    }
    Fixture {
        positions,
        triangles: fixture.triangles,
    }
}

fn curved() -> Vec<Fixture> {
    vec![
        bumpy_patch(8, 1),
        bumpy_patch(12, 4).map(|p| p * DVec3::new(1.0, 0.05, 2.0)),
        spherical_cap(2.6, 8),
        saddle_patch(9),
        cone_patch(0.6, 8),
        cylinder_patch(1.0, 2.0, 14, 7),
        annulus(0.1, 1.0, 16, 5),
        with_holes(),
    ]
}

#[test]
fn a_flat_patch_with_its_own_boundary_is_its_own_map() {
    let flat = [
        disk(6),
        irregular_disk(9, 3),
        grid(2.0, 1.0, 8, 5),
        annulus(0.3, 1.0, 18, 4),
        irregular_disk(7, 1).map(|p| DVec3::new(p.x, p.y * 1e-3, 0.0)),
        irregular_disk(7, 1).map(|p| p * 1e-30),
        disk(1),
        grid(1.0, 1.0, 1, 1),
    ];
    for fixture in flat {
        let patch = patch(&fixture);
        for weights in PRECISE_WEIGHTS {
            let boundary = own_boundary(&patch);
            let map = fixed_map(&patch, &boundary, &with(weights), &Watch::new()).unwrap();
            let error = distance(&map.uv, &plane(&patch));
            assert!(error < 1e-10, "{weights:?}: {error:e}");
            assert!(map.flips.is_zero());
        }
    }
}

#[test]
fn the_map_is_the_solution_of_the_dense_cotangent_system() {
    for fixture in [bumpy_patch(5, 2), saddle_patch(6), spherical_cap(2.0, 5)] {
        let patch = patch(&fixture);
        let watch = Watch::new();
        let boundary = boundary_on_curve(&patch, &BoundaryCurve::Circle, &watch).unwrap();
        let map = fixed_map(&patch, &boundary, &with(Weights::Cotangent), &watch).unwrap();
        let error = distance(&map.uv, &dense_map(patch.surface(), &boundary));
        assert!(error < 1e-12, "{error:e}");
        assert!(map.residual < 1e-14);
    }
}

/// [DMA02] §4.1 with λ = 1, μ = 0, row by row from positions, with a dense LU.
fn dense_map(surface: &Surface, boundary: &BoundaryPositions) -> PerVertex<DVec2> {
    let mesh = surface.mesh();
    let cotangents = corner_cotangents(&face_shapes(surface)).unwrap();
    let order = mesh.vertex_count();
    let mut matrix = Mat::<f64>::zeros(order, order);
    for side in mesh.halfedges() {
        let cotangent = cotangents[side.previous()];
        let [i, j] = mesh.ends(side).map(|v| v.0 as usize);
        for (i, j) in [(i, j), (j, i)] {
            matrix[(i, j)] += cotangent;
            matrix[(i, i)] -= cotangent;
        }
    }
    let mut right_side = Mat::<f64>::zeros(order, 2);
    for &(vertex, place) in boundary.places() {
        let row = vertex.0 as usize;
        for column in 0..order {
            matrix[(row, column)] = 0.0;
        }
        matrix[(row, row)] = 1.0;
        right_side[(row, 0)] = place.x;
        right_side[(row, 1)] = place.y;
    }
    let solution = matrix.partial_piv_lu().solve(&right_side);
    PerVertex::from_fn(order, |v: VertexId| {
        DVec2::new(solution[(v.0 as usize, 0)], solution[(v.0 as usize, 1)])
    })
}

#[test]
fn positive_weights_on_a_convex_curve_never_flip_a_triangle() {
    let curves = [
        BoundaryCurve::Circle,
        BoundaryCurve::Square(Corners::Automatic),
        BoundaryCurve::Square(Corners::EvenlySpaced),
        BoundaryCurve::Rectangle {
            aspect: None,
            corners: Corners::Automatic,
        },
    ];
    for fixture in curved() {
        let patch = patch(&fixture);
        for curve in curves {
            for weights in [Weights::MeanValue, Weights::Uniform] {
                let map = on_curve(&patch, curve, with(weights));
                assert!(map.flip_free_in_theory);
                assert!(
                    map.flips.is_zero(),
                    "{weights:?} {curve:?}: {:?}",
                    map.flips
                );
            }
        }
    }
}

#[test]
fn conformal_maps_with_delaunay_weights_flip_no_intrinsic_triangle_on_a_circle() {
    for fixture in curved() {
        let patch = patch(&fixture);
        let options = FixedOptions {
            weights: Weights::DelaunayCotangent,
            holes: Holes::Closed,
        };
        let map = on_curve(&patch, BoundaryCurve::Circle, options);
        assert!(
            map.intrinsic_flips.unwrap().is_zero(),
            "{:?}",
            map.intrinsic_flips
        );
        assert!(!map.flip_free_in_theory);
    }
}

#[test]
fn cotangent_maps_are_free_of_flips_where_they_say_so() {
    let mut promised = 0;
    for fixture in curved() {
        let options = FixedOptions {
            weights: Weights::Cotangent,
            holes: Holes::Closed,
        };
        let map = on_curve(&patch(&fixture), BoundaryCurve::Circle, options);
        promised += usize::from(map.flip_free_in_theory);
        assert!(!map.flip_free_in_theory || map.flips.is_zero());
    }
    assert!((1..8).contains(&promised), "{promised} of 8");
}

#[test]
fn no_triangle_collapses_on_a_straight_side() {
    // Ears: triangles with two boundary edges, many of them on each side.
    let mut ears = grid(1.0, 1.0, 6, 6);
    for k in 0..6 {
        let [a, b] = [k, k + 1];
        let tip = ears.positions.len() as u32;
        let middle = (ears.positions[a as usize] + ears.positions[b as usize]) / 2.0;
        ears.positions.push(middle - DVec3::Y * 0.1);
        ears.triangles.push([b, a, tip]);
    }
    for fixture in [ears, disk(3), irregular_disk(1, 1), grid(1.0, 1.0, 5, 1)] {
        let patch = patch(&fixture);
        for corners in [Corners::Automatic, Corners::EvenlySpaced] {
            let watch = Watch::new();
            let square = BoundaryCurve::Square(corners);
            let boundary = boundary_on_curve(&patch, &square, &watch).unwrap();
            for weights in ALL_WEIGHTS {
                let map = fixed_map(&patch, &boundary, &with(weights), &watch).unwrap();
                assert!(map.flips.is_zero(), "{weights:?} {:?}", map.flips);
            }
        }
    }
}

#[test]
fn bowed_sides_are_told() {
    let mut ear = grid(1.0, 1.0, 4, 4);
    ear.positions.push(DVec3::new(0.375, -0.1, 0.0));
    ear.triangles.push([2, 1, 25]);
    let patch = patch(&ear);
    let corners = Corners::At([0, 4, 24, 20].map(VertexId));
    let watch = Watch::new();
    let boundary = boundary_on_curve(&patch, &BoundaryCurve::Square(corners), &watch).unwrap();
    assert_eq!(watch.warnings()[0].code, "bowed-side");
    let place = |vertex| {
        boundary
            .places()
            .iter()
            .find(|(v, _)| v.0 == vertex)
            .unwrap()
            .1
    };
    // Only the ear's tip leaves the side.
    assert!(place(25).y < place(0).y - 1e-3);
    assert!((place(1).y - place(0).y).abs() < 1e-15);
    assert!((place(2).y - place(0).y).abs() < 1e-15);
}

#[test]
fn the_boundary_follows_the_curve_by_arc_length() {
    let patch = patch(&bumpy_patch(6, 2));
    let watch = Watch::new();
    let circle = boundary_on_curve(&patch, &BoundaryCurve::Circle, &watch).unwrap();
    let places = circle.places();
    let area = patch.unit_area() * patch.unit_length().powi(2);
    let count = places.len();
    let angle = |k: usize| places[k % count].1.to_angle();
    let mut lengths = Vec::new();
    for k in 0..count {
        assert!((PI * places[k].1.length_squared() / area - 1.0).abs() < 1e-14);
        let turn = (angle(k + 1) - angle(k)).rem_euclid(2.0 * PI);
        let ends = [places[k].0, places[(k + 1) % count].0];
        let step = patch
            .surface()
            .position(ends[0])
            .distance(patch.surface().position(ends[1]));
        lengths.push(step / turn);
    }
    assert!(lengths.iter().all(|l| (l / lengths[0] - 1.0).abs() < 1e-12));

    let rectangle = BoundaryCurve::Rectangle {
        aspect: Some(2.0),
        corners: Corners::EvenlySpaced,
    };
    let places = boundary_on_curve(&patch, &rectangle, &watch).unwrap();
    let extent = places
        .places()
        .iter()
        .fold(DVec2::ZERO, |most, (_, p)| most.max(p.abs()));
    assert!((extent.x / extent.y - 2.0).abs() < 1e-14);
    assert!((4.0 * extent.x * extent.y / area - 1.0).abs() < 1e-14);
}

#[test]
fn a_bent_rectangle_keeps_its_shape_and_corners() {
    let bent = grid(3.0, 1.0, 30, 10).map(|p| DVec3::new(p.x.sin(), p.x.cos(), p.y));
    let curve = BoundaryCurve::Rectangle {
        aspect: None,
        corners: Corners::Automatic,
    };
    let map = on_curve(&patch(&bent), curve, with(Weights::Cotangent));
    let flat = plane(&patch(&grid(3.0, 1.0, 30, 10)));
    // The chords of the bent strip are a little shorter than its arcs.
    assert!(distance_up_to_similarity(&map.uv, &flat) < 1e-3);
    assert!(map.energy.conformal < 1e-6);
}

#[test]
fn corners_and_aspects_that_cannot_be_are_refused() {
    let patch = patch(&disk(3));
    let refuse = |curve| {
        let refusal = boundary_on_curve(&patch, &curve, &Watch::new()).unwrap_err();
        assert!(refusal.hint().is_some());
    };
    refuse(BoundaryCurve::Square(Corners::At(
        [0, 19, 20, 21].map(VertexId),
    )));
    refuse(BoundaryCurve::Square(Corners::At(
        [19, 19, 20, 21].map(VertexId),
    )));
    for aspect in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let (aspect, corners) = (Some(aspect), Corners::Automatic);
        refuse(BoundaryCurve::Rectangle { aspect, corners });
    }
}

#[test]
fn scaling_rotating_and_renumbering_change_nothing_but_rounding() {
    let fixture = bumpy_patch(6, 5);
    let (renumbered, new_of_old) = fixture.renumbered(9);
    for weights in ALL_WEIGHTS {
        let original = on_circle(&patch(&fixture), weights);
        for exponent in [-40, 40] {
            let scale = 2.0_f64.powi(exponent);
            let scaled = on_circle(&patch(&fixture.clone().map(|p| p * scale)), weights);
            assert_eq!(scaled.uv.map(|&p| p / scale), original.uv);
        }
        let moved = fixture
            .clone()
            .map(|p| rotated(p) + DVec3::new(3.0, -7.0, 2.0));
        let error = distance(&on_circle(&patch(&moved), weights).uv, &original.uv);
        assert!(error < 1e-10, "{weights:?}: {error:e}");
        let other = on_circle(&patch(&renumbered), weights);
        let other = in_old_numbers(&other.uv, &new_of_old);
        let error = distance_up_to_similarity(&other, &original.uv);
        assert!(error < 1e-10, "{weights:?}: {error:e}");
    }
}

/// The orders at which the largest and the mean square error against a closed form fall when the
/// rings of a mesh double from 12 to 48.
fn orders(fixture_of: impl Fn(u32) -> Fixture, answer: impl Fn(DVec3) -> DVec2) -> [f64; 2] {
    let errors = [12, 48].map(|rings| {
        let patch = patch(&fixture_of(rings));
        let expected = patch.surface().positions().map(|&p| answer(p));
        let map = on_circle(&patch, Weights::Cotangent);
        [
            distance_up_to_similarity(&map.uv, &expected),
            mean_distance_up_to_similarity(&map.uv, &expected),
        ]
    });
    [0, 1].map(|norm| (errors[0][norm] / errors[1][norm]).log2() / 2.0)
}

#[test]
fn the_map_of_a_spherical_cap_converges_to_the_stereographic_projection() {
    let stereographic = |p: DVec3| p.truncate() / (1.0 + p.z);
    let [largest, mean] = orders(|rings| spherical_cap(1.0, rings), stereographic);
    assert!((1.85..2.2).contains(&largest), "{largest}");
    assert!((1.85..2.2).contains(&mean), "{mean}");
}

/// Developed, a cone of this angle is a sector; the power 2π over the angle closes it to a disk.
fn cone_orders(total_angle: f64) -> [f64; 2] {
    let power = |p: DVec3| {
        let radius = p.length().powf(2.0 * PI / total_angle);
        p.truncate().normalize_or_zero() * radius
    };
    orders(|rings| cone_patch(total_angle, rings), power)
}

#[test]
fn the_map_of_a_cone_converges_to_the_power_map() {
    let [largest, mean] = cone_orders(PI);
    assert!((1.85..2.2).contains(&largest), "{largest}");
    assert!((1.85..2.2).contains(&mean), "{mean}");
    // Where the power is 4/3, the map is less smooth at the tip, and there the error falls as the
    // map itself does.
    let [largest, mean] = cone_orders(1.5 * PI);
    assert!((1.25..1.45).contains(&largest), "{largest}");
    assert!(mean > largest, "{mean}");
}

#[test]
fn holes_may_be_natural_closed_or_fixed() {
    let patch = patch(&annulus(0.4, 1.0, 24, 5));
    let hole = patch.holes().next().unwrap();
    let mean_radius = |map: &FlatMap| {
        let radii: Vec<f64> = patch
            .loop_vertices(hole)
            .map(|v| map.uv[v].length())
            .collect();
        radii.iter().sum::<f64>() / radii.len() as f64
    };
    let radius = |holes| {
        let weights = Weights::Cotangent;
        mean_radius(&on_curve(
            &patch,
            BoundaryCurve::Circle,
            FixedOptions { weights, holes },
        ))
    };
    // Harmonic on the ring a < r < 1 with zero flux at a: (r + a²/r) / (1 + a²).
    let outer = (0.84_f64).sqrt();
    let natural = 2.0 * 0.4 / (1.0 + 0.16) * outer;
    assert!((radius(Holes::Natural) / natural - 1.0).abs() < 0.03);
    // The cone over a circular hole is flat: the ring lies in its disk as before.
    assert!((radius(Holes::Closed) / (0.4 * outer) - 1.0).abs() < 0.03);
    let fixed = fixed_map(
        &patch,
        &own_boundary(&patch),
        &with(Weights::Uniform),
        &Watch::new(),
    );
    assert!((mean_radius(&fixed.unwrap()) - 0.4).abs() < 1e-14);
}

#[test]
fn one_system_serves_many_places_of_its_boundary() {
    let patch = patch(&bumpy_patch(6, 2));
    let watch = Watch::new();
    let circle = boundary_on_curve(&patch, &BoundaryCurve::Circle, &watch).unwrap();
    let square = BoundaryCurve::Square(Corners::Automatic);
    let square = boundary_on_curve(&patch, &square, &watch).unwrap();
    for weights in ALL_WEIGHTS {
        let system = FixedSystem::new(&patch, &circle, &with(weights), &watch).unwrap();
        let reused = system.map(&square, &watch).unwrap();
        let fresh = fixed_map(&patch, &square, &with(weights), &watch).unwrap();
        assert!(distance(&reused.uv, &fresh.uv) < 1e-13);
    }
    let ring = crate::support::patch(&annulus(0.4, 1.0, 24, 5));
    let outer = boundary_on_curve(&ring, &BoundaryCurve::Circle, &watch).unwrap();
    let system = FixedSystem::new(&ring, &outer, &FixedOptions::default(), &watch).unwrap();
    let refusal = system.map(&own_boundary(&ring), &watch).unwrap_err();
    assert!(matches!(refusal, FlattenError::OtherBoundary { .. }));
}

#[test]
fn a_patch_without_interior_is_its_boundary_and_says_so() {
    let watch = Watch::new();
    let patch = patch(&grid(1.0, 1.0, 4, 1));
    let boundary = boundary_on_curve(&patch, &BoundaryCurve::Circle, &watch).unwrap();
    for weights in ALL_WEIGHTS {
        let map = fixed_map(&patch, &boundary, &with(weights), &watch).unwrap();
        for &(vertex, place) in boundary.places() {
            assert!(map.uv[vertex].distance(place) < 1e-15);
        }
        assert!(map.flips.is_zero());
    }
    assert!(watch.warnings().iter().any(|w| w.code == "no-interior"));
}

#[test]
fn flips_are_counted_and_told() {
    // A clockwise boundary turns every triangle over.
    let patch = patch(&disk(3));
    let mirrored = |vertex| {
        let p = patch.surface().position(vertex);
        (vertex, DVec2::new(p.x, -p.y))
    };
    let boundary = BoundaryPositions::new(&patch, patch.boundary_vertices().map(mirrored)).unwrap();
    let watch = Watch::new();
    let map = fixed_map(&patch, &boundary, &FixedOptions::default(), &watch).unwrap();
    assert_eq!(map.flips.flipped, patch.mesh().face_count());
    assert_eq!(watch.warnings()[0].code, "flipped-triangles");
    assert_eq!(map.method, Method::FixedConformal);
    assert!((map.energy.area + 1.0).abs() < 1e-12);
}

#[test]
fn degenerate_triangles_end_in_a_map_and_a_warning() {
    let mut fixture = bumpy_patch(5, 1);
    let [a, b, c] = fixture.triangles[20].map(|v| v as usize);
    fixture.positions[a] = (fixture.positions[b] + fixture.positions[c]) / 2.0;
    let patch = patch(&fixture);
    for weights in ALL_WEIGHTS {
        let watch = Watch::new();
        let boundary = boundary_on_curve(&patch, &BoundaryCurve::Circle, &watch).unwrap();
        let map = fixed_map(&patch, &boundary, &with(weights), &watch).unwrap();
        assert!(map.residual <= 1e-9);
        assert!(map.uv.iter().all(|p| p.is_finite()));
        let told = watch.warnings().iter().any(|w| w.code == "mollified");
        let uses_area = matches!(weights, Weights::Cotangent | Weights::MeanValue);
        assert_eq!(told, uses_area, "{weights:?}");
    }
}
