//! What an integer grid map promises, on surfaces with known answers.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use graticule_fixtures::{
    Fixture, Noise, annulus, cube, cylinder_patch, disk, grid, icosphere, torus,
};

use super::alignment::wanted_edges;
use super::cut::DualForest;
use super::frames::FaceFrames;
use super::net::{Draft, check_turns, nets};
use super::*;
use crate::field::{CrossField, FieldOptions, Symmetry, cross_field, feature_edges};
use crate::geometry::{IntrinsicTriangulation, vertex_frames};
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerEdge, PerFace, PerVertex, Surface, VertexId};
use crate::periodic::{GridMap, QuarterTurn, Transition};
use crate::watch::Watch;

fn surface(fixture: Fixture) -> Surface {
    Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
}

fn options(density: GridDensity) -> IntegerGridOptions {
    IntegerGridOptions {
        density,
        ..IntegerGridOptions::default()
    }
}

fn map_of(surface: &Surface, field: &CrossField, options: &IntegerGridOptions) -> IntegerGridMap {
    integer_grid_map(surface, field, options, &Watch::new()).unwrap()
}

/// The map along a field that follows curvature, boundary and sharp edges.
fn smooth_map(surface: &Surface, density: GridDensity) -> IntegerGridMap {
    let field = cross_field(surface, &FieldOptions::default(), &Watch::new())
        .unwrap()
        .field;
    let features = feature_edges(surface, PI / 3.0, 1);
    map_of(
        surface,
        &field,
        &IntegerGridOptions {
            features,
            ..options(density)
        },
    )
}

/// A field along a direction in space.
fn field_along(surface: &Surface, direction: impl Fn(DVec3) -> DVec3) -> CrossField {
    let frames = vertex_frames(surface);
    let angles = PerVertex::from_fn(surface.mesh().vertex_count(), |vertex: VertexId| {
        let along = frames[vertex].project(direction(surface.position(vertex)));
        libm::atan2(along.y, along.x)
    });
    CrossField::from_angles(Symmetry::Cross, angles)
}

fn round(surface: &Surface, map: &GridMap, vertex: VertexId) -> Transition {
    let sides = surface.mesh().outgoing(vertex).map(HalfedgeId::previous);
    let steps = sides.filter_map(|side| map.transition(side));
    steps.fold(Transition::identity(), Transition::then)
}

fn singular_vertices(surface: &Surface, map: &GridMap) -> Vec<VertexId> {
    let inside = surface
        .mesh()
        .vertices()
        .filter(|&v| !surface.mesh().is_boundary_vertex(v));
    inside
        .filter(|&vertex| !round(surface, map, vertex).is_identity())
        .collect()
}

fn assert_regular(surface: &Surface, found: &IntegerGridMap) {
    assert_eq!(found.report.flips, 0);
    for face in surface.mesh().faces() {
        let [a, b, c] = found.map.face_coordinates(face);
        assert!((b - a).perp_dot(c - a) > 0.0, "{face}");
    }
    for vertex in singular_vertices(surface, &found.map) {
        let corner = surface.mesh().vertex_halfedge(vertex);
        assert_eq!(
            found.map.coordinate(corner),
            found.map.coordinate(corner).round()
        );
    }
}

fn is_whole(value: f64) -> bool {
    value.fract() == 0.0
}

#[test]
fn a_plane_with_a_constant_field_gets_its_own_coordinates() {
    let plane = surface(grid(4.0, 3.0, 8, 6));
    let field = field_along(&plane, |_| DVec3::X);
    let found = map_of(&plane, &field, &options(GridDensity::EdgeLength(0.5)));
    assert_eq!(found.report.singular_vertices, 0);
    assert!((found.report.cells - 48.0).abs() < 1e-9);
    assert!(found.report.gradient_error < 1e-9, "{:?}", found.report);
    for corner in plane.mesh().halfedges() {
        let point = found.map.coordinate(corner);
        assert!(point.distance(point.round()) < 1e-8, "{point}");
    }
    assert_regular(&plane, &found);
}

