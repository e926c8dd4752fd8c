//! Whole numbers near the least of a quadratic energy.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::separation::Guard;
use super::system::WholeEnergy;
use crate::watch::{Stopped, Watch};

/// Rounds one parameter after the other, each time the one that costs least, with all others at
/// their best for those rounded so far (N. Ray et al. and D. Bommes et al. call it greedy rounding;
/// here the cost is that of the energy, not the distance).
///
/// The inverse of the energy's matrix is kept up to date: fixing a parameter takes a rank-one
/// matrix away. Cost: cubic in the number of parameters, with a small factor.
pub(super) struct Rounding {
    /// The inverse of the matrix over the parameters not rounded yet; 0 elsewhere.
    inverse: Mat<f64>,
    /// The parameters where the energy is least, at a density of one line per unit of length.
    relaxed: Vec<f64>,
    energy: WholeEnergy,
}

impl Rounding {
    /// `None` where the energy does not determine the parameters.
    pub(super) fn new(energy: WholeEnergy) -> Option<Self> {
        let count = energy.loads.len();
        if count == 0 {
            return Some(Self {
                inverse: Mat::zeros(0, 0),
                relaxed: Vec::new(),
                energy,
            });
        }
        let factor = energy.matrix.llt(Side::Lower).ok()?;
        let inverse = factor.solve(Mat::<f64>::identity(count, count));
        let loads = Mat::from_fn(count, 1, |row, _| energy.loads[row]);
        let relaxed = factor.solve(loads);
        let relaxed: Vec<f64> = (0..count).map(|row| relaxed[(row, 0)]).collect();
        let is_finite = relaxed.iter().all(|value| value.is_finite());
        is_finite.then_some(Self {
            inverse,
            relaxed,
            energy,
        })
    }

    /// The rounded parameters at a density.
    ///
    /// A parameter that would round neighbours of `guard` together takes the next whole number that
    /// does not.
    pub(super) fn at(
        &self,
        density: f64,
        guard: &Guard,
        watch: &Watch,
    ) -> Result<Vec<i64>, Stopped> {
        let mut values: Vec<f64> = self.relaxed.iter().map(|value| density * value).collect();
        let mut inverse = self.inverse.clone();
        let mut open: Vec<usize> = (0..values.len()).collect();
        let mut is_settled = vec![false; values.len()];
        while let Some(place) = cheapest(&open, &values, &inverse) {
            watch.check()?;
            let column = open.swap_remove(place);
            let relaxed = values[column];
            let whole = best_whole(relaxed, |whole| {
                values[column] = whole;
                guard.broken(column, &values, &is_settled, density)
            });
            values[column] = relaxed;
            is_settled[column] = true;
            let step = whole - relaxed;
            fix(&mut inverse, &mut values, &open, column, step);
            values[column] = whole;
        }
        self.mend(density, guard, &mut values);
        Ok(values.into_iter().map(|value| value as i64).collect())
    }

    /// Changes single parameters as long as fewer neighbours are together for it, each time the one
    /// that parts most, of these the one that costs least.
    fn mend(&self, density: f64, guard: &Guard, values: &mut [f64]) {
        let mut slopes: Vec<f64> = self
            .energy
            .loads
            .iter()
            .map(|load| -density * load)
            .collect();
        for (column, &value) in values.iter().enumerate() {
            self.add_column(&mut slopes, column, value);
        }
        while let Some((column, step)) = self.best_mending(density, guard, values, &slopes) {
            values[column] += step;
            self.add_column(&mut slopes, column, step);
        }
    }

    fn add_column(&self, slopes: &mut [f64], column: usize, factor: f64) {
        let entries = self.energy.matrix.col_as_slice(column);
        for (slope, entry) in slopes.iter_mut().zip(entries) {
            *slope += factor * entry;
        }
    }

