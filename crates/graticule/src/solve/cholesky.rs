//! Cholesky factorisation of symmetric positive definite matrices, held for reuse.

use std::sync::Arc;

use faer::c64;

use super::multifrontal::Multifrontal;
use super::solution::{Factored, Solution, solve_checked};
use super::{Ordering, SolveError, Symbolic, SymmetricMatrix};
use crate::tolerance;

/// `A = L Lᵀ` for a symmetric positive definite `A`.
///
/// Subtrees of the elimination are factored side by side; the result is the same for any number of
/// threads. Nothing depends on the matrix's scale: `L` has the square root of its size.
#[derive(Clone, Debug)]
pub struct Cholesky {
    symbolic: Arc<Symbolic>,
    factor: Arc<Multifrontal>,
    matrix: SymmetricMatrix,
    norm: f64,
}

impl Cholesky {
    /// Orders, plans and factors in one go.
    ///
    /// # Errors
    /// As [`Symbolic::new`] and [`factor`](Self::factor).
    pub fn new(matrix: &SymmetricMatrix, ordering: &Ordering) -> Result<Self, SolveError> {
        Self::factor(&Symbolic::new(matrix, ordering)?, matrix)
    }

    /// Factors a matrix with the pattern for which `symbolic` was made.
    ///
    /// # Errors
    /// [`SolveError::NotPositiveDefinite`] names the column at which it shows; also a pivot that
    /// is zero up to rounding ([`tolerance::SINGULAR_PIVOT`]) counts as not positive.
    /// [`SolveError::PatternMismatch`], [`SolveError::OutOfMemory`].
    pub fn factor(symbolic: &Arc<Symbolic>, matrix: &SymmetricMatrix) -> Result<Self, SolveError> {
        symbolic.check_pattern(matrix.lower().pattern())?;
        let factor = Multifrontal::new(symbolic.plan(), matrix.lower().values())?;
        check_pivots(&factor, matrix)?;
        Ok(Self {
            symbolic: Arc::clone(symbolic),
            factor: Arc::new(factor),
            norm: matrix.row_sum_norm(),
            matrix: matrix.clone(),
        })
    }

    /// The plan, for other matrices of the same pattern.
    #[must_use]
    pub fn symbolic(&self) -> &Arc<Symbolic> {
        &self.symbolic
    }

    pub(super) fn multifrontal(&self) -> &Multifrontal {
        &self.factor
    }

    /// The matrix that was factored.
    #[must_use]
    pub fn matrix(&self) -> &SymmetricMatrix {
        &self.matrix
    }

    /// Solves `A x = b` for one or several right-hand sides, one column after the other.
    ///
    /// Refined once where the residual asks for it.
    ///
    /// # Errors
    /// [`SolveError::Inaccurate`] where the residual stays above
    /// [`tolerance::LINEAR_RESIDUAL`]; [`SolveError::NonFiniteRightSide`],
    /// [`SolveError::LengthMismatch`].
    pub fn solve(&self, right_sides: &[f64]) -> Result<Solution, SolveError> {
        solve_checked(self, right_sides, 1)
    }
}

impl Factored for Cholesky {
    fn order(&self) -> usize {
        self.matrix.order()
    }

    fn norm(&self) -> f64 {
        self.norm
    }

    fn multiply_into(&self, input: &[f64], output: &mut [f64]) {
        self.matrix.multiply_into(input, output);
    }

    fn solve_in_place(&self, columns: &mut [f64]) -> Result<(), SolveError> {
        // Two columns as one complex one: the factor is read once for both.
        let mut pairs = columns.chunks_exact_mut(2 * self.order().max(1));
        for pair in &mut pairs {
            let (one, other) = pair.split_at_mut(self.order());
            let both = one.iter().zip(&*other);
            let both: Vec<c64> = both.map(|(&re, &im)| c64::new(re, im)).collect();
            let solved = self.factor.solve(&both)?;
            for ((one, other), solved) in one.iter_mut().zip(other).zip(solved) {
                (*one, *other) = (solved.re, solved.im);
            }
        }
        let last = pairs.into_remainder();
        if !last.is_empty() {
            last.copy_from_slice(&self.factor.solve(last)?);
        }
        Ok(())
    }
}

fn check_pivots(factor: &Multifrontal, matrix: &SymmetricMatrix) -> Result<(), SolveError> {
    let unknowns = factor.plan().order();
    let own = matrix.diagonal();
    for (column, &unknown) in factor.real_columns().zip(unknowns) {
        let root = column.values[0];
        let pivot = root * root;
        let column = unknown as usize;
        // Not `<`: what is not a number is not positive either.
        let positive = pivot > tolerance::SINGULAR_PIVOT * own[column];
        if !positive || !root.is_finite() {
            return Err(SolveError::NotPositiveDefinite { column, pivot });
        }
    }
    Ok(())
}
