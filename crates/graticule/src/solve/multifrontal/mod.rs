//! Multifrontal Cholesky factorisation of Hermitian matrices that are real in most places.
//!
//! Blocks of columns with the same rows are gathered into dense fronts; each front eliminates its
//! own columns and passes the rest on to its parent (I. Duff and J. Reid, *The multifrontal solution
//! of indefinite sparse symmetric linear equations*, 1983). A block is complex only if complex
//! numbers reach it, from its own columns or from its descendants. The matrices of conformal maps
//! have them at the boundary alone: most of what lies inside is factored with a quarter of the
//! operations and kept in half of the memory.

use faer::c64;

use self::eliminate::{Columns, Elimination};
use self::plan::Plan;
use super::memory::reserved;
use super::{HermitianMatrix, Ordering, SolveError};

mod eliminate;
mod front;
mod plan;
mod substitution;
mod tree;

/// `L` with `L Lᴴ = A`, by blocks.
pub(super) struct Multifrontal {
    plan: Plan,
    /// Where the panel of each block starts among the numbers of its kind.
    starts: Vec<usize>,
    real: Vec<f64>,
    complex: Vec<c64>,
}

/// The panel of a block: `width` columns of `height` numbers.
enum Values<'a> {
    Real(&'a [f64]),
    Complex(&'a [c64]),
}

impl Multifrontal {
    /// Factors a positive definite matrix.
    ///
    /// # Errors
    /// [`SolveError::NotPositiveDefinite`], [`SolveError::OutOfMemory`].
    pub(super) fn new(matrix: &HermitianMatrix, ordering: &Ordering) -> Result<Self, SolveError> {
        let complex = matrix.complex_unknowns();
        let plan = Plan::new(matrix.pattern(), ordering, |unknown| {
            complex[unknown as usize]
        });
        let mut lengths = [0, 0];
        let mut starts = Vec::with_capacity(plan.blocks.len());
        for block in &plan.blocks {
            let length = &mut lengths[usize::from(block.complex)];
            starts.push(*length);
            *length += block.height() * block.width();
        }
        let mut factor = Self {
            real: reserved(lengths[0])?,
            complex: reserved(lengths[1])?,
            starts,
            plan,
        };
        factor.eliminate(matrix)?;
        Ok(factor)
    }

    fn eliminate(&mut self, matrix: &HermitianMatrix) -> Result<(), SolveError> {
        let columns = Columns::of(matrix, &self.plan);
        let mut elimination = Elimination::new(&self.plan, &columns)?;
        for (index, block) in self.plan.blocks.iter().enumerate() {
            let length = block.height() * block.width();
            if block.complex {
                elimination.eliminate(index, extended(&mut self.complex, length))?;
            } else {
                elimination.eliminate(index, extended(&mut self.real, length))?;
            }
        }
        Ok(())
    }

    fn values(&self, index: usize) -> Values<'_> {
        let block = &self.plan.blocks[index];
        let start = self.starts[index];
        let range = start..start + block.height() * block.width();
        if block.complex {
            Values::Complex(&self.complex[range])
        } else {
            Values::Real(&self.real[range])
        }
    }

    /// Rows and columns.
    pub(super) fn order(&self) -> usize {
        self.plan.order.len()
    }

    /// Numbers stored in the factor: real and complex ones.
    pub(super) fn entries(&self) -> [usize; 2] {
        [self.real.len(), self.complex.len()]
    }
}

/// Zeros added at the end: memory is first touched where it is used.
fn extended<T: Clone + Default>(values: &mut Vec<T>, length: usize) -> &mut [T] {
    let start = values.len();
    values.resize(start + length, T::default());
    &mut values[start..]
}
