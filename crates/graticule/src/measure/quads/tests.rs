use glam::{DVec2, DVec3};
use graticule_fixtures::{
    QuadFixture, cube, grid, icosphere, quad_cube, quad_grid, quad_torus, torus,
};

use super::*;
use crate::mesh::{Polygons, Surface};

fn soup(mesh: &QuadFixture) -> PolygonSoup {
    PolygonSoup {
        positions: mesh.positions.clone(),
        polygons: mesh.quads.iter().map(|quad| &quad[..]).collect(),
        ..PolygonSoup::default()
    }
}

fn of_polygons(positions: &[[f64; 3]], polygons: &[&[u32]]) -> PolygonSoup {
    PolygonSoup {
        positions: positions.iter().map(|&p| p.into()).collect(),
        polygons: polygons.iter().copied().collect::<Polygons>(),
        ..PolygonSoup::default()
    }
}

fn measured(soup: &PolygonSoup) -> QuadMeasure {
    measure_quads(soup, &Watch::new()).unwrap()
}

fn compared(soup: &PolygonSoup, reference: &Surface) -> ReferenceMeasure {
    compare_to_reference(soup, reference, &Watch::new()).unwrap()
}

fn surface(fixture: graticule_fixtures::Fixture) -> Surface {
    Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
}

#[track_caller]
fn assert_near(value: f64, expected: f64) {
    assert!(
        (value - expected).abs() < 1e-9,
        "{value} instead of {expected}"
    );
}

#[test]
fn the_scaled_jacobian_of_known_quads_is_known() {
    let flat = |corners: [[f64; 2]; 4]| corners.map(|[x, y]| DVec3::new(x, y, 0.0));
    let rectangle = [[0., 0.], [3., 0.], [3., 1.], [0., 1.]];
    assert_near(scaled_jacobian(flat(rectangle)), 1.0);
    let rhombus = [
        [0., 0.],
        [1., 0.],
        [1.5, 0.75_f64.sqrt()],
        [0.5, 0.75_f64.sqrt()],
    ];
    assert_near(scaled_jacobian(flat(rhombus)), 0.75_f64.sqrt());
    let dart = [[0., 0.], [2., 0.], [0.5, 0.5], [0., 2.]];
    assert!(scaled_jacobian(flat(dart)) < 0.0);
    let bow_tie = [[0., 0.], [1., 0.], [0., 1.], [1., 1.]];
    assert!(scaled_jacobian(flat(bow_tie)) <= 0.0);
    let with_triangle_corner = [[0., 0.], [1., 0.], [2., 0.], [0., 1.]];
    assert_near(scaled_jacobian(flat(with_triangle_corner)), 0.0);
    assert_near(scaled_jacobian([DVec3::ONE; 4]), 0.0);
}

#[test]
fn a_cube_of_quads_has_its_known_figures() {
    let measure = measured(&soup(&quad_cube(4)));
    assert_eq!([measure.polygons.quads, measure.polygons.total], [96, 96]);
    assert_near(measure.polygons.area, 24.0);
    assert_near(measure.polygons.quad_area_share, 1.0);
    let connections = measure.connections;
    assert_eq!([connections.vertices, connections.edges], [98, 192]);
    assert_eq!(connections.euler_characteristic, 2);
    assert_eq!([connections.components, connections.boundary_loops], [1, 0]);
    assert!(connections.manifold);
    assert_eq!(
        [
            measure.valences.irregular,
            measure.valences.irregular_inside
        ],
        [8, 8]
    );
    assert_eq!(measure.valences.inside, [(3, 8), (4, 90)].into());
    let quality = measure.quality.unwrap();
    assert_near(quality.scaled_jacobian.min, 1.0);
    assert_near(quality.angle_deviation.max, 0.0);
    assert_near(quality.aspect.unwrap().max, 1.0);
    assert_near(quality.planarity.max, 0.0);
    assert_near(measure.edge_length.unwrap().mean, 0.5);
    assert_near(measure.edge_length.unwrap().variation, 0.0);
    assert_eq!([measure.straight_corners, measure.folds], [0, 0]);
    // Four rows around each of three axes, which cross each other and not themselves.
    let rows = Strips {
        count: 12,
        closed: 12,
        longest: 16,
        self_crossing: 0,
        spiral: 0,
    };
    assert_eq!(measure.strips, rows);
}

#[test]
fn the_corners_of_a_rectangle_are_irregular_and_its_rows_open() {
    let measure = measured(&soup(&quad_grid(DVec2::new(3.0, 1.0), 6, 2)));
    assert_eq!(measure.valences.irregular, 4);
    assert_eq!(measure.valences.boundary, [(2, 4), (3, 12)].into());
    assert_eq!(measure.connections.boundary_loops, 1);
    let rows = Strips {
        count: 8,
        closed: 0,
        longest: 6,
        self_crossing: 0,
        spiral: 0,
    };
    assert_eq!(measure.strips, rows);
}

