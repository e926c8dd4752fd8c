//! Cholesky factorisation of symmetric positive definite matrices, held for reuse.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::LltRef;
use faer::{Conj, MatMut, Par, Side, Spec};

use super::memory::{memory, zeros};
use super::solution::{Factored, Solution, solve_checked};
use super::{Ordering, SolveError, Symbolic, SymmetricMatrix};
use crate::tolerance;

/// `A = L Lᵀ` for a symmetric positive definite `A`.
///
/// One thread: triangular solves get slower with more, and the result is the same however many there are.
/// Nothing depends on the matrix's scale: `L` has the square root of its size.
#[derive(Clone, Debug)]
pub struct Cholesky {
    symbolic: Arc<Symbolic>,
    factor: Vec<f64>,
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
        let mut factor = zeros(symbolic.faer().len_val())?;
        let plan = symbolic.faer();
        let scratch = plan.factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default());
        let done = plan.factorize_numeric_llt(
            &mut factor,
            matrix.lower().faer(),
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory(scratch)?),
            Spec::default(),
        );
        if done.is_err() {
            return Err(first_bad_pivot(symbolic, matrix)?);
        }
        check_pivots(symbolic, matrix, &factor)?;
        Ok(Self {
            symbolic: Arc::clone(symbolic),
            factor,
            norm: matrix.row_sum_norm(),
            matrix: matrix.clone(),
        })
    }

    /// The plan, for other matrices of the same pattern.
    #[must_use]
    pub fn symbolic(&self) -> &Arc<Symbolic> {
        &self.symbolic
    }

    /// The entries of `L`, as the plan lays them out.
    pub(super) fn values(&self) -> &[f64] {
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

    fn solve_in_place(&self, columns: &mut [f64]) {
        let order = self.order();
        if order == 0 {
            return;
        }
        let count = columns.len() / order;
        let plan = self.symbolic.faer();
        let mut memory = MemBuffer::new(plan.solve_in_place_scratch::<f64>(count, Par::Seq));
        LltRef::new(plan, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(columns, order, count),
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }
}

fn check_pivots(
    symbolic: &Symbolic,
    matrix: &SymmetricMatrix,
    factor: &[f64],
) -> Result<(), SolveError> {
    for (place, root) in symbolic.diagonal(factor).enumerate() {
        let column = symbolic.unknown_at(place);
        let pivot = root * root;
        let own = matrix.lower().get(column, column);
        // Not `<`: what is not a number is not positive either.
        let positive = pivot > tolerance::SINGULAR_PIVOT * own;
        if !positive || !root.is_finite() {
            return Err(SolveError::NotPositiveDefinite { column, pivot });
        }
    }
    Ok(())
}

/// Finds the pivot at which Cholesky stopped: the first of `L D Lᵀ` that is not positive.
fn first_bad_pivot(
    symbolic: &Symbolic,
    matrix: &SymmetricMatrix,
) -> Result<SolveError, SolveError> {
    let (factor, _) = symbolic.factor_ldlt(matrix, LdltRegularization::default())?;
    let (place, pivot) = symbolic
        .diagonal(&factor)
        .enumerate()
        .find(|&(_, pivot)| pivot.is_nan() || pivot <= 0.0)
        .unwrap_or((0, 0.0));
    Ok(SolveError::NotPositiveDefinite {
        column: symbolic.unknown_at(place),
        pivot,
    })
}
