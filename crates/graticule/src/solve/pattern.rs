//! Where the entries of a sparse matrix stand.

use super::SolveError;

/// The places of the stored entries of a sparse matrix, column by column, rows ascending.
///
/// Matrices of one problem share their pattern, so that a symbolic factorisation made for one
/// serves the others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    rows: usize,
    column_starts: Vec<u32>,
    row_indices: Vec<u32>,
}

impl Pattern {
    /// Checked by the callers: starts ascend from 0 to the number of entries, rows ascend strictly
    /// within each column and are below `rows`.
    pub(super) fn new(rows: usize, column_starts: Vec<u32>, row_indices: Vec<u32>) -> Self {
        debug_assert_eq!(
            column_starts.last().copied().unwrap_or(0) as usize,
            row_indices.len()
        );
        Self {
            rows,
            column_starts,
            row_indices,
        }
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.column_starts.len() - 1
    }

    /// Number of stored entries.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.row_indices.len()
    }

    /// Rows of the entries of one column, ascending.
    ///
    /// # Panics
    /// If the column is out of range.
    #[must_use]
    pub fn column(&self, column: usize) -> &[u32] {
        &self.row_indices[self.range(column)]
    }

    /// Numbers of the entries of one column.
    pub(crate) fn range(&self, column: usize) -> std::ops::Range<usize> {
        self.column_starts[column] as usize..self.column_starts[column + 1] as usize
    }

    pub(super) fn column_starts(&self) -> &[u32] {
        &self.column_starts
    }

    pub(super) fn row_indices(&self) -> &[u32] {
        &self.row_indices
    }

    /// Number of the entry at a place, if one is stored there. Logarithmic in the column's length.
    #[must_use]
    pub fn find(&self, row: usize, column: usize) -> Option<usize> {
        let row = u32::try_from(row).ok()?;
        let start = self.column_starts[column] as usize;
        let within = self.column(column).binary_search(&row).ok()?;
        Some(start + within)
    }

    pub(super) fn faer(&self) -> faer::sparse::SymbolicSparseColMatRef<'_, u32> {
        faer::sparse::SymbolicSparseColMatRef::new_checked(
            self.rows,
            self.columns(),
            &self.column_starts,
            None,
            &self.row_indices,
        )
    }
}

/// Triplets grouped by column, rows ascending, equal places in the order given: the start of each
/// column among them, and rows and values.
///
/// So sums over equal places never depend on anything but the order in which the triplets came.
/// Linear time but for the sorting within each column.
pub(super) fn group_by_column(
    columns: usize,
    triplets: &[(u32, u32, f64)],
) -> (Vec<usize>, Vec<(u32, f64)>) {
    let mut starts = vec![0_usize; columns + 1];
    for &(_, column, _) in triplets {
        starts[column as usize + 1] += 1;
    }
    for column in 0..columns {
        starts[column + 1] += starts[column];
    }
    let mut next = starts.clone();
    let mut grouped = vec![(0, 0.0); triplets.len()];
    for &(row, column, value) in triplets {
        let place = &mut next[column as usize];
        grouped[*place] = (row, value);
        *place += 1;
    }
    for ends in starts.windows(2) {
        grouped[ends[0]..ends[1]].sort_by_key(|&(row, _)| row);
    }
    (starts, grouped)
}

/// Refuses sizes that 32-bit indices cannot name.
pub(super) fn check_size(count: usize) -> Result<(), SolveError> {
    // Signed 32-bit indices mark absent entries in the symbolic factorisation.
    let limit = i32::MAX as usize;
    if count > limit {
        return Err(SolveError::TooLarge { count, limit });
    }
    Ok(())
}
