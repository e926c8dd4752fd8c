//! Whole numbers near the least of a quadratic energy.

use faer::linalg::matmul::matmul;
use faer::linalg::solvers::Solve;
use faer::{Accum, Mat, Par, Side};

use super::guard::{Guard, SettledPairs};
use super::system::WholeEnergy;
use crate::watch::{Stopped, Watch};

/// Rounds one parameter after the other, each time the one that costs least, with all others at
/// their best for those rounded so far (N. Ray et al. and D. Bommes et al. call it greedy rounding;
/// here the cost is that of the energy, not the distance).
///
/// The inverse of the energy's matrix is kept up to date: fixing a parameter takes a rank-one
/// matrix away. These are gathered and taken away many at a time. Cost: cubic in the number of
/// parameters, at the speed of dense products.
pub(super) struct Rounding {
    /// The inverse of the matrix over the parameters.
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

    /// The parameters where the energy is least, at a density of one line per unit of length.
    pub(super) fn relaxed(&self) -> &[f64] {
        &self.relaxed
    }

    /// Takes over another right-hand side.
    pub(super) fn load(&mut self, loads: Vec<f64>) {
        let relaxed = |row: usize| {
            let entries = self.inverse.col_as_slice(row).iter().zip(&loads);
            entries.map(|(entry, load)| entry * load).sum()
        };
        self.relaxed = (0..loads.len()).map(relaxed).collect();
        self.energy.loads = loads;
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
        let mut settled = guard.none_settled(density);
        let mut open = OpenParameters::all(&self.inverse);
        while !open.columns.is_empty() {
            watch.check()?;
            let mut steps = Vec::with_capacity(GATHERED);
            while let Some(place) = open.cheapest(&values, steps.len()) {
                let column = open.columns[place];
                let relaxed = values[column];
                let whole = best_whole(relaxed, |whole| settled.broken_by(column, whole));
                steps.push(open.fix(place, whole - relaxed, &steps, &mut values));
                values[column] = whole;
                settled.settle(column, whole);
            }
            open.take_away(&steps);
        }
        let mut slopes = self.slopes(density, &values);
        self.mend(&mut settled, &mut values, &mut slopes);
        self.descend(&mut settled, &mut values, &mut slopes);
        Ok(values.into_iter().map(|value| value as i64).collect())
    }

    /// Changes single parameters as long as fewer neighbours are together for it: for each two that
    /// are the parameter that parts most, of these the one that costs least.
    fn mend(&self, settled: &mut SettledPairs<'_>, values: &mut [f64], slopes: &mut [f64]) {
        let mut broken = settled.broken_pairs();
        while !broken.is_empty() {
            let before = broken.len();
            for pair in broken {
                if let Some((column, step)) = self.best_mending(pair, settled, slopes) {
                    values[column] += step;
                    settled.shift(column, step);
                    self.add_column(slopes, column, step);
                }
            }
            broken = settled.broken_pairs();
            if broken.len() >= before {
                break;
            }
        }
    }

    /// The derivative of the energy by each parameter.
    fn slopes(&self, density: f64, values: &[f64]) -> Vec<f64> {
        let loads = self.energy.loads.iter();
        let mut slopes: Vec<f64> = loads.map(|load| -density * load).collect();
        for (column, &value) in values.iter().enumerate() {
            self.add_column(&mut slopes, column, value);
        }
        slopes
    }

    /// Moves single parameters to the next whole number as long as that lowers the energy and brings
    /// no neighbours together: what was rounded early did not know of what was rounded late.
    fn descend(&self, settled: &mut SettledPairs<'_>, values: &mut [f64], slopes: &mut [f64]) {
        for _ in 0..MOST_DESCENTS {
            let mut moved = false;
            for column in 0..values.len() {
                let own = self.energy.matrix[(column, column)];
                let step = -slopes[column].signum();
                let cost = step * slopes[column] + 0.5 * own;
                if cost < -LEAST_DESCENT * own && settled.parted_by(column, step) >= 0 {
                    values[column] += step;
                    settled.shift(column, step);
                    self.add_column(slopes, column, step);
                    moved = true;
                }
            }
            if !moved {
                break;
            }
        }
    }

    fn add_column(&self, slopes: &mut [f64], column: usize, factor: f64) {
        let entries = self.energy.matrix.col_as_slice(column);
        for (slope, entry) in slopes.iter_mut().zip(entries) {
            *slope += factor * entry;
        }
    }

