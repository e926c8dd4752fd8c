//! Sparse matrices: general and symmetric.

use std::sync::Arc;

use super::SolveError;
use super::pattern::{Pattern, check_size, group_by_column};

/// A sparse matrix of finite numbers, stored by columns, rows ascending within each.
///
/// Explicit zeros are kept, so that matrices of one family keep one pattern.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseMatrix {
    pattern: Arc<Pattern>,
    values: Vec<f64>,
}

impl SparseMatrix {
    /// The matrix whose entries are the sums of the triplets `(row, column, value)` at their place.
    ///
    /// Sums run in the order given. Linear time but for the sorting within each column.
    ///
    /// # Errors
    /// [`SolveError::OutOfRange`] for a place outside the matrix, [`SolveError::NonFinite`] where
    /// an entry or its sum is not finite, [`SolveError::TooLarge`] beyond 32-bit indices.
    pub fn from_triplets(
        rows: usize,
        columns: usize,
        triplets: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Result<Self, SolveError> {
        check_size(rows.max(columns))?;
        let mut checked = Vec::new();
        for (row, column, value) in triplets {
            if row >= rows || column >= columns {
                return Err(SolveError::OutOfRange {
                    row,
                    column,
                    rows,
                    columns,
                });
            }
            checked.push((row as u32, column as u32, value));
        }
        check_size(checked.len())?;
        Self::summed([rows, columns], &checked)
    }

    fn summed(
        [rows, columns]: [usize; 2],
        triplets: &[(u32, u32, f64)],
    ) -> Result<Self, SolveError> {
        let (ends, grouped) = group_by_column(columns, triplets);
        let mut starts = Vec::with_capacity(columns + 1);
        let mut row_indices = Vec::with_capacity(grouped.len());
        let mut values = Vec::with_capacity(grouped.len());
        starts.push(0);
        for ends in ends.windows(2) {
            for equal in grouped[ends[0]..ends[1]].chunk_by(|a, b| a.0 == b.0) {
                row_indices.push(equal[0].0);
                values.push(equal.iter().map(|entry| entry.1).sum());
            }
            starts.push(row_indices.len() as u32);
        }
        Self::new(Arc::new(Pattern::new(rows, starts, row_indices)), values)
    }

    /// The matrix with the given values, in the order of the pattern's entries.
    ///
    /// # Errors
    /// [`SolveError::LengthMismatch`] unless there is one value for each entry,
    /// [`SolveError::NonFinite`] for a value that is not finite.
    pub fn new(pattern: Arc<Pattern>, values: Vec<f64>) -> Result<Self, SolveError> {
        SolveError::check_length("values", values.len(), pattern.entries())?;
        if let Some(entry) = values.iter().position(|value| !value.is_finite()) {
            let column = pattern
                .column_starts()
                .partition_point(|&start| start as usize <= entry)
                - 1;
            return Err(SolveError::NonFinite {
                row: pattern.row_indices()[entry] as usize,
                column,
                value: values[entry],
            });
        }
        Ok(Self { pattern, values })
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.pattern.rows()
    }

    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.pattern.columns()
    }

    /// The places of the entries.
    #[must_use]
    pub fn pattern(&self) -> &Arc<Pattern> {
        &self.pattern
    }

    /// The values, in the order of the pattern's entries.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Rows and values of one column, rows ascending.
    ///
    /// # Panics
    /// If the column is out of range.
    pub fn column(&self, column: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let values = &self.values[self.pattern.range(column)];
        let rows = self.pattern.column(column).iter();
        rows.zip(values).map(|(&row, &value)| (row as usize, value))
    }

