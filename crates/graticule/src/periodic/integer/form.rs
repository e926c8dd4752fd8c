//! Sums of whole unknowns with whole coefficients.

/// A sum of unknowns with whole coefficients, ascending, none zero.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Form(Vec<(u32, i64)>);

impl Form {
    /// One unknown.
    pub(super) fn unknown(column: u32) -> Self {
        Self(vec![(column, 1)])
    }

    /// The unknowns and their coefficients.
    pub(super) fn terms(&self) -> &[(u32, i64)] {
        &self.0
    }

    /// Whether the sum is empty.
    pub(super) fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds a multiple of another sum.
    pub(super) fn add(&mut self, factor: i64, other: &Self) {
        if factor == 0 || other.is_zero() {
            return;
        }
        let mine = std::mem::take(&mut self.0);
        let mut rest = other.0.iter().peekable();
        for (column, value) in mine {
            while let Some(&(before, more)) = rest.next_if(|(other, _)| *other < column) {
                self.0.push((before, factor * more));
            }
            let same = rest.next_if(|(other, _)| *other == column);
            let value = value + same.map_or(0, |(_, more)| factor * more);
            if value != 0 {
                self.0.push((column, value));
            }
        }
        self.0
            .extend(rest.map(|&(column, more)| (column, factor * more)));
    }

    /// The sum for given unknowns.
    pub(super) fn value(&self, unknowns: &[i64]) -> i64 {
        let terms = self.0.iter();
        terms
            .map(|&(column, factor)| factor * unknowns[column as usize])
            .sum()
    }

    /// The sum for given unknowns that need not be whole.
    pub(super) fn real_value(&self, unknowns: &[f64]) -> f64 {
        let terms = self.0.iter();
        terms
            .map(|&(column, factor)| factor as f64 * unknowns[column as usize])
            .sum()
    }

    /// The coefficient of an unknown.
    pub(super) fn coefficient(&self, column: u32) -> i64 {
        let place = self.0.binary_search_by_key(&column, |term| term.0);
        place.map_or(0, |place| self.0[place].1)
    }
}
