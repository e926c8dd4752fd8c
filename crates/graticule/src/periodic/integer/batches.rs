//! Rounding of very many whole numbers, some at a time, by sparse solutions alone.

use glam::DVec3;

use super::IntegerGridError;
use super::form::Form;
use super::rounding::best_whole;
use super::separation::Guard;
use super::solver::Parts;
use super::system::assemble;
use crate::solve::{DirichletSystem, Placement, SymmetricMatrix};
use crate::watch::Watch;

/// The energy of a net over its real unknowns and the free parameters of the whole ones.
///
/// Where a dense matrix over the whole unknowns would be too large, the parameters are rounded in
/// batches: those nearest to whole numbers first, the others at their best for these. Each batch
/// costs one sparse factorisation; their number grows with the logarithm of that of the parameters.
pub(super) struct BatchSystem {
    reals: usize,
    matrix: SymmetricMatrix,
    loads: Vec<f64>,
    points: Vec<DVec3>,
}

/// A batch settles this one part of so many of the open parameters.
const BATCH_PART: usize = 3;

/// The fewest parameters in a batch.
const LEAST_BATCH: usize = 64;

impl BatchSystem {
    /// `rows` gives the whole unknowns in terms of the parameters.
    pub(super) fn new(
        parts: Parts<'_>,
        (rows, parameters): (&[Form], usize),
    ) -> Result<Self, IntegerGridError> {
        let reals = parts.unknowns.reals;
        let whole = |column: u32, factor: f64, terms: &mut Vec<(u32, f64)>| {
            let row = rows[column as usize].terms().iter();
            terms.extend(
                row.map(|&(parameter, value)| (reals as u32 + parameter, factor * value as f64)),
            );
        };
        let (matrix, loads) = assemble(parts, reals + parameters, whole)?;
        let mut points = parts.unknowns.points(parts.mesh, parts.positions);
        points.resize(reals + parameters, DVec3::ZERO);
        Ok(Self {
            reals,
            matrix,
            loads,
            points,
        })
    }

    /// The rounded parameters at a density, and the best real unknowns for them.
    pub(super) fn at(
        &self,
        density: f64,
        guard: &Guard,
        watch: &Watch,
    ) -> Result<(Vec<i64>, Vec<f64>), IntegerGridError> {
        let loads: Vec<f64> = self.loads.iter().map(|load| density * load).collect();
        let parameters = self.loads.len() - self.reals;
        let mut is_settled = vec![false; parameters];
        let mut wholes = vec![0.0; parameters];
        loop {
            watch.check()?;
            let fixed: Vec<usize> = (0..parameters).filter(|&place| is_settled[place]).collect();
            let values: Vec<f64> = fixed.iter().map(|&place| wholes[place]).collect();
            let columns: Vec<usize> = fixed.iter().map(|&place| self.reals + place).collect();
            let placement = Placement::at(&self.points);
            let system = DirichletSystem::new(&self.matrix, &columns, placement)?;
            let mut solved = system.solve_with_loads(&values, &loads)?.values;
            let mut current = solved.split_off(self.reals);
            let batch = next_batch(&current, &is_settled);
            if batch.is_empty() {
                let wholes = wholes.into_iter().map(|whole| whole as i64).collect();
                return Ok((wholes, solved));
            }
            for place in batch {
                let whole = best_whole(current[place], |whole| {
                    let relaxed = std::mem::replace(&mut current[place], whole);
                    let broken = guard.broken(place, &current, &is_settled, density);
                    current[place] = relaxed;
                    broken
                });
                (current[place], wholes[place]) = (whole, whole);
                is_settled[place] = true;
            }
        }
    }
}

/// The open parameters that are nearest to whole numbers.
fn next_batch(values: &[f64], is_settled: &[bool]) -> Vec<usize> {
    let off = |&place: &usize| (values[place] - values[place].round()).abs();
    let mut open: Vec<usize> = (0..values.len())
        .filter(|&place| !is_settled[place])
        .collect();
    open.sort_by(|a, b| off(a).total_cmp(&off(b)).then(a.cmp(b)));
    open.truncate((open.len() / BATCH_PART).max(LEAST_BATCH));
    open
}
