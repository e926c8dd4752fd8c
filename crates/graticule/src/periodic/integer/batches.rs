//! Rounding of very many whole numbers, some at a time, by sparse solutions alone.

use super::IntegerGridError;
use super::form::Form;
use super::guard::Guard;
use super::rounding::best_whole;
use super::solver::Parts;
use super::system::{normal_equations, right_side};
use crate::solve::{DirichletSystem, Placement, SymmetricMatrix};
use crate::tolerance::STIFF_EQUATION;
use crate::watch::Watch;

/// The energy of a net over its real unknowns and its whole ones, whose equations are stiff springs.
///
/// Where a dense matrix over the whole unknowns would be too large, the parameters are rounded in
/// batches: those nearest to whole numbers first, the others at their best for these. Each batch
/// costs one sparse factorisation; their number grows with the logarithm of that of the parameters.
/// The springs keep all matrices sparse; they only shape what is rounded: the whole unknowns follow
/// from the parameters exactly, and the real ones from those.
pub(super) struct BatchSystem {
    reals: usize,
    matrix: SymmetricMatrix,
    loads: Vec<f64>,
    /// The unknown that stands for each parameter.
    carriers: Vec<usize>,
    /// The whole unknowns in terms of the parameters.
    rows: Vec<Form>,
    /// The system over the real unknowns, all others given.
    real_system: DirichletSystem,
}

/// A batch settles this one part of so many of the open parameters.
const BATCH_PART: usize = 2;

/// The fewest parameters in a batch.
const LEAST_BATCH: usize = 128;

impl BatchSystem {
    /// `rows` gives the whole unknowns in terms of the parameters.
    pub(super) fn new(
        parts: Parts<'_>,
        (rows, parameters): (&[Form], usize),
    ) -> Result<Self, IntegerGridError> {
        let unknowns = parts.unknowns;
        let reals = unknowns.reals;
        let carriers = Carriers::of(rows, parameters);
        let count = reals + rows.len() + carriers.added.len();
        let mut equations = normal_equations(parts, count)?;
        for equation in unknowns.equations.iter().chain(&carriers.added) {
            let terms = equation.terms().iter();
            let terms = terms.map(|&(column, factor)| (reals as u32 + column, factor as f64));
            equations.add(STIFF_EQUATION, terms, 0.0);
        }
        let (matrix, loads) = equations.finish()?;
        let wholes: Vec<usize> = (reals..count).collect();
        let real_system = DirichletSystem::new(&matrix, &wholes, Placement::unknown())?;
        let carriers = carriers.columns.iter();
        Ok(Self {
            reals,
            matrix,
            loads,
            carriers: carriers.map(|&column| reals + column as usize).collect(),
            rows: rows.to_vec(),
            real_system,
        })
    }

    /// Takes over other wishes.
    pub(super) fn wish(&mut self, parts: Parts<'_>) {
        self.loads = right_side(parts, self.loads.len());
    }

    /// The rounded parameters at a density, and the best real unknowns for them.
    pub(super) fn at(
        &self,
        density: f64,
        guard: &Guard,
        watch: &Watch,
    ) -> Result<(Vec<i64>, Vec<f64>), IntegerGridError> {
        let loads: Vec<f64> = self.loads.iter().map(|load| density * load).collect();
        let mut wholes: Vec<Option<f64>> = vec![None; self.carriers.len()];
        let mut settled = guard.none_settled(density);
        loop {
            watch.check()?;
            let open = self.relaxed(&wholes, &loads)?;
            if open.is_empty() {
                break;
            }
            for (place, value) in next_batch(open) {
                let whole = best_whole(value, |whole| settled.broken_by(place, whole));
                settled.settle(place, whole);
                wholes[place] = Some(whole);
            }
        }
        let parameters: Vec<i64> = wholes.into_iter().flatten().map(|w| w as i64).collect();
        let reals = self.reals_at(&parameters, &loads)?;
        Ok((parameters, reals))
    }

