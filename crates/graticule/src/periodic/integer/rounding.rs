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
}

impl Rounding {
    /// `None` where the energy does not determine the parameters.
    pub(super) fn new(energy: &WholeEnergy) -> Option<Self> {
        let count = energy.loads.len();
        if count == 0 {
            return Some(Self {
                inverse: Mat::zeros(0, 0),
                relaxed: Vec::new(),
            });
        }
        let factor = energy.matrix.llt(Side::Lower).ok()?;
        let inverse = factor.solve(Mat::<f64>::identity(count, count));
        let loads = Mat::from_fn(count, 1, |row, _| energy.loads[row]);
        let relaxed = factor.solve(loads);
        let relaxed: Vec<f64> = (0..count).map(|row| relaxed[(row, 0)]).collect();
        relaxed
            .iter()
            .all(|value| value.is_finite())
            .then_some(Self { inverse, relaxed })
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
        Ok(values.into_iter().map(|value| value as i64).collect())
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
