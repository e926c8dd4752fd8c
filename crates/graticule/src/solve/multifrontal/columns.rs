//! The entries of a matrix in the order of its elimination.

use faer::c64;

use super::tree::{Neighbours, Source};
use crate::solve::Pattern;

/// A number of a matrix.
pub(in crate::solve) trait Value: Copy + Sync {
    fn as_complex(self) -> c64;
}

impl Value for f64 {
    fn as_complex(self) -> c64 {
        c64::new(self, 0.0)
    }
}

impl Value for c64 {
    fn as_complex(self) -> c64 {
        self
    }
}

/// Where the entries of a Hermitian matrix's lower triangle stand in the lower triangle of the
/// matrix in elimination order.
#[derive(Debug)]
pub(super) struct Columns {
    diagonal: Vec<Option<Source>>,
    later: Neighbours,
}

impl Columns {
    /// `order` has the unknown of the lower triangle `pattern` at each place, `later` the pairs.
    pub(super) fn new(pattern: &Pattern, order: &[u32], later: Neighbours) -> Self {
        let own = |&unknown: &u32| {
            let entry = pattern.find(unknown as usize, unknown as usize)?;
            Some(Source::diagonal(entry))
        };
        Self {
            diagonal: order.iter().map(own).collect(),
            later,
        }
    }

    /// Rows and numbers in the column at a place, of the matrix with these values.
    pub(super) fn of_column<'a>(
        &'a self,
        column: usize,
        values: &'a [impl Value],
    ) -> impl Iterator<Item = (u32, c64)> + 'a {
        let value = |source: Source| {
            let value = values[source.entry()].as_complex();
            if source.is_upper() {
                value.conj()
            } else {
                value
            }
        };
        let own = self.diagonal[column].map(|source| (column as u32, value(source)));
        let rows = self.later.of(column).iter().copied();
        let sources = self.later.sources(column).iter();
        own.into_iter()
            .chain(rows.zip(sources.map(move |&source| value(source))))
    }
}
