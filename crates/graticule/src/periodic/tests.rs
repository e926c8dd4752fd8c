//! [`parameterize`] and the energy behind it.
#![allow(clippy::float_cmp, reason = "exactness is what is tested")]

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec2;
use graticule_fixtures::{
    Fixture, Noise, cube, cylinder_patch, disk, grid, icosphere, irregular_disk, torus,
};

use super::energy::{phase_graph, rotor};
use super::hierarchy::phases_from_coarse;
use super::phase_graph::NodeOrder;
use super::*;
use crate::field::{
    CrossField, CurlOptions, FieldOptions, FieldResult, Symmetry, cross_field, feature_edges,
};
use crate::geometry::{IntrinsicTriangulation, intrinsic_delaunay};
use crate::measure::SourceTriangle;
use crate::mesh::{EdgeId, Element, PerVertex, Surface, VertexId};
use crate::watch::Watch;

mod meshing;

fn surface(fixture: Fixture) -> Surface {
    Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
}

/// The same direction everywhere in the plane, as any of the four of a cross.
fn straight_field(surface: &Surface, angle: f64) -> CrossField {
    let mut noise = Noise::new(5);
    let angles = PerVertex::from_fn(surface.mesh().vertex_count(), |vertex| {
        let first = surface.halfedge_vector(surface.mesh().vertex_halfedge(vertex));
        let quarter = noise.below(4) as f64 * FRAC_PI_2;
        angle - libm::atan2(first.y, first.x) + quarter
    });
    CrossField::from_angles(Symmetry::Cross, angles)
}

fn random_field(surface: &Surface, seed: u64) -> CrossField {
    let mut noise = Noise::new(seed);
    let count = surface.mesh().vertex_count();
    let angles = PerVertex::from_fn(count, |_: VertexId| TAU * noise.unit());
    CrossField::from_angles(Symmetry::Cross, angles)
}

fn random_phases(count: usize, seed: u64) -> PerVertex<Phases> {
    let mut noise = Noise::new(seed);
    PerVertex::from_fn(count, |_: VertexId| {
        [rotor(noise.unit()), rotor(noise.unit())]
    })
}

fn field_of(surface: &Surface, curl_correction: bool) -> FieldResult {
    let options = FieldOptions {
        curl_correction: curl_correction.then(CurlOptions::default),
        ..FieldOptions::default()
    };
    cross_field(surface, &options, &Watch::new()).unwrap()
}

fn covered(
    surface: &Surface,
    field: &FieldResult,
    options: &ParameterizeOptions,
) -> Parameterization {
    let scale = field.scale.as_ref();
    parameterize(surface, &field.field, scale, options, &Watch::new()).unwrap()
}

fn edges(size: f64) -> ParameterizeOptions {
    ParameterizeOptions {
        chart_size: ChartSize::MeanEdges(size),
        ..ParameterizeOptions::default()
    }
}

fn as_numbered(vertices: usize) -> NodeOrder {
    let starts = random_phases(vertices, 21);
    NodeOrder {
        nodes: (0..2 * vertices as u32).collect(),
        starts_from: starts.iter().flatten().copied().collect(),
    }
}

fn one(count: usize, value: f64) -> PerVertex<f64> {
    PerVertex::filled(count, value)
}

#[test]
fn quarter_turns_of_phases_are_those_of_their_coordinates() {
    let mut noise = Noise::new(1);
    for _ in 0..20 {
        let place = DVec2::new(noise.signed(), noise.signed());
        let phases = |p: DVec2| [rotor(p.x), rotor(p.y)];
        for quarters in 0..4 {
            let turn = QuarterTurn::of_quarters(quarters);
            let turned = turned_phases(phases(place), turn);
            let expected = phases(turn.inverse().apply(place));
            assert!((0..2).all(|k| turned[k].distance(expected[k]) < 1e-12));
        }
        let once = |p| turned_phases(p, QuarterTurn::LEFT);
        let own = phases(place);
        assert_eq!(once(once(once(once(own)))), own);
        assert_eq!(
            once(once(own)),
            [0, 1].map(|k| DVec2::new(own[k].x, -own[k].y))
        );
        // Lines at whole coordinates stay: what is 1 stays 1.
        assert_eq!(once([DVec2::X; 2]), [DVec2::X; 2]);
    }
}