#[test]
fn a_row_that_winds_around_a_torus_is_a_spiral() {
    let straight = measured(&soup(&quad_torus(1.0, 0.4, 12, 5))).strips;
    assert_eq!(
        [straight.count, straight.closed, straight.spiral],
        [17, 17, 0]
    );
    // Glued with a shift of one, the five rows around become one that winds five times.
    let mut mesh = quad_torus(1.0, 0.4, 12, 5);
    for quad in &mut mesh.quads[11 * 5..] {
        for corner in &mut quad[1..3] {
            *corner = (*corner + 1) % 5;
        }
    }
    let wound = measured(&soup(&mesh)).strips;
    assert_eq!([wound.count, wound.longest, wound.spiral], [13, 60, 1]);
    assert_eq!(wound.self_crossing, 0);
}

#[test]
fn a_row_that_crosses_itself_is_seen() {
    // Three quads around a vertex: each row turns there and meets another one's quad.
    let corner = of_polygons(
        &[
            [0., 0., 0.],
            [1., 0., 0.],
            [1., 1., 0.],
            [0., 1., 0.],
            [-1., 1., 0.],
            [-1., -1., 0.],
            [1., -1., 0.],
        ],
        &[&[0, 1, 2, 3], &[0, 3, 4, 5], &[0, 5, 6, 1]],
    );
    let strips = measured(&corner).strips;
    assert_eq!(
        [strips.count, strips.closed, strips.self_crossing],
        [3, 0, 0]
    );
    // From the right side of the first quad over two others and down into its upper side.
    let loop_back = of_polygons(
        &[
            [0., 0., 0.],
            [1., 0., 0.],
            [1., 1., 0.],
            [0., 1., 0.],
            [2., 0., 0.],
            [2., 1., 0.],
            [1., 2., 0.],
            [0., 2., 0.],
        ],
        &[&[0, 1, 2, 3], &[1, 4, 5, 2], &[5, 4, 7, 6], &[3, 2, 6, 7]],
    );
    let strips = measured(&loop_back).strips;
    assert_eq!(strips.self_crossing, 1);
}

#[test]
fn other_polygons_are_counted_apart() {
    let mixed = of_polygons(
        &[
            [0., 0., 0.],
            [1., 0., 0.],
            [1., 1., 0.],
            [0., 1., 0.],
            [2., 0., 0.],
            [3., 1., 0.],
            [2., 2., 0.],
        ],
        &[
            &[0, 1, 2, 3],
            &[1, 4, 2],
            &[4, 5, 6, 2],
            &[0, 1],
            &[0, 1, 77],
        ],
    );
    let measure = measured(&mixed);
    let polygons = &measure.polygons;
    assert_eq!(
        [
            polygons.total,
            polygons.left_out,
            polygons.triangles,
            polygons.quads
        ],
        [5, 2, 1, 2]
    );
    assert_near(polygons.area, 1.0 + 0.5 + 2.0);
    assert_near(polygons.quad_area_share, 3.0 / 3.5);
    assert!(measure.elements.scaled_jacobians[1].is_nan());
    assert!(measure.elements.scaled_jacobians[2] > 0.0);
}

#[test]
fn cracks_folds_and_crowded_edges_are_found() {
    let crack = of_polygons(
        &[
            [0., 0., 0.],
            [2., 0., 0.],
            [2., 1., 0.],
            [0., 1., 0.],
            [1., 0., 0.],
            [1., -1., 0.],
            [0., -1., 0.],
        ],
        &[&[0, 1, 2, 3], &[6, 5, 4, 0]],
    );
    assert_eq!(measured(&crack).connections.t_vertices, 1);
    let folded = of_polygons(
        &[
            [0., 0., 0.],
            [1., 0., 0.],
            [1., 1., 0.],
            [0., 1., 0.],
            [0.1, 0.9, 0.1],
            [0.9, 0.9, 0.1],
        ],
        &[&[0, 1, 2, 3], &[1, 0, 4, 5]],
    );
    assert_eq!(measured(&folded).folds, 1);
    let crowded = of_polygons(
        &[
            [0., 0., 0.],
            [1., 0., 0.],
            [1., 1., 0.],
            [0., 1., 0.],
            [0., 0., 1.],
            [1., 0., 1.],
            [0., -1., 0.],
            [1., -1., 0.],
        ],
        &[&[0, 1, 2, 3], &[1, 0, 4, 5], &[0, 1, 7, 6]],
    );
    let connections = measured(&crowded).connections;
    assert_eq!(
        [
            connections.non_manifold_edges,
            connections.inconsistent_edges
        ],
        [1, 1]
    );
    assert!(!connections.manifold);
}

