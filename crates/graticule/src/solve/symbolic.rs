//! The symbolic part of a factorisation: what depends on the pattern alone.

use std::sync::Arc;

use faer::dyn_stack::MemStack;
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::{Par, Side, Spec};

use super::memory::{memory, zeros};
use super::{Ordering, Pattern, SolveError, SymmetricMatrix};

/// The elimination of a symmetric matrix, planned: order, and where the factor's entries will stand.
///
/// One plan serves all matrices of one pattern; share it by [`Arc`].
#[derive(Debug)]
pub struct Symbolic {
    pattern: Arc<Pattern>,
    faer: SymbolicCholesky<u32>,
    entries: usize,
    operations: f64,
}

impl Symbolic {
    /// Plans the elimination of matrices with the pattern of `matrix`, in the given order.
    ///
    /// # Errors
    /// [`SolveError::LengthMismatch`] unless the ordering is one of the matrix's unknowns,
    /// [`SolveError::OutOfMemory`].
    pub fn new(matrix: &SymmetricMatrix, ordering: &Ordering) -> Result<Arc<Self>, SolveError> {
        let pattern = Arc::clone(matrix.lower().pattern());
        Self::of_lower_pattern(pattern, ordering, SupernodalThreshold::AUTO).map(Arc::new)
    }

    pub(super) fn of_lower_pattern(
        pattern: Arc<Pattern>,
        ordering: &Ordering,
        threshold: SupernodalThreshold,
    ) -> Result<Self, SolveError> {
        SolveError::check_length("ordered unknowns", ordering.len(), pattern.columns())?;
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: threshold,
            ..Default::default()
        };
        let order = SymmetricOrdering::Custom(ordering.faer());
        let bytes = pattern.entries() * size_of::<u32>();
        let faer = factorize_symbolic_cholesky(pattern.faer(), Side::Lower, order, params)
            .map_err(|_| SolveError::OutOfMemory { bytes })?;
        let (entries, operations) = cost(&faer);
        Ok(Self {
            pattern,
            faer,
            entries,
            operations,
        })
    }

    /// Number of rows and columns.
    #[must_use]
    pub fn order(&self) -> usize {
        self.pattern.columns()
    }

    /// Entries of the lower triangular factor, with the few explicit zeros that blocks contain.
    #[must_use]
    pub fn factor_entries(&self) -> usize {
        self.entries
    }

    /// Multiplications of one numeric factorisation, roughly.
    #[must_use]
    pub fn operations(&self) -> f64 {
        self.operations
    }

    /// Bytes that the numeric factor occupies.
    #[must_use]
    pub fn factor_bytes(&self) -> usize {
        self.faer.len_val() * size_of::<f64>()
    }

    pub(super) fn faer(&self) -> &SymbolicCholesky<u32> {
        &self.faer
    }

    /// The caller's number of the unknown at a place of the elimination order.
    pub(super) fn unknown_at(&self, place: usize) -> usize {
        self.faer
            .perm()
            .map_or(place, |order| order.arrays().0[place] as usize)
    }

    /// `L D Lᵀ` of a matrix with the planned pattern, into the `factor`; tells whether the
    /// elimination came to its end. An exact zero, unless regularised, stops it there; what comes
    /// after stays zero.
    pub(super) fn factor_ldlt(
        &self,
        matrix: &SymmetricMatrix,
        regularization: LdltRegularization<'_, f64>,
    ) -> Result<(Vec<f64>, bool), SolveError> {
        let mut factor = zeros(self.faer.len_val())?;
        let scratch = self
            .faer
            .factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Spec::default());
        let done = self.faer.factorize_numeric_ldlt(
            &mut factor,
            matrix.lower().faer(),
            Side::Lower,
            regularization,
            Par::Seq,
            MemStack::new(&mut memory(scratch)?),
            Spec::default(),
        );
        let finished = done.is_ok();
        Ok((factor, finished))
    }

    /// Diagonal entries of a factor, by place in the elimination order.
    pub(super) fn diagonal<'a>(&'a self, factor: &'a [f64]) -> Box<dyn Iterator<Item = f64> + 'a> {
        match self.faer.raw() {
            SymbolicCholeskyRaw::Simplicial(simplicial) => {
                let starts = &simplicial.col_ptr()[..self.order()];
                Box::new(starts.iter().map(|&start| factor[start as usize]))
            }
            SymbolicCholeskyRaw::Supernodal(supernodal) => {
                let blocks = 0..supernodal.n_supernodes();
                Box::new(blocks.flat_map(move |block| {
                    let start = supernodal.col_ptr_for_val()[block] as usize;
                    let columns =
                        supernodal.supernode_end()[block] - supernodal.supernode_begin()[block];
                    let rows = (columns + supernodal.nnz_per_super()[block]) as usize;
                    (0..columns as usize).map(move |column| factor[start + column * rows + column])
                }))
            }
        }
    }

    pub(super) fn check_pattern(&self, pattern: &Arc<Pattern>) -> Result<(), SolveError> {
        if Arc::ptr_eq(&self.pattern, pattern) || self.pattern == *pattern {
            return Ok(());
        }
        Err(SolveError::PatternMismatch)
    }
}

/// Entries of the factor and multiplications to make it.
fn cost(symbolic: &SymbolicCholesky<u32>) -> (usize, f64) {
    let columns = |lengths: &mut dyn Iterator<Item = usize>| {
        lengths.fold((0, 0.0), |(entries, operations), length| {
            (entries + length, operations + (length as f64).powi(2) / 2.0)
        })
    };
    match symbolic.raw() {
        SymbolicCholeskyRaw::Simplicial(simplicial) => {
            let starts = simplicial.col_ptr();
            columns(&mut starts.windows(2).map(|pair| (pair[1] - pair[0]) as usize))
        }
        SymbolicCholeskyRaw::Supernodal(supernodal) => {
            let blocks = supernodal.supernode_begin().iter();
            let blocks = blocks.zip(supernodal.supernode_end());
            let blocks = blocks.zip(supernodal.nnz_per_super());
            let lengths = blocks.flat_map(|((&begin, &end), &below)| {
                (1..=end - begin).map(move |above| (above + below) as usize)
            });
            columns(&mut { lengths })
        }
    }
}
