//! The symbolic part of a factorisation: what depends on the pattern alone.

use std::sync::Arc;

use super::multifrontal::Plan;
use super::{Ordering, Pattern, SolveError, SymmetricMatrix};

/// The elimination of a symmetric matrix, planned: order, and where the factor's entries will stand.
///
/// One plan serves all matrices of one pattern; share it by [`Arc`].
#[derive(Debug)]
pub struct Symbolic {
    pattern: Arc<Pattern>,
    plan: Arc<Plan>,
}

impl Symbolic {
    /// Plans the elimination of matrices with the pattern of `matrix`, in the given order.
    ///
    /// # Errors
    /// [`SolveError::LengthMismatch`] unless the ordering is one of the matrix's unknowns.
    pub fn new(matrix: &SymmetricMatrix, ordering: &Ordering) -> Result<Arc<Self>, SolveError> {
        let pattern = Arc::clone(matrix.lower().pattern());
        Self::of_lower_pattern(pattern, ordering).map(Arc::new)
    }

    pub(super) fn of_lower_pattern(
        pattern: Arc<Pattern>,
        ordering: &Ordering,
    ) -> Result<Self, SolveError> {
        SolveError::check_length("ordered unknowns", ordering.len(), pattern.columns())?;
        let plan = Arc::new(Plan::new(&pattern, ordering, |_| false));
        Ok(Self { pattern, plan })
    }

    /// Number of rows and columns.
    #[must_use]
    pub fn order(&self) -> usize {
        self.pattern.columns()
    }

    /// Entries of the lower triangular factor, with the few explicit zeros that blocks contain.
    #[must_use]
    pub fn factor_entries(&self) -> usize {
        self.plan.cost().0
    }

    /// Multiplications of one numeric factorisation, roughly.
    #[must_use]
    pub fn operations(&self) -> f64 {
        self.plan.cost().1
    }

    pub(super) fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    pub(super) fn check_pattern(&self, pattern: &Arc<Pattern>) -> Result<(), SolveError> {
        if Arc::ptr_eq(&self.pattern, pattern) || self.pattern == *pattern {
            return Ok(());
        }
        Err(SolveError::PatternMismatch)
    }
}
