use glam::DVec3;
use graticule::solve::{Graph, Ordering, Placement, Symbolic};
use graticule_fixtures::{Fixture, Noise, disk, grid, icosphere, torus};
use proptest::prelude::*;

use crate::common::{edges, laplacian};

fn is_permutation(ordering: &Ordering) -> bool {
    let mut sorted = ordering.order().to_vec();
    sorted.sort_unstable();
    sorted.into_iter().eq(0..ordering.len() as u32)
}

fn fill(fixture: &Fixture, ordering: &Ordering) -> usize {
    let matrix = laplacian(fixture, 1.0);
    Symbolic::new(&matrix, ordering).unwrap().factor_entries()
}

fn graph(fixture: &Fixture) -> Graph {
    Graph::from_edges(fixture.positions.len(), edges(fixture).into_iter())
}

/// A closed surface of 48 000 vertices with bumps, numbered at random.
fn bumpy_torus() -> Fixture {
    let bumpy = torus(1.0, 0.4, 320, 150).map(|p| p * (1.0 + 0.08 * (9.0 * p.x).sin()));
    bumpy.renumbered(5).0
}

#[test]
fn dissection_fills_less_than_minimum_degree_on_a_large_mesh() {
    let fixture = bumpy_torus();
    let graph = graph(&fixture);
    let dissected = fill(
        &fixture,
        &Ordering::nested_dissection(&graph, &fixture.positions),
    );
    let by_degree = fill(&fixture, &Ordering::minimum_degree(&graph));
    assert!(
        dissected < by_degree,
        "{dissected} entries against {by_degree}"
    );
    // 57 entries per column of this mesh when the ordering was made.
    assert!(
        dissected < 60 * fixture.positions.len(),
        "{dissected} entries"
    );
}

#[test]
fn dissection_does_not_need_the_coordinates_to_be_good() {
    let fixture = bumpy_torus();
    let graph = graph(&fixture);
    let good = fill(
        &fixture,
        &Ordering::nested_dissection(&graph, &fixture.positions),
    );
    let mut noise = Noise::new(1);
    let count = fixture.positions.len();
    let random: Vec<DVec3> = (0..count)
        .map(|_| DVec3::new(noise.signed(), noise.signed(), noise.signed()))
        .collect();
    let without = fill(
        &fixture,
        &Ordering::nested_dissection(&graph, &vec![DVec3::X; count]),
    );
    let misled = fill(&fixture, &Ordering::nested_dissection(&graph, &random));
    assert!(without < 2 * good, "{without} entries against {good}");
    assert!(misled < 2 * good, "{misled} entries against {good}");
}

#[test]
fn scale_and_place_of_the_coordinates_do_not_matter() {
    let fixture = torus(1.0, 0.4, 100, 60);
    let graph = graph(&fixture);
    let order = Ordering::nested_dissection(&graph, &fixture.positions);
    for scale in [
        2.0_f64.powi(40),
        2.0_f64.powi(-40),
        2.0_f64.powi(990),
        2.0_f64.powi(-990),
    ] {
        let scaled: Vec<DVec3> = fixture.positions.iter().map(|&p| p * scale).collect();
        assert_eq!(Ordering::nested_dissection(&graph, &scaled), order);
    }
}

#[test]
fn numbers_that_are_not_finite_still_give_an_order() {
    let mut fixture = grid(1.0, 1.0, 60, 60);
    for (index, bad) in [f64::NAN, f64::INFINITY, f64::MAX, -f64::MAX]
        .into_iter()
        .enumerate()
    {
        fixture.positions[100 * index + 7].y = bad;
    }
    let ordering = Ordering::nested_dissection(&graph(&fixture), &fixture.positions);
    assert!(is_permutation(&ordering));
}

#[test]
fn the_order_is_the_same_for_any_number_of_threads() {
    let fixture = bumpy_torus();
    let graph = graph(&fixture);
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| Ordering::nested_dissection(&graph, &fixture.positions))
    };
    assert_eq!(with_threads(1), with_threads(4));
}

