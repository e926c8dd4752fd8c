use glam::{DMat3, DVec2, DVec3};
use graticule::geometry::{
    EdgeLengths, IntrinsicTriangulation, Mollification, TriangleShape, corner_angles,
    cotangent_weights, total_area,
};
use graticule::mesh::{EdgeId, HalfedgeId, Surface};
use graticule::watch::Watch;
use graticule_fixtures::Noise;

use super::{
    all_fixtures, angle_sums, assert_sound, delaunay, fixtures, function, largest, surface,
    turn_between, unflipped,
};

#[test]
fn flips_leave_a_sound_triangulation_of_the_same_surface() {
    for (name, fixture, _) in all_fixtures() {
        let surface = surface(&fixture);
        let before = unflipped(&surface);
        let (after, report) = delaunay(&surface);
        assert_sound(&before, name);
        assert_sound(&after, name);
        assert!(report.is_complete, "{name}");
        assert_eq!(report.mollification, Mollification::default(), "{name}");
        assert_same_surface(&before, &after, name);
    }
}

fn assert_same_surface(
    before: &IntrinsicTriangulation,
    after: &IntrinsicTriangulation,
    name: &str,
) {
    let [a, b] = [before, after].map(|t| total_area(t.shapes()));
    assert!((a - b).abs() < 1e-10 * a, "{name}");
    let [a, b] = [before, after].map(angle_sums);
    let worst = largest(a.iter().zip(&b).map(|(a, b)| a - b));
    assert!(worst < 1e-10, "{name}: {worst:e}");
}

#[test]
fn delaunay_weights_inside_are_not_negative() {
    for (name, fixture, _) in all_fixtures() {
        let surface = surface(&fixture);
        let mesh = surface.mesh();
        let (triangulation, report) = delaunay(&surface);
        let weights = cotangent_weights(&triangulation).unwrap();
        for (&[i, j], &weight) in weights.ends.iter().zip(&weights.weights) {
            let is_boundary = mesh.is_boundary_vertex(i) && mesh.is_boundary_vertex(j);
            assert!(weight >= 0.0 || is_boundary, "{name} {i} {j}: {weight}");
            assert!(weight.is_finite() && i < j);
        }
        assert!(report.least_inner_weight > -1e-9, "{name}: {report:?}");
        assert!(weights.ends.is_sorted());
        assert_eq!(weights.vertex_count(), mesh.vertex_count());
    }
}

#[test]
fn a_flat_delaunay_triangulation_is_straight_and_has_empty_circles() {
    let stretched = fixtures::irregular_disk(20, 3).map(|p| p * DVec3::new(50.0, 1.0, 1.0));
    for (name, fixture) in [
        ("disk", fixtures::irregular_disk(20, 7)),
        ("flat triangles", fixtures::grid_with_flat_triangles(8, 5)),
        ("stretched", stretched),
        ("sheared", fixtures::sheared_strip(60)),
    ] {
        let surface = surface(&fixture);
        let (triangulation, report) = delaunay(&surface);
        assert!(report.flips > 0, "{name}");
        for halfedge in triangulation.halfedges() {
            assert_straight(&surface, &triangulation, halfedge, name);
            assert_empty_circle(&surface, &triangulation, halfedge, name);
        }
    }
}

/// Length and direction are those of the line between the ends.
fn assert_straight(
    surface: &Surface,
    triangulation: &IntrinsicTriangulation,
    halfedge: HalfedgeId,
    name: &str,
) {
    let ends = triangulation.ends(halfedge);
    let [from, to] = ends.map(|vertex| surface.position(vertex).truncate());
    let length = triangulation.edge_length(triangulation.edge(halfedge));
    assert!(
        (length - from.distance(to)).abs() < 1e-12 * length,
        "{name}"
    );
    let zero = surface.mesh().vertex_halfedge(ends[0]);
    let zero = surface.halfedge_vector(zero).truncate().to_angle();
    let expected = (to - from).to_angle() - zero;
    let error = turn_between(triangulation.direction(halfedge), expected);
    assert!(error < 1e-9, "{name} {halfedge}: {error}");
}

fn assert_empty_circle(
    surface: &Surface,
    triangulation: &IntrinsicTriangulation,
    halfedge: HalfedgeId,
    name: &str,
) {
    let Some(twin) = triangulation.twin(halfedge) else {
        return;
    };
    let [a, b, c] = triangulation.triangle(halfedge.face());
    let d = triangulation.origin(twin.previous());
    let [a, b, c, d] = [a, b, c, d].map(|vertex| {
        let DVec2 { x, y } = surface.position(vertex).truncate();
        robust::Coord { x, y }
    });
    let inside = robust::incircle(a, b, c, d);
    assert!(inside < 1e-9, "{name} {halfedge}: {inside}");
}