#[test]
fn steps_from_both_ends_agree() {
    let sphere = surface(icosphere(2));
    let own = IntrinsicTriangulation::of(&sphere).unwrap();
    let steps = edge_steps(&own, &random_field(&sphere, 2), &one(162, 3.0));
    for edge in own.edges() {
        let step = steps.of_edge(edge);
        assert_eq!(step.reversed().reversed(), step);
        let [p, q] = [DVec2::new(0.3, -0.4), DVec2::new(0.1, 0.2)];
        let there = edge_jump(step, p, q);
        assert_eq!(edge_jump(step.reversed(), q, p), there.inverse());
    }
}

#[test]
fn a_straight_field_has_the_steps_of_the_plane() {
    let patch = surface(irregular_disk(6, 3));
    let own = IntrinsicTriangulation::of(&patch).unwrap();
    let field = straight_field(&patch, 0.3);
    let steps = edge_steps(&own, &field, &one(patch.mesh().vertex_count(), 2.0));
    for edge in own.edges() {
        let halfedge = own.edge_halfedge(edge);
        let vector = patch.halfedge_vector(halfedge).truncate();
        let wanted = DVec2::from_angle(-0.3).rotate(vector) * 2.0;
        let found = steps.of_edge(edge).delta;
        // In the frame of the origin: up to a quarter turn.
        let off = (0..4).map(|k| QuarterTurn::of_quarters(k).apply(found).distance(wanted));
        assert!(off.fold(1.0, f64::min) < 1e-12);
    }
}

#[test]
fn the_edge_energy_is_the_square_of_the_miss_where_that_is_small() {
    let step = EdgeStep {
        turn: QuarterTurn::RIGHT,
        delta: DVec2::new(0.7, -1.2),
    };
    let origin = DVec2::new(0.2, 0.9);
    let miss = DVec2::new(1e-4, -2e-4);
    let destination = step.turn.apply(origin + step.delta + miss) + DVec2::new(3.0, -5.0);
    let phases = |p: DVec2| [rotor(p.x), rotor(p.y)];
    let energy = edge_energy(step, phases(origin), phases(destination));
    assert!((energy / (TAU * miss).length_squared() - 1.0).abs() < 1e-6);
}

#[test]
fn half_cotangents_solve_the_system_of_appendix_b_times_the_area() {
    let mut noise = Noise::new(4);
    for _ in 0..20 {
        let corners = [0, 1, 2].map(|_| DVec2::new(noise.unit(), noise.unit()));
        let e = [0, 1, 2].map(|i| corners[(i + 2) % 3] - corners[(i + 1) % 3]);
        let area = 0.5 * e[0].perp_dot(e[1]).abs();
        let lambda = [0, 1, 2].map(|i| {
            let [a, b] = [-e[(i + 1) % 3], e[(i + 2) % 3]];
            0.5 * a.dot(b) / a.perp_dot(b).abs() / area
        });
        let sum = |f: &dyn Fn(DVec2) -> f64| (0..3).map(|i| lambda[i] * f(e[i])).sum::<f64>();
        let off = [
            sum(&|e| e.x * e.x) - 1.0,
            sum(&|e| e.y * e.y) - 1.0,
            sum(&|e| e.x * e.y),
        ];
        assert!(off.iter().all(|off| off.abs() < 1e-7), "{off:?}");
    }
}

