//! Preconditioners for conjugate gradients.

use super::{SolveError, SparseMatrix, SymmetricMatrix};

/// An approximate inverse, symmetric and positive definite.
pub trait Preconditioner {
    /// `output ≈ A⁻¹ * input`.
    fn apply(&self, input: &[f64], output: &mut [f64]);
}

/// No preconditioning.
#[derive(Clone, Copy, Debug, Default)]
pub struct Identity;

impl Preconditioner for Identity {
    fn apply(&self, input: &[f64], output: &mut [f64]) {
        output.copy_from_slice(input);
    }
}

/// Division by the diagonal.
#[derive(Clone, Debug)]
pub struct Jacobi {
    inverse: Vec<f64>,
}

impl Jacobi {
    /// # Errors
    /// [`SolveError::NotPositiveDefinite`] for a diagonal entry that is not positive.
    pub fn new(matrix: &SymmetricMatrix) -> Result<Self, SolveError> {
        let diagonal = matrix.diagonal();
        if let Some(column) = diagonal.iter().position(|&entry| entry <= 0.0) {
            let pivot = diagonal[column];
            return Err(SolveError::NotPositiveDefinite { column, pivot });
        }
        Ok(Self {
            inverse: diagonal.iter().map(|entry| entry.recip()).collect(),
        })
    }
}

impl Preconditioner for Jacobi {
    fn apply(&self, input: &[f64], output: &mut [f64]) {
        for ((to, from), inverse) in output.iter_mut().zip(input).zip(&self.inverse) {
            *to = from * inverse;
        }
    }
}

/// Cholesky without fill: the factor keeps the matrix's pattern (Meijerink and van der Vorst 1977).
///
/// Exists for Laplacians with positive weights. For other matrices a pivot may fail; the diagonal
/// is then strengthened until all are positive (Manteuffel 1980), which
/// [`shift`](Self::shift) tells.
#[derive(Clone, Debug)]
pub struct IncompleteCholesky {
    /// Columns of the factor; the diagonal entry is the first of each.
    factor: SparseMatrix,
    shift: f64,
}

impl IncompleteCholesky {
    /// # Errors
    /// [`SolveError::NotPositiveDefinite`] for a diagonal entry that is not positive.
    pub fn new(matrix: &SymmetricMatrix) -> Result<Self, SolveError> {
        Jacobi::new(matrix)?;
        let mut shift = 0.0;
        // With the diagonal doubled often enough the matrix is dominated by it: this ends.
        loop {
            if let Some(factor) = incomplete_factor(matrix.lower(), shift) {
                return Ok(Self { factor, shift });
            }
            shift = if shift == 0.0 { 1e-3 } else { 4.0 * shift };
        }
    }

    /// Share of itself that was added to the diagonal; zero for most matrices.
    #[must_use]
    pub fn shift(&self) -> f64 {
        self.shift
    }
}

impl Preconditioner for IncompleteCholesky {
    fn apply(&self, input: &[f64], output: &mut [f64]) {
        output.copy_from_slice(input);
        for column in 0..output.len() {
            let mut entries = self.factor.column(column);
            let diagonal = entries.next().map_or(1.0, |entry| entry.1);
            let solved = output[column] / diagonal;
            output[column] = solved;
            for (row, value) in entries {
                output[row] -= value * solved;
            }
        }
        for column in (0..output.len()).rev() {
            let mut entries = self.factor.column(column);
            let diagonal = entries.next().map_or(1.0, |entry| entry.1);
            let known: f64 = entries.map(|(row, value)| value * output[row]).sum();
            output[column] = (output[column] - known) / diagonal;
        }
    }
}

/// The factor of `A + shift · diag A` on the pattern of `A`; `None` where a pivot is not positive.
fn incomplete_factor(lower: &SparseMatrix, shift: f64) -> Option<SparseMatrix> {
    let pattern = lower.pattern();
    let mut values = lower.values().to_vec();
    for column in 0..lower.columns() {
        values[pattern.range(column).start] *= 1.0 + shift;
    }
    for column in 0..lower.columns() {
        let range = pattern.range(column);
        let own = lower.values()[range.start];
        let pivot = values[range.start];
        // Not `<=`: what is not a number is not positive either.
        let positive = pivot > crate::tolerance::SINGULAR_PIVOT * own;
        if !positive {
            return None;
        }
        let root = pivot.sqrt();
        values[range.start] = root;
        for value in &mut values[range.start + 1..range.end] {
            *value /= root;
        }
        subtract_products(pattern, &mut values, range);
    }
    SparseMatrix::new(std::sync::Arc::clone(pattern), values).ok()
}

/// Takes the products of one finished column's entries away where the pattern has room for them.
fn subtract_products(pattern: &super::Pattern, values: &mut [f64], column: std::ops::Range<usize>) {
    let rows = &pattern.row_indices()[column.clone()];
    for first in 1..rows.len() {
        let target = pattern.range(rows[first] as usize);
        let factor = values[column.start + first];
        let mut place = target.start;
        for second in first..rows.len() {
            let row = rows[second];
            while place < target.end && pattern.row_indices()[place] < row {
                place += 1;
            }
            if place < target.end && pattern.row_indices()[place] == row {
                values[place] -= factor * values[column.start + second];
            }
        }
    }
}
