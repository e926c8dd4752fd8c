//! Layouts of whole surfaces: validity everywhere.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use graticule_fixtures::{
    Fixture, Noise, annulus, block_with_holes, cube, cylinder_patch, disk, grid,
    grid_with_flat_triangles, icosphere, needles, torus,
};

use super::{
    ArcKind, ChartKind, ChartLayout, ChartLines, LayoutMap, LayoutOptions, LayoutReport,
    base_complex, chart_layout, layout_from_map,
};
use crate::geometry::{face_areas, face_shapes};
use crate::mesh::{Element, FaceId, HalfedgeId, Surface, Topology};
use crate::periodic::{ChartSize, ParameterizeOptions};
use crate::quads::tests::map_of;
use crate::watch::Watch;

fn surface_of(fixture: Fixture) -> Surface {
    Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
}

fn with_size(size: ChartSize, map: LayoutMap) -> LayoutOptions {
    LayoutOptions {
        coordinates: ParameterizeOptions {
            chart_size: size,
            ..ParameterizeOptions::default()
        },
        map,
        ..LayoutOptions::default()
    }
}

/// Checks all that a layout promises.
fn assert_valid(layout: &ChartLayout, input: &Surface, name: &str) {
    layout
        .check_areas(input)
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    let mesh = layout.surface().mesh();
    let mut sides = vec![0; layout.arcs().len()];
    for (arc, _) in layout
        .charts()
        .iter()
        .flat_map(|chart| chart.sides.iter().flatten())
    {
        sides[arc.index()] += 1;
    }
    for (arc, sides) in layout.arcs().iter().zip(sides) {
        let expected = if arc.kind == ArcKind::Boundary { 1 } else { 2 };
        assert_eq!(sides, expected, "{name}: {arc:?}");
    }
    for face in mesh.faces() {
        let points = face.halfedges().map(|corner| layout.coordinates()[corner]);
        let regular = layout.chart(layout.chart_of()[face]).kind == ChartKind::Regular;
        assert_eq!(points.iter().all(Option::is_some), regular, "{name}");
        if let [Some(a), Some(b), Some(c)] = points {
            assert!((b - a).perp_dot(c - a) > 0.0, "{name}: {face}");
        }
    }
    for vertex in mesh.vertices() {
        let there = layout.refined().vertex_origin[vertex].position(input);
        assert_eq!(there, layout.surface().position(vertex), "{name}");
    }
    let complex = base_complex(layout);
    let expected = Topology::of(input.mesh()).total.euler_characteristic;
    assert_eq!(complex.euler_characteristic(), expected, "{name}");
    complex
        .mesh
        .check(input)
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    let valences: u32 = complex.valences().iter().sum();
    assert_eq!(valences as usize, 2 * layout.arcs().len(), "{name}");
    assert_transitions_agree(layout, name);
}

/// Checks that coordinates agree on both sides of the arcs between regular charts.
fn assert_transitions_agree(layout: &ChartLayout, name: &str) {
    let mesh = layout.surface().mesh();
    let is_closed = mesh.boundary_loop_count() == 0;
    let complex = base_complex(layout);
    for (chart, neighbors) in complex.neighbors.iter().enumerate() {
        for neighbor in neighbors {
            let Some(transition) = neighbor.transition else {
                continue;
            };
            let quarters = transition.shift * 4.0;
            assert!(!is_closed || quarters == quarters.round(), "{name}");
            for &vertex in &layout.arc(neighbor.arc).vertices {
                let point_in = |wanted: usize| -> DVec2 {
                    let corner = (mesh.outgoing(vertex))
                        .find(|corner| layout.chart_of()[corner.face()].index() == wanted);
                    layout.coordinates()[corner.unwrap()].unwrap()
                };
                let beyond = point_in(neighbor.chart.unwrap().index());
                let miss = transition.apply(point_in(chart)).distance(beyond);
                assert!(miss < 1e-9, "{name}: {miss:e}");
            }
        }
    }
}

