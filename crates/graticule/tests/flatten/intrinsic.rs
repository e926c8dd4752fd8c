//! The authalic map, mixes, near-optimal maps and optimised boundaries.

use faer::Mat;
use faer::linalg::solvers::Solve;
use glam::{DVec2, DVec3};
use graticule::flatten::{
    BoundaryCurve, BoundaryOptimalOptions, BoundaryPositions, FixedOptions, FlattenError,
    Functional, Holes, Method, Mix, NaturalOptions, NearOptimalMap, NearOptimalOptions, Patch,
    Weights, boundary_on_curve, boundary_optimal_map, fixed_map, natural_map, near_optimal_map,
};
use graticule::mesh::{PerVertex, Surface};
use graticule::watch::Watch;
use graticule_fixtures::{
    Noise, annulus, bumpy_patch, disk, grid, irregular_disk, saddle_patch, spherical_cap,
};

use crate::support::{distance, distance_up_to_similarity, own_boundary, patch, plane};

fn circle(patch: &Patch) -> BoundaryPositions {
    boundary_on_curve(patch, &BoundaryCurve::Circle, &Watch::new()).unwrap()
}

fn mix(lambda: f64, mu: f64) -> FixedOptions {
    FixedOptions {
        weights: Weights::Intrinsic(Mix::new(lambda, mu).unwrap()),
        ..FixedOptions::default()
    }
}

const MIXES: [[f64; 2]; 6] = [
    [1.0, 0.0],
    [0.0, 1.0],
    [0.5, 0.5],
    [0.01, 1.0],
    [3.0, 0.1],
    [-7.0, -2.0],
];

#[test]
fn a_flat_patch_is_its_own_map_for_every_mix() {
    let flat = [
        disk(6),
        irregular_disk(9, 3),
        grid(2.0, 1.0, 8, 5),
        annulus(0.3, 1.0, 18, 4),
        irregular_disk(7, 1).map(|p| p * 1e-30),
        irregular_disk(7, 1).map(|p| p * 3e12),
        disk(1),
        grid(1.0, 1.0, 1, 1),
    ];
    for fixture in flat {
        let patch = patch(&fixture);
        let boundary = own_boundary(&patch);
        for [lambda, mu] in MIXES {
            let map = fixed_map(&patch, &boundary, &mix(lambda, mu), &Watch::new()).unwrap();
            let error = distance(&map.uv, &plane(&patch));
            assert!(error < 1e-10, "{lambda}:{mu} {error:e}");
            assert!(map.flips.is_zero());
        }
    }
}

/// `(cot γ + cot δ) / |ij|²` and `cot α + cot β` of [DMA02] §4.1 by vectors in space, for every
/// ordered pair of neighbours.
fn paper_weights(surface: &Surface) -> [Mat<f64>; 2] {
    let mesh = surface.mesh();
    let order = mesh.vertex_count();
    let [mut conformal, mut authalic] = [(); 2].map(|()| Mat::<f64>::zeros(order, order));
    let cotangent = |at: DVec3, one: DVec3, other: DVec3| {
        let (one, other) = (one - at, other - at);
        one.dot(other) / one.cross(other).length()
    };
    for face in mesh.faces() {
        let corners = mesh.triangle(face);
        for k in 0..3 {
            for (here, there) in [(k, (k + 1) % 3), (k, (k + 2) % 3)] {
                let opposite = 3 - here - there;
                let [i, j, o] = [here, there, opposite].map(|c| surface.position(corners[c]));
                let (row, column) = (corners[here].0 as usize, corners[there].0 as usize);
                conformal[(row, column)] += cotangent(o, i, j);
                authalic[(row, column)] += cotangent(j, i, o) / i.distance_squared(j);
            }
        }
    }
    [conformal, authalic]
}

fn mean_square_length(surface: &Surface) -> f64 {
    let mesh = surface.mesh();
    let squares = mesh.edges().map(|edge| {
        let side = mesh.edge_halfedge(edge);
        surface.halfedge_vector(side).length_squared()
    });
    squares.sum::<f64>() / mesh.edge_count() as f64
}

