use glam::DVec3;
use graticule::geometry::{
    EdgeLengths, GeometryError, IntrinsicTriangulation, Mollification, TriangleShape,
    authalic_weights, cotangent_weights, face_shapes, intrinsic_delaunay, mean_value_weights,
    mollify,
};
use graticule::mesh::{EdgeId, FaceId, PerEdge};
use graticule::watch::Watch;
use graticule_fixtures::Noise;

use super::{assert_sound, delaunay, fixtures, surface, unflipped};

#[test]
fn triangles_without_area_are_flipped_away_where_flips_can() {
    let surface = surface(&fixtures::grid_with_flat_triangles(6, 4));
    let refusal = cotangent_weights(&unflipped(&surface)).unwrap_err();
    assert!(matches!(
        refusal,
        GeometryError::DegenerateFace { height_ratio, .. } if height_ratio == 0.0
    ));
    let (triangulation, report) = delaunay(&surface);
    assert_eq!(report.mollification, Mollification::default());
    let ratios = triangulation
        .shapes()
        .iter()
        .map(TriangleShape::height_ratio);
    assert!(ratios.fold(1.0, f64::min) > 0.1);
}

#[test]
fn triangles_without_area_at_the_boundary_are_mollified_and_told() {
    // A square with a triangle without area along its lower side, and a tiny cube elsewhere.
    let mut fixture = fixtures::grid(1.0, 1.0, 1, 1);
    fixture.positions.push(DVec3::X * 0.5);
    fixture.triangles.push([1, 0, 4]);
    let cube = fixtures::cube().map(|p| p * 1e-9 + DVec3::Z);
    let surface = surface(&fixture.joined(&cube));
    let watch = Watch::new();
    let (triangulation, report) = intrinsic_delaunay(&surface, &watch).unwrap();
    assert!(report.is_complete);
    assert_sound(&triangulation, "mollified");
    // One flip gives the triangle an area.
    assert_eq!(report.mollification, Mollification::default());
    assert!(watch.warnings().is_empty());

    // The long side on the boundary cannot be flipped.
    let mut fixture = fixtures::grid(1.0, 1.0, 1, 1);
    fixture.positions.push(DVec3::X * 2.0);
    fixture.triangles.push([1, 0, 4]);
    let surface = self::surface(&fixture.joined(&fixtures::cube().map(|p| p * 1e-9 + DVec3::Z)));
    let (triangulation, report) = intrinsic_delaunay(&surface, &watch).unwrap();
    let mollification = report.mollification;
    assert_eq!((mollification.faces, mollification.components), (1, 1));
    assert!(mollification.largest_shift > 0.0 && mollification.largest_shift < 1e-9);
    assert_eq!(watch.warnings()[0].code, "mollified");
    assert!(report.is_complete);
    assert_sound(&triangulation, "mollified");
    let weights = cotangent_weights(&triangulation).unwrap();
    assert!(weights.weights.iter().all(|weight| weight.is_finite()));
    // The other component is untouched.
    let shapes = face_shapes(&surface);
    let last = FaceId(shapes.len() as u32 - 1);
    assert_eq!(triangulation.shape(last), &shapes[last]);
}

#[test]
fn coincident_vertices_and_parts_get_a_size() {
    let mut fixture = fixtures::irregular_disk(5, 1);
    fixture.positions[3] = fixture.positions[2];
    let point = fixtures::cube().map(|_| DVec3::ONE * 3.0);
    let (triangulation, report) = delaunay(&surface(&fixture.joined(&point)));
    assert_eq!(report.mollification.components, 2);
    assert!(report.is_complete);
    assert_sound(&triangulation, "coincident");
    assert!(cotangent_weights(&triangulation).is_ok());
    assert!(mean_value_weights(&triangulation).is_ok());
    assert!(authalic_weights(&triangulation).is_ok());
}

#[test]
fn mollified_lengths_satisfy_the_triangle_inequality() {
    let surface = surface(&fixtures::icosphere(1));
    let mesh = surface.mesh();
    let mut noise = Noise::new(1);
    let lengths = PerEdge::from_fn(mesh.edge_count(), |_: EdgeId| noise.unit());
    let lengths = EdgeLengths::new(mesh, lengths).unwrap();
    let refusal = IntrinsicTriangulation::from_lengths(mesh, &lengths).unwrap_err();
    assert!(matches!(refusal, GeometryError::TriangleInequality { .. }));
    let (mollified, report) = mollify(mesh, &lengths);
    assert!(report.faces > 0 && report.components == 1);
    let mut triangulation = IntrinsicTriangulation::from_lengths(mesh, &mollified).unwrap();
    let flips = triangulation.make_delaunay(&Watch::new()).unwrap();
    assert!(flips.is_complete && flips.least_inner_weight > -1e-6);
    assert_sound(&triangulation, "random lengths");
}

#[test]
fn mollification_leaves_good_lengths_alone_and_is_the_least() {
    let surface = surface(&fixtures::icosphere(1));
    let mesh = surface.mesh();
    let lengths = EdgeLengths::of(&surface);
    let (same, report) = mollify(mesh, &lengths);
    assert_eq!((same, report), (lengths.clone(), Mollification::default()));
    // One edge as long as its two neighbours together and a tenth more.
    let mut broken = PerEdge::new(lengths.as_slice().to_vec());
    let [a, b, c] = FaceId(0).halfedges().map(|h| mesh.edge(h));
    broken[a] = 1.1 * (broken[b] + broken[c]);
    let missing = broken[a] - broken[b] - broken[c];
    let (_, report) = mollify(mesh, &EdgeLengths::new(mesh, broken).unwrap());
    assert!(report.largest_shift >= missing);
    assert!(report.largest_shift < missing * 1.5);
}

#[test]
fn thinner_and_thinner_needles_end_in_finite_weights() {
    for exponent in 0..18 {
        let ratio = 10.0_f64.powi(exponent);
        for seed in 0..4 {
            let surface = surface(&fixtures::needles(6, ratio, seed));
            let (triangulation, report) = delaunay(&surface);
            assert!(report.is_complete, "{ratio:e}");
            assert_sound(&triangulation, "needles");
            let weights = cotangent_weights(&triangulation).unwrap();
            assert!(weights.weights.iter().all(|weight| weight.is_finite()));
            let mollified = report.mollification.components > 0;
            assert!(!mollified || ratio > 1e6, "{ratio:e}: {report:?}");
            assert!(mean_value_weights(&triangulation).is_ok(), "{ratio:e}");
        }
    }
}

#[test]
fn a_stopped_run_says_so() {
    let surface = surface(&fixtures::irregular_disk(80, 1));
    let watch = Watch::new();
    watch.cancel_handle().cancel();
    let stopped = intrinsic_delaunay(&surface, &watch).unwrap_err();
    assert!(matches!(stopped, GeometryError::Stopped(_)));
}
