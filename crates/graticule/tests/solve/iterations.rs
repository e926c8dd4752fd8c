use std::time::Duration;

use graticule::solve::{
    Cholesky, ConjugateGradientOptions, EigenOptions, Identity, IncompleteCholesky, Jacobi,
    ParallelMatrix, Pencil, Placement, SolveError, SymmetricMatrix, conjugate_gradients,
    smallest_eigenvector,
};
use graticule::watch::Watch;
use graticule_fixtures::{Fixture, bumpy_patch, disk, torus};

use crate::common::{difference, laplacian, random, random_definite};

fn options(tolerance: f64) -> ConjugateGradientOptions<'static> {
    ConjugateGradientOptions {
        tolerance,
        ..Default::default()
    }
}

fn direct(fixture: &Fixture, matrix: &SymmetricMatrix, b: &[f64]) -> Vec<f64> {
    let ordering = Placement::at(&fixture.positions).ordering(matrix.lower().pattern());
    Cholesky::new(matrix, &ordering.unwrap())
        .unwrap()
        .solve(b)
        .unwrap()
        .values
}

#[test]
fn conjugate_gradients_agree_with_cholesky_under_every_preconditioner() {
    let fixture = bumpy_patch(20, 1);
    let matrix = laplacian(&fixture, 1e-2);
    let b = random(matrix.order(), 1);
    let expected = direct(&fixture, &matrix, &b);
    let (run, watch) = (options(1e-12), Watch::new());
    let jacobi = Jacobi::new(&matrix).unwrap();
    let incomplete = IncompleteCholesky::new(&matrix).unwrap();
    assert_eq!(incomplete.shift(), 0.0);
    let by_none = conjugate_gradients(&matrix, &Identity, &b, run, &watch).unwrap();
    let by_jacobi = conjugate_gradients(&matrix, &jacobi, &b, run, &watch).unwrap();
    let by_incomplete = conjugate_gradients(&matrix, &incomplete, &b, run, &watch).unwrap();
    for solution in [&by_none, &by_jacobi, &by_incomplete] {
        assert!(difference(&expected, &solution.values) < 1e-9);
        assert!(solution.residual <= 1e-12);
    }
    assert!(2 * by_incomplete.iterations < by_jacobi.iterations);
}

#[test]
fn incomplete_cholesky_without_fill_to_leave_out_is_exact() {
    // A tree eliminated from the leaves has no fill.
    let chain = SymmetricMatrix::laplacian(50, (0..49).map(|i| ([i, i + 1], 1.0))).unwrap();
    let entries = chain.lower().triplets().chain([(49, 49, 1.0)]);
    let matrix = SymmetricMatrix::from_triplets(50, entries).unwrap();
    let incomplete = IncompleteCholesky::new(&matrix).unwrap();
    let (run, watch) = (options(1e-10), Watch::new());
    let solution = conjugate_gradients(&matrix, &incomplete, &random(50, 1), run, &watch).unwrap();
    assert_eq!(solution.iterations, 1);
}

#[test]
fn incomplete_cholesky_is_strengthened_where_a_pivot_fails() {
    // Definite, but its incomplete factor does not exist (Kershaw 1978).
    let triplets = [
        (0, 0, 3.0),
        (0, 1, -2.0),
        (0, 3, 2.0),
        (1, 1, 3.0),
        (1, 2, -2.0),
        (2, 2, 3.0),
        (2, 3, -2.0),
        (3, 3, 3.0),
    ];
    let matrix = SymmetricMatrix::from_triplets(4, triplets).unwrap();
    let incomplete = IncompleteCholesky::new(&matrix).unwrap();
    assert!(incomplete.shift() > 0.0);
    let (run, watch) = (options(1e-12), Watch::new());
    let b = matrix.multiply(&[1.0, 2.0, 3.0, 4.0]);
    let solution = conjugate_gradients(&matrix, &incomplete, &b, run, &watch).unwrap();
    assert!(difference(&[1.0, 2.0, 3.0, 4.0], &solution.values) < 1e-10);
}

#[test]
fn a_start_at_the_solution_needs_no_iteration() {
    let matrix = random_definite(100, 5);
    let x = random(100, 1);
    let b = matrix.multiply(&x);
    let watch = Watch::new();
    let run = ConjugateGradientOptions {
        start: Some(&x),
        ..options(1e-12)
    };
    let warm = conjugate_gradients(&matrix, &Identity, &b, run, &watch).unwrap();
    assert_eq!(warm.iterations, 0);
    let zero = conjugate_gradients(&matrix, &Identity, &[0.0; 100], run, &watch).unwrap();
    assert_eq!(zero.values, [0.0; 100]);
}

#[test]
fn the_result_is_the_same_for_any_number_of_threads() {
    let fixture = torus(1.0, 0.4, 400, 200);
    let matrix = laplacian(&fixture, 1.0);
    let parallel = ParallelMatrix::new(&matrix);
    let b = random(matrix.order(), 1);
    let jacobi = Jacobi::new(&matrix).unwrap();
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let watch = Watch::new();
        let run = || conjugate_gradients(&parallel, &jacobi, &b, options(1e-8), &watch);
        pool.install(run).unwrap()
    };
    assert_eq!(with_threads(1), with_threads(3));
}