#[test]
fn a_torus_with_a_field_along_its_circles_has_no_irregular_point() {
    let torus = surface(torus(2.0, 0.7, 40, 16));
    let field = field_along(&torus, |p| DVec3::new(-p.y, p.x, 0.0));
    let found = map_of(&torus, &field, &options(GridDensity::Quads(500)));
    assert!(singular_vertices(&torus, &found.map).is_empty());
    assert!(
        (found.report.cells / 500.0 - 1.0).abs() < 0.1,
        "{:?}",
        found.report
    );
    assert!(is_whole((found.report.cells * 1e6).round() / 1e6));
    assert_regular(&torus, &found);
}

#[test]
fn a_cube_has_eight_irregular_points_and_exact_squares() {
    let cube = surface(cube().subdivided().subdivided().subdivided());
    let found = smooth_map(&cube, GridDensity::EdgeLength(0.25));
    assert_eq!(singular_vertices(&cube, &found.map).len(), 8);
    assert!(
        (found.report.cells - 96.0).abs() < 1e-6,
        "{:?}",
        found.report
    );
    assert!(found.report.gradient_error < 1e-6, "{:?}", found.report);
    assert_regular(&cube, &found);
}

#[test]
fn a_sphere_is_covered_without_flips_down_to_few_quads() {
    let sphere = surface(icosphere(3));
    for quads in [60, 300, 3000] {
        let found = smooth_map(&sphere, GridDensity::Quads(quads));
        assert_regular(&sphere, &found);
        let turns = singular_vertices(&sphere, &found.map).into_iter();
        let turns = turns.map(|v| i32::from(round(&sphere, &found.map, v).turn.quarters()));
        assert_eq!(turns.sum::<i32>() % 4, 0);
        assert_eq!(found.report.singular_vertices, 8);
    }
}

#[test]
fn the_number_of_cells_is_the_number_asked_for() {
    let sphere = surface(icosphere(4));
    for quads in [500, 2000, 50_000] {
        let cells = smooth_map(&sphere, GridDensity::Quads(quads)).report.cells;
        assert!(
            (cells / quads as f64 - 1.0).abs() < 0.03,
            "{cells} for {quads}"
        );
    }
}

#[test]
fn lines_run_along_boundaries() {
    let cases = [
        cylinder_patch(1.0, 2.0, 32, 10),
        annulus(0.5, 1.0, 48, 8),
        disk(10),
    ];
    for fixture in cases {
        let surface = surface(fixture);
        let found = smooth_map(&surface, GridDensity::Quads(200));
        let report = &found.report;
        assert_eq!(
            (report.dropped_edges, report.released_vertices),
            (0, 0),
            "{report:?}"
        );
        for boundary in surface.mesh().boundary_loops() {
            for &side in surface.mesh().boundary_loop(boundary) {
                let [a, b] = [side, side.next()].map(|corner| found.map.coordinate(corner));
                let along = |c: usize| is_whole(a[c]) && a[c].to_bits() == b[c].to_bits();
                assert!(along(0) || along(1), "{a} {b}");
            }
        }
        assert_regular(&surface, &found);
    }
}

#[test]
fn without_alignment_boundaries_are_free() {
    let plane = surface(grid(3.1, 2.3, 9, 7));
    let field = field_along(&plane, |_| DVec3::new(1.0, 0.4, 0.0));
    let options = IntegerGridOptions {
        align_boundary: false,
        ..options(GridDensity::EdgeLength(0.4))
    };
    let found = map_of(&plane, &field, &options);
    assert!((found.report.cells - 3.1 * 2.3 / 0.16).abs() < 1e-6);
    assert!(found.report.gradient_error < 1e-9);
    assert_regular(&plane, &found);
}

#[test]
fn batches_of_whole_numbers_make_a_map_as_well() {
    let sphere = surface(icosphere(3));
    let field = cross_field(&sphere, &FieldOptions::default(), &Watch::new())
        .unwrap()
        .field;
    let options = options(GridDensity::Quads(600));
    let watch = Watch::new();
    let draft = Draft::of(sphere, &field, &options, &watch).unwrap();
    let mut net = nets(vec![draft], &watch).unwrap().remove(0);
    let dense = net.solve(20.0, &watch).unwrap();
    let (cells, [error, _]) = (dense.cells, net.gradient_errors(&dense));
    net.sum_up_in_batches().unwrap();
    let batched = net.solve(20.0, &watch).unwrap();
    assert!((batched.cells / cells - 1.0).abs() < 0.05);
    assert!(net.gradient_errors(&batched)[0] < 2.25 * error);
}

