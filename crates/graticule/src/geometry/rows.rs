use crate::mesh::{Element, VertexId};

/// Entries of a matrix over vertices, row by row, each row sorted by column without repetition.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rows {
    starts: Vec<u32>,
    columns: Vec<VertexId>,
    values: Vec<f64>,
}

impl Rows {
    /// Sorts entries `(row, column, value)` into rows and adds up, in the order given, those with
    /// the same place. Entries on the diagonal are left out.
    pub(super) fn collect(row_count: usize, entries: Vec<(VertexId, VertexId, f64)>) -> Self {
        let bucketed = bucket_by_row(row_count, &entries);
        let mut rows = Self {
            starts: Vec::with_capacity(row_count + 1),
            columns: Vec::with_capacity(entries.len()),
            values: Vec::with_capacity(entries.len()),
        };
        let (starts, mut bucketed) = bucketed;
        drop(entries);
        rows.starts.push(0);
        for row in 0..row_count {
            let bucket = &mut bucketed[starts[row] as usize..starts[row + 1] as usize];
            // Stable, so that the sums below have a fixed order.
            bucket.sort_by_key(|&(column, _)| column);
            for same in bucket.chunk_by(|a, b| a.0 == b.0) {
                rows.columns.push(same[0].0);
                rows.values.push(same.iter().map(|&(_, value)| value).sum());
            }
            rows.starts.push(rows.columns.len() as u32);
        }
        rows
    }

    pub(super) fn row_count(&self) -> usize {
        self.starts.len() - 1
    }

    pub(super) fn columns(&self, row: VertexId) -> &[VertexId] {
        &self.columns[self.range(row)]
    }

    pub(super) fn values(&self, row: VertexId) -> &[f64] {
        &self.values[self.range(row)]
    }

    pub(super) fn into_values(self) -> Vec<f64> {
        self.values
    }

    fn range(&self, row: VertexId) -> std::ops::Range<usize> {
        self.starts[row.index()] as usize..self.starts[row.index() + 1] as usize
    }
}

/// Where each row begins, and the entries off the diagonal in the order of the rows.
fn bucket_by_row(
    row_count: usize,
    entries: &[(VertexId, VertexId, f64)],
) -> (Vec<u32>, Vec<(VertexId, f64)>) {
    let off_diagonal = || entries.iter().filter(|(row, column, _)| row != column);
    let mut starts = vec![0_u32; row_count + 1];
    for (row, _, _) in off_diagonal() {
        starts[row.index() + 1] += 1;
    }
    for row in 0..row_count {
        starts[row + 1] += starts[row];
    }
    let mut filled = starts.clone();
    let mut bucketed = vec![(VertexId(0), 0.0); starts[row_count] as usize];
    for &(row, column, value) in off_diagonal() {
        let place = &mut filled[row.index()];
        bucketed[*place as usize] = (column, value);
        *place += 1;
    }
    (starts, bucketed)
}