/// The map by dense elimination of [DMA02] §4.1, boundary rows being those of the identity.
fn dense_map(
    surface: &Surface,
    boundary: &BoundaryPositions,
    lambda: f64,
    mu: f64,
) -> PerVertex<DVec2> {
    let [conformal, authalic] = paper_weights(surface);
    let square = mean_square_length(surface);
    let order = surface.mesh().vertex_count();
    let mut matrix = Mat::<f64>::zeros(order, order);
    for i in 0..order {
        for j in 0..order {
            let weight = lambda * conformal[(i, j)] + mu * square * authalic[(i, j)];
            matrix[(i, j)] += weight;
            matrix[(i, i)] -= weight;
        }
    }
    let mut right_side = Mat::<f64>::zeros(order, 2);
    for &(vertex, place) in boundary.places() {
        let row = vertex.0 as usize;
        for column in 0..order {
            matrix[(row, column)] = f64::from(u8::from(column == row));
        }
        right_side[(row, 0)] = place.x;
        right_side[(row, 1)] = place.y;
    }
    let solved = matrix.partial_piv_lu().solve(&right_side);
    PerVertex::from_fn(order, |v: graticule::mesh::VertexId| {
        DVec2::new(solved[(v.0 as usize, 0)], solved[(v.0 as usize, 1)])
    })
}

#[test]
fn every_mix_is_the_solution_of_the_dense_system_of_the_paper() {
    for fixture in [bumpy_patch(5, 2), saddle_patch(6), spherical_cap(2.0, 5)] {
        let patch = patch(&fixture);
        let boundary = circle(&patch);
        for [lambda, mu] in MIXES {
            let map = fixed_map(&patch, &boundary, &mix(lambda, mu), &Watch::new()).unwrap();
            let dense = dense_map(patch.surface(), &boundary, lambda, mu);
            let error = distance(&map.uv, &dense);
            assert!(error < 1e-10, "{lambda}:{mu} {error:e}");
        }
    }
}

#[test]
fn at_the_authalic_map_the_chi_energy_of_every_ring_is_level() {
    let patch = patch(&bumpy_patch(5, 3));
    let surface = patch.surface();
    let map = fixed_map(&patch, &circle(&patch), &mix(0.0, 1.0), &Watch::new()).unwrap();
    assert_eq!(map.method, Method::FixedAuthalic);
    let [_, weights] = paper_weights(surface);
    // [DMA02] Eq. 5: the energy of the ring of one vertex.
    let energy = |vertex: usize, at: DVec2| -> f64 {
        let others = map.uv.as_slice().iter().enumerate();
        let terms = others.map(|(j, u)| weights[(vertex, j)] * at.distance_squared(*u));
        terms.sum()
    };
    for vertex in surface.mesh().vertices() {
        let (index, here) = (vertex.0 as usize, map.uv[vertex]);
        let step = 1e-3;
        let slope = |axis: DVec2| {
            (energy(index, here + axis * step) - energy(index, here - axis * step)) / (2.0 * step)
        };
        let slope = DVec2::new(slope(DVec2::X), slope(DVec2::Y));
        // [DMA02] Eq. 6 is half of it.
        let pulls = (0..map.uv.len()).map(|j| (here - map.uv.as_slice()[j]) * weights[(index, j)]);
        let gradient = 2.0 * pulls.sum::<DVec2>();
        let size: f64 = (0..map.uv.len()).map(|j| weights[(index, j)].abs()).sum();
        assert!(slope.distance(gradient) < 1e-9 * size);
        if !surface.mesh().is_boundary_vertex(vertex) {
            assert!(slope.length() < 1e-9 * size, "{vertex}: {slope}");
        }
    }
}