fn smallest_area(layout: &ChartLayout) -> f64 {
    let areas = face_areas(&face_shapes(layout.surface()));
    areas.iter().copied().fold(f64::INFINITY, f64::min)
}

fn lay_out(surface: &Surface, options: &LayoutOptions, name: &str) -> (ChartLayout, LayoutReport) {
    let found = chart_layout(surface, options, &Watch::new());
    let found = found.unwrap_or_else(|error| panic!("{name}: {error}"));
    assert_valid(&found.layout, surface, name);
    (found.layout, found.report)
}

#[test]
fn every_surface_has_a_valid_layout_from_either_map() {
    let shapes = [
        ("sphere", icosphere(3)),
        ("torus", torus(2.0, 0.7, 40, 20)),
        ("cube", cube().subdivided().subdivided().subdivided()),
        ("grid", grid(3.0, 2.0, 15, 10)),
        ("disk", disk(8)),
        ("annulus", annulus(1.0, 2.0, 30, 8)),
        ("tube", cylinder_patch(0.2, 3.0, 8, 40)),
        ("block", block_with_holes(2).subdivided().subdivided()),
    ];
    for (name, fixture) in shapes {
        let surface = surface_of(fixture);
        for map in [LayoutMap::Periodic, LayoutMap::IntegerGrid] {
            for size in [3.0, 10.0] {
                let options = with_size(ChartSize::MeanEdges(size), map);
                let (layout, _) = lay_out(&surface, &options, name);
                assert!(smallest_area(&layout) > 0.0, "{name}");
            }
        }
    }
}

#[test]
fn coarse_and_hostile_surfaces_have_layouts_too() {
    let shapes = [
        ("tetrahedron", {
            let corners = [
                [1.0, 1.0, 1.0],
                [-1.0, -1.0, 1.0],
                [-1.0, 1.0, -1.0],
                [1.0, -1.0, -1.0],
            ];
            Fixture {
                positions: corners.map(DVec3::from_array).to_vec(),
                triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
            }
        }),
        ("cube", cube()),
        ("flat triangles", grid_with_flat_triangles(6, 4)),
        ("needles", needles(6, 100.0, 3)),
    ];
    for (name, fixture) in shapes {
        let surface = surface_of(fixture);
        for size in [0.2, 1.0, 100.0] {
            let options = with_size(ChartSize::MeanEdges(size), LayoutMap::Periodic);
            lay_out(&surface, &options, &format!("{name} at {size}"));
        }
    }
}

#[test]
fn random_maps_give_valid_layouts() {
    let shapes = [
        torus(2.0, 0.7, 12, 8),
        disk(4),
        cube().subdivided(),
        icosphere(1),
    ];
    for (number, fixture) in shapes.into_iter().enumerate() {
        let surface = surface_of(fixture);
        let mesh = surface.mesh();
        for seed in 0..15 {
            let mut noise = Noise::new(seed);
            let points: Vec<DVec2> = (0..mesh.vertex_count())
                .map(|_| DVec2::new(noise.signed(), noise.signed()) * 2.5)
                .collect();
            let left_out: Vec<FaceId> = mesh.faces().filter(|_| noise.unit() < 0.05).collect();
            let map = map_of(&surface, |c| points[mesh.origin(c).index()], &left_out);
            for lines in [ChartLines::All, ChartLines::Rectangles(2)] {
                let name = format!("{number} {seed} {lines:?}");
                let found = layout_from_map(&surface, &map, &[], lines, &Watch::new());
                let (layout, _) = found.unwrap_or_else(|error| panic!("{name}: {error}"));
                assert_valid(&layout, &surface, &name);
            }
        }
    }
}