    /// All entries as `(row, column, value)`, column by column.
    pub fn triplets(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.columns()).flat_map(move |column| {
            self.column(column)
                .map(move |(row, value)| (row, column, value))
        })
    }

    /// The entry at a place; zero where none is stored.
    ///
    /// # Panics
    /// If the column is out of range.
    #[must_use]
    pub fn get(&self, row: usize, column: usize) -> f64 {
        self.pattern
            .find(row, column)
            .map_or(0.0, |entry| self.values[entry])
    }

    /// The transposed matrix. Linear time.
    #[must_use]
    pub fn transpose(&self) -> Self {
        let mut starts = vec![0_u32; self.rows() + 1];
        for &row in self.pattern.row_indices() {
            starts[row as usize + 1] += 1;
        }
        for row in 0..self.rows() {
            starts[row + 1] += starts[row];
        }
        let mut next = starts.clone();
        let mut row_indices = vec![0_u32; self.values.len()];
        let mut values = vec![0.0; self.values.len()];
        for (row, column, value) in self.triplets() {
            let place = next[row] as usize;
            row_indices[place] = column as u32;
            values[place] = value;
            next[row] += 1;
        }
        Self {
            pattern: Arc::new(Pattern::new(self.columns(), starts, row_indices)),
            values,
        }
    }

    /// `output = self * input`.
    ///
    /// # Panics
    /// Unless `input` has one number per column and `output` one per row.
    pub fn multiply_into(&self, input: &[f64], output: &mut [f64]) {
        assert_eq!(input.len(), self.columns(), "one number per column");
        assert_eq!(output.len(), self.rows(), "one number per row");
        output.fill(0.0);
        for (column, &factor) in input.iter().enumerate() {
            for (row, value) in self.column(column) {
                output[row] += value * factor;
            }
        }
    }

    /// `selfᵀ * input`.
    ///
    /// # Panics
    /// Unless `input` has one number per row.
    #[must_use]
    pub fn multiply_transposed(&self, input: &[f64]) -> Vec<f64> {
        assert_eq!(input.len(), self.rows(), "one number per row");
        (0..self.columns())
            .map(|column| self.column(column).map(|(row, v)| v * input[row]).sum())
            .collect()
    }

    /// `self * input`.
    ///
    /// # Panics
    /// Unless `input` has one number per column.
    #[must_use]
    pub fn multiply(&self, input: &[f64]) -> Vec<f64> {
        let mut output = vec![0.0; self.rows()];
        self.multiply_into(input, &mut output);
        output
    }

    /// Largest sum of absolute values in a row: the operator norm that belongs to the maximum norm.
    #[must_use]
    pub fn row_sum_norm(&self) -> f64 {
        let mut sums = vec![0.0; self.rows()];
        for (row, _, value) in self.triplets() {
            sums[row] += value.abs();
        }
        sums.into_iter().fold(0.0, f64::max)
    }

    /// Largest sum of absolute values in a column.
    #[must_use]
    pub fn column_sum_norm(&self) -> f64 {
        (0..self.columns())
            .map(|column| self.column(column).map(|(_, value)| value.abs()).sum())
            .fold(0.0, f64::max)
    }

    /// Largest absolute value of an entry.
    #[must_use]
    pub fn largest_entry(&self) -> f64 {
        self.values.iter().fold(0.0, |most, v| v.abs().max(most))
    }

    /// The same pattern with every value times `factor`.
    ///
    /// # Errors
    /// [`SolveError::NonFinite`] where a product overflows.
    pub fn scaled(&self, factor: f64) -> Result<Self, SolveError> {
        let values = self.values.iter().map(|value| value * factor).collect();
        Self::new(Arc::clone(&self.pattern), values)
    }

    pub(super) fn faer(&self) -> faer::sparse::SparseColMatRef<'_, u32, f64> {
        faer::sparse::SparseColMatRef::new(self.pattern.faer(), &self.values)
    }
}

/// A symmetric sparse matrix, of which the lower triangle is stored.
#[derive(Clone, Debug, PartialEq)]
pub struct SymmetricMatrix {
    lower: SparseMatrix,
}

