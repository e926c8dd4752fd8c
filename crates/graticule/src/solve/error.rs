//! Why a linear system has no answer.

use crate::Hint;
use crate::watch::Stopped;

/// Why a matrix could not be built, factored or solved with.
///
/// Rows, columns and unknowns are numbered as the caller gave them.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// More rows, columns or entries than 32-bit numbers can name.
    #[error("{count} rows or entries were given; at most {limit} can be numbered")]
    TooLarge {
        /// The number given.
        count: usize,
        /// The largest number.
        limit: usize,
    },
    /// The factor does not fit into memory.
    #[error("the factorisation needs {bytes} bytes, which could not be allocated")]
    OutOfMemory {
        /// Bytes asked for.
        bytes: usize,
    },
    /// An entry lies outside the matrix.
    #[error("entry ({row}, {column}) is outside a matrix of {rows} rows and {columns} columns")]
    OutOfRange {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// Rows of the matrix.
        rows: usize,
        /// Columns of the matrix.
        columns: usize,
    },
    /// An entry is infinite or not a number.
    #[error("entry ({row}, {column}) of the matrix is {value}")]
    NonFinite {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// Its value.
        value: f64,
    },
    /// A right-hand side is infinite or not a number.
    #[error("row {row} of right-hand side {column} is {value}")]
    NonFiniteRightSide {
        /// Row of the number.
        row: usize,
        /// Number of the right-hand side.
        column: usize,
        /// Its value.
        value: f64,
    },
    /// A square matrix is needed.
    #[error("the matrix has {rows} rows and {columns} columns, not equally many")]
    NotSquare {
        /// Rows of the matrix.
        rows: usize,
        /// Columns of the matrix.
        columns: usize,
    },
    /// Mirrored entries differ.
    #[error("the matrix has {value} at ({row}, {column}) and {mirrored} at the mirrored place")]
    NotSymmetric {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// Its value.
        value: f64,
        /// Value at the mirrored place.
        mirrored: f64,
    },
    /// An array has the wrong length.
    #[error("{given} {what} were given where {expected} belong")]
    LengthMismatch {
        /// What the array holds.
        what: &'static str,
        /// Its length.
        given: usize,
        /// The right length.
        expected: usize,
    },
    /// A matrix does not have the pattern for which the symbolic factorisation was made.
    #[error("the matrix has another pattern than the one that was analysed")]
    PatternMismatch,
    /// An unknown is fixed twice or is not there.
    #[error("unknown {unknown} cannot be fixed: {reason}")]
    BadFixedUnknown {
        /// The unknown.
        unknown: usize,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// Cholesky met a pivot that is not positive.
    #[error("the matrix is not positive definite: column {column} has the pivot {pivot:e}")]
    NotPositiveDefinite {
        /// The column at which it shows.
        column: usize,
        /// The pivot met there.
        pivot: f64,
    },
    /// An operator known by its products only gave a direction no positive energy.
    #[error(
        "the operator is not positive definite: iteration {iteration} met a direction of energy \
         {energy:e}"
    )]
    IndefiniteOperator {
        /// The iteration.
        iteration: usize,
        /// The energy of its direction.
        energy: f64,
    },
    /// No pivot is left for a column.
    #[error("the matrix is singular: column {column} has the pivot {pivot:e}")]
    Singular {
        /// The column at which it shows.
        column: usize,
        /// The pivot met there.
        pivot: f64,
    },
    /// A constraint contradicts the ones before it.
    #[error(
        "constraint {row} contradicts the ones before it: they give it the value {implied:e}, \
         it asks for {asked:e}"
    )]
    ContradictoryConstraint {
        /// The constraint.
        row: usize,
        /// The value that follows from the earlier constraints.
        implied: f64,
        /// The value that it asks for.
        asked: f64,
    },
    /// A constraint has no coefficients but asks for a value other than zero.
    #[error("constraint {row} has no coefficients but asks for {asked:e}")]
    EmptyConstraint {
        /// The constraint.
        row: usize,
        /// The value that it asks for.
        asked: f64,
    },
    /// The solution does not fulfil the system.
    #[error("the relative residual is {residual:e}; at most {tolerance:e} is accepted")]
    Inaccurate {
        /// The relative residual after refinement.
        residual: f64,
        /// The largest that is accepted.
        tolerance: f64,
    },
    /// An iteration did not converge.
    #[error("no convergence in {iterations} iterations: {residual:e} is left of {tolerance:e}")]
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// What is left, relative.
        residual: f64,
        /// What was asked for.
        tolerance: f64,
    },
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl SolveError {
    pub(super) fn check_length(
        what: &'static str,
        given: usize,
        expected: usize,
    ) -> Result<(), Self> {
        if given == expected {
            return Ok(());
        }
        Err(Self::LengthMismatch {
            what,
            given,
            expected,
        })
    }

    pub(super) fn check_square(rows: usize, columns: usize) -> Result<(), Self> {
        if rows == columns {
            return Ok(());
        }
        Err(Self::NotSquare { rows, columns })
    }
}

impl Hint for SolveError {
    fn hint(&self) -> Option<String> {
        let text = match self {
            Self::TooLarge { .. } | Self::OutOfMemory { .. } => "simplify the mesh first",
            Self::NonFinite { .. } | Self::NonFiniteRightSide { .. } => {
                "look for degenerate triangles: `graticule repair` drops them"
            }
            Self::NotPositiveDefinite { .. } | Self::Singular { .. } => {
                "fix at least one unknown in every connected component, and use an intrinsic \
                 Delaunay triangulation where weights are negative"
            }
            Self::ContradictoryConstraint { .. } | Self::EmptyConstraint { .. } => {
                "remove this constraint or make it agree with the others"
            }
            Self::Inaccurate { .. } | Self::NotConverged { .. } => {
                "the system is ill-conditioned: repair slivers or use an intrinsic Delaunay \
                 triangulation"
            }
            Self::Stopped(stopped) => return stopped.hint(),
            _ => return None,
        };
        Some(text.into())
    }
}