#[test]
fn a_square_with_a_straight_map_is_cut_into_unit_squares() {
    let surface = surface_of(grid(3.0, 2.0, 7, 5));
    let map = map_of(
        &surface,
        |corner| surface.position(surface.mesh().origin(corner)).truncate(),
        &[],
    );
    let (layout, report) =
        layout_from_map(&surface, &map, &[], ChartLines::All, &Watch::new()).unwrap();
    assert_valid(&layout, &surface, "square");
    assert_eq!([report.nodes, report.arcs, report.charts], [12, 17, 6]);
    assert_eq!([report.regular, report.t_junctions], [6, 0]);
    let areas = face_areas(&face_shapes(layout.surface()));
    for chart in 0..6 {
        let faces = layout
            .chart_of()
            .enumerate()
            .filter(|(_, of)| of.index() == chart);
        let area: f64 = faces.map(|(face, _)| areas[face]).sum();
        // Coordinates of a map are multiples of 2^-32.
        assert!((area - 1.0).abs() < 1e-9, "{area}");
    }
}

#[test]
fn a_close_net_on_a_square_is_cut_into_rectangles_of_the_size_asked_for() {
    let surface = surface_of(grid(3.0, 2.0, 7, 5));
    let place = |corner| surface.position(surface.mesh().origin(corner)).truncate() * 4.0;
    let map = map_of(&surface, place, &[]);
    for (spacings, charts) in [(4, 6), (6, 2), (12, 1), (2, 24)] {
        let lines = ChartLines::Rectangles(spacings);
        let found = layout_from_map(&surface, &map, &[], lines, &Watch::new());
        let (layout, report) = found.unwrap();
        assert_valid(&layout, &surface, "square");
        assert_eq!([report.charts, report.regular], [charts; 2], "{spacings}");
    }
}

#[test]
fn singular_points_of_an_integer_grid_map_are_corners_of_rectangles() {
    let shapes = [
        ("sphere", icosphere(4)),
        ("torus", torus(2.0, 0.7, 40, 20)),
        (
            "cube",
            cube().subdivided().subdivided().subdivided().subdivided(),
        ),
        ("annulus", annulus(1.0, 2.0, 30, 8)),
    ];
    for (name, fixture) in shapes {
        let surface = surface_of(fixture);
        for size in [6.0, 30.0] {
            let options = with_size(ChartSize::MeanEdges(size), LayoutMap::IntegerGrid);
            let (_, report) = lay_out(&surface, &options, name);
            assert_eq!(
                report.regular, report.charts,
                "{name} at {size}: {report:?}"
            );
        }
    }
}

#[test]
fn features_that_no_line_follows_are_no_arcs_of_rectangles() {
    let surface = surface_of(grid(3.0, 3.0, 9, 9));
    let mesh = surface.mesh();
    let lies = |edge, is_on: &dyn Fn(DVec3) -> bool| {
        let ends = mesh.ends(mesh.edge_halfedge(edge));
        ends.iter().all(|&vertex| is_on(surface.position(vertex)))
    };
    let place = |corner| surface.position(mesh.origin(corner)).truncate();
    let map = map_of(&surface, place, &[]);
    let followed = |point: DVec3| (point.y - 1.0).abs() < 1e-9 && point.x < 2.4;
    let crossed = |point: DVec3| (point.x - point.y).abs() < 1e-9;
    for (is_on, length) in [(&followed as &dyn Fn(DVec3) -> bool, 2.0), (&crossed, 0.0)] {
        let features: Vec<_> = mesh.edges().filter(|&edge| lies(edge, is_on)).collect();
        assert!(features.len() > 3);
        let lines = ChartLines::Rectangles(3);
        let found = layout_from_map(&surface, &map, &features, lines, &Watch::new());
        let (layout, report) = found.unwrap();
        assert_valid(&layout, &surface, "features");
        assert_eq!(report.regular, report.charts);
        let arcs = (layout.arcs().iter()).filter(|arc| arc.kind == ArcKind::Feature);
        let places = |vertex| layout.surface().position(vertex);
        let found: f64 = (arcs.flat_map(|arc| arc.vertices.windows(2)))
            .map(|ends| places(ends[0]).distance(places(ends[1])))
            .sum();
        assert!((found - length).abs() < 0.4, "{found} of {length}");
    }
}

