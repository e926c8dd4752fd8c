use std::f64::consts::TAU;

use graticule::geometry::{
    DirectedWeights, EdgeWeights, IntrinsicTriangulation, angle_defects, authalic_weights,
    cotangent_weights, divergence, divergence_in_space, face_curvatures, face_shapes, gradients,
    gradients_in_space, mean_value_weights, mixed_voronoi_areas, total_area, transport_angles,
    uniform_directed_weights, uniform_weights, vertex_areas,
};
use graticule::mesh::{PerVertex, VertexId};

use super::{
    all_fixtures, delaunay, fixtures, function, inner_vertices, largest, surface, turn_between,
    unflipped,
};

#[test]
fn angle_defects_and_holonomies_sum_to_the_euler_characteristic() {
    for (name, fixture, euler) in all_fixtures() {
        let surface = surface(&fixture);
        for triangulation in [unflipped(&surface), delaunay(&surface).0] {
            let defects = angle_defects(&triangulation);
            let total: f64 = defects.iter().sum();
            assert!((total - TAU * euler).abs() < 1e-9, "{name}: {total}");
            let on_boundary = defects
                .enumerate()
                .filter(|&(vertex, _)| triangulation.is_boundary_vertex(vertex));
            let turning: f64 = on_boundary.map(|(_, defect)| defect).sum();
            let held: f64 = face_curvatures(&triangulation).iter().sum();
            assert!((held + turning - TAU * euler).abs() < 1e-9, "{name}");
        }
    }
}

#[test]
fn a_vector_carried_round_a_triangle_turns_by_its_curvature() {
    for (name, fixture, _) in all_fixtures() {
        let surface = surface(&fixture);
        for triangulation in [unflipped(&surface), delaunay(&surface).0] {
            let transport = transport_angles(&triangulation);
            let curvatures = face_curvatures(&triangulation);
            for face in triangulation.faces() {
                let round: f64 = face.halfedges().map(|h| transport[h]).iter().sum();
                let error = turn_between(round, curvatures[face]);
                assert!(error < 1e-9, "{name} {face}: {error}");
            }
        }
    }
}

#[test]
fn constant_directions_on_a_flat_surface_are_transported_into_themselves() {
    let surface = surface(&fixtures::irregular_disk(8, 4));
    let (triangulation, _) = delaunay(&surface);
    let transport = transport_angles(&triangulation);
    // The angle of one direction of the plane in the frame of each vertex.
    let fixed = PerVertex::from_fn(triangulation.vertex_count(), |vertex| {
        let zero = surface.mesh().vertex_halfedge(vertex);
        1.0 - surface.halfedge_vector(zero).truncate().to_angle()
    });
    for halfedge in triangulation.halfedges() {
        let [i, j] = triangulation.ends(halfedge);
        assert!(turn_between(fixed[i] + transport[halfedge], fixed[j]) < 1e-9);
    }
}

#[test]
fn laplacians_of_flat_surfaces_do_away_with_linear_functions() {
    let bounds = [
        (fixtures::irregular_disk(15, 2), 1e-12),
        (fixtures::annulus(0.5, 1.0, 30, 5), 1e-12),
        (fixtures::grid_with_flat_triangles(7, 5), 1e-12),
        (fixtures::needles(12, 1e3, 4), 1e-11),
        (fixtures::needles(12, 1e6, 4), 1e-8),
    ];
    for (fixture, bound) in bounds {
        let surface = surface(&fixture);
        let linear = function(&surface, |p| 3.0 * p.x - 2.0 * p.y + 1.0);
        let inner = inner_vertices(&surface);
        let original = unflipped(&surface);
        // Triangles without area have weights only after the flips.
        if original.shapes().iter().all(|shape| !shape.is_degenerate()) {
            assert_linear_precision(&original, &linear, &inner, bound);
        }
        assert_linear_precision(&delaunay(&surface).0, &linear, &inner, bound);
    }
}

fn assert_linear_precision(
    triangulation: &IntrinsicTriangulation,
    linear: &PerVertex<f64>,
    inner: &[VertexId],
    bound: f64,
) {
    let cotangent = cotangent_weights(triangulation).unwrap();
    let residuals = cotangent.apply(linear);
    let mut sizes = PerVertex::filled(linear.len(), 0.0);
    for (&[i, j], weight) in cotangent.ends.iter().zip(&cotangent.weights) {
        let size = (weight * (linear[i] - linear[j])).abs();
        sizes[i] += size;
        sizes[j] += size;
    }
    for &vertex in inner {
        let share = residuals[vertex].abs() / sizes[vertex];
        assert!(share < bound, "cotangent, {vertex}: {share:e}");
    }
    let directed = [
        ("mean value", mean_value_weights(triangulation).unwrap()),
        ("authalic", authalic_weights(triangulation).unwrap()),
    ];
    for (name, weights) in directed {
        let residuals = weights.apply(linear);
        for &vertex in inner {
            let share = residuals[vertex].abs() / row_size(&weights, linear, vertex);
            assert!(share < bound, "{name}, {vertex}: {share:e}");
        }
    }
}

fn row_size(weights: &DirectedWeights, values: &PerVertex<f64>, vertex: VertexId) -> f64 {
    let row = weights
        .neighbors(vertex)
        .iter()
        .zip(weights.weights(vertex));
    row.map(|(&other, weight)| (weight * (values[other] - values[vertex])).abs())
        .sum()
}

