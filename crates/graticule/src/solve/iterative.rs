//! Preconditioned conjugate gradients.

use rayon::prelude::*;

use super::solution::{check_solution, largest, power_of_two, relative_to};
use super::{Preconditioner, SolveError, SparseMatrix, SymmetricMatrix};
use crate::watch::Watch;

/// Sums run over pieces of this length, one after the other: the same result for any number of
/// threads.
const PIECE: usize = 4096;

/// From this length on the pieces are shared among threads.
const PARALLEL: usize = 1 << 16;

/// A symmetric positive definite operator that can be applied to a vector.
pub trait LinearOperator {
    /// Number of unknowns.
    fn order(&self) -> usize;

    /// `output = A * input`, both of length [`order`](Self::order).
    fn apply(&self, input: &[f64], output: &mut [f64]);
}

impl LinearOperator for SymmetricMatrix {
    fn order(&self) -> usize {
        SymmetricMatrix::order(self)
    }

    fn apply(&self, input: &[f64], output: &mut [f64]) {
        self.multiply_into(input, output);
    }
}

/// A symmetric matrix with both triangles stored, whose rows are multiplied in parallel.
#[derive(Clone, Debug)]
pub struct ParallelMatrix {
    full: SparseMatrix,
}

impl ParallelMatrix {
    /// Stores both triangles.
    #[must_use]
    pub fn new(matrix: &SymmetricMatrix) -> Self {
        Self {
            full: matrix.to_full(),
        }
    }
}

impl LinearOperator for ParallelMatrix {
    fn order(&self) -> usize {
        self.full.rows()
    }

    fn apply(&self, input: &[f64], output: &mut [f64]) {
        // Columns are rows: the matrix is symmetric.
        let rows = |start: usize, piece: &mut [f64]| {
            for (row, sum) in (start..).zip(piece) {
                *sum = self.full.column(row).map(|(c, v)| v * input[c]).sum();
            }
        };
        if output.len() < PARALLEL {
            rows(0, output);
        } else {
            let pieces = output.par_chunks_mut(PIECE).enumerate();
            pieces.for_each(|(piece, output)| rows(piece * PIECE, output));
        }
    }
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConjugateGradientOptions<'a> {
    /// Where to start; from zero if absent.
    pub start: Option<&'a [f64]>,
    /// The norm of the residual at which to stop, relative to that of the right-hand side.
    pub tolerance: f64,
    /// Most iterations.
    pub most_iterations: usize,
}

impl Default for ConjugateGradientOptions<'_> {
    fn default() -> Self {
        Self {
            start: None,
            tolerance: 1e-10,
            most_iterations: 10_000,
        }
    }
}

/// Where the iteration ended.
#[derive(Clone, Debug, PartialEq)]
pub struct ConjugateGradientSolution {
    /// The unknowns.
    pub values: Vec<f64>,
    /// Iterations done.
    pub iterations: usize,
    /// Euclidean norm of `b − A x`, computed afresh at the end, relative to that of `b`.
    pub residual: f64,
}

/// Solves `A x = b` for a symmetric positive definite operator (Hestenes and Stiefel 1952).
///
/// The vectors' products are summed in fixed pieces: the result is the same for any number of
/// threads. Each iteration costs one application of the operator and of the preconditioner.
///
/// # Errors
/// [`SolveError::NotConverged`] after the most iterations or when rounding stops progress above the
/// tolerance, [`SolveError::IndefiniteOperator`], [`SolveError::NonFiniteRightSide`],
/// [`SolveError::LengthMismatch`], [`SolveError::Stopped`].
pub fn conjugate_gradients(
    operator: &impl LinearOperator,
    preconditioner: &impl Preconditioner,
    right_side: &[f64],
    options: ConjugateGradientOptions<'_>,
    watch: &Watch,
) -> Result<ConjugateGradientSolution, SolveError> {
    let order = operator.order();
    SolveError::check_length("numbers on the right", right_side.len(), order)?;
    super::solution::count_columns(right_side, order)?;
    let start = options
        .start
        .map_or_else(|| vec![0.0; order], <[f64]>::to_vec);
    SolveError::check_length("numbers to start from", start.len(), order)?;
    let scale = power_of_two(largest(right_side));
    if largest(right_side) == 0.0 {
        return Ok(ConjugateGradientSolution {
            values: vec![0.0; order],
            iterations: 0,
            residual: 0.0,
        });
    }
    let mut run = Run {
        operator,
        preconditioner,
        right_side: right_side.iter().map(|b| b / scale).collect(),
        values: start.iter().map(|x| x / scale).collect(),
    };
    let (iterations, residual) = run.iterate(options, watch)?;
    let values: Vec<f64> = run.values.iter().map(|x| x * scale).collect();
    let checked = check_solution(values, 0.0)?;
    // Not `>`: a residual that is not a number has not converged.
    let converged = residual <= options.tolerance;
    if !converged {
        return Err(SolveError::NotConverged {
            iterations,
            residual,
            tolerance: options.tolerance,
        });
    }
    Ok(ConjugateGradientSolution {
        values: checked.values,
        iterations,
        residual,
    })
}

