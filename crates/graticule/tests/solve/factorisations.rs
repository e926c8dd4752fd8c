use graticule::solve::{
    Cholesky, Exchange, Graph, Ldlt, Lu, LuSymbolic, Ordering, Placement, SolveError, SparseMatrix,
    Symbolic, SymmetricMatrix,
};
use graticule_fixtures::{bumpy_patch, disk, torus};

use crate::common::{
    dense, dense_solve, difference, edges, laplacian, random, random_definite, random_general,
};

fn degree_order(matrix: &SparseMatrix) -> Ordering {
    Ordering::minimum_degree(&Graph::of_pattern(matrix.pattern()))
}

fn cholesky(matrix: &SymmetricMatrix) -> Cholesky {
    Cholesky::new(matrix, &degree_order(matrix.lower())).unwrap()
}

#[test]
fn cholesky_agrees_with_dense_elimination() {
    for (order, seed) in [(1, 1), (2, 2), (7, 3), (90, 4)] {
        let matrix = random_definite(order, seed);
        let b = random(2 * order, seed);
        let solution = cholesky(&matrix).solve(&b).unwrap();
        assert!(solution.residual <= 1e-14);
        for (column, b) in solution.columns(order).zip(b.chunks(order)) {
            let exact = dense_solve(dense(&matrix.to_full()), b);
            assert!(difference(&exact, column) < 1e-12);
        }
    }
}

#[test]
fn block_and_scalar_factorisations_agree() {
    // Large enough that blocks of columns pay.
    let fixture = torus(1.0, 0.4, 70, 50);
    let matrix = laplacian(&fixture, 1e-3);
    let b = random(matrix.order(), 1);
    let placement = Placement::at(&fixture.positions);
    let ordering = placement.ordering(matrix.lower().pattern()).unwrap();
    let [one, other] = [&ordering, &Ordering::natural(matrix.order())]
        .map(|ordering| Cholesky::new(&matrix, ordering).unwrap().solve(&b).unwrap());
    assert!(difference(&one.values, &other.values) < 1e-10);
    let lu = Lu::new(&matrix.to_full(), &ordering).unwrap();
    assert_eq!(lu.exchange(), Exchange::WithinBlocks);
    assert!(difference(&one.values, &lu.solve(&b).unwrap().values) < 1e-10);
}

#[test]
fn a_plan_held_for_reuse_gives_what_a_fresh_one_gives() {
    let fixture = disk(30);
    let first = laplacian(&fixture, 1.0);
    let second = first.with_values(laplacian(&fixture, 0.25).lower().values().to_vec());
    let second = second.unwrap();
    let ordering = degree_order(first.lower());
    let symbolic = Symbolic::new(&first, &ordering).unwrap();
    let b = random(first.order(), 3);
    Cholesky::factor(&symbolic, &first)
        .unwrap()
        .solve(&b)
        .unwrap();
    let reused = Cholesky::factor(&symbolic, &second)
        .unwrap()
        .solve(&b)
        .unwrap();
    let fresh = Cholesky::new(&second, &ordering)
        .unwrap()
        .solve(&b)
        .unwrap();
    assert_eq!(reused, fresh);
    let other = laplacian(&disk(29), 1.0);
    assert!(matches!(
        Cholesky::factor(&symbolic, &other),
        Err(SolveError::PatternMismatch)
    ));
}

#[test]
fn scaling_by_a_power_of_two_changes_no_digit() {
    let matrix = laplacian(&bumpy_patch(20, 1), 1e-4);
    let general = random_general(200, 4);
    let b = random(matrix.order(), 3);
    let plain = cholesky(&matrix).solve(&b).unwrap();
    let lu_plain = Lu::new(&general, &degree_order(&general)).unwrap();
    let lu_plain = lu_plain.solve(&b[..200]).unwrap();
    for exponent in [-600, -100, 40, 100, 600] {
        let scale = 2.0_f64.powi(exponent);
        let values = matrix.lower().values().iter().map(|v| v * scale).collect();
        let scaled = matrix.with_values(values).unwrap();
        let solution = cholesky(&scaled).solve(&b).unwrap();
        assert_eq!(solution.residual, plain.residual, "at 2^{exponent}");
        let rescaled: Vec<f64> = solution.values.iter().map(|v| v * scale).collect();
        assert_eq!(rescaled, plain.values, "at 2^{exponent}");
        let scaled = general.scaled(scale).unwrap();
        let solution = Lu::new(&scaled, &degree_order(&scaled)).unwrap();
        let solution = solution.solve(&b[..200]).unwrap();
        let rescaled: Vec<f64> = solution.values.iter().map(|v| v * scale).collect();
        assert_eq!(rescaled, lu_plain.values, "at 2^{exponent}");
    }
}