#[test]
fn random_flips_keep_area_curvature_and_soundness() {
    let cases = [
        fixtures::icosphere(0),
        fixtures::torus(2.0, 0.7, 4, 3),
        fixtures::disk(2),
        fixtures::cone_closed(3.0, 3, 1),
    ];
    for (seed, fixture) in cases.iter().enumerate() {
        let surface = surface(fixture);
        let before = unflipped(&surface);
        let mut after = flipped_at_random(&before, seed as u64);
        assert_sound(&after, "flipped at random");
        assert_same_surface(&before, &after, "flipped at random");
        // The Laplacian of the Delaunay triangulation is the surface's, wherever one starts.
        let report = after.make_delaunay(&Watch::new()).unwrap();
        assert!(report.is_complete);
        let values = function(&surface, |p| p.x + p.y * p.z);
        let energy = |t| cotangent_weights(t).unwrap().energy(&values);
        let [a, b] = [energy(&delaunay(&surface).0), energy(&after)];
        assert!((a - b).abs() < 1e-9 * a, "{a} {b}");
    }
}

fn flipped_at_random(start: &IntrinsicTriangulation, seed: u64) -> IntrinsicTriangulation {
    let mut result = start.clone();
    let mut noise = Noise::new(seed);
    let mut flips = 0;
    // Thinner triangles are left alone: lengths would grow and angles shrink without bound.
    let thinnest = 0.02;
    for _ in 0..500 {
        let edge = EdgeId(noise.below(result.edge_count()) as u32);
        let mut tried = result.clone();
        let ratios = |t: &IntrinsicTriangulation| t.shapes().map(TriangleShape::height_ratio);
        if tried.flip(edge) && ratios(&tried).iter().all(|&ratio| ratio > thinnest) {
            result = tried;
            flips += 1;
        }
    }
    assert!(flips > 50, "{flips}");
    result
}

#[test]
fn random_flips_reach_loops_and_double_edges() {
    let start = unflipped(&surface(&fixtures::cone_closed(3.0, 3, 1)));
    let [mut loops, mut doubles] = [0, 0];
    for seed in 0..20 {
        let flipped = flipped_at_random(&start, seed);
        let ends = |edge| flipped.ends(flipped.edge_halfedge(edge));
        let mut pairs: Vec<_> = flipped.edges().map(ends).collect();
        loops += pairs.iter().filter(|[i, j]| i == j).count();
        for pair in &mut pairs {
            pair.sort_unstable();
        }
        pairs.sort_unstable();
        doubles += pairs.windows(2).filter(|pair| pair[0] == pair[1]).count();
        let weights = cotangent_weights(&flipped).unwrap();
        assert!(weights.ends.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(weights.ends.iter().all(|[i, j]| i < j));
    }
    assert!(loops > 0 && doubles > 0, "{loops} {doubles}");
}

#[test]
fn flipping_twice_gives_the_same_two_triangles() {
    let positions = [(0.0, 0.0), (1.0, 0.1), (0.4, 0.9), (0.5, -0.7)];
    let positions = positions.map(|(x, y)| DVec3::new(x, y, 0.3));
    let surface = Surface::from_triangles(positions.to_vec(), &[[0, 1, 2], [1, 0, 3]]).unwrap();
    let before = unflipped(&surface);
    let mut after = before.clone();
    let edge = before.edge(HalfedgeId(0));
    assert!(after.flip(edge));
    let diagonal = positions[2].distance(positions[3]);
    assert!((after.edge_length(edge) - diagonal).abs() < 1e-15);
    assert!(after.flip(edge));
    let angles = |t: &IntrinsicTriangulation| {
        let mut angles: Vec<f64> = corner_angles(t.shapes()).into_vec();
        angles.sort_by(f64::total_cmp);
        angles
    };
    for (a, b) in angles(&before).iter().zip(angles(&after)) {
        assert!((a - b).abs() < 1e-14);
    }
    assert_sound(&after, "flipped twice");
    let boundary: Vec<_> = surface.mesh().edges().filter(|&e| e != edge).collect();
    assert!(boundary.iter().all(|&edge| !after.flip(edge)));
}

#[test]
fn points_on_a_circle_are_left_as_they_are() {
    // Every cell is a rectangle or trapezoid, its corners on a circle up to rounding.
    let turn = DMat3::from_rotation_z(0.7);
    for fixture in [
        fixtures::grid(1.0, 0.1, 30, 30),
        fixtures::cylinder_patch(1.0, 100.0, 60, 7),
        fixtures::torus(2.0, 0.7, 30, 20),
    ] {
        let fixture = fixture.map(|p| turn * p + DVec3::splat(0.1));
        let (_, report) = delaunay(&surface(&fixture));
        assert!(report.is_complete);
        assert_eq!(report.flips, 0);
    }
}

#[test]
fn lengths_alone_give_the_geometry_of_the_surface() {
    let surface = surface(&fixtures::bumpy_patch(10, 2));
    let lengths = EdgeLengths::of(&surface);
    let measured = IntrinsicTriangulation::from_lengths(surface.mesh(), &lengths).unwrap();
    let [a, b] = [&unflipped(&surface), &measured].map(|t| cotangent_weights(t).unwrap());
    let worst = largest(a.weights.iter().zip(&b.weights).map(|(a, b)| a - b));
    assert!(worst < 1e-11, "{worst:e}");
    assert!((measured.mean_edge_length() - lengths.mean()).abs() < 1e-15);
}