#[test]
fn the_triangle_energy_is_the_integral_whatever_the_meshing_and_the_edge_energy_is_not() {
    // Phases of the map (x + 0.1 x², y) on a square under a straight field: the integral of
    // (2π · 0.2 x)² is (0.4 π)² / 3.
    let energies = |columns, rows| {
        let patch = surface(grid(1.0, 1.0, columns, rows));
        let own = IntrinsicTriangulation::of(&patch).unwrap();
        let count = patch.mesh().vertex_count();
        let angles = PerVertex::from_fn(count, |vertex| {
            let first = patch.halfedge_vector(patch.mesh().vertex_halfedge(vertex));
            -libm::atan2(first.y, first.x)
        });
        let field = CrossField::from_angles(Symmetry::Cross, angles);
        let steps = edge_steps(&own, &field, &one(count, 1.0));
        let phases = patch
            .positions()
            .map(|p| [rotor(p.x + 0.1 * p.x * p.x), rotor(p.y)]);
        [EnergyKind::Triangle, EnergyKind::Edge]
            .map(|kind| total_energy(&own, &steps, &energy_weights(&own, kind).unwrap(), &phases))
    };
    let integral = (0.4 * TAU / 2.0).powi(2) / 3.0;
    let [regular, anisotropic] = [energies(24, 24), energies(24, 4)];
    for [triangle, _] in [regular, anisotropic] {
        assert!(
            (triangle / integral - 1.0).abs() < 5e-3,
            "{triangle} {integral}"
        );
    }
    assert!(
        anisotropic[1] < 0.5 * regular[1],
        "{regular:?} {anisotropic:?}"
    );
}

#[test]
fn the_mean_of_a_linear_field_has_the_same_minimiser() {
    // Appendix A: ∫ |g − K|² − A |g − mean K|² does not depend on the gradient g.
    let mut noise = Noise::new(8);
    let vector = |noise: &mut Noise| DVec2::new(noise.signed(), noise.signed());
    let field = [0, 1, 2].map(|_| vector(&mut noise));
    // The steps hold the means over the edges; three of these integrate squares exactly.
    let means = [0, 1, 2].map(|i| 0.5 * (field[i] + field[(i + 1) % 3]));
    let mean = means.iter().sum::<DVec2>() / 3.0;
    let excess = |g: DVec2| {
        let integral = means.iter().map(|k| (g - *k).length_squared()).sum::<f64>() / 3.0;
        integral - (g - mean).length_squared()
    };
    let reference = excess(DVec2::ZERO);
    assert!((0..9).all(|_| (excess(vector(&mut noise)) - reference).abs() < 1e-12));
}

#[test]
fn the_quadratic_form_is_the_sum_of_the_edge_energies() {
    let sphere = surface(icosphere(2));
    let own = IntrinsicTriangulation::of(&sphere).unwrap();
    let count = sphere.mesh().vertex_count();
    let steps = edge_steps(&own, &random_field(&sphere, 7), &one(count, 1.7));
    let weights = energy_weights(&own, EnergyKind::Triangle).unwrap();
    let mut phases = random_phases(count, 9);
    let mut fixed = PerVertex::filled(count, [false; 2]);
    for vertex in [3, 4, 50] {
        let vertex = VertexId::from_index(vertex);
        fixed[vertex] = [true, vertex.0 == 4];
        phases[vertex][0] = DVec2::X;
        if vertex.0 == 4 {
            phases[vertex][1] = DVec2::X;
        }
    }
    let order = as_numbered(count);
    let graph = phase_graph(&own, &steps, &weights, &fixed, &order);
    let free = fixed.iter().flatten().zip(phases.iter().flatten());
    let values: Vec<DVec2> = free
        .filter(|(fixed, _)| !**fixed)
        .map(|(_, x)| *x)
        .collect();
    let sum = total_energy(&own, &steps, &weights, &phases);
    assert!((graph.energy(&values) / sum - 1.0).abs() < 1e-12);
    let mut relaxed = values.clone();
    graph.relax_units(&mut relaxed);
    assert!(graph.energy(&relaxed) < graph.energy(&values));
}