#[test]
fn right_hand_sides_of_any_size_are_solved_alike() {
    let matrix = random_definite(50, 9);
    let b = random(50, 2);
    let factor = cholesky(&matrix);
    let plain = factor.solve(&b).unwrap();
    for scale in [2.0_f64.powi(-900), 2.0_f64.powi(900)] {
        let scaled: Vec<f64> = b.iter().map(|v| v * scale).collect();
        let solution = factor.solve(&scaled).unwrap();
        let back: Vec<f64> = solution.values.iter().map(|v| v / scale).collect();
        assert_eq!(back, plain.values);
    }
    assert_eq!(factor.solve(&[0.0; 50]).unwrap().values, [0.0; 50]);
    assert!(factor.solve(&[]).unwrap().values.is_empty());
}

#[test]
fn a_matrix_that_is_not_definite_is_refused_at_its_column() {
    // One component with a negative pivot; the others are fine.
    let mut triplets: Vec<_> = (0..40).map(|i| (i, i, 2.0)).collect();
    triplets.push((17, 23, 3.0));
    let matrix = SymmetricMatrix::from_triplets(40, triplets).unwrap();
    let error = Cholesky::new(&matrix, &degree_order(matrix.lower())).unwrap_err();
    let SolveError::NotPositiveDefinite { column, pivot } = error else {
        panic!("{error}")
    };
    assert!(column == 17 || column == 23);
    assert!((pivot - (2.0 - 9.0 / 2.0)).abs() < 1e-14);
}

#[test]
fn indefinite_blocks_of_columns_are_refused_too() {
    let fixture = torus(1.0, 0.4, 120, 90);
    let mut triplets: Vec<_> = laplacian(&fixture, 1e-2).lower().triplets().collect();
    triplets.push((5000, 5000, -20.0));
    let matrix = SymmetricMatrix::from_triplets(fixture.positions.len(), triplets).unwrap();
    let placement = Placement::at(&fixture.positions);
    let ordering = placement.ordering(matrix.lower().pattern()).unwrap();
    let error = Cholesky::new(&matrix, &ordering).unwrap_err();
    let SolveError::NotPositiveDefinite { pivot, .. } = error else {
        panic!("{error}")
    };
    assert!(pivot < 0.0);
}

#[test]
fn a_laplacian_without_anything_fixed_is_refused() {
    for fixture in [disk(3), disk(30), torus(1.0, 0.4, 120, 90)] {
        let matrix = laplacian(&fixture, 0.0);
        let placement = Placement::at(&fixture.positions);
        let ordering = placement.ordering(matrix.lower().pattern()).unwrap();
        let error = Cholesky::new(&matrix, &ordering).unwrap_err();
        assert!(
            matches!(error, SolveError::NotPositiveDefinite { .. }),
            "{error}"
        );
    }
}

#[test]
fn lu_agrees_with_dense_elimination_straight_and_transposed() {
    for (order, seed) in [(1, 1), (2, 5), (9, 3), (120, 4)] {
        let matrix = random_general(order, seed);
        let lu = Lu::new(&matrix, &degree_order(&matrix)).unwrap();
        let b = random(2 * order, seed);
        let straight = lu.solve(&b).unwrap();
        let transposed = lu.solve_transposed(&b).unwrap();
        for (column, b) in b.chunks(order).enumerate() {
            let range = column * order..(column + 1) * order;
            let exact = dense_solve(dense(&matrix), b);
            assert!(difference(&exact, &straight.values[range.clone()]) < 1e-9);
            let exact = dense_solve(dense(&matrix.transpose()), b);
            assert!(difference(&exact, &transposed.values[range]) < 1e-9);
        }
    }
}

/// Rows sum to zero, neighbours have other weights in each direction, the boundary is heavier.
fn directed_laplacian(order: usize, edges: &[[u32; 2]]) -> SparseMatrix {
    let weights = random(2 * edges.len(), 8);
    let triplets = edges
        .iter()
        .zip(weights.chunks(2))
        .flat_map(|(&[a, b], w)| {
            let [a, b] = [a as usize, b as usize];
            let [ab, ba] = [1.5 + w[0], 1.5 + w[1]];
            [(a, a, ab), (a, b, -ab), (b, b, ba), (b, a, -ba)]
        });
    let diagonal = (0..order).map(|index| (index, index, 1e-3));
    SparseMatrix::from_triplets(order, order, triplets.chain(diagonal)).unwrap()
}

#[test]
fn directed_laplacians_need_no_exchanges_across_blocks() {
    let fixture = bumpy_patch(40, 2);
    let matrix = directed_laplacian(fixture.positions.len(), &edges(&fixture));
    let ordering = Placement::at(&fixture.positions)
        .ordering(matrix.pattern())
        .unwrap();
    let symbolic = LuSymbolic::new(&matrix, &ordering).unwrap();
    let lu = Lu::factor(&symbolic, &matrix).unwrap();
    assert_eq!(lu.exchange(), Exchange::WithinBlocks);
    let expected = random(2 * matrix.rows(), 5);
    let b: Vec<f64> = expected
        .chunks(matrix.rows())
        .flat_map(|x| matrix.multiply(x))
        .collect();
    assert!(difference(&expected, &lu.solve(&b).unwrap().values) < 1e-8);
    let b = matrix.multiply_transposed(&expected[..matrix.rows()]);
    let solution = lu.solve_transposed(&b).unwrap();
    assert!(difference(&expected[..matrix.rows()], &solution.values) < 1e-8);
    assert!(solution.residual < 1e-13);
}