impl SymmetricMatrix {
    /// The symmetric matrix of order `order` summed from triplets `(row, column, value)`.
    ///
    /// Each pair of mirrored entries is given once, in either triangle: `(i, j, v)` adds `v` at
    /// both places.
    ///
    /// # Errors
    /// As [`SparseMatrix::from_triplets`].
    pub fn from_triplets(
        order: usize,
        triplets: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Result<Self, SolveError> {
        let lower = triplets
            .into_iter()
            .map(|(row, column, value)| (row.max(column), row.min(column), value));
        // Every column keeps a diagonal entry: pivots, shifts and preconditioners stand there.
        let diagonal = (0..order).map(|index| (index, index, 0.0));
        SparseMatrix::from_triplets(order, order, diagonal.chain(lower)).map(|lower| Self { lower })
    }

    /// The graph Laplacian: each `([a, b], weight)` adds `weight` to the diagonal at `a` and `b`
    /// and subtracts it between them. Rows sum to zero up to rounding.
    ///
    /// # Errors
    /// As [`SparseMatrix::from_triplets`].
    pub fn laplacian(
        order: usize,
        weighted_edges: impl IntoIterator<Item = ([usize; 2], f64)>,
    ) -> Result<Self, SolveError> {
        let entries = weighted_edges
            .into_iter()
            .flat_map(|([a, b], weight)| [(a, a, weight), (b, b, weight), (a, b, -weight)]);
        Self::from_triplets(order, entries)
    }

    /// The symmetric matrix equal to `full`.
    ///
    /// # Errors
    /// [`SolveError::NotSquare`], or [`SolveError::NotSymmetric`] where mirrored entries differ at
    /// all: an assembly in symmetric order gives equal bits.
    pub fn from_full(full: &SparseMatrix) -> Result<Self, SolveError> {
        SolveError::check_square(full.rows(), full.columns())?;
        let transposed = full.transpose();
        for (row, column, value) in full.triplets() {
            let mirrored = transposed.get(row, column);
            if (mirrored - value).abs() > 0.0 {
                return Err(SolveError::NotSymmetric {
                    row,
                    column,
                    value,
                    mirrored,
                });
            }
        }
        let lower = full.triplets().filter(|(row, column, _)| row >= column);
        Self::from_triplets(full.rows(), lower)
    }

    /// The matrix with the pattern of `self` and other values, in the order of
    /// [`lower`](Self::lower)'s entries.
    ///
    /// # Errors
    /// As [`SparseMatrix::new`].
    pub fn with_values(&self, values: Vec<f64>) -> Result<Self, SolveError> {
        SparseMatrix::new(Arc::clone(self.lower.pattern()), values).map(|lower| Self { lower })
    }

    /// Number of rows and columns.
    #[must_use]
    pub fn order(&self) -> usize {
        self.lower.columns()
    }

    /// The lower triangle with the diagonal.
    #[must_use]
    pub fn lower(&self) -> &SparseMatrix {
        &self.lower
    }

    /// Both triangles as a general matrix.
    #[must_use]
    pub fn to_full(&self) -> SparseMatrix {
        let upper = self.lower.transpose();
        let columns = self.order();
        let mut starts = Vec::with_capacity(columns + 1);
        let mut row_indices = Vec::with_capacity(2 * self.lower.values.len());
        let mut values = Vec::with_capacity(2 * self.lower.values.len());
        starts.push(0);
        for column in 0..columns {
            let above = upper.column(column).filter(|&(row, _)| row < column);
            for (row, value) in above.chain(self.lower.column(column)) {
                row_indices.push(row as u32);
                values.push(value);
            }
            starts.push(row_indices.len() as u32);
        }
        SparseMatrix {
            pattern: Arc::new(Pattern::new(columns, starts, row_indices)),
            values,
        }
    }

    /// The diagonal.
    #[must_use]
    pub fn diagonal(&self) -> Vec<f64> {
        // The first entry of each column of the lower triangle.
        let first = |column: usize| self.lower.values[self.lower.pattern.range(column).start];
        (0..self.order()).map(first).collect()
    }

    /// `output = self * input`.
    ///
    /// # Panics
    /// Unless both have one number per row.
    pub fn multiply_into(&self, input: &[f64], output: &mut [f64]) {
        assert_eq!(input.len(), self.order(), "one number per column");
        assert_eq!(output.len(), self.order(), "one number per row");
        output.fill(0.0);
        for column in 0..self.order() {
            let mut sum = 0.0;
            for (row, value) in self.lower.column(column) {
                sum += value * input[row];
                if row != column {
                    output[row] += value * input[column];
                }
            }
            output[column] += sum;
        }
    }

    /// `self * input`.
    ///
    /// # Panics
    /// Unless `input` has one number per row.
    #[must_use]
    pub fn multiply(&self, input: &[f64]) -> Vec<f64> {
        let mut output = vec![0.0; self.order()];
        self.multiply_into(input, &mut output);
        output
    }

    /// Largest sum of absolute values in a row.
    #[must_use]
    pub fn row_sum_norm(&self) -> f64 {
        let mut sums = vec![0.0; self.order()];
        for (row, column, value) in self.lower.triplets() {
            sums[row] += value.abs();
            if row != column {
                sums[column] += value.abs();
            }
        }
        sums.into_iter().fold(0.0, f64::max)
    }
}