#[test]
fn a_field_without_curl_has_its_exact_phases_on_the_way_from_coarse_to_fine() {
    let patch = surface(irregular_disk(20, 6));
    let (delaunay, _) = intrinsic_delaunay(&patch, &Watch::new()).unwrap();
    let count = patch.mesh().vertex_count();
    let steps = edge_steps(&delaunay, &straight_field(&patch, 1.1), &one(count, 4.0));
    let weights = energy_weights(&delaunay, EnergyKind::Triangle).unwrap();
    let fixed = PerVertex::filled(count, [false; 2]);
    let order = as_numbered(count);
    let graph = phase_graph(&delaunay, &steps, &weights, &fixed, &order);
    let options = CoarseToFineOptions { sweeps: 1, seed: 3 };
    let values = phases_from_coarse(&graph, options, &Watch::new()).unwrap();
    assert!(graph.energy(&values) < 1e-18 * count as f64);
    assert!(
        graph
            .agreements(&values)
            .iter()
            .all(|x| (x - 1.0).abs() < 1e-9)
    );
}

#[test]
fn a_straight_field_on_a_flat_patch_gives_exactly_affine_coordinates() {
    let two = irregular_disk(12, 2).joined(&grid(3.0, 2.0, 12, 9).map(|p| p + 5.0));
    let patch = surface(two);
    let field = straight_field(&patch, 0.4);
    let options = ParameterizeOptions {
        follow_boundary: false,
        ..edges(4.0)
    };
    for triangles in [EnergyTriangles::Delaunay, EnergyTriangles::Own] {
        let options = ParameterizeOptions {
            triangles,
            ..options.clone()
        };
        let map = parameterize(&patch, &field, None, &options, &Watch::new()).unwrap();
        assert_eq!(map.singular, SingularElements::default());
        let distortion = map.report.distortion;
        assert!((distortion.stretch - 1.0).abs() < 1e-9 && distortion.shear < 1e-9);
        assert_eq!(distortion.left_out_area, 0.0);
        // One sheet: no seam, and every jump of the layout the same.
        let seams = map.layout.transitions.iter().flatten();
        assert!(seams.clone().count() > 0 && seams.copied().all(Transition::is_identity));
        let exact = map.grid_map(patch.mesh()).unwrap();
        let off = patch.mesh().halfedges().map(|corner| {
            exact
                .coordinate(corner)
                .distance(map.layout.coordinates[corner])
        });
        assert!(off.fold(0.0, f64::max) < 1e-9);
    }
}

/// Spread of the lengths of both gradients over the surface, relative to the largest.
fn spread(surface: &Surface, map: &Parameterization) -> f64 {
    let mut range = [f64::INFINITY, 0.0_f64];
    for face in surface.mesh().faces() {
        let source = SourceTriangle::from_positions(surface.corner_positions(face)).unwrap();
        let corners = face
            .halfedges()
            .map(|corner| map.layout.coordinates[corner]);
        let sigma = source.jacobian(corners).singular_values();
        range = [range[0].min(sigma[0]), range[1].max(sigma[0])];
    }
    1.0 - range[0] / range[1]
}

#[test]
fn a_cylinder_has_affine_coordinates_that_close() {
    let cylinder = surface(cylinder_patch(1.0, 2.0, 40, 13));
    let field = field_of(&cylinder, false);
    for chart_size in [4.0, 7.3] {
        let map = covered(&cylinder, &field, &edges(chart_size));
        assert_eq!(map.report.singular_share, 0.0);
        assert_eq!(map.report.singular_vertices, 0);
        assert!(map.report.distortion.shear < 1e-6);
        assert!(spread(&cylinder, &map) < 1e-3);
    }
}

#[test]
fn a_torus_scaled_by_its_curl_correction_has_no_singular_element() {
    let torus = surface(torus(2.0, 0.7, 60, 24));
    let field = field_of(&torus, true);
    for minimizer in [
        Minimizer::default(),
        Minimizer::DiffuseAndNormalise(DiffusionOptions::default()),
        Minimizer::Newton(NewtonOptions::default()),
    ] {
        let options = ParameterizeOptions {
            minimizer,
            ..edges(6.0)
        };
        let map = covered(&torus, &field, &options);
        assert_eq!(map.singular, SingularElements::default(), "{minimizer:?}");
        assert!(map.report.distortion.shear < 0.05, "{:?}", map.report);
    }
}