#[test]
fn a_zero_diagonal_is_met_by_exchanging_rows() {
    let matrix = SparseMatrix::from_triplets(2, 2, [(0, 1, 2.0), (1, 0, 4.0)]).unwrap();
    let lu = Lu::new(&matrix, &Ordering::natural(2)).unwrap();
    assert_eq!(lu.solve(&[6.0, 8.0]).unwrap().values, [2.0, 3.0]);
}

#[test]
fn a_singular_matrix_is_refused_at_its_column() {
    let mut triplets: Vec<_> = (0..30).map(|i| (i, i, 1.0)).collect();
    triplets.extend([(3, 11, 1.0), (11, 3, 1.0)]);
    let matrix = SparseMatrix::from_triplets(30, 30, triplets).unwrap();
    let error = Lu::new(&matrix, &degree_order(&matrix)).unwrap_err();
    let SolveError::Singular { column, .. } = error else {
        panic!("{error}")
    };
    assert!(column == 3 || column == 11);
    let empty = SparseMatrix::from_triplets(3, 3, [(0, 0, 1.0), (2, 2, 1.0)]).unwrap();
    let error = Lu::new(&empty, &Ordering::natural(3)).unwrap_err();
    assert!(
        matches!(error, SolveError::Singular { column: 1, .. }),
        "{error}"
    );
}

#[test]
fn indefinite_systems_are_solved_with_refinement() {
    // Positive and negative pivots, and one that is exactly zero at its turn.
    let triplets = [
        (0, 0, 1.0),
        (0, 1, 1.0),
        (1, 1, 1.0),
        (1, 2, 1.0),
        (2, 2, -3.0),
    ];
    let matrix = SymmetricMatrix::from_triplets(3, triplets).unwrap();
    let factor = Ldlt::new(&matrix, &Ordering::natural(3), None).unwrap();
    let solution = factor.solve(&matrix.multiply(&[1.0, 2.0, 3.0])).unwrap();
    assert!(difference(&[1.0, 2.0, 3.0], &solution.values) < 1e-12);
    assert!(solution.residual < 1e-13);
}

#[test]
fn empty_systems_have_empty_solutions() {
    let empty = SymmetricMatrix::from_triplets(0, []).unwrap();
    let ordering = Ordering::natural(0);
    assert!(
        Cholesky::new(&empty, &ordering)
            .unwrap()
            .solve(&[])
            .unwrap()
            .values
            .is_empty()
    );
    let lu = Lu::new(&empty.to_full(), &ordering).unwrap();
    assert!(lu.solve(&[]).unwrap().values.is_empty());
    assert!(lu.solve_transposed(&[]).unwrap().values.is_empty());
    let ldlt = Ldlt::new(&empty, &ordering, None).unwrap();
    assert!(ldlt.solve(&[]).unwrap().values.is_empty());
}

#[test]
fn wrong_lengths_and_bad_numbers_on_the_right_are_named() {
    let factor = cholesky(&random_definite(5, 1));
    let error = factor.solve(&[1.0; 7]).unwrap_err();
    assert!(matches!(error, SolveError::LengthMismatch { given: 7, .. }));
    let mut b = [1.0; 10];
    b[8] = f64::INFINITY;
    let error = factor.solve(&b).unwrap_err();
    assert!(matches!(
        error,
        SolveError::NonFiniteRightSide {
            row: 3,
            column: 1,
            ..
        }
    ));
}

#[test]
fn a_solution_that_overflows_is_refused() {
    let matrix = SymmetricMatrix::from_triplets(1, [(0, 0, 1e-300)]).unwrap();
    let error = cholesky(&matrix).solve(&[1e300]).unwrap_err();
    assert!(matches!(error, SolveError::Inaccurate { .. }));
}

#[test]
fn huge_ratios_of_weights_are_solved() {
    let fixture = bumpy_patch(25, 3);
    let edges = edges(&fixture);
    let exponents = random(edges.len(), 4);
    let weighted = edges
        .iter()
        .zip(exponents)
        .map(|(&[a, b], exponent)| ([a as usize, b as usize], 10.0_f64.powf(5.7 * exponent)));
    let order = fixture.positions.len();
    let laplacian = SymmetricMatrix::laplacian(order, weighted).unwrap();
    let pinned = laplacian.lower().triplets().chain([(0, 0, 1.0)]);
    let matrix = SymmetricMatrix::from_triplets(order, pinned).unwrap();
    let solution = cholesky(&matrix).solve(&random(order, 1)).unwrap();
    assert!(solution.residual < 1e-13);
}