struct Run<'a, A, P> {
    operator: &'a A,
    preconditioner: &'a P,
    right_side: Vec<f64>,
    values: Vec<f64>,
}

impl<A: LinearOperator, P: Preconditioner> Run<'_, A, P> {
    /// Iterates; the recurrence's residual drifts from the true one, which is computed afresh when
    /// it seems small enough, and the iteration restarted once more where it is not.
    fn iterate(
        &mut self,
        options: ConjugateGradientOptions<'_>,
        watch: &Watch,
    ) -> Result<(usize, f64), SolveError> {
        let whole = dot(&self.right_side, &self.right_side).sqrt();
        let goal = options.tolerance * whole;
        let mut done = 0;
        let mut previous = f64::INFINITY;
        loop {
            let mut residual = self.residual();
            let size = dot(&residual, &residual).sqrt();
            let stuck = size > previous / 2.0 || size.is_nan();
            if size <= goal || stuck || done >= options.most_iterations {
                return Ok((done, relative_to(size, whole)));
            }
            previous = size;
            let left = options.most_iterations - done;
            done += self.descend(&mut residual, goal, left, watch)?;
        }
    }

    fn residual(&self) -> Vec<f64> {
        let mut residual = vec![0.0; self.values.len()];
        self.operator.apply(&self.values, &mut residual);
        add(&mut residual, &self.right_side, |r, b| b - r);
        residual
    }

    /// Runs until the recurrence's residual falls to `goal`; iterations done.
    fn descend(
        &mut self,
        residual: &mut [f64],
        goal: f64,
        most: usize,
        watch: &Watch,
    ) -> Result<usize, SolveError> {
        let order = residual.len();
        let [mut direction, mut image, mut step] = [(); 3].map(|()| vec![0.0; order]);
        let mut last = 0.0;
        for done in 0..most {
            watch.check()?;
            self.preconditioner.apply(residual, &mut step);
            let product = dot(residual, &step);
            let share = if done == 0 { 0.0 } else { product / last };
            last = product;
            add(&mut direction, &step, |d, s| s + share * d);
            self.operator.apply(&direction, &mut image);
            let energy = dot(&direction, &image);
            // Not `<=`: an energy that is not a number is not positive.
            let positive = energy > 0.0 && product > 0.0;
            if !positive {
                return Err(SolveError::IndefiniteOperator {
                    iteration: done + 1,
                    energy: energy.min(product),
                });
            }
            let length = product / energy;
            add(&mut self.values, &direction, |x, d| x + length * d);
            add(residual, &image, |r, q| r - length * q);
            if dot(residual, residual).sqrt() <= goal {
                return Ok(done + 1);
            }
        }
        Ok(most)
    }
}

/// `target = change(target, other)`, entry by entry.
fn add(target: &mut [f64], other: &[f64], change: impl Fn(f64, f64) -> f64 + Sync) {
    let entries = |target: &mut [f64], other: &[f64]| {
        for (t, &o) in target.iter_mut().zip(other) {
            *t = change(*t, o);
        }
    };
    if target.len() < PARALLEL {
        entries(target, other);
    } else {
        let pieces = target.par_chunks_mut(PIECE).zip(other.par_chunks(PIECE));
        pieces.for_each(|(target, other)| entries(target, other));
    }
}

/// The inner product, summed in fixed pieces.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let piece = |(a, b): (&[f64], &[f64])| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    if a.len() < PARALLEL {
        return a.chunks(PIECE).zip(b.chunks(PIECE)).map(piece).sum();
    }
    let sums: Vec<f64> = a
        .par_chunks(PIECE)
        .zip(b.par_chunks(PIECE))
        .map(piece)
        .collect();
    sums.iter().sum()
}