    /// The open parameters where the energy is least, with their numbers.
    fn relaxed(
        &self,
        wholes: &[Option<f64>],
        loads: &[f64],
    ) -> Result<Vec<(usize, f64)>, IntegerGridError> {
        let open: Vec<usize> = (0..wholes.len())
            .filter(|&place| wholes[place].is_none())
            .collect();
        if open.is_empty() {
            return Ok(Vec::new());
        }
        let fixed = (0..wholes.len()).filter(|&place| wholes[place].is_some());
        let columns: Vec<usize> = fixed.map(|place| self.carriers[place]).collect();
        let values: Vec<f64> = wholes.iter().copied().flatten().collect();
        let system = DirichletSystem::new(&self.matrix, &columns, Placement::unknown())?;
        let solved = system.solve_with_loads(&values, loads)?.values;
        let value = |place: usize| (place, solved[self.carriers[place]]);
        Ok(open.into_iter().map(value).collect())
    }

    /// The best real unknowns for whole parameters.
    fn reals_at(&self, parameters: &[i64], loads: &[f64]) -> Result<Vec<f64>, IntegerGridError> {
        let wholes = self.rows.iter().map(|row| row.value(parameters) as f64);
        let mut given: Vec<f64> = wholes.collect();
        // What was added for a parameter without an unknown of its own touches no real one.
        given.resize(loads.len() - self.reals, 0.0);
        let mut reals = self.real_system.solve_with_loads(&given, loads)?.values;
        reals.truncate(self.reals);
        Ok(reals)
    }
}

/// The whole unknowns that stand for parameters.
struct Carriers {
    /// The one of each parameter.
    columns: Vec<u32>,
    /// Unknowns that were added, after the whole ones: for each a sum that has to vanish.
    added: Vec<Form>,
}

impl Carriers {
    /// A parameter is mostly a whole unknown itself. Where Euclid's steps changed it, an unknown is
    /// added, and the shortest of the rows with it says what it is.
    fn of(rows: &[Form], parameters: usize) -> Self {
        let mut own = vec![None; parameters];
        let mut shortest: Vec<Option<usize>> = vec![None; parameters];
        for (number, row) in rows.iter().enumerate() {
            for &(parameter, factor) in row.terms() {
                let parameter = parameter as usize;
                if factor == 1 && row.terms().len() == 1 {
                    own[parameter].get_or_insert(number as u32);
                }
                let known = &mut shortest[parameter];
                let length = |number: usize| rows[number].terms().len();
                if known.is_none_or(|known| length(number) < length(known)) {
                    *known = Some(number);
                }
            }
        }
        let mut carriers = Self {
            columns: Vec::with_capacity(parameters),
            added: Vec::new(),
        };
        let mut defining = Vec::new();
        for (own, shortest) in own.into_iter().zip(shortest) {
            let added = || {
                defining.push(shortest);
                (rows.len() + defining.len() - 1) as u32
            };
            let column = own.unwrap_or_else(added);
            carriers.columns.push(column);
        }
        for number in defining.into_iter().flatten() {
            let mut sum = Form::unknown(number as u32);
            for &(parameter, factor) in rows[number].terms() {
                sum.add(
                    -factor,
                    &Form::unknown(carriers.columns[parameter as usize]),
                );
            }
            carriers.added.push(sum);
        }
        carriers
    }
}

/// Of the open parameters those nearest to whole numbers.
fn next_batch(mut open: Vec<(usize, f64)>) -> Vec<(usize, f64)> {
    let off = |&(_, value): &(usize, f64)| (value - value.round()).abs();
    open.sort_by(|a, b| off(a).total_cmp(&off(b)).then(a.0.cmp(&b.0)));
    open.truncate((open.len() / BATCH_PART).max(LEAST_BATCH));
    open
}

#[cfg(test)]
mod tests {
    use super::super::lattice::tests::form;
    use super::*;

    #[test]
    fn a_parameter_without_an_unknown_of_its_own_gets_one() {
        let rows = [form(&[(0, 3)]), form(&[(0, -2), (1, 1)]), form(&[(1, 1)])];
        let carriers = Carriers::of(&rows, 2);
        assert_eq!(carriers.columns, [3, 2]);
        assert_eq!(carriers.added, [form(&[(0, 1), (3, -3)])]);
    }
}
