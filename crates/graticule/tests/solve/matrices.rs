use graticule::solve::{SolveError, SparseMatrix, SymmetricMatrix};

use crate::common::{dense, difference, random, random_general};

#[test]
fn equal_places_are_summed_and_rows_ascend() {
    let triplets = [(2, 1, 1.0), (0, 1, 2.0), (2, 1, 3.0), (1, 0, 5.0)];
    let matrix = SparseMatrix::from_triplets(3, 2, triplets).unwrap();
    let all: Vec<_> = matrix.triplets().collect();
    assert_eq!(all, [(1, 0, 5.0), (0, 1, 2.0), (2, 1, 4.0)]);
    assert_eq!(matrix.get(2, 1), 4.0);
    assert_eq!(matrix.get(0, 0), 0.0);
}

#[test]
fn sums_run_in_the_order_given() {
    // In another order the small number would survive.
    let triplets = [(0, 0, 1.0), (0, 0, 1e-17), (0, 0, -1.0)];
    let matrix = SparseMatrix::from_triplets(1, 1, triplets).unwrap();
    assert_eq!(matrix.get(0, 0), 0.0);
}

#[test]
fn products_agree_with_the_transposed_matrix() {
    let matrix = random_general(60, 1);
    let [x, y] = [random(60, 2), random(60, 3)];
    let transposed = matrix.transpose();
    assert_eq!(transposed.transpose(), matrix);
    assert!(difference(&transposed.multiply(&x), &matrix.multiply_transposed(&x)) < 1e-14);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let [left, right] = [
        dot(&y, &matrix.multiply(&x)),
        dot(&matrix.multiply_transposed(&y), &x),
    ];
    assert!((left - right).abs() < 1e-12);
    assert_eq!(matrix.row_sum_norm(), transposed.column_sum_norm());
}

#[test]
fn a_symmetric_matrix_is_its_full_form() {
    let triplets = [(0, 1, 2.0), (2, 1, 3.0), (1, 1, 7.0)];
    let matrix = SymmetricMatrix::from_triplets(3, triplets).unwrap();
    let full = matrix.to_full();
    let expected = [[0.0, 2.0, 0.0], [2.0, 7.0, 3.0], [0.0, 3.0, 0.0]];
    assert_eq!(dense(&full), expected);
    assert_eq!(SymmetricMatrix::from_full(&full).unwrap(), matrix);
    assert_eq!(
        matrix.multiply(&[1.0, 2.0, 3.0]),
        full.multiply(&[1.0, 2.0, 3.0])
    );
    assert_eq!(matrix.row_sum_norm(), 12.0);
}

#[test]
fn rows_of_a_laplacian_sum_to_zero() {
    let edges = [([0, 1], 2.0), ([1, 2], 0.5), ([2, 0], 4.0)];
    let laplacian = SymmetricMatrix::laplacian(3, edges).unwrap();
    assert_eq!(laplacian.multiply(&[1.0; 3]), [0.0; 3]);
    assert_eq!(laplacian.diagonal(), [6.0, 2.5, 4.5]);
}

#[test]
fn entries_that_are_not_finite_are_named() {
    let triplets = [(0, 0, 1.0), (2, 1, f64::NAN)];
    let error = SparseMatrix::from_triplets(3, 3, triplets).unwrap_err();
    assert!(matches!(
        error,
        SolveError::NonFinite {
            row: 2,
            column: 1,
            ..
        }
    ));
    let overflow = [(1, 2, f64::MAX), (1, 2, f64::MAX)];
    let error = SparseMatrix::from_triplets(3, 3, overflow).unwrap_err();
    assert!(matches!(
        error,
        SolveError::NonFinite {
            row: 1,
            column: 2,
            ..
        }
    ));
}

#[test]
fn places_outside_and_asymmetry_are_named() {
    let error = SparseMatrix::from_triplets(2, 2, [(0, 2, 1.0)]).unwrap_err();
    assert!(matches!(
        error,
        SolveError::OutOfRange {
            row: 0,
            column: 2,
            ..
        }
    ));
    let lopsided = SparseMatrix::from_triplets(2, 2, [(0, 1, 1.0), (1, 0, 2.0)]).unwrap();
    let error = SymmetricMatrix::from_full(&lopsided).unwrap_err();
    assert!(matches!(error, SolveError::NotSymmetric { .. }));
}