#[test]
fn mean_value_weights_are_positive() {
    for (name, fixture, _) in all_fixtures() {
        let (triangulation, _) = delaunay(&surface(&fixture));
        let weights = mean_value_weights(&triangulation).unwrap();
        let mut all = triangulation.vertices().flat_map(|v| weights.weights(v));
        assert!(all.all(|&weight| weight > 0.0), "{name}");
    }
}

#[test]
fn authalic_weights_follow_their_definition() {
    // One triangle with a right angle at vertex 0 and legs 1 and 2.
    let positions = vec![glam::DVec3::ZERO, glam::DVec3::X, glam::DVec3::Y * 2.0];
    let surface = graticule::mesh::Surface::from_triangles(positions, &[[0, 1, 2]]).unwrap();
    let weights = authalic_weights(&unflipped(&surface)).unwrap();
    let row = |vertex| weights.weights(VertexId(vertex)).to_vec();
    // Row 0: the angle at 1 has the cotangent 1/2, that at 2 the cotangent 2.
    let expected = [[0.5, 2.0 / 4.0], [0.0, 2.0 / 5.0], [0.0, 0.5 / 5.0]];
    for (vertex, expected) in expected.iter().enumerate() {
        for (weight, expected) in row(vertex as u32).iter().zip(expected) {
            assert!((weight - expected).abs() < 1e-15, "row {vertex}");
        }
    }
}

#[test]
fn every_laplacian_does_away_with_constants_and_symmetric_ones_conserve() {
    let mut noise = fixtures::Noise::new(5);
    for (name, fixture, _) in all_fixtures() {
        let surface = surface(&fixture);
        let (triangulation, _) = delaunay(&surface);
        let constant = function(&surface, |_| 1.0);
        let random = function(&surface, |p| p.x);
        let random = random.map(|_| noise.signed());
        let symmetric = [
            cotangent_weights(&triangulation).unwrap(),
            uniform_weights(surface.mesh()),
        ];
        for weights in &symmetric {
            let flow = weights.apply(&constant);
            assert!(flow.iter().all(|&flow| flow == 0.0), "{name}");
            let flow = weights.apply(&random);
            let sum: f64 = flow.iter().sum();
            let size: f64 = flow.iter().map(|f| f.abs()).sum();
            assert!(sum.abs() < 1e-12 * size, "{name}");
            // ½ uᵀ L u is the energy.
            let product: f64 = flow.iter().zip(&random).map(|(l, u)| l * u).sum();
            let energy = weights.energy(&random);
            assert!((product / 2.0 - energy).abs() < 1e-9 * size, "{name}");
        }
        let directed = uniform_directed_weights(surface.mesh());
        assert_eq!(directed.weight_count(), 2 * surface.mesh().edge_count());
        assert!(
            disagreement(&symmetric[1], &directed, &random) < 1e-12,
            "{name}"
        );
    }
}

fn disagreement(first: &EdgeWeights, second: &DirectedWeights, values: &PerVertex<f64>) -> f64 {
    let [a, b] = [first.apply(values), second.apply(values)];
    largest(a.iter().zip(&b).map(|(a, b)| a - b))
}

#[test]
fn the_dirichlet_energy_of_the_coordinates_is_the_area() {
    for (name, fixture, _) in all_fixtures() {
        let surface = surface(&fixture);
        let triangulation = unflipped(&surface);
        let Ok(weights) = cotangent_weights(&triangulation) else {
            assert_eq!(name, "flat triangles");
            continue;
        };
        let area = total_area(triangulation.shapes());
        let mut energy = 0.0;
        let mut size = area;
        for (ends, weight) in weights.ends.iter().zip(&weights.weights) {
            let [from, to] = ends.map(|vertex| surface.position(vertex));
            let term = 0.5 * weight * from.distance_squared(to);
            energy += term;
            size += term.abs();
        }
        assert!(
            (energy - area).abs() < 1e-12 * size,
            "{name}: {energy} {area}"
        );
    }
}

#[test]
fn the_divergence_of_the_gradient_is_the_laplacian_in_both_formulations() {
    for fixture in [
        fixtures::bumpy_patch(10, 1),
        fixtures::torus(2.0, 0.7, 20, 11),
        fixtures::needles(6, 1e3, 1),
    ] {
        let surface = surface(&fixture);
        let triangulation = unflipped(&surface);
        let values = function(&surface, |p| (2.0 * p.x + p.z).sin() + p.y * p.y);
        let laplacian = cotangent_weights(&triangulation).unwrap().apply(&values);
        let flat = gradients(&triangulation, &values).unwrap();
        let flat = divergence(&triangulation, &flat);
        let spatial = gradients_in_space(&surface, &values).unwrap();
        let spatial = divergence_in_space(&surface, &spatial);
        let size = largest(laplacian.iter().copied());
        for (vertex, laplacian) in laplacian.enumerate() {
            assert!((flat[vertex] + laplacian).abs() < 1e-11 * size);
            assert!((spatial[vertex] + laplacian).abs() < 1e-11 * size);
        }
    }
}

#[test]
fn vertex_areas_sum_to_the_area_and_are_not_negative() {
    for (name, fixture, _) in all_fixtures() {
        let surface = surface(&fixture);
        let (triangulation, _) = delaunay(&surface);
        let area = total_area(&face_shapes(&surface));
        let both = [
            vertex_areas(&triangulation),
            mixed_voronoi_areas(&triangulation),
        ];
        for areas in both {
            assert!(areas.iter().all(|&area| area >= 0.0), "{name}");
            let total: f64 = areas.iter().sum();
            assert!((total - area).abs() < 1e-9 * area, "{name}");
        }
    }
}