#[test]
fn one_preparation_serves_every_density() {
    let sphere = surface(icosphere(3));
    let field = cross_field(&sphere, &FieldOptions::default(), &Watch::new())
        .unwrap()
        .field;
    let mut grid = IntegerGrid::of(
        &sphere,
        &field,
        &IntegerGridOptions::default(),
        &Watch::new(),
    )
    .unwrap();
    for quads in [2000, 300] {
        let density = GridDensity::Quads(quads);
        let made = grid.map(density, &Watch::new()).unwrap();
        assert_eq!(made, map_of(&sphere, &field, &options(density)));
    }
}

#[test]
fn the_order_of_components_changes_nothing() {
    let ring = torus(2.0, 0.7, 40, 16);
    let ball = icosphere(3).map(|p| p + DVec3::X * 10.0);
    let block = cube().subdivided().subdivided();
    let block = block.map(|p| p - DVec3::X * 8.0);
    let [one, other] = [[&ring, &ball, &block], [&block, &ring, &ball]].map(joined_map);
    assert_eq!(one.report.cells.to_bits(), other.report.cells.to_bits());
    let places = |fixture: &Fixture| 3 * fixture.triangles.len() as u32;
    let moved = places(&ring) + places(&ball);
    for corner in 0..moved + places(&block) {
        let shift = if corner < moved { places(&block) } else { 0 };
        let elsewhere = HalfedgeId(if shift > 0 {
            corner + shift
        } else {
            corner - moved
        });
        let corner = HalfedgeId(corner);
        assert_eq!(one.map.coordinate(corner), other.map.coordinate(elsewhere));
        let turned = one.map.transition(corner);
        assert_eq!(turned, other.map.transition(elsewhere));
    }
}

/// The map of several components along the fields that each has by itself.
fn joined_map(parts: [&Fixture; 3]) -> IntegerGridMap {
    let angles = parts.iter().flat_map(|&part| {
        let part = surface(part.clone());
        let field = cross_field(&part, &FieldOptions::default(), &Watch::new());
        field
            .unwrap()
            .field
            .angles()
            .iter()
            .copied()
            .collect::<Vec<f64>>()
    });
    let field = CrossField::from_angles(Symmetry::Cross, PerVertex::new(angles.collect()));
    let [first, second, third] = parts;
    let all = surface(first.clone().joined(second).joined(third));
    let features = feature_edges(&all, PI / 3.0, 1);
    let density = GridDensity::Quads(600);
    let options = IntegerGridOptions {
        features,
        ..options(density)
    };
    map_of(&all, &field, &options)
}

#[test]
fn components_do_not_disturb_each_other() {
    let both = torus(2.0, 0.7, 40, 16).joined(&icosphere(3).map(|p| p + DVec3::X * 10.0));
    let surface = surface(both);
    let found = smooth_map(&surface, GridDensity::Quads(600));
    assert_eq!(found.report.singular_vertices, 8);
    assert_regular(&surface, &found);
}

#[test]
fn scaling_changes_no_digit() {
    let fixture = icosphere(3);
    let own = surface(fixture.clone());
    let field = cross_field(&own, &FieldOptions::default(), &Watch::new())
        .unwrap()
        .field;
    let expected = map_of(&own, &field, &options(GridDensity::Quads(400)));
    for exponent in [-40, 40] {
        let scaled = surface(fixture.clone().map(|p| p * f64::powi(2.0, exponent)));
        let found = map_of(&scaled, &field, &options(GridDensity::Quads(400)));
        assert_eq!(found.map, expected.map);
    }
}

