//! Keeps neighbours of the net apart while its whole numbers are settled.

use glam::DVec2;

use super::form::Form;
use super::separation::{Separation, is_decisive};

/// The separations over the free parameters, and which of them each parameter belongs to.
#[derive(Clone, Debug, Default)]
pub(super) struct Guard {
    pairs: Vec<Pair>,
    /// For each parameter its pairs.
    uses: Vec<Vec<Use>>,
}

#[derive(Clone, Debug)]
struct Pair {
    /// The part of the wish that whole numbers decide on.
    wish: DVec2,
    parameters: Vec<u32>,
}

/// By how much the difference of a pair grows with a parameter.
#[derive(Clone, Copy, Debug)]
struct Use {
    pair: u32,
    slope: DVec2,
}

impl Guard {
    /// `rows` gives the whole unknowns in terms of the parameters.
    pub(super) fn new(separations: &[Separation], rows: &[Form], parameters: usize) -> Self {
        let mut guard = Self {
            pairs: Vec::with_capacity(separations.len()),
            uses: vec![Vec::new(); parameters],
        };
        for separation in separations {
            let difference = separation
                .difference
                .each_ref()
                .map(|form| form.as_ref().map(|form| substituted(form, rows)));
            if is_decisive(&difference, separation.wish) {
                guard.push(&difference, separation.decided());
            }
        }
        guard
    }

    fn push(&mut self, difference: &[Option<Form>; 2], wish: DVec2) {
        let number = self.pairs.len() as u32;
        let forms = difference.iter().flatten();
        let columns = forms.flat_map(|form| form.terms().iter().map(|term| term.0));
        let mut parameters: Vec<u32> = columns.collect();
        parameters.sort_unstable();
        parameters.dedup();
        for &parameter in &parameters {
            let slope = |c: usize| {
                let form: Option<&Form> = difference[c].as_ref();
                form.map_or(0.0, |form| form.coefficient(parameter) as f64)
            };
            self.uses[parameter as usize].push(Use {
                pair: number,
                slope: DVec2::new(slope(0), slope(1)),
            });
        }
        self.pairs.push(Pair { wish, parameters });
    }

    /// No parameter settled yet, at a density.
    pub(super) fn none_settled(&self, density: f64) -> SettledPairs<'_> {
        SettledPairs {
            guard: self,
            density,
            sums: vec![DVec2::ZERO; self.pairs.len()],
            open: self
                .pairs
                .iter()
                .map(|pair| pair.parameters.len() as u32)
                .collect(),
        }
    }
}

fn substituted(form: &Form, rows: &[Form]) -> Form {
    let mut sum = Form::default();
    for &(unknown, factor) in form.terms() {
        sum.add(factor, &rows[unknown as usize]);
    }
    sum
}

/// How far the pairs of a guard are settled.
pub(super) struct SettledPairs<'a> {
    guard: &'a Guard,
    density: f64,
    /// The part of each difference that is settled.
    sums: Vec<DVec2>,
    /// The parameters of each that are not.
    open: Vec<u32>,
}

impl SettledPairs<'_> {
    fn is_broken_at(&self, pair: usize, difference: DVec2) -> bool {
        let wish = self.guard.pairs[pair].wish * self.density;
        wish.length() <= FARTHEST_GUARDED && difference.dot(wish) <= 0.0
    }

    /// Whether a settled pair ends up at one point or the wrong way round.
    pub(super) fn is_broken(&self, pair: usize) -> bool {
        self.open[pair] == 0 && self.is_broken_at(pair, self.sums[pair])
    }

    pub(super) fn broken_pairs(&self) -> Vec<usize> {
        let pairs = 0..self.sums.len();
        pairs.filter(|&pair| self.is_broken(pair)).collect()
    }

    pub(super) fn parameters_of(&self, pair: usize) -> impl Iterator<Item = usize> {
        let parameters = self.guard.pairs[pair].parameters.iter();
        parameters.map(|&parameter| parameter as usize)
    }

    /// The number of pairs, all their other parameters settled, that this value would break.
    pub(super) fn broken_by(&self, parameter: usize, value: f64) -> usize {
        let last = self.guard.uses[parameter].iter();
        last.filter(|used| self.open[used.pair as usize] == 1)
            .filter(|used| {
                let pair = used.pair as usize;
                self.is_broken_at(pair, self.sums[pair] + used.slope * value)
            })
            .count()
    }

    pub(super) fn settle(&mut self, parameter: usize, value: f64) {
        for used in &self.guard.uses[parameter] {
            self.open[used.pair as usize] -= 1;
        }
        self.shift(parameter, value);
    }

    /// Moves a parameter.
    pub(super) fn shift(&mut self, parameter: usize, step: f64) {
        for used in &self.guard.uses[parameter] {
            self.sums[used.pair as usize] += used.slope * step;
        }
    }

    /// How many pairs fewer are broken after a parameter has moved.
    pub(super) fn parted_by(&self, parameter: usize, step: f64) -> i64 {
        let change = |used: &Use| {
            let pair = used.pair as usize;
            let after = self.is_broken_at(pair, self.sums[pair] + used.slope * step);
            i64::from(self.is_broken(pair)) - i64::from(after)
        };
        self.guard.uses[parameter].iter().map(change).sum()
    }
}

/// Places farther apart than this many line spacings are not rounded together.
const FARTHEST_GUARDED: f64 = 4.0;
