//! Multifrontal Cholesky factorisation of Hermitian matrices that are real in most places.
//!
//! Blocks of columns with the same rows are gathered into dense fronts; each front eliminates its
//! own columns and passes the rest on to its parent (I. Duff and J. Reid, *The multifrontal solution
//! of indefinite sparse symmetric linear equations*, 1983). A block is complex only if complex
//! numbers reach it, from its own columns or from its descendants. The matrices of conformal maps
//! have them at the boundary alone: most of what lies inside is factored with a quarter of the
//! operations and kept in half of the memory.

use std::ops::Range;
use std::sync::Arc;

use faer::c64;
use rayon::prelude::*;

use self::eliminate::{Elimination, Panels, PassedOn};
use super::SolveError;

mod columns;
mod eliminate;
mod front;
mod parts;
mod plan;
mod substitution;
mod tree;

pub(super) use columns::Value;
pub(super) use plan::Plan;

/// `L` with `L Lᴴ = A`, by blocks.
///
/// The parts of the plan are eliminated side by side. What a block computes depends on its own
/// columns and on what its children pass on, in their order: the result has the same bits for any
/// number of threads.
pub(super) struct Multifrontal {
    plan: Arc<Plan>,
    /// For each block the panels that hold its own, and where it starts among them.
    homes: Vec<(u32, usize)>,
    /// Those of each part, and of the blocks that are in none.
    panels: Vec<Panels>,
}

/// The panel of a block: `width` columns of `height` numbers.
pub(super) enum PanelValues<'a> {
    Real(&'a [f64]),
    Complex(&'a [c64]),
}

impl Multifrontal {
    /// Factors a positive definite matrix of the planned pattern with these values in its lower
    /// triangle.
    ///
    /// # Errors
    /// [`SolveError::NotPositiveDefinite`], [`SolveError::OutOfMemory`].
    pub(super) fn new<V: Value>(plan: &Arc<Plan>, values: &[V]) -> Result<Self, SolveError> {
        let done: Vec<_> = (plan.parts.par_iter())
            .map(|part| eliminated_part(plan, values, part.clone()))
            .collect();
        // The first error in order, not in time.
        let done: Result<Vec<_>, SolveError> = done.into_iter().collect();
        let (mut panels, passed_on): (Vec<_>, Vec<_>) = done?.into_iter().unzip();
        panels.push(eliminated_rest(plan, values, &passed_on)?);
        Ok(Self {
            homes: homes(plan),
            plan: Arc::clone(plan),
            panels,
        })
    }

    fn values(&self, index: usize) -> PanelValues<'_> {
        let block = &self.plan.blocks()[index];
        let (home, start) = self.homes[index];
        let panels = &self.panels[home as usize];
        let range = start..start + block.height() * block.width();
        if block.complex {
            PanelValues::Complex(&panels.complex[range])
        } else {
            PanelValues::Real(&panels.real[range])
        }
    }

    /// Rows and columns.
    pub(super) fn order(&self) -> usize {
        self.plan.order().len()
    }

    pub(super) fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    /// Numbers stored in the factor: real and complex ones.
    pub(super) fn entries(&self) -> [usize; 2] {
        let sum = |length: fn(&Panels) -> usize| self.panels.iter().map(length).sum();
        [
            sum(|panels| panels.real.len()),
            sum(|panels| panels.complex.len()),
        ]
    }

    /// Each column of a real factor from its diagonal on: the places of its rows, and the numbers.
    /// Columns that hold complex numbers are left out.
    pub(super) fn real_columns(&self) -> impl Iterator<Item = RealColumn<'_>> {
        let blocks = self.plan.blocks().iter().enumerate();
        blocks.flat_map(|(index, block)| {
            let panel = match self.values(index) {
                PanelValues::Real(panel) => panel,
                PanelValues::Complex(_) => &[],
            };
            let below = self.plan.rows_below(block);
            let columns = block
                .columns
                .clone()
                .zip(panel.chunks_exact(block.height()));
            columns.map(move |(column, values)| RealColumn {
                own: column..block.columns.end,
                below,
                values: &values[column - block.columns.start..],
            })
        })
    }
}

impl std::fmt::Debug for Multifrontal {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Multifrontal")
            .field("order", &self.order())
            .field("entries", &self.entries())
            .finish()
    }
}

/// A column of a real factor.
pub(super) struct RealColumn<'a> {
    /// Places of the rows of its block, from the diagonal on.
    pub(super) own: Range<usize>,
    /// Places of the other rows.
    pub(super) below: &'a [u32],
    /// The numbers in all of them.
    pub(super) values: &'a [f64],
}