#[test]
fn soups_without_anything_to_measure_are_measured() {
    for soup in [
        PolygonSoup::default(),
        of_polygons(&[[0., 0., 0.]], &[&[0, 0, 0, 0], &[], &[5, 6, 7]]),
        of_polygons(
            &[[f64::NAN, 0., 0.], [1., 0., 0.], [1., 1., 0.]],
            &[&[0, 1, 2]],
        ),
        of_polygons(&[[2., 3., 4.]; 4], &[&[0, 1, 2, 3]]),
    ] {
        let measure = measured(&soup);
        let json = serde_json::to_string(&measure).unwrap();
        assert!(!json.contains("NaN"), "{json}");
        let reference = surface(cube());
        let compared = compared(&soup, &reference);
        assert!(!compared.topology_kept);
        assert!(
            compared
                .sharp_edges
                .is_none_or(|lines| lines.max_distance.is_finite())
        );
    }
    let huge = of_polygons(
        &[[0., 0., 0.], [1e200, 0., 0.], [0., 1e200, 0.]],
        &[&[0, 1, 2]],
    );
    let refused = measure_quads(&huge, &Watch::new());
    assert!(matches!(
        refused,
        Err(MeasureError::ExtentOutOfRange { what: "mesh", .. })
    ));
}

#[test]
fn figures_without_unit_do_not_depend_on_scale() {
    let mesh = quad_cube(3).jittered(0.1, 1);
    let reference = cube().map(|p| 2.0 * p - 1.0);
    let factor = 2.0_f64.powi(40);
    let mut large = measured(&soup(&mesh.clone().map(|p| p * factor)));
    let mut small = measured(&soup(&mesh));
    assert_eq!(
        large.polygons.area.to_bits(),
        (small.polygons.area * factor * factor).to_bits()
    );
    large.polygons.area = small.polygons.area;
    large.edge_length = None;
    small.edge_length = None;
    large.elements = QuadElements::default();
    small.elements = QuadElements::default();
    assert_eq!(large, small);
    let [small, large] = [1.0, factor].map(|factor| {
        let reference = surface(reference.clone().map(|p| p * factor));
        compared(&soup(&mesh.clone().map(|p| p * factor)), &reference)
    });
    assert_eq!(small, large);
}

#[test]
fn a_mesh_on_its_reference_is_at_no_distance() {
    let reference = surface(cube().map(|p| 2.0 * p - 1.0).subdivided().subdivided());
    let measure = compared(&soup(&quad_cube(5)), &reference);
    assert!(measure.topology_kept);
    assert!(measure.distance.max < 1e-12 && measure.distance_from_reference.max < 1e-12);
    assert!(measure.normal_deviation.p95 < 1e-6);
    let sharp = measure.sharp_edges.unwrap();
    assert_eq!(sharp.edges, 48);
    assert_near(sharp.carried_share, 1.0);
    assert_near(sharp.met_share, 1.0);
    assert!(measure.boundary.is_none());
}

#[test]
fn a_shifted_sheet_is_at_its_distance() {
    let reference = surface(grid(3.0, 4.0, 6, 8));
    let mesh = quad_grid(DVec2::new(3.0, 4.0), 3, 4).map(|p| p + 0.05 * DVec3::Z);
    let measure = compared(&soup(&mesh), &reference);
    for deviation in [measure.distance, measure.distance_from_reference] {
        for figure in [deviation.mean, deviation.rms, deviation.max] {
            assert_near(figure, 1.0);
        }
    }
    let boundary = measure.boundary.unwrap();
    assert_near(boundary.max_distance, 1.0);
    assert_near(boundary.carried_share, 1.0);
    assert_near(boundary.met_share, 0.0);
    assert!(measure.sharp_edges.is_none());
}

#[test]
fn a_missing_part_shows_in_the_distance_from_the_reference() {
    let both = icosphere(2).joined(&icosphere(1).map(|p| 0.1 * p + 2.0 * DVec3::X));
    let mesh = quad_cube(6).map(DVec3::normalize);
    let measure = compared(&soup(&mesh), &surface(both));
    assert!(measure.distance.max < 2.0);
    assert!(measure.distance_from_reference.max > 20.0);
    assert!(!measure.topology_kept);
}

#[test]
fn turned_over_meshes_have_flipped_normals() {
    let mut mesh = quad_torus(1.0, 0.4, 24, 12);
    for quad in &mut mesh.quads {
        quad.reverse();
    }
    let measure = compared(&soup(&mesh), &surface(torus(1.0, 0.4, 48, 24)));
    assert!(measure.normal_deviation.flipped_share > 0.999);
    assert!(measure.topology_kept);
}

#[test]
fn any_number_of_threads_gives_the_same_figures() {
    let reference = surface(torus(1.0, 0.4, 48, 24));
    let mesh = soup(&quad_torus(1.0, 0.4, 24, 12).jittered(0.02, 5));
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(3)
        .build()
        .unwrap();
    assert_eq!(
        pool.install(|| compared(&mesh, &reference)),
        compared(&mesh, &reference)
    );
}