    /// The change of one parameter of a pair that parts most; `None` where none parts any, or the
    /// pair is parted already.
    fn best_mending(
        &self,
        pair: usize,
        settled: &SettledPairs<'_>,
        slopes: &[f64],
    ) -> Option<(usize, f64)> {
        if !settled.is_broken(pair) {
            return None;
        }
        let mut best = None;
        for column in settled.parameters_of(pair) {
            for step in [1.0, -1.0, 2.0, -2.0] {
                let parts = settled.parted_by(column, step);
                let own = self.energy.matrix[(column, column)];
                let cost = step * slopes[column] + 0.5 * step * step * own;
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

/// Times that all parameters are looked at again, at most; mostly it ends after two or three.
const MOST_DESCENTS: usize = 20;

/// What a move must lower the energy by, in what the parameter costs one step from its best.
const LEAST_DESCENT: f64 = 1e-6;

/// Parameters fixed before their rank-one matrices are taken away together.
const GATHERED: usize = 32;

/// The parameters not rounded yet.
struct OpenParameters {
    /// Their numbers.
    columns: Vec<usize>,
    /// The inverse of their matrix, before the steps gathered.
    inverse: Mat<f64>,
    /// The diagonal of the inverse after them; 0 for what they fixed.
    diagonal: Vec<f64>,
}

impl OpenParameters {
    fn all(inverse: &Mat<f64>) -> Self {
        let count = inverse.nrows();
        Self {
            columns: (0..count).collect(),
            inverse: inverse.clone(),
            diagonal: (0..count).map(|row| inverse[(row, row)]).collect(),
        }
    }

    /// The place of the parameter whose rounding costs least; `None` where enough are gathered.
    fn cheapest(&self, values: &[f64], gathered: usize) -> Option<usize> {
        let cost = |&place: &usize| {
            let value = values[self.columns[place]];
            (value - value.round()).powi(2) / self.diagonal[place]
        };
        let open = (0..self.columns.len()).filter(|&place| self.diagonal[place] > 0.0);
        open.filter(|_| gathered < GATHERED)
            .min_by(|a, b| cost(a).total_cmp(&cost(b)))
    }

    /// Moves a parameter by `step` and the open ones to their best. Gives the column of the inverse
    /// whose square goes.
    fn fix(
        &mut self,
        place: usize,
        step: f64,
        gathered: &[Vec<f64>],
        values: &mut [f64],
    ) -> Vec<f64> {
        let mut entries = self.inverse.col_as_slice(place).to_vec();
        for other in gathered {
            let factor = other[place];
            for (entry, more) in entries.iter_mut().zip(other) {
                *entry -= factor * more;
            }
        }
        let own = entries[place];
        let scale = own.max(f64::MIN_POSITIVE).sqrt();
        for (row, entry) in entries.iter_mut().enumerate() {
            if self.diagonal[row] > 0.0 {
                values[self.columns[row]] += *entry / own.max(f64::MIN_POSITIVE) * step;
            }
            *entry /= scale;
            // What rounding errors make of nothing stays open.
            let least = f64::MIN_POSITIVE.max(1e-14 * self.diagonal[row]);
            if self.diagonal[row] > 0.0 {
                self.diagonal[row] = (self.diagonal[row] - *entry * *entry).max(least);
            }
        }
        self.diagonal[place] = 0.0;
        entries
    }

    /// Takes the squares of the columns away, and the rows that were fixed out.
    fn take_away(&mut self, steps: &[Vec<f64>]) {
        let kept: Vec<usize> = (0..self.columns.len())
            .filter(|&place| self.diagonal[place] > 0.0)
            .collect();
        let count = kept.len();
        let shares = Mat::from_fn(count, steps.len(), |row, step| steps[step][kept[row]]);
        let mut inverse = Mat::from_fn(count, count, |row, column| {
            self.inverse[(kept[row], kept[column])]
        });
        let (left, right) = (shares.as_ref(), shares.transpose());
        matmul(inverse.as_mut(), Accum::Add, left, right, -1.0, Par::Seq);
        self.inverse = inverse;
        self.columns = kept.iter().map(|&place| self.columns[place]).collect();
        self.diagonal = (0..count).map(|row| self.inverse[(row, row)]).collect();
        for own in &mut self.diagonal {
            *own = own.max(f64::MIN_POSITIVE);
        }
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

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use graticule_fixtures::Noise;

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

    /// Two parameters that were both rounded to 0, mended.
    fn mended(rounding: &Rounding, guard: &Guard) -> [i64; 2] {
        let mut values = [0.0; 2];
        let mut settled = guard.none_settled(1.0);
        for column in 0..2 {
            settled.settle(column, 0.0);
        }
        let mut slopes = rounding.slopes(1.0, &values);
        rounding.mend(&mut settled, &mut values, &mut slopes);
        values.map(|value| value as i64)
    }

    #[test]
    fn many_parameters_are_rounded_to_where_each_belongs() {
        let wished: Vec<f64> = (0..100).map(|number| f64::from(number) + 0.3).collect();
        let (rounding, guard) = chain(&wished);
        let rounded = rounding.at(1.0, &guard, &Watch::new()).unwrap();
        assert_eq!(rounded, (0..100).collect::<Vec<i64>>());
    }

    /// Greedy rounding as it is defined, with a new inverse for every step.
    fn rounded_one_by_one(matrix: &Mat<f64>, loads: &[f64]) -> Vec<i64> {
        let mut fixed: Vec<Option<f64>> = vec![None; loads.len()];
        loop {
            let open: Vec<usize> = (0..loads.len()).filter(|&c| fixed[c].is_none()).collect();
            let count = open.len();
            if count == 0 {
                return fixed.into_iter().flatten().map(|x| x as i64).collect();
            }
            let own = Mat::from_fn(count, count, |r, c| matrix[(open[r], open[c])]);
            let load = |row: usize| {
                let terms = fixed.iter().enumerate();
                let known = terms.map(|(c, x)| matrix[(row, c)] * x.unwrap_or_default());
                loads[row] - known.sum::<f64>()
            };
            let right = Mat::from_fn(count, 1, |row, _| load(open[row]));
            let factor = own.llt(Side::Lower).unwrap();
            let inverse = factor.solve(Mat::<f64>::identity(count, count));
            let relaxed = factor.solve(right);
            let off = |place: usize| relaxed[(place, 0)] - relaxed[(place, 0)].round();
            let cost = |place: usize| off(place).powi(2) / inverse[(place, place)];
            let best = (0..count).min_by(|&a, &b| cost(a).total_cmp(&cost(b)));
            let best = best.unwrap();
            fixed[open[best]] = Some(relaxed[(best, 0)].round());
        }
    }

    /// More parameters than are gathered at a time, each tied to its neighbours.
    #[test]
    fn gathered_steps_round_as_single_ones_do() {
        let count = 2 * GATHERED + 10;
        let mut matrix = Mat::<f64>::identity(count, count);
        for row in 1..count {
            matrix[(row, row)] += 2.0;
            matrix[(row - 1, row - 1)] += 2.0;
            matrix[(row, row - 1)] -= 2.0;
            matrix[(row - 1, row)] -= 2.0;
        }
        let mut noise = Noise::new(5);
        let loads: Vec<f64> = (0..count).map(|_| 3.0 * noise.signed()).collect();
        let expected = rounded_one_by_one(&matrix, &loads);
        let rounding = Rounding::new(WholeEnergy { matrix, loads }).unwrap();
        let guard = Guard::new(&[], &[], count);
        assert_eq!(rounding.at(1.0, &guard, &Watch::new()).unwrap(), expected);
        assert!(expected.iter().any(|&whole| whole != 0));
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
    fn rounding_ends_where_no_single_step_lowers_the_energy() {
        let (count, mut noise) = (24, Noise::new(11));
        let factor = Mat::from_fn(count, count, |_, _| noise.signed());
        let matrix = Mat::from_fn(count, count, |row, column| {
            let product: f64 = (0..count)
                .map(|k| factor[(row, k)] * factor[(column, k)])
                .sum();
            product + if row == column { 0.05 } else { 0.0 }
        });
        let loads: Vec<f64> = (0..count).map(|_| 9.0 * noise.signed()).collect();
        let energy = WholeEnergy {
            matrix: matrix.clone(),
            loads: loads.clone(),
        };
        let rounding = Rounding::new(energy).unwrap();
        let guard = Guard::new(&[], &[], count);
        let rounded = rounding.at(1.0, &guard, &Watch::new()).unwrap();
        let values: Vec<f64> = rounded.iter().map(|&whole| whole as f64).collect();
        let energy = |values: &[f64]| -> f64 {
            let row = |row: usize| -> f64 {
                let product: f64 = (0..count).map(|c| matrix[(row, c)] * values[c]).sum();
                values[row] * (0.5 * product - loads[row])
            };
            (0..count).map(row).sum()
        };
        let least = energy(&values);
        for column in 0..count {
            for step in [-1.0, 1.0] {
                let mut moved = values.clone();
                moved[column] += step;
                assert!(energy(&moved) > least - 1e-4, "{column} {step}");
            }
        }
    }

    #[test]
    fn neighbours_that_are_together_are_parted_at_least_cost() {
        let (rounding, guard) = chain(&[0.0, 0.3]);
        assert_eq!(mended(&rounding, &guard), [0, 1]);
        let (rounding, guard) = chain(&[-0.3, 0.0]);
        assert_eq!(mended(&rounding, &guard), [-1, 0]);
    }
}