#[test]
fn around_singular_triangles_norms_are_small_and_energies_high() {
    let sphere = surface(icosphere(4));
    let field = field_of(&sphere, false);
    for minimizer in [
        Minimizer::default(),
        Minimizer::Newton(NewtonOptions::default()),
    ] {
        let options = ParameterizeOptions {
            minimizer,
            ..edges(6.0)
        };
        let map = covered(&sphere, &field, &options);
        let SingularElements {
            field_faces,
            phase_faces,
            ..
        } = &map.singular;
        let ends = field_faces.iter().chain(phase_faces);
        let at: Vec<VertexId> = ends
            .flat_map(|&face| sphere.mesh().triangle(face))
            .collect();
        assert!(!at.is_empty());
        let everywhere: Vec<VertexId> = sphere.mesh().vertices().collect();
        let mean = |values: &PerVertex<f64>, of: &[VertexId]| -> f64 {
            of.iter().map(|&vertex| values[vertex]).sum::<f64>() / of.len() as f64
        };
        let PhaseTension { norms, energies } = &map.tension;
        assert!(norms.iter().all(|norm| (0.0..=1.0).contains(norm)));
        assert!(mean(norms, &at) < mean(norms, &everywhere));
        assert!(mean(energies, &at) > mean(energies, &everywhere));
    }
}

#[test]
fn newton_descends_to_the_energy_of_the_other_minimisers() {
    let torus = surface(torus(2.0, 0.7, 40, 16));
    let field = field_of(&torus, true);
    let energy = |minimizer| {
        let options = ParameterizeOptions {
            minimizer,
            ..edges(6.0)
        };
        covered(&torus, &field, &options).report.minimization
    };
    let newton = energy(Minimizer::Newton(NewtonOptions {
        penalty: 1.0,
        ..NewtonOptions::default()
    }));
    assert!(newton.gradient.unwrap() <= 1e-6);
    let other = energy(Minimizer::CoarseToFine(CoarseToFineOptions {
        sweeps: 200,
        seed: 0,
    }));
    assert!(
        (newton.energy / other.energy - 1.0).abs() < 0.05,
        "{newton:?} {other:?}"
    );
}

#[test]
fn every_triangle_that_fails_a_check_is_in_a_list() {
    let sphere = surface(icosphere(4));
    let field = field_of(&sphere, false);
    let map = covered(&sphere, &field, &edges(6.0));
    let faces = &field.singularities.faces;
    let expected: Vec<_> = faces.iter().map(|singularity| singularity.face).collect();
    assert_eq!(map.singular.field_faces, expected);
    let regular = map.kinds.iter().filter(|kind| **kind == FaceKind::Regular);
    let all = sphere.mesh().face_count();
    assert_eq!(regular.count() + map.singular.face_count(), all);
    assert!(map.singular.inverted_faces.is_empty());
    assert!(map.report.singular_share < 0.01, "{:?}", map.report);
    // Each edge of a triangle that does not close, and nothing else, has no transition.
    let open = sphere
        .mesh()
        .halfedges()
        .filter(|&h| map.layout.transitions[h].is_none());
    assert_eq!(open.count(), 2 * map.singular.edges.len());
    map.grid_map(sphere.mesh()).unwrap();
}