#[test]
fn a_mix_means_the_same_in_every_unit() {
    let small = patch(&bumpy_patch(6, 4));
    for scale in [0.3, 1e-9, 7e15] {
        let large = patch(&bumpy_patch(6, 4).map(|p| p * scale));
        let map = |patch: &Patch| fixed_map(patch, &circle(patch), &mix(1.0, 2.0), &Watch::new());
        let (one, other) = (map(&small).unwrap(), map(&large).unwrap());
        let other = other.uv.map(|p| *p / scale);
        assert!(distance(&other, &one.uv) < 1e-11);
    }
}

#[test]
fn a_mix_of_nothing_is_refused() {
    for [lambda, mu] in [[0.0, 0.0], [f64::NAN, 1.0], [1.0, f64::INFINITY]] {
        let refusal = Mix::new(lambda, mu).unwrap_err();
        assert!(matches!(refusal, FlattenError::BadMix { .. }));
    }
}

fn near_optimal(patch: &Patch, functional: Functional) -> NearOptimalMap {
    let options = NearOptimalOptions {
        functional,
        holes: Holes::Closed,
    };
    near_optimal_map(patch, &circle(patch), options, &Watch::new()).unwrap()
}

/// The printed functional of a map, without the stray square of the areas.
fn printed(patch: &Patch, functional: Functional, uv: &PerVertex<DVec2>) -> f64 {
    let (mesh, surface) = (patch.mesh(), patch.surface());
    if functional == Functional::EdgeLength {
        let terms = mesh.edges().map(|edge| {
            let [a, b] = mesh.ends(mesh.edge_halfedge(edge));
            let length = surface.position(a).distance_squared(surface.position(b));
            (uv[a].distance_squared(uv[b]) / length - 1.0).powi(2)
        });
        return terms.sum::<f64>() / mesh.edge_count() as f64;
    }
    let terms = mesh.faces().map(|face| {
        let [a, b, c] = mesh.triangle(face);
        let flat = (uv[b] - uv[a]).perp_dot(uv[c] - uv[a]);
        let [p, q, r] = surface.corner_positions(face);
        (flat / (q - p).cross(r - p).length() - 1.0).powi(2)
    });
    terms.sum::<f64>() / mesh.face_count() as f64
}

#[test]
fn the_best_mix_is_that_of_a_fine_scan() {
    for fixture in [bumpy_patch(6, 2), spherical_cap(2.2, 6), saddle_patch(6)] {
        let patch = patch(&fixture);
        let fixed = |lambda, mu| {
            let map = fixed_map(&patch, &circle(&patch), &mix(lambda, mu), &Watch::new());
            map.unwrap().uv
        };
        let [conformal, authalic] = [fixed(1.0, 0.0), fixed(0.0, 1.0)];
        for functional in [Functional::EdgeLength, Functional::Area] {
            let found = near_optimal(&patch, functional);
            assert_eq!(found.map.method, Method::NearOptimal);
            let at = |lambda: f64| {
                let combined = conformal
                    .enumerate()
                    .map(|(v, a)| (*a * lambda + authalic[v] * (1.0 - lambda)) * found.scale);
                printed(&patch, functional, &PerVertex::new(combined.collect()))
            };
            let best = found.best;
            assert!((at(best.lambda) - best.value).abs() < 1e-10 * best.value.max(1e-3));
            for k in -2000..=3000 {
                let lambda = f64::from(k) * 1e-3;
                assert!(
                    at(lambda) >= best.value * (1.0 - 1e-9),
                    "{functional:?} {lambda}"
                );
            }
        }
    }
}

#[test]
fn searched_mixes_are_no_worse_than_a_scan() {
    let patch = patch(&bumpy_patch(6, 2));
    for functional in [Functional::Stretch, Functional::SymmetricDirichlet] {
        let found = near_optimal(&patch, functional);
        assert!(!found.curve.is_empty());
        for point in &found.curve {
            assert!(point.value >= found.best.value, "{functional:?} {point:?}");
        }
    }
}

#[test]
fn on_a_flat_patch_every_mix_is_optimal() {
    let patch = patch(&irregular_disk(6, 2));
    for functional in Functional::ALL {
        let options = NearOptimalOptions {
            functional,
            holes: Holes::Closed,
        };
        let boundary = own_boundary(&patch);
        let found = near_optimal_map(&patch, &boundary, options, &Watch::new()).unwrap();
        assert!(
            distance(&found.map.uv, &plane(&patch)) < 1e-9,
            "{functional:?}"
        );
    }
}

