//! Overdetermined complex systems, by an orthogonal factorisation held for reuse.

use faer::c64;
use faer::linalg::solvers::SolveLstsqCore;
use faer::sparse::linalg::solvers::Qr;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Conj, MatMut};

use super::SolveError;

/// `A = Q R` for a sparse complex matrix with at least as many rows as columns.
///
/// Against a Cholesky factor of `Aᴴ A` it takes several times the work and loses half the digits
/// that the other does: it serves where the other loses all.
pub struct LeastSquares {
    rows: usize,
    columns: usize,
    factor: Qr<u32, c64>,
}

impl LeastSquares {
    /// Factors the matrix with these entries; several at one place are summed.
    ///
    /// # Errors
    /// [`SolveError::OutOfRange`] for an entry that is not in the matrix, [`SolveError::NotSquare`]
    /// if there are more columns than rows, [`SolveError::OutOfMemory`].
    pub fn new(
        rows: usize,
        columns: usize,
        entries: &[(usize, usize, c64)],
    ) -> Result<Self, SolveError> {
        if columns > rows {
            return Err(SolveError::NotSquare { rows, columns });
        }
        let outside = |&&(row, column, _): &&(usize, usize, c64)| row >= rows || column >= columns;
        if let Some(&(row, column, _)) = entries.iter().find(outside) {
            return Err(SolveError::OutOfRange {
                row,
                column,
                rows,
                columns,
            });
        }
        let triplets = entries.iter().map(|&(row, column, value)| Triplet {
            row: row as u32,
            col: column as u32,
            val: value,
        });
        let triplets: Vec<_> = triplets.collect();
        let out_of_memory = SolveError::OutOfMemory {
            bytes: size_of_val(&triplets[..]),
        };
        let factor = SparseColMat::try_new_from_triplets(rows, columns, &triplets)
            .ok()
            .and_then(|matrix| matrix.sp_qr().ok());
        Ok(Self {
            rows,
            columns,
            factor: factor.ok_or(out_of_memory)?,
        })
    }

    /// The `x` for which `A x` is nearest to the right-hand side: one number per column. Not
    /// finite if the columns are dependent.
    ///
    /// # Errors
    /// [`SolveError::LengthMismatch`] unless there is one number per row.
    pub fn solve(&self, right_side: &[c64]) -> Result<Vec<c64>, SolveError> {
        SolveError::check_length("numbers on the right", right_side.len(), self.rows)?;
        let mut values = right_side.to_vec();
        let column = MatMut::from_column_major_slice_mut(&mut values, self.rows, 1);
        self.factor.solve_lstsq_in_place_with_conj(Conj::No, column);
        values.truncate(self.columns);
        Ok(values)
    }
}
