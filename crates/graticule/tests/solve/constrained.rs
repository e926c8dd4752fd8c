use graticule::solve::{
    DirichletLu, DirichletSystem, Placement, SaddleSystem, SolveError, SparseMatrix,
    SymmetricMatrix,
};
use graticule_fixtures::{bumpy_patch, disk, torus};

use crate::common::{
    dense, dense_solve, difference, laplacian, random, random_definite, random_general,
};

#[test]
fn eliminated_unknowns_keep_their_values_and_the_rest_fulfils_its_equations() {
    let fixture = bumpy_patch(12, 1);
    let matrix = laplacian(&fixture, 0.0);
    let fixed = [5, 0, 200, 33];
    let system = DirichletSystem::new(&matrix, &fixed, Placement::at(&fixture.positions)).unwrap();
    let fixed_values = random(8, 1);
    let loads = random(2 * matrix.order(), 2);
    let solution = system.solve_with_loads(&fixed_values, &loads).unwrap();
    for (column, x) in solution.columns(matrix.order()).enumerate() {
        let image = matrix.multiply(x);
        for (row, value) in image.iter().enumerate() {
            match fixed.iter().position(|&unknown| unknown == row) {
                Some(place) => assert_eq!(x[row], fixed_values[4 * column + place]),
                None => assert!((value - loads[column * matrix.order() + row]).abs() < 1e-11),
            }
        }
    }
    let unloaded = system.solve(&fixed_values).unwrap();
    let zero = vec![0.0; 2 * matrix.order()];
    assert_eq!(
        unloaded,
        system.solve_with_loads(&fixed_values, &zero).unwrap()
    );
}

#[test]
fn elimination_agrees_with_a_large_penalty() {
    let fixture = disk(8);
    let matrix = laplacian(&fixture, 0.0);
    let (fixed, values) = ([3, 90, 150], [0.0, 1.0, 2.0]);
    let system = DirichletSystem::new(&matrix, &fixed, Placement::unknown()).unwrap();
    let exact = system.solve(&values).unwrap();
    let mut rows = dense(&matrix.to_full());
    let mut b = vec![0.0; matrix.order()];
    for (unknown, value) in fixed.into_iter().zip(values) {
        rows[unknown][unknown] += 1e9;
        b[unknown] = 1e9 * value;
    }
    assert!(difference(&exact.values, &dense_solve(rows, &b)) < 1e-7);
}

#[test]
fn constants_are_reproduced() {
    let fixture = torus(1.0, 0.4, 60, 50);
    let matrix = laplacian(&fixture, 0.0);
    let fixed: Vec<usize> = (0..100).chain(1500..1600).collect();
    let system = DirichletSystem::new(&matrix, &fixed, Placement::at(&fixture.positions)).unwrap();
    let solution = system.solve(&vec![3.5; 200]).unwrap();
    assert!(
        solution
            .values
            .iter()
            .all(|value| (value - 3.5).abs() < 1e-11)
    );
}