#[test]
fn scale_does_not_matter_to_conjugate_gradients() {
    let matrix = random_definite(60, 3);
    let b = random(60, 1);
    let (run, watch) = (options(1e-12), Watch::new());
    let solve = |scale: f64| {
        let values = matrix.lower().values().iter().map(|v| v * scale).collect();
        let matrix = matrix.with_values(values).unwrap();
        let b: Vec<f64> = b.iter().map(|b| b * scale).collect();
        conjugate_gradients(&matrix, &Jacobi::new(&matrix).unwrap(), &b, run, &watch).unwrap()
    };
    let plain = solve(1.0);
    for scale in [1e-30, 1e30] {
        assert!(difference(&plain.values, &solve(scale).values) < 1e-12);
    }
}

#[test]
fn an_iteration_that_does_not_end_well_says_so() {
    let matrix = laplacian(&disk(20), 1e-3);
    let b = random(matrix.order(), 1);
    let watch = Watch::new();
    let few = ConjugateGradientOptions {
        most_iterations: 5,
        ..options(1e-12)
    };
    let error = conjugate_gradients(&matrix, &Identity, &b, few, &watch).unwrap_err();
    assert!(
        matches!(error, SolveError::NotConverged { iterations: 5, .. }),
        "{error}"
    );
    let negative = SymmetricMatrix::from_triplets(2, [(0, 0, 1.0), (1, 1, -1.0)]).unwrap();
    let error =
        conjugate_gradients(&negative, &Identity, &[0.0, 1.0], options(1e-12), &watch).unwrap_err();
    assert!(
        matches!(error, SolveError::IndefiniteOperator { .. }),
        "{error}"
    );
    assert!(Jacobi::new(&negative).is_err());
    let late = Watch::new().with_time_limit(Duration::ZERO);
    let error = conjugate_gradients(&matrix, &Identity, &b, options(1e-12), &late);
    assert!(matches!(error.unwrap_err(), SolveError::Stopped(_)));
}

fn pencil<'a>(
    stiffness: &'a SymmetricMatrix,
    mass: &'a SymmetricMatrix,
    deflated: &'a [Vec<f64>],
) -> Pencil<'a> {
    Pencil {
        stiffness,
        mass,
        deflated,
    }
}

#[test]
fn the_smallest_eigenvector_of_a_chain_is_a_cosine() {
    let count = 200;
    let chain = SymmetricMatrix::laplacian(count, (0..count - 1).map(|i| ([i, i + 1], 1.0)));
    let chain = chain.unwrap();
    let mass = SymmetricMatrix::from_triplets(count, (0..count).map(|i| (i, i, 1.0))).unwrap();
    let ordering = Placement::unknown()
        .ordering(chain.lower().pattern())
        .unwrap();
    let (run, watch) = (EigenOptions::default(), Watch::new());
    let pair = smallest_eigenvector(
        pencil(&chain, &mass, &[vec![1.0; count]]),
        &ordering,
        run,
        &watch,
    )
    .unwrap();
    let angle = std::f64::consts::PI / count as f64;
    assert!((pair.value - (2.0 - 2.0 * angle.cos())).abs() < 1e-11);
    let cosine: Vec<f64> = (0..count)
        .map(|i| (angle * (i as f64 + 0.5)).cos())
        .collect();
    let sign = pair.vector[0].signum() * (2.0 / count as f64).sqrt();
    let scaled: Vec<f64> = cosine.iter().map(|c| c * sign).collect();
    assert!(difference(&scaled, &pair.vector) < 1e-6);
    assert!(pair.residual <= 1e-12);
}

#[test]
fn a_mass_on_few_unknowns_is_enough() {
    let matrix = laplacian(&disk(12), 0.0);
    let count = matrix.order();
    // Mass on the outermost ring only, as for a spectral conformal map.
    let ring: Vec<_> = (count - 72..count).map(|i| (i, i, 1.0)).collect();
    let mass = SymmetricMatrix::from_triplets(count, ring).unwrap();
    let ordering = Placement::unknown()
        .ordering(matrix.lower().pattern())
        .unwrap();
    let (run, watch) = (EigenOptions::default(), Watch::new());
    let pair = smallest_eigenvector(
        pencil(&matrix, &mass, &[vec![1.0; count]]),
        &ordering,
        run,
        &watch,
    )
    .unwrap();
    assert!(pair.value > 0.0);
    let image = matrix.multiply(&pair.vector);
    let weighed = mass.multiply(&pair.vector);
    let apart = image
        .iter()
        .zip(weighed)
        .map(|(a, b)| (a - pair.value * b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-10);
    let constant: f64 = pair.vector[count - 72..].iter().sum();
    assert!(constant.abs() < 1e-9);
}

#[test]
fn a_pencil_without_energy_in_some_direction_is_refused() {
    let nothing = SymmetricMatrix::from_triplets(3, [(0, 0, 1.0)]).unwrap();
    let ordering = Placement::unknown()
        .ordering(nothing.lower().pattern())
        .unwrap();
    let (run, watch) = (EigenOptions::default(), Watch::new());
    let error =
        smallest_eigenvector(pencil(&nothing, &nothing, &[]), &ordering, run, &watch).unwrap_err();
    assert!(
        matches!(error, SolveError::NotPositiveDefinite { .. }),
        "{error}"
    );
}