#[test]
fn singular_vertices_add_up_for_any_field() {
    for (fixture, euler) in [(icosphere(2), 2), (torus(2.0, 0.7, 20, 10), 0), (cube(), 2)] {
        let surface = surface(fixture);
        let mesh = surface.mesh();
        let triangulation = IntrinsicTriangulation::of(&surface).unwrap();
        for seed in 0..5 {
            let mut noise = Noise::new(seed);
            let angles = PerVertex::from_fn(mesh.vertex_count(), |_| PI * noise.signed());
            let field = CrossField::from_angles(Symmetry::Cross, angles);
            let wished = PerVertex::filled(mesh.vertex_count(), None);
            let mut frames = FaceFrames::of(mesh, &triangulation, &field, &wished);
            assert_eq!(frames.steps.iter().sum::<i32>(), 4 * euler);
            check_turns(&surface, &frames).unwrap();
            let forest = DualForest::of(mesh, &PerEdge::filled(mesh.edge_count(), false));
            frames.straighten(mesh, &forest);
            check_turns(&surface, &frames).unwrap();
            for &(_, entered) in &forest.order {
                assert!(entered.is_none_or(|from| frames.turns[from] == QuarterTurn::NONE));
            }
        }
    }
}

#[test]
fn a_plan_with_known_coordinates_gives_them_back() {
    let patch = surface(disk(5));
    let mesh = patch.mesh();
    let triangulation = IntrinsicTriangulation::of(&patch).unwrap();
    let known = |vertex: VertexId| patch.position(vertex).truncate() * 3.0 + DVec2::new(2.0, 1.0);
    let mut noise = Noise::new(8);
    let charts = PerFace::from_fn(mesh.face_count(), |_: FaceId| Transition {
        turn: QuarterTurn::of_quarters((noise.unit() * 4.0) as i32),
        shift: [(noise.signed() * 9.0) as i32, (noise.signed() * 9.0) as i32],
    });
    let corners = PerCorner::from_fn(mesh.halfedge_count(), |h: HalfedgeId| charts[h.face()]);
    let wishes = PerCorner::from_fn(mesh.halfedge_count(), |h: HalfedgeId| {
        charts[h.face()]
            .turn
            .apply(known(mesh.destination(h)) - known(mesh.origin(h)))
    });
    let left_out = PerFace::from_fn(mesh.face_count(), |face: FaceId| face.0 == 7);
    let first = known(VertexId(0));
    for given in [
        vec![(VertexId(0), 0, first.x), (VertexId(0), 1, first.y)],
        Vec::new(),
    ] {
        let plan = NetPlan {
            corners: &corners,
            wishes: &wishes,
            left_out: &left_out,
            given: &given,
        };
        let found = poisson_net(mesh, patch.positions(), &triangulation, &plan).unwrap();
        let moved = if given.is_empty() { first } else { DVec2::ZERO };
        for vertex in mesh.vertices() {
            assert!(found[vertex].distance(known(vertex) - moved) < 1e-9);
        }
    }
}

#[test]
fn what_is_asked_for_is_checked() {
    let sphere = surface(icosphere(1));
    let count = sphere.mesh().vertex_count();
    let zero = |symmetry, count| CrossField::from_angles(symmetry, PerVertex::filled(count, 0.0));
    let good = zero(Symmetry::Cross, count);
    let refusal = |field: &CrossField, options: IntegerGridOptions| {
        integer_grid_map(&sphere, field, &options, &Watch::new()).unwrap_err()
    };
    for density in [
        GridDensity::EdgeLength(0.0),
        GridDensity::EdgeLength(f64::NAN),
        GridDensity::Quads(0),
    ] {
        let refused = refusal(&good, options(density));
        assert!(matches!(refused, IntegerGridError::Option { .. }));
    }
    let edges = wanted_edges(sphere.mesh(), &[], true);
    assert!(edges.is_empty());
    let far = crate::mesh::EdgeId(9999);
    let beyond = IntegerGridOptions {
        features: vec![far],
        ..IntegerGridOptions::default()
    };
    assert!(matches!(
        refusal(&good, beyond),
        IntegerGridError::NoSuchEdge { .. }
    ));
    for wrong in [zero(Symmetry::Line, count), zero(Symmetry::Cross, 3)] {
        let refused = refusal(&wrong, IntegerGridOptions::default());
        assert!(matches!(refused, IntegerGridError::Field { .. }));
    }
    let sizing = Some(PerVertex::filled(count, -1.0));
    let negative = IntegerGridOptions {
        sizing,
        ..IntegerGridOptions::default()
    };
    assert!(matches!(
        refusal(&good, negative),
        IntegerGridError::Option { .. }
    ));
}