#[test]
fn an_optimised_boundary_lowers_its_functional_step_by_step_and_flips_nothing() {
    let patch = patch(&bumpy_patch(7, 5));
    let natural = natural_map(&patch, &NaturalOptions::default(), &Watch::new()).unwrap();
    let starts = [
        circle(&patch),
        BoundaryPositions::of_map(&patch, &natural.uv).unwrap(),
    ];
    for functional in Functional::ALL {
        for start in &starts {
            let options = BoundaryOptimalOptions {
                functional,
                ..BoundaryOptimalOptions::default()
            };
            let watch = Watch::new();
            let before = fixed_map(&patch, start, &options.fixed, &watch).unwrap();
            let found = boundary_optimal_map(&patch, start, &options, &watch).unwrap();
            let values: Vec<f64> = found.history.iter().map(|step| step.value).collect();
            assert!(
                values.windows(2).all(|pair| pair[1] < pair[0]),
                "{values:?}"
            );
            assert!(found.history.len() > 3);
            assert!(found.at_rest, "{functional:?}: {values:?}");
            assert!(found.map.flips.flipped <= before.flips.flipped);
            let slopes = [0, found.history.len() - 1].map(|k| found.history[k].gradient);
            assert!(slopes[1] < 0.05 * slopes[0], "{functional:?} {slopes:?}");
        }
    }
}

#[test]
fn a_flat_patch_on_a_circle_finds_back_to_itself() {
    let patch = patch(&grid(2.0, 1.0, 8, 4));
    for functional in [Functional::EdgeLength, Functional::SymmetricDirichlet] {
        let options = BoundaryOptimalOptions {
            functional,
            most_steps: 1000,
            ..BoundaryOptimalOptions::default()
        };
        let found = boundary_optimal_map(&patch, &circle(&patch), &options, &Watch::new()).unwrap();
        let error = distance_up_to_similarity(&found.map.uv, &plane(&patch));
        assert!(error < 1e-2, "{functional:?}: {error:e}");
    }
}

#[test]
fn squeezed_triangles_do_not_end_the_descent() {
    // The circle squeezes the ends of a strip; edge lengths let triangles collapse there.
    let patch = patch(&grid(6.0, 1.0, 24, 4));
    let options = BoundaryOptimalOptions {
        functional: Functional::EdgeLength,
        most_steps: 1000,
        ..BoundaryOptimalOptions::default()
    };
    let found = boundary_optimal_map(&patch, &circle(&patch), &options, &Watch::new()).unwrap();
    let values: Vec<f64> = found.history.iter().map(|step| step.value).collect();
    assert!(values.windows(2).all(|pair| pair[1] < pair[0]));
    assert!(values[values.len() - 1] < 1e-2 * values[0], "{values:?}");
}

#[test]
fn a_folded_start_is_told_and_left_out() {
    let patch = patch(&irregular_disk(4, 6));
    let mut noise = Noise::new(3);
    let places = own_boundary(&patch);
    let shaken = places.places().iter().map(|&(vertex, place)| {
        let push = DVec2::new(noise.signed(), noise.signed()) * 0.4;
        (vertex, place + push)
    });
    let start = BoundaryPositions::new(&patch, shaken).unwrap();
    let options = BoundaryOptimalOptions {
        functional: Functional::SymmetricDirichlet,
        ..BoundaryOptimalOptions::default()
    };
    let watch = Watch::new();
    let before = fixed_map(&patch, &start, &options.fixed, &Watch::new()).unwrap();
    let found = boundary_optimal_map(&patch, &start, &options, &watch).unwrap();
    assert!(found.left_out > 0);
    assert!(
        watch
            .warnings()
            .iter()
            .any(|w| w.code == "flipped-left-out")
    );
    assert!(found.map.flips.flipped <= before.flips.flipped);
}
