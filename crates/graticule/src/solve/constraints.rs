//! Linear constraints: which rows are independent, and whether the others agree with them.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use super::solution::{largest, power_of_two};
use super::{SolveError, SparseMatrix};
use crate::tolerance;

/// Constraint rows after Gaussian elimination, one row after the other.
///
/// Rows that meet no common unknowns cost nothing but their own length; chains of rows fill in as
/// they are eliminated.
#[derive(Clone, Debug)]
pub(super) struct Independence {
    /// For each row: multiples of earlier reduced rows that were taken away.
    steps: Vec<Vec<(usize, f64)>>,
    /// Whether anything is left of the row after that.
    independent: Vec<bool>,
    /// Powers of two near the rows' largest coefficients, by which they were divided.
    scales: Vec<f64>,
}

impl Independence {
    /// Eliminates the rows of `constraints`, given transposed: one column per constraint.
    pub(super) fn of_columns(transposed: &SparseMatrix) -> Self {
        let mut result = Self {
            steps: Vec::new(),
            independent: Vec::new(),
            scales: Vec::new(),
        };
        let mut pivot_rows = PivotRows {
            row_of_unknown: vec![None; transposed.rows()],
            rows: BTreeMap::new(),
        };
        for constraint in 0..transposed.columns() {
            let coefficients: Vec<f64> = transposed.column(constraint).map(|c| c.1).collect();
            let scale = power_of_two(largest(&coefficients));
            let row = transposed.column(constraint);
            let mut row: BTreeMap<usize, f64> = row
                .map(|(unknown, value)| (unknown, value / scale))
                .collect();
            result.steps.push(pivot_rows.reduce(&mut row));
            result.independent.push(pivot_rows.accept(constraint, row));
            result.scales.push(scale);
        }
        result
    }

    pub(super) fn rows(&self) -> usize {
        self.steps.len()
    }

    /// Powers of two near the rows' largest coefficients.
    pub(super) fn scales(&self) -> &[f64] {
        &self.scales
    }

    pub(super) fn is_independent(&self, row: usize) -> bool {
        self.independent[row]
    }

    /// Whether the values asked for follow the rows' dependences.
    ///
    /// # Errors
    /// [`SolveError::ContradictoryConstraint`] or [`SolveError::EmptyConstraint`].
    pub(super) fn check_targets(&self, targets: &[f64]) -> Result<(), SolveError> {
        let mut reduced = vec![0.0; targets.len()];
        for (row, steps) in self.steps.iter().enumerate() {
            let asked = targets[row] / self.scales[row];
            let implied: f64 = steps.iter().map(|&(pivot, f)| f * reduced[pivot]).sum();
            let size: f64 = steps.iter().map(|&(p, f)| (f * reduced[p]).abs()).sum();
            reduced[row] = asked - implied;
            if self.independent[row] {
                continue;
            }
            if steps.is_empty() && asked != 0.0 {
                let asked = targets[row];
                return Err(SolveError::EmptyConstraint { row, asked });
            }
            if reduced[row].abs() > tolerance::DEPENDENT_CONSTRAINT * (size + asked.abs()) {
                return Err(SolveError::ContradictoryConstraint {
                    row,
                    implied: implied * self.scales[row],
                    asked: targets[row],
                });
            }
        }
        Ok(())
    }
}

/// Reduced rows, each with a pivot that later rows are freed of.
struct PivotRows {
    row_of_unknown: Vec<Option<usize>>,
    /// Pivot unknown and coefficients of each independent row.
    rows: BTreeMap<usize, (usize, Vec<(usize, f64)>)>,
}

impl PivotRows {
    /// Takes multiples of the pivot rows away until none of their pivots is left in `row`.
    fn reduce(&self, row: &mut BTreeMap<usize, f64>) -> Vec<(usize, f64)> {
        let mut steps = Vec::new();
        let pivots = row
            .keys()
            .filter_map(|&unknown| self.row_of_unknown[unknown]);
        // A pivot row holds no pivots of earlier rows: in this order each is needed once.
        let mut waiting: BinaryHeap<Reverse<usize>> = pivots.map(Reverse).collect();
        while let Some(Reverse(index)) = waiting.pop() {
            let (pivot, coefficients) = &self.rows[&index];
            let Some(value) = row.remove(pivot) else {
                continue;
            };
            let own = coefficients
                .iter()
                .find(|c| c.0 == *pivot)
                .map_or(1.0, |c| c.1);
            let factor = value / own;
            steps.push((index, factor));
            for &(unknown, coefficient) in coefficients.iter().filter(|c| c.0 != *pivot) {
                let entry = row.entry(unknown).or_insert_with(|| {
                    waiting.extend(self.row_of_unknown[unknown].map(Reverse));
                    0.0
                });
                *entry -= factor * coefficient;
            }
        }
        steps
    }

    /// Keeps what is left of a row if that is more than rounding errors; whether it was kept.
    fn accept(&mut self, constraint: usize, row: BTreeMap<usize, f64>) -> bool {
        let mut best: Option<(usize, f64)> = None;
        for (&unknown, &value) in &row {
            if best.is_none_or(|(_, most): (usize, f64)| value.abs() > most.abs()) {
                best = Some((unknown, value));
            }
        }
        let Some((pivot, value)) = best else {
            return false;
        };
        if value.abs() <= tolerance::DEPENDENT_CONSTRAINT {
            return false;
        }
        self.row_of_unknown[pivot] = Some(constraint);
        self.rows
            .insert(constraint, (pivot, row.into_iter().collect()));
        true
    }
}