/// Two pyramids of three sides, tip to tip, joined by a ring of three vertices next to one point: a neck
/// of no width, whose triangles are needles.
fn hourglass() -> Surface {
    let rings = [
        (-2.0, 1.0),
        (-1.0, 0.8),
        (0.0, 1e-12),
        (1.0, 0.8),
        (2.0, 1.0),
    ];
    let mut fixture = Fixture {
        positions: vec![DVec3::new(0.0, 0.0, -2.2), DVec3::new(0.0, 0.0, 2.2)],
        triangles: Vec::new(),
    };
    for (z, radius) in rings {
        for corner in 0..3 {
            let (sin, cos) = libm::sincos(f64::from(corner) * std::f64::consts::TAU / 3.0);
            fixture
                .positions
                .push(DVec3::new(radius * cos, radius * sin, z));
        }
    }
    let at = |ring: u32, corner: u32| 2 + 3 * ring + corner % 3;
    for corner in 0..3 {
        fixture
            .triangles
            .push([0, at(0, corner + 1), at(0, corner)]);
        fixture
            .triangles
            .push([1, at(4, corner), at(4, corner + 1)]);
        for ring in 0..4 {
            let [a, b] = [at(ring, corner), at(ring, corner + 1)];
            let [c, d] = [at(ring + 1, corner + 1), at(ring + 1, corner)];
            fixture.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
}

#[test]
fn a_neck_of_no_width_leaves_the_equations_regular() {
    let coarse = hourglass();
    let watch = Watch::new();
    // Parts of needles are needles, and some have no other neighbours.
    let fine = crate::mesh::refine(&coarse, 0.2, &watch).unwrap();
    for surface in [&coarse, &fine.refined.surface] {
        let field = cross_field(surface, &FieldOptions::default(), &watch).unwrap();
        let options = options(GridDensity::Quads(200));
        let made = integer_grid_map(surface, &field.field, &options, &watch).unwrap();
        assert!(made.report.cells.is_finite());
    }
}

#[test]
fn cells_of_a_cylinder_are_stretched_along_it() {
    let flat = grid(1.0, 1.0, 40, 40);
    let tube = flat.map(|p| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * p.x);
        DVec3::new(cos, sin, std::f64::consts::TAU * p.y)
    });
    let surface = Surface::from_triangles(tube.positions, &tube.triangles).unwrap();
    let field = cross_field(&surface, &FieldOptions::default(), &Watch::new()).unwrap();
    let along = field.curvatures.as_ref().unwrap().map(|curvature| Stretch {
        direction: curvature.direction + std::f64::consts::FRAC_PI_2,
        ratio: 4.0,
    });
    let options = IntegerGridOptions {
        stretch: Some(along),
        ..options(GridDensity::Quads(400))
    };
    let made = integer_grid_map(&surface, &field.field, &options, &Watch::new()).unwrap();
    let (mut along, mut around) = (0.0, 0.0);
    for corner in surface.mesh().halfedges() {
        let side = surface.halfedge_vector(corner);
        let [from, to] = [corner, corner.next()].map(|c| made.map.coordinate(c));
        let lines = from.distance(to);
        if side.truncate().length() < 1e-9 {
            along += lines / side.length();
        } else if side.z.abs() < 1e-9 {
            around += lines / side.length();
        }
    }
    let ratio = around / along;
    assert!((3.2..4.8).contains(&ratio), "{ratio}");
    assert!(
        (made.report.cells - 400.0).abs() < 20.0,
        "{}",
        made.report.cells
    );
}

#[test]
fn a_stretch_that_is_none_is_refused() {
    let surface = surface(icosphere(1));
    let count = surface.mesh().vertex_count();
    let field = cross_field(&surface, &FieldOptions::default(), &Watch::new()).unwrap();
    for (given, direction, ratio) in [(count, 0.0, 0.5), (count, f64::NAN, 2.0), (3, 0.0, 2.0)] {
        let stretch = Some(PerVertex::filled(given, Stretch { direction, ratio }));
        let wanted = IntegerGridOptions {
            stretch,
            ..options(GridDensity::Quads(100))
        };
        let refused = integer_grid_map(&surface, &field.field, &wanted, &Watch::new());
        assert!(refused.is_err(), "{given} {direction} {ratio}");
    }
}
