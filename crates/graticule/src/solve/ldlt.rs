//! Regularised `L D Lᵀ` of symmetric indefinite matrices, with refinement.

use std::sync::Arc;

use faer::dyn_stack::MemStack;
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::{Conj, MatMut, Par, Side, Spec};

use super::memory::{memory, zeros};
use super::solution::{Factored, Solution, power_of_two, solve_checked};
use super::{Ordering, SolveError, SymmetricMatrix};
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
    plan: Arc<SymbolicCholesky<u32>>,
    factor: Vec<f64>,
    scaled: SymmetricMatrix,
    scales: Vec<f64>,
    norm: f64,
}

impl Ldlt {
    /// Factors a matrix, eliminating in the given order. `signs` tells for each unknown whether its
    /// pivot is expected to be positive (`1`) or negative (`-1`).
    ///
    /// # Errors
    /// [`SolveError::Singular`] where a pivot overflows, [`SolveError::LengthMismatch`] unless there
    /// is one place in order, and one sign, per unknown, [`SolveError::OutOfMemory`].
    pub fn new(
        matrix: &SymmetricMatrix,
        ordering: &Ordering,
        signs: Option<&[i8]>,
    ) -> Result<Self, SolveError> {
        SolveError::check_length("ordered unknowns", ordering.len(), matrix.order())?;
        if let Some(signs) = signs {
            SolveError::check_length("signs", signs.len(), matrix.order())?;
        }
        let plan = plan(matrix, ordering)?;
        let (scaled, scales) = equilibrated(matrix)?;
        Ok(Self {
            factor: factor_values(&plan, &scaled, signs)?,
            plan: Arc::new(plan),
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

fn plan(
    matrix: &SymmetricMatrix,
    ordering: &Ordering,
) -> Result<SymbolicCholesky<u32>, SolveError> {
    let pattern = matrix.lower().pattern();
    let bytes = pattern.entries() * size_of::<u32>();
    let order = SymmetricOrdering::Custom(ordering.faer());
    let params = CholeskySymbolicParams::default();
    factorize_symbolic_cholesky(pattern.faer(), Side::Lower, order, params)
        .map_err(|_| SolveError::OutOfMemory { bytes })
}

fn factor_values(
    plan: &SymbolicCholesky<u32>,
    scaled: &SymmetricMatrix,
    signs: Option<&[i8]>,
) -> Result<Vec<f64>, SolveError> {
    let regularization = LdltRegularization {
        dynamic_regularization_signs: signs,
        dynamic_regularization_delta: tolerance::PIVOT_REPLACEMENT,
        dynamic_regularization_epsilon: tolerance::REGULARISED_PIVOT,
    };
    let mut factor = zeros(plan.len_val())?;
    let scratch = plan.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Spec::default());
    // An exact zero stops the elimination; what comes after stays zero.
    let done = plan.factorize_numeric_ldlt(
        &mut factor,
        scaled.lower().faer(),
        Side::Lower,
        regularization,
        Par::Seq,
        MemStack::new(&mut memory(scratch)?),
        Spec::default(),
    );
    if done.is_ok() && factor.iter().all(|value| value.is_finite()) {
        return Ok(factor);
    }
    let pivots = pivot_places(plan).into_iter().map(|place| factor[place]);
    let mut pivots = pivots.enumerate();
    let bad = pivots.find(|(_, pivot)| !pivot.is_finite() || *pivot == 0.0);
    let (place, pivot) = bad.unwrap_or((0, 0.0));
    let unknown = |order: faer::perm::PermRef<'_, u32>| order.arrays().0[place] as usize;
    Err(SolveError::Singular {
        column: plan.perm().map_or(place, unknown),
        pivot,
    })
}

/// Where the diagonal entries stand among a factor's values, in elimination order.
fn pivot_places(plan: &SymbolicCholesky<u32>) -> Vec<usize> {
    match plan.raw() {
        SymbolicCholeskyRaw::Simplicial(simplicial) => {
            let starts = &simplicial.col_ptr()[..plan.ncols()];
            starts.iter().map(|&start| start as usize).collect()
        }
        SymbolicCholeskyRaw::Supernodal(supernodal) => {
            let places = (0..supernodal.n_supernodes()).flat_map(|block| {
                let start = supernodal.col_ptr_for_val()[block] as usize;
                let columns =
                    supernodal.supernode_end()[block] - supernodal.supernode_begin()[block];
                let rows = (columns + supernodal.nnz_per_super()[block]) as usize;
                (0..columns as usize).map(move |column| start + column * rows + column)
            });
            places.collect()
        }
    }
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

    fn solve_in_place(&self, columns: &mut [f64]) -> Result<(), SolveError> {
        let order = self.order();
        if order == 0 {
            return Ok(());
        }
        let count = columns.len() / order;
        let scratch = self.plan.solve_in_place_scratch::<f64>(count, Par::Seq);
        LdltRef::new(&self.plan, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(columns, order, count),
            Par::Seq,
            MemStack::new(&mut memory(scratch)?),
        );
        Ok(())
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