#[test]
fn charts_that_close_round_a_tube_get_closer_lines() {
    let surface = surface_of(cylinder_patch(0.25, 6.0, 16, 60));
    let position = |corner| surface.position(surface.mesh().origin(corner));
    let angle = |point: DVec3| point.y.atan2(point.x) / TAU;
    // One line along the tube, so that charts between the lines across touch themselves.
    let place = |corner: HalfedgeId| {
        let first = angle(position(corner.face().halfedges()[0]));
        let here = angle(position(corner));
        DVec2::new(
            here - (here - first).round() + 0.3,
            position(corner).z + 0.25,
        )
    };
    let map = map_of(&surface, place, &[]);
    let watch = Watch::new();
    let (layout, report) = layout_from_map(&surface, &map, &[], ChartLines::All, &watch).unwrap();
    assert_valid(&layout, &surface, "tube");
    assert!(report.refined_charts > 0, "{report:?}");
    assert_eq!([report.split_charts, report.polygonal], [0, 0]);
    let codes: Vec<_> = watch
        .warnings()
        .iter()
        .map(|warning| warning.code)
        .collect();
    assert_eq!(codes, ["charts-refined"]);
}

#[test]
fn a_tube_without_any_line_is_cut_along_edges() {
    let surface = surface_of(cylinder_patch(0.25, 3.0, 16, 30));
    let all: Vec<FaceId> = surface.mesh().faces().collect();
    let map = map_of(&surface, |_| DVec2::ZERO, &all);
    let watch = Watch::new();
    let (layout, report) = layout_from_map(&surface, &map, &[], ChartLines::All, &watch).unwrap();
    assert_valid(&layout, &surface, "tube");
    assert_eq!(report.regular, 0);
    assert_eq!(report.left_out_triangles, all.len());
    let codes: Vec<_> = watch
        .warnings()
        .iter()
        .map(|warning| warning.code)
        .collect();
    assert!(codes.contains(&"charts-split"), "{codes:?}");
}

#[test]
fn features_are_arcs() {
    let surface = surface_of(grid(3.0, 3.0, 9, 9));
    let mesh = surface.mesh();
    let on_diagonal = |edge| {
        let ends = mesh
            .ends(mesh.edge_halfedge(edge))
            .map(|v| surface.position(v));
        ends.iter().all(|p| (p.x - p.y).abs() < 1e-9)
    };
    let features: Vec<_> = mesh.edges().filter(|&edge| on_diagonal(edge)).collect();
    let place = |corner| surface.position(mesh.origin(corner)).truncate() + 0.37;
    let map = map_of(&surface, place, &[]);
    let (layout, _) =
        layout_from_map(&surface, &map, &features, ChartLines::All, &Watch::new()).unwrap();
    assert_valid(&layout, &surface, "features");
    let length: f64 = (layout.arcs().iter())
        .filter(|arc| arc.kind == ArcKind::Feature)
        .flat_map(|arc| arc.vertices.windows(2))
        .map(|ends| {
            layout
                .surface()
                .position(ends[0])
                .distance(layout.surface().position(ends[1]))
        })
        .sum();
    assert!((length - 18.0_f64.sqrt()).abs() < 1e-9, "{length}");
}

#[test]
fn scaling_changes_nothing() {
    let fixture = icosphere(3);
    let options = with_size(ChartSize::MeanEdges(5.0), LayoutMap::Periodic);
    let [small, plain, large] = [-40, 0, 40].map(|exponent| {
        let scaled = fixture.clone().map(|point| point * 2.0_f64.powi(exponent));
        lay_out(&surface_of(scaled), &options, "scaled").0
    });
    for other in [small, large] {
        assert_eq!(other.arcs(), plain.arcs());
        assert_eq!(other.charts(), plain.charts());
        assert_eq!(other.coordinates(), plain.coordinates());
    }
}