#[test]
fn lines_run_along_features_and_meet_at_corners() {
    let shape = surface(cube().subdivided().subdivided().subdivided().subdivided());
    let field = field_of(&shape, false);
    let sharp = feature_edges(&shape, 1.0, 10);
    let options = ParameterizeOptions {
        features: sharp.clone(),
        ..edges(4.0)
    };
    let map = covered(&shape, &field, &options);
    assert_eq!(
        map.report.unaligned_edges + map.report.released_coordinates,
        0
    );
    assert!(map.report.inverted_faces == 0, "{:?}", map.report);
    let grid = map.grid_map(shape.mesh()).unwrap();
    let mesh = shape.mesh();
    for edge in sharp {
        let halfedge = mesh.edge_halfedge(edge);
        if grid.is_left_out(halfedge.face()) {
            continue;
        }
        let [from, to] = [halfedge, halfedge.next()].map(|corner| grid.coordinate(corner));
        let is_line = |k: usize| from[k] == to[k] && from[k] == from[k].round();
        assert!(is_line(0) || is_line(1), "{from} {to}");
    }
    for vertex in mesh.vertices() {
        let p = shape.position(vertex);
        if p.to_array().iter().all(|x| *x == 0.0 || *x == 1.0) {
            assert_eq!(map.whole[vertex], [true; 2]);
        }
    }
}

#[test]
fn lines_that_have_no_room_are_released_and_told() {
    // A strip far narrower than a chart.
    let strip = surface(grid(8.0, 0.3, 80, 3));
    let watch = Watch::new();
    let options = ParameterizeOptions {
        chart_size: ChartSize::Length(1.0),
        ..ParameterizeOptions::default()
    };
    let field = field_of(&strip, false);
    let map = parameterize(&strip, &field.field, None, &options, &watch).unwrap();
    assert_eq!(map.report.inverted_faces, 0);
    assert!(map.report.released_coordinates > 0);
    assert!(
        watch
            .warnings()
            .iter()
            .any(|warning| warning.code == "lines-released")
    );
}

#[test]
fn scaling_by_a_power_of_two_changes_no_coordinate() {
    let at = |exponent: i32| {
        let factor = 2.0_f64.powi(exponent);
        let sphere = surface(icosphere(3).map(|p| p * factor));
        let map = covered(&sphere, &field_of(&sphere, true), &edges(5.0));
        (map.layout, map.singular, map.chart_size / factor)
    };
    let reference = at(0);
    assert!(at(-40) == reference && at(40) == reference);
}

#[test]
fn chart_sizes_by_edges_length_and_count_agree() {
    let patch = surface(grid(4.0, 3.0, 16, 12));
    let field = straight_field(&patch, 0.0);
    let size = |chart_size| {
        let options = ParameterizeOptions {
            chart_size,
            ..ParameterizeOptions::default()
        };
        let map = parameterize(&patch, &field, None, &options, &Watch::new()).unwrap();
        (map.chart_size, map.report.charts)
    };
    let (by_length, charts) = size(ChartSize::Length(0.5));
    assert_eq!(by_length, 0.5);
    assert!((charts - 48.0).abs() < 1e-9);
    assert!((size(ChartSize::Count(48.0)).0 - 0.5).abs() < 1e-12);
}

#[test]
fn input_that_fits_nothing_is_refused_by_name() {
    let patch = surface(disk(3));
    let field = straight_field(&patch, 0.0);
    let count = patch.mesh().vertex_count();
    let run = |scale: Option<&PerVertex<f64>>, options: &ParameterizeOptions| {
        parameterize(&patch, &field, scale, options, &Watch::new()).unwrap_err()
    };
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refusal = run(None, &edges(value));
        assert!(matches!(
            refusal,
            PeriodicError::Option {
                name: "chart size",
                ..
            }
        ));
        let refusal = run(Some(&one(count, value)), &edges(4.0));
        assert!(matches!(refusal, PeriodicError::Scale { .. }));
    }
    let short = one(3, 1.0);
    let refusal = run(Some(&short), &edges(4.0));
    assert!(matches!(
        refusal,
        PeriodicError::VertexCount { given: 3, .. }
    ));
    let refusal = run(None, &edges(1e-9));
    assert!(matches!(refusal, PeriodicError::ChartsTooSmall { .. }));
    let options = ParameterizeOptions {
        features: vec![EdgeId(99_999)],
        ..edges(4.0)
    };
    let refusal = run(None, &options);
    assert!(matches!(
        refusal,
        PeriodicError::NoSuchEdge { edge: 99_999, .. }
    ));
}
