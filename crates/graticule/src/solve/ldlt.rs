//! Regularised `L D Lᵀ` of symmetric indefinite matrices, with refinement.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::cholesky::LdltRef;
use faer::{Conj, MatMut, Par};

use super::solution::{Factored, Solution, power_of_two, solve_checked};
use super::{SolveError, Symbolic, SymmetricMatrix};
use crate::tolerance;

/// Refinement steps allowed; each gains the digits that the regularisation cost.
const REFINEMENTS: usize = 12;

/// `S A S = L D Lᵀ` for a symmetric matrix that need not be definite.
///
/// `S` is diagonal, powers of two, and brings the largest entry of every row near one. Pivots that
/// come out too small, or with another sign than expected, are replaced by a small number; the
/// refinement of every solution makes up for it. The order of elimination must suit: an unknown
/// without a diagonal entry comes after one that it meets.
#[derive(Clone, Debug)]
pub struct Ldlt {
    symbolic: Arc<Symbolic>,
    factor: Vec<f64>,
    scaled: SymmetricMatrix,
    scales: Vec<f64>,
    norm: f64,
}

impl Ldlt {
    /// Factors a matrix with the pattern for which `symbolic` was made. `signs` tells for each
    /// unknown whether its pivot is expected to be positive (`1`) or negative (`-1`).
    ///
    /// # Errors
    /// [`SolveError::Singular`] where a pivot overflows, [`SolveError::PatternMismatch`],
    /// [`SolveError::LengthMismatch`] unless there is one sign per unknown,
    /// [`SolveError::OutOfMemory`].
    pub fn factor(
        symbolic: &Arc<Symbolic>,
        matrix: &SymmetricMatrix,
        signs: Option<&[i8]>,
    ) -> Result<Self, SolveError> {
        symbolic.check_pattern(matrix.lower().pattern())?;
        if let Some(signs) = signs {
            SolveError::check_length("signs", signs.len(), matrix.order())?;
        }
        let (scaled, scales) = equilibrated(matrix)?;
        let factor = factor_values(symbolic, &scaled, signs)?;
        Ok(Self {
            symbolic: Arc::clone(symbolic),
            factor,
            norm: scaled.row_sum_norm(),
            scaled,
            scales,
        })
    }

    /// Solves `A x = b` for one or several right-hand sides, one column after the other.
    ///
    /// The residual is that of the scaled system `S A S`.
    ///
    /// # Errors
    /// As [`Cholesky::solve`](super::Cholesky::solve).
    pub fn solve(&self, right_sides: &[f64]) -> Result<Solution, SolveError> {
        let scaled = scale_columns(right_sides, &self.scales);
        let mut solution = solve_checked(self, &scaled, REFINEMENTS)?;
        solution.values = scale_columns(&solution.values, &self.scales);
        Ok(solution)
    }
}

fn factor_values(
    symbolic: &Symbolic,
    scaled: &SymmetricMatrix,
    signs: Option<&[i8]>,
) -> Result<Vec<f64>, SolveError> {
    let regularization = LdltRegularization {
        dynamic_regularization_signs: signs,
        dynamic_regularization_delta: tolerance::PIVOT_REPLACEMENT,
        dynamic_regularization_epsilon: tolerance::REGULARISED_PIVOT,
    };
    let (factor, finished) = symbolic.factor_ldlt(scaled, regularization)?;
    if finished && factor.iter().all(|value| value.is_finite()) {
        return Ok(factor);
    }
    let mut pivots = symbolic.diagonal(&factor).enumerate();
    let bad = pivots.find(|(_, pivot)| !pivot.is_finite() || *pivot == 0.0);
    let (place, pivot) = bad.unwrap_or((0, 0.0));
    Err(SolveError::Singular {
        column: symbolic.unknown_at(place),
        pivot,
    })
}

impl Factored for Ldlt {
    fn order(&self) -> usize {
        self.scales.len()
    }

    fn norm(&self) -> f64 {
        self.norm
    }

    fn multiply_into(&self, input: &[f64], output: &mut [f64]) {
        self.scaled.multiply_into(input, output);
    }

    fn solve_in_place(&self, columns: &mut [f64]) {
        let order = self.order();
        if order == 0 {
            return;
        }
        let count = columns.len() / order;
        let plan = self.symbolic.faer();
        let mut memory = MemBuffer::new(plan.solve_in_place_scratch::<f64>(count, Par::Seq));
        LdltRef::new(plan, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(columns, order, count),
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }
}

/// Each column times the scales, entry by entry.
pub(super) fn scale_columns(columns: &[f64], scales: &[f64]) -> Vec<f64> {
    let repeated = scales.iter().cycle();
    columns.iter().zip(repeated).map(|(v, s)| v * s).collect()
}

/// `S A S` with the largest entry of every row near one, and the diagonal of `S`: powers of two,
/// so that nothing is rounded (Ruiz 2001, three sweeps).
fn equilibrated(matrix: &SymmetricMatrix) -> Result<(SymmetricMatrix, Vec<f64>), SolveError> {
    let mut scales = vec![1.0; matrix.order()];
    for _ in 0..3 {
        let mut largest = vec![0.0_f64; matrix.order()];
        for (row, column, value) in matrix.lower().triplets() {
            let value = (value * scales[row] * scales[column]).abs();
            largest[row] = largest[row].max(value);
            largest[column] = largest[column].max(value);
        }
        for (scale, most) in scales.iter_mut().zip(largest) {
            *scale /= power_of_two(power_of_two(most).sqrt());
        }
    }
    let values = matrix.lower().triplets();
    let values = values.map(|(row, column, value)| value * scales[row] * scales[column]);
    let scaled = matrix.with_values(values.collect())?;
    Ok((scaled, scales))
}