    /// The change of one parameter that parts most neighbours; `None` where none parts any.
    fn best_mending(
        &self,
        density: f64,
        guard: &Guard,
        values: &mut [f64],
        slopes: &[f64],
    ) -> Option<(usize, f64)> {
        let is_settled = vec![true; values.len()];
        let mut best = None;
        for column in guard.broken_parameters(values, density) {
            let before = guard.broken(column, values, &is_settled, density);
            for step in [1.0, -1.0, 2.0, -2.0] {
                values[column] += step;
                let after = guard.broken(column, values, &is_settled, density);
                values[column] -= step;
                let own = self.energy.matrix[(column, column)];
                let cost = step * slopes[column] + 0.5 * step * step * own;
                let parts = before.saturating_sub(after);
                let is_better = best
                    .is_none_or(|(most, least, _)| parts > most || (parts == most && cost < least));
                if parts > 0 && is_better {
                    best = Some((parts, cost, (column, step)));
                }
            }
        }
        best.map(|(_, _, change)| change)
    }
}

/// Of the whole numbers near a value the nearest of those that break least.
pub(super) fn best_whole(value: f64, mut broken: impl FnMut(f64) -> usize) -> f64 {
    let nearest = value.round();
    let side = if value >= nearest { 1.0 } else { -1.0 };
    let mut best = (usize::MAX, nearest);
    for offset in [0.0, side, -side, 2.0 * side, -2.0 * side] {
        let count = broken(nearest + offset);
        if count < best.0 {
            best = (count, nearest + offset);
        }
        if count == 0 {
            break;
        }
    }
    best.1
}

/// The place in `open` of the parameter whose rounding costs least.
fn cheapest(open: &[usize], values: &[f64], inverse: &Mat<f64>) -> Option<usize> {
    let cost = |&column: &usize| {
        let off = values[column] - values[column].round();
        off * off / inverse[(column, column)].max(f64::MIN_POSITIVE)
    };
    let places = 0..open.len();
    places.min_by(|&a, &b| {
        let [a, b] = [open[a], open[b]];
        cost(&a).total_cmp(&cost(&b)).then(a.cmp(&b))
    })
}

/// Moves a parameter by `step`, the open ones to their best, and takes it out of the inverse.
fn fix(inverse: &mut Mat<f64>, values: &mut [f64], open: &[usize], column: usize, step: f64) {
    let own = inverse[(column, column)];
    if own <= 0.0 {
        return;
    }
    let shares: Vec<f64> = open
        .iter()
        .map(|&row| inverse[(row, column)] / own)
        .collect();
    for (&row, share) in open.iter().zip(&shares) {
        values[row] += share * step;
    }
    for &other in open {
        let factor = inverse[(other, column)];
        let entries = inverse.col_as_slice_mut(other);
        for (&row, share) in open.iter().zip(&shares) {
            entries[row] -= share * factor;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::form::Form;
    use super::super::separation::Separation;
    use super::*;

    /// Parameters that cost their squared distance from the given values, each to be at least one
    /// below the next.
    fn chain(wished: &[f64]) -> (Rounding, Guard) {
        let count = wished.len();
        let energy = WholeEnergy {
            matrix: Mat::identity(count, count),
            loads: wished.to_vec(),
        };
        let rows: Vec<Form> = (0..count as u32).map(Form::unknown).collect();
        let pairs: Vec<Separation> = rows
            .windows(2)
            .map(|pair| {
                let mut difference = pair[1].clone();
                difference.add(-1, &pair[0]);
                Separation {
                    difference: [Some(difference), None],
                    wish: DVec2::X,
                }
            })
            .collect();
        let guard = Guard::new(&pairs, &rows, count);
        (Rounding::new(energy).unwrap(), guard)
    }

    #[test]
    fn neighbours_are_not_rounded_together() {
        let (rounding, guard) = chain(&[0.1, 0.3, 0.4, 3.2]);
        let rounded = rounding.at(1.0, &guard, &Watch::new()).unwrap();
        assert!(
            rounded.windows(2).all(|pair| pair[0] < pair[1]),
            "{rounded:?}"
        );
    }

    #[test]
    fn neighbours_that_are_together_are_parted_at_least_cost() {
        let (rounding, guard) = chain(&[0.0, 0.3]);
        let mut values = [0.0, 0.0];
        rounding.mend(1.0, &guard, &mut values);
        assert_eq!(values.map(|value| value as i64), [0, 1]);
        let (rounding, guard) = chain(&[-0.3, 0.0]);
        let mut values = [0.0, 0.0];
        rounding.mend(1.0, &guard, &mut values);
        assert_eq!(values.map(|value| value as i64), [-1, 0]);
    }
}