#[test]
fn a_vertex_that_meets_all_others_is_eliminated_last() {
    let fixture = disk(40);
    let count = fixture.positions.len() as u32;
    let hub = (0..count).map(|vertex| [count, vertex]);
    let edges: Vec<_> = edges(&fixture).into_iter().chain(hub).collect();
    let graph = Graph::from_edges(count as usize + 1, edges.into_iter());
    let mut points = fixture.positions;
    points.push(DVec3::ZERO);
    let ordering = Ordering::nested_dissection(&graph, &points);
    assert!(is_permutation(&ordering));
    assert_eq!(ordering.order().last(), Some(&count));
}

#[test]
fn components_do_not_mix() {
    let one = icosphere(4);
    let both = one.clone().joined(&one);
    let alone = fill(
        &one,
        &Ordering::nested_dissection(&graph(&one), &one.positions),
    );
    let order = Ordering::nested_dissection(&graph(&both), &both.positions);
    assert!(is_permutation(&order));
    // Coincident components are told apart by the graph alone.
    assert_eq!(fill(&both, &order), 2 * alone);
}

#[test]
fn empty_and_edgeless_graphs_have_orders() {
    for count in [0, 1, 2, 500] {
        let graph = Graph::from_edges(count, std::iter::empty());
        assert!(is_permutation(&Ordering::nested_dissection(
            &graph,
            &vec![DVec3::ZERO; count]
        )));
        assert!(is_permutation(&Ordering::minimum_degree(&graph)));
    }
}

#[test]
fn unknowns_of_one_vertex_follow_each_other() {
    let ordering = Ordering::from_order(vec![2, 0, 1]).unwrap();
    assert_eq!(ordering.expanded(2).order(), [4, 5, 0, 1, 2, 3]);
    assert_eq!(Ordering::from_order(vec![0, 0]), None);
    assert_eq!(Ordering::from_order(vec![0, 2]), None);
}

#[test]
fn blocks_are_ordered_by_their_points() {
    let fixture = torus(1.0, 0.4, 90, 60);
    let vertices = laplacian(&fixture, 1.0);
    let blocks = vertices
        .lower()
        .triplets()
        .flat_map(|(row, column, value)| {
            [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[r, c]| (2 * row + r, 2 * column + c, value))
        });
    let order = 2 * fixture.positions.len();
    let blocks = graticule::solve::SparseMatrix::from_triplets(order, order, blocks).unwrap();
    let placement = Placement::at(&fixture.positions);
    let single = placement.ordering(vertices.lower().pattern()).unwrap();
    let double = placement.with_block(2).ordering(blocks.pattern()).unwrap();
    assert_eq!(double, single.expanded(2));
    assert!(placement.ordering(blocks.pattern()).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn any_graph_and_any_points_give_a_permutation(
        count in 1_usize..700,
        seed in any::<u64>(),
        density in 0_usize..6,
        distinct in 1_usize..30,
    ) {
        let mut noise = Noise::new(seed);
        let edges: Vec<[u32; 2]> = (0..density * count)
            .map(|_| [noise.below(count) as u32, noise.below(count) as u32])
            .collect();
        let graph = Graph::from_edges(count, edges.into_iter());
        let mut coordinate = || noise.below(distinct) as f64;
        let points: Vec<DVec3> = (0..count)
            .map(|_| DVec3::new(coordinate(), coordinate(), 0.0))
            .collect();
        let ordering = Ordering::nested_dissection(&graph, &points);
        prop_assert!(is_permutation(&ordering));
        let inverse: Vec<u32> = (0..count as u32)
            .map(|place| ordering.places()[ordering.order()[place as usize] as usize])
            .collect();
        prop_assert!(inverse.into_iter().eq(0..count as u32));
    }
}