#[test]
fn everything_or_nothing_fixed() {
    let matrix = random_definite(6, 2);
    let all: Vec<usize> = (0..6).rev().collect();
    let values = [5.0, 4.0, 3.0, 2.0, 1.0, 0.0];
    let system = DirichletSystem::new(&matrix, &all, Placement::unknown()).unwrap();
    assert_eq!(
        system.solve(&values).unwrap().values,
        [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    );
    let none = DirichletSystem::new(&matrix, &[], Placement::unknown()).unwrap();
    let b = random(6, 1);
    let solution = none.solve_with_loads(&[], &b).unwrap();
    assert!(difference(&dense_solve(dense(&matrix.to_full()), &b), &solution.values) < 1e-13);
}

#[test]
fn a_component_without_fixed_unknown_is_named() {
    let one = disk(5);
    let first = one.positions.len();
    let both = one.clone().joined(&one);
    let matrix = laplacian(&both, 0.0);
    let error = DirichletSystem::new(&matrix, &[0, 1], Placement::at(&both.positions)).unwrap_err();
    let SolveError::NotPositiveDefinite { column, .. } = error else {
        panic!("{error}")
    };
    assert!(column >= first);
}

#[test]
fn bad_fixed_unknowns_are_named() {
    let matrix = random_definite(6, 2);
    for (fixed, bad) in [([1, 9], 9), ([4, 4], 4)] {
        let error = DirichletSystem::new(&matrix, &fixed, Placement::unknown()).unwrap_err();
        assert!(matches!(error, SolveError::BadFixedUnknown { unknown, .. } if unknown == bad));
    }
}

#[test]
fn directed_systems_are_eliminated_likewise_and_pull_gradients_back() {
    let order = 50;
    let matrix = random_general(order, 3);
    let fixed = [4, 30, 11];
    let system = DirichletLu::new(&matrix, &fixed, Placement::unknown()).unwrap();
    let solve = |values: &[f64]| system.solve(values).unwrap().values;
    let values = [1.0, -2.0, 0.5];
    let x = solve(&values);
    let image = matrix.multiply(&x);
    let free = system.free().iter().map(|&row| image[row as usize].abs());
    assert!(free.fold(0.0, f64::max) < 1e-10);
    let gradient = random(order, 1);
    let pulled = system.pull_back(&gradient).unwrap().values;
    let value = |x: &[f64]| x.iter().zip(&gradient).map(|(x, g)| x * g).sum::<f64>();
    for place in 0..3 {
        // The map is linear: differences of any length are exact.
        let mut moved = values;
        moved[place] += 1.0;
        let slope = value(&solve(&moved)) - value(&x);
        assert!((slope - pulled[place]).abs() < 1e-9 * slope.abs().max(1.0));
    }
}

/// `[K Bᵀ; B 0]`, dense.
fn dense_saddle(matrix: &SymmetricMatrix, constraints: &SparseMatrix) -> Vec<Vec<f64>> {
    let order = matrix.order() + constraints.rows();
    let mut rows = dense(&matrix.to_full());
    for row in &mut rows {
        row.resize(order, 0.0);
    }
    rows.resize(order, vec![0.0; order]);
    for (row, column, value) in constraints.triplets() {
        rows[matrix.order() + row][column] = value;
        rows[column][matrix.order() + row] = value;
    }
    rows
}

#[test]
fn saddle_systems_agree_with_dense_elimination() {
    let matrix = random_definite(40, 1);
    let triplets = [
        (0, 3, 1.0),
        (0, 9, -1.0),
        (1, 20, 0.5),
        (1, 21, 0.25),
        (1, 22, 0.25),
    ];
    let constraints = SparseMatrix::from_triplets(2, 40, triplets).unwrap();
    let system = SaddleSystem::new(&matrix, &constraints, Placement::unknown()).unwrap();
    let [loads, targets] = [random(80, 1), random(4, 2)];
    let solution = system.solve(&loads, &targets).unwrap();
    for column in 0..2 {
        let mut b = loads[40 * column..][..40].to_vec();
        b.extend(&targets[2 * column..][..2]);
        let exact = dense_solve(dense_saddle(&matrix, &constraints), &b);
        assert!(difference(&exact[..40], &solution.values[40 * column..][..40]) < 1e-12);
        assert!(difference(&exact[40..], &solution.multipliers[2 * column..][..2]) < 1e-11);
    }
}

#[test]
fn a_singular_laplacian_is_held_by_its_constraints_alone() {
    let fixture = bumpy_patch(20, 1);
    let count = fixture.positions.len();
    let matrix = laplacian(&fixture, 0.0);
    let pins = SparseMatrix::from_triplets(2, count, [(0, 17, 1.0), (1, 800, 1.0)]).unwrap();
    let placement = Placement::at(&fixture.positions);
    let system = SaddleSystem::new(&matrix, &pins, placement).unwrap();
    let solution = system.solve(&vec![0.0; count], &[1.0, 2.0]).unwrap();
    let eliminated = DirichletSystem::new(&matrix, &[17, 800], placement).unwrap();
    let expected = eliminated.solve(&[1.0, 2.0]).unwrap();
    assert!(difference(&expected.values, &solution.values) < 1e-11);
    assert!(solution.residual < 1e-13);
}

#[test]
fn one_constraint_on_all_unknowns_fixes_their_mean() {
    let fixture = torus(1.0, 0.4, 90, 60);
    let count = fixture.positions.len();
    let matrix = laplacian(&fixture, 0.0);
    let mean = (0..count).map(|unknown| (0, unknown, 1.0));
    let mean = SparseMatrix::from_triplets(1, count, mean).unwrap();
    let system = SaddleSystem::new(&matrix, &mean, Placement::at(&fixture.positions)).unwrap();
    let mut loads = random(count, 1);
    let average = loads.iter().sum::<f64>() / count as f64;
    for load in &mut loads {
        *load -= average;
    }
    let solution = system.solve(&loads, &[0.0]).unwrap();
    assert!(solution.multipliers[0].abs() < 1e-10);
    let image = matrix.multiply(&solution.values);
    assert!(difference(&loads, &image) < 1e-10);
    assert!(solution.values.iter().sum::<f64>().abs() < 1e-8);
}

#[test]
fn scales_of_matrix_and_constraints_do_not_matter() {
    let fixture = disk(10);
    let count = fixture.positions.len();
    let matrix = laplacian(&fixture, 0.0);
    let triplets = [(0, 5, 1.0), (1, 60, 0.5), (1, 61, 0.5)];
    let solve = |matrix_scale: f64, constraint_scale: f64| {
        let values = matrix
            .lower()
            .values()
            .iter()
            .map(|v| v * matrix_scale)
            .collect();
        let matrix = matrix.with_values(values).unwrap();
        let rows = triplets.map(|(r, c, v)| (r, c, v * constraint_scale));
        let rows = SparseMatrix::from_triplets(2, count, rows).unwrap();
        let system = SaddleSystem::new(&matrix, &rows, Placement::unknown()).unwrap();
        let targets = [1.0, 3.0].map(|v| v * constraint_scale);
        system.solve(&vec![0.0; count], &targets).unwrap().values
    };
    let plain = solve(1.0, 1.0);
    for (k, b) in [
        (1e30, 1.0),
        (1e-30, 1.0),
        (1.0, 1e30),
        (1.0, 1e-30),
        (1e-30, 1e30),
    ] {
        assert!(difference(&plain, &solve(k, b)) < 1e-11, "at {k:e}, {b:e}");
    }
}

fn constrained(rows: &[(usize, usize, f64)], count: usize) -> SaddleSystem {
    let matrix = random_definite(10, 4);
    let constraints = SparseMatrix::from_triplets(count, 10, rows.iter().copied()).unwrap();
    SaddleSystem::new(&matrix, &constraints, Placement::unknown()).unwrap()
}

#[test]
fn redundant_constraints_are_accepted() {
    // The third is twice the first minus the second; the fourth repeats the second.
    let rows = [
        (0, 1, 1.0),
        (0, 2, 1.0),
        (1, 2, 1.0),
        (1, 3, 1.0),
        (2, 1, 2.0),
        (2, 2, 1.0),
        (2, 3, -1.0),
        (3, 2, 1e9),
        (3, 3, 1e9),
    ];
    let system = constrained(&rows, 4);
    assert_eq!(system.redundant(), [2, 3]);
    let loads = random(10, 1);
    let solution = system.solve(&loads, &[0.7, 0.2, 1.2, 0.2e9]).unwrap();
    let alone = constrained(&rows[..4], 2)
        .solve(&loads, &[0.7, 0.2])
        .unwrap();
    assert_eq!(solution.values, alone.values);
    assert_eq!(solution.multipliers[2..], [0.0, 0.0]);
}

#[test]
fn contradictory_constraints_are_named() {
    let rows = [(0, 1, 1.0), (1, 1, 1.0), (1, 2, 1.0), (2, 2, 4.0)];
    let system = constrained(&rows, 3);
    let error = system.solve(&[0.0; 10], &[1.0, 3.0, 9.0]).unwrap_err();
    let SolveError::ContradictoryConstraint {
        row,
        implied,
        asked,
    } = error
    else {
        panic!("{error}")
    };
    assert_eq!((row, asked), (2, 9.0));
    assert!((implied - 8.0).abs() < 1e-12);
    assert!(system.solve(&[0.0; 10], &[1.0, 3.0, 8.0]).is_ok());
}

#[test]
fn constraints_without_coefficients_ask_for_zero() {
    let system = constrained(&[(1, 0, 1.0)], 2);
    assert!(system.solve(&[0.0; 10], &[0.0, 1.0]).is_ok());
    let error = system.solve(&[0.0; 10], &[2.0, 1.0]).unwrap_err();
    assert_eq!(error, SolveError::EmptyConstraint { row: 0, asked: 2.0 });
}

#[test]
fn no_constraints_at_all_is_a_plain_system() {
    let matrix = random_definite(10, 4);
    let none = SparseMatrix::from_triplets(0, 10, []).unwrap();
    let system = SaddleSystem::new(&matrix, &none, Placement::unknown()).unwrap();
    let b = random(10, 7);
    let exact = dense_solve(dense(&matrix.to_full()), &b);
    assert!(difference(&exact, &system.solve(&b, &[]).unwrap().values) < 1e-13);
}