fn eliminated_part<V: Value>(
    plan: &Plan,
    values: &[V],
    part: Range<usize>,
) -> Result<(Panels, PassedOn), SolveError> {
    let mut panels = Panels::with_room(plan.blocks()[part.clone()].iter())?;
    let mut elimination = Elimination::new(plan, values)?;
    elimination.run(part, &mut panels)?;
    Ok((panels, elimination.passed_on()))
}

/// Eliminates the blocks that are in no part.
fn eliminated_rest<V: Value>(
    plan: &Plan,
    values: &[V],
    passed_on: &[PassedOn],
) -> Result<Panels, SolveError> {
    let gaps = gaps(plan);
    let rest = gaps.iter().flat_map(|gap| &plan.blocks()[gap.clone()]);
    let mut panels = Panels::with_room(rest)?;
    let mut elimination = Elimination::new(plan, values)?;
    for (place, gap) in gaps.into_iter().enumerate() {
        if let Some(before) = place.checked_sub(1) {
            elimination.adopt(&passed_on[before])?;
        }
        elimination.run(gap, &mut panels)?;
    }
    Ok(panels)
}

/// The blocks before the first part, between each two, and after the last.
fn gaps(plan: &Plan) -> Vec<Range<usize>> {
    let starts = std::iter::once(0).chain(plan.parts.iter().map(|part| part.end));
    let ends = plan.parts.iter().map(|part| part.start);
    let ends = ends.chain([plan.blocks().len()]);
    starts.zip(ends).map(|(start, end)| start..end).collect()
}

fn homes(plan: &Plan) -> Vec<(u32, usize)> {
    let mut homes = vec![(plan.parts.len() as u32, 0); plan.blocks().len()];
    for (home, part) in (0..).zip(&plan.parts) {
        for slot in &mut homes[part.clone()] {
            slot.0 = home;
        }
    }
    let mut filled = vec![[0, 0]; plan.parts.len() + 1];
    for ((home, start), block) in homes.iter_mut().zip(plan.blocks()) {
        let length = &mut filled[*home as usize][usize::from(block.complex)];
        *start = *length;
        *length += block.height() * block.width();
    }
    homes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::{Graph, Ordering, SymmetricMatrix};
    use graticule_fixtures::Noise;

    /// Two grids without connection, weighted at random.
    fn matrix(side: usize) -> SymmetricMatrix {
        let mut noise = Noise::new(5);
        let count = 2 * side * side;
        let ends = (0..count).flat_map(|k| {
            let right = (k % side + 1 < side).then_some([k + 1, k]);
            let up = (k / side % side + 1 < side).then_some([k + side, k]);
            right.into_iter().chain(up)
        });
        let mut entries: Vec<_> = (0..count).map(|k| (k, k, 5.0)).collect();
        entries.extend(ends.map(|[row, column]| (row, column, noise.signed())));
        SymmetricMatrix::from_triplets(count, entries).unwrap()
    }

    fn plan(matrix: &SymmetricMatrix) -> Plan {
        let graph = Graph::of_pattern(matrix.lower().pattern());
        let ordering = Ordering::minimum_degree(&graph);
        Plan::new(matrix.lower().pattern(), &ordering, |_| false)
    }

    #[test]
    fn parts_hold_all_descendants_of_their_blocks_and_no_small_matrix_is_parted() {
        let plan = plan(&matrix(130));
        assert!(plan.parts.len() > 8, "{}", plan.parts.len());
        assert!(plan.parts.is_sorted_by_key(|part| part.start));
        let part_of = |index: usize| plan.parts.iter().position(|part| part.contains(&index));
        for (index, block) in plan.blocks().iter().enumerate() {
            let above = block.parent.and_then(part_of);
            assert!(above.is_none() || above == part_of(index));
        }
        assert!(self::plan(&matrix(20)).parts.is_empty());
    }

    #[test]
    fn parts_change_no_bit() {
        let matrix = matrix(130);
        let parted = Arc::new(plan(&matrix));
        let mut whole = plan(&matrix);
        whole.parts.clear();
        let values = matrix.lower().values();
        let right_side = values[..matrix.order()].iter().map(|v| v.as_complex());
        let right_side: Vec<_> = right_side.collect();
        let [one, other] = [parted, Arc::new(whole)].map(|plan| {
            let factor = Multifrontal::new(&plan, values).unwrap();
            factor.solve(&right_side).unwrap()
        });
        assert_eq!(one, other);
    }
}
