//! The elimination: fronts in postorder, and what they pass on.

use std::ops::Range;

use faer::c64;
use faer::dyn_stack::MemBuffer;

use super::columns::Value;
use super::front::{Panel, Scalar, Update, factor_scratch, packed_len};
use super::plan::{Block, Plan};
use crate::solve::SolveError;
use crate::solve::memory::{memory, reserve, reserved};

/// Numbers of one kind.
pub(super) struct Stack<T> {
    /// Updates that wait for their parent's front, the latest last.
    waiting: Vec<T>,
    /// Room for the update that is being made.
    square: Vec<T>,
    scratch: MemBuffer,
}

impl<T: Scalar> Stack<T> {
    fn new(plan: &Plan) -> Result<Self, SolveError> {
        let widest = plan.blocks().iter().map(Block::width).max().unwrap_or(0);
        Ok(Self {
            waiting: Vec::new(),
            square: Vec::new(),
            scratch: memory(factor_scratch::<T>(widest))?,
        })
    }
}

/// The panels of some blocks, one after the other.
pub(super) struct Panels {
    pub(super) real: Vec<f64>,
    pub(super) complex: Vec<c64>,
}

impl Panels {
    /// Room for blocks.
    pub(super) fn with_room<'a>(
        blocks: impl Iterator<Item = &'a Block>,
    ) -> Result<Self, SolveError> {
        let mut lengths = [0, 0];
        for block in blocks {
            lengths[usize::from(block.complex)] += block.height() * block.width();
        }
        Ok(Self {
            real: reserved(lengths[0])?,
            complex: reserved(lengths[1])?,
        })
    }
}

/// Zeros added at the end: memory is first touched where it is used.
fn extended<T: Clone + Default>(values: &mut Vec<T>, length: usize) -> &mut [T] {
    let start = values.len();
    values.resize(start + length, T::default());
    &mut values[start..]
}

/// A block whose parent has not come yet, and where its update starts on the stack of its kind.
#[derive(Clone, Copy)]
struct Waiting {
    block: usize,
    start: usize,
}

/// What the blocks of a part pass on to blocks outside it.
pub(super) struct PassedOn {
    waiting: Vec<Waiting>,
    real: Vec<f64>,
    complex: Vec<c64>,
}

/// The state of an elimination.
pub(super) struct Elimination<'a, V> {
    plan: &'a Plan,
    /// Those of the matrix's lower triangle.
    values: &'a [V],
    /// Place of each row in the current front.
    places: Vec<u32>,
    /// Places in the current front of the rows of its children, one child after the other.
    child_places: Vec<u32>,
    waiting: Vec<Waiting>,
    real: Stack<f64>,
    complex: Stack<c64>,
}

/// Numbers that have a stack.
pub(super) trait Stacked: Scalar {
    fn stack<'a, V>(elimination: &'a mut Elimination<'_, V>) -> &'a mut Stack<Self>;
}

impl Stacked for f64 {
    fn stack<'a, V>(elimination: &'a mut Elimination<'_, V>) -> &'a mut Stack<Self> {
        &mut elimination.real
    }
}

impl Stacked for c64 {
    fn stack<'a, V>(elimination: &'a mut Elimination<'_, V>) -> &'a mut Stack<Self> {
        &mut elimination.complex
    }
}

impl<'a, V: Value> Elimination<'a, V> {
    pub(super) fn new(plan: &'a Plan, values: &'a [V]) -> Result<Self, SolveError> {
        Ok(Self {
            plan,
            values,
            places: vec![0; plan.order().len()],
            child_places: Vec::new(),
            waiting: Vec::new(),
            real: Stack::new(plan)?,
            complex: Stack::new(plan)?,
        })
    }

    /// Eliminates blocks whose other descendants have been eliminated or adopted, and puts their
    /// columns of the factor after those that are in `panels`.
    pub(super) fn run(
        &mut self,
        blocks: Range<usize>,
        panels: &mut Panels,
    ) -> Result<(), SolveError> {
        for index in blocks {
            let block = &self.plan.blocks()[index];
            let length = block.height() * block.width();
            if block.complex {
                self.eliminate(index, extended(&mut panels.complex, length))?;
            } else {
                self.eliminate(index, extended(&mut panels.real, length))?;
            }
        }
        Ok(())
    }

    /// Eliminates the columns of a block and leaves its part of the factor in `values`.
    fn eliminate<T: Stacked>(&mut self, index: usize, values: &mut [T]) -> Result<(), SolveError> {
        let block = &self.plan.blocks()[index];
        let mut panel = Panel {
            values,
            width: block.width(),
            depth: block.depth(),
        };
        self.number_rows(block);
        self.gather(block, &mut panel);
        let children = self.children(index);
        self.for_each_child(children, |places, update| panel.add(places, update));
        let done = panel.factor(&mut T::stack(self).scratch);
        done.map_err(|(column, pivot)| SolveError::NotPositiveDefinite {
            column: self.plan.order()[block.columns.start + column] as usize,
            pivot,
        })?;
        if block.depth() == 0 {
            self.forget(children);
            return Ok(());
        }
        let mut square = std::mem::take(&mut T::stack(self).square);
        let count = block.depth() * block.depth();
        if square.len() < count {
            let more = count - square.len();
            reserve(&mut square, more)?;
            square.resize(count, T::default());
        }
        let update = &mut square[..count];
        panel.update_into(update);
        self.for_each_child(children, |places, child| {
            panel.pass_on(update, places, child);
        });
        T::stack(self).square = square;
        self.forget(children);
        self.keep::<T>(index)
    }

    fn number_rows(&mut self, block: &Block) {
        let below = self.plan.rows_below(block).iter();
        let rows = block.columns.clone().chain(below.map(|&row| row as usize));
        for (place, row) in (0..).zip(rows) {
            self.places[row] = place;
        }
    }

    /// Puts the matrix's own entries into the panel.
    fn gather<T: Scalar>(&self, block: &Block, panel: &mut Panel<'_, T>) {
        let columns = panel.values.chunks_exact_mut(block.height());
        for (values, column) in columns.zip(block.columns.clone()) {
            for (row, value) in self.plan.columns.of_column(column, self.values) {
                values[self.places[row as usize] as usize] = T::of(value);
            }
        }
    }

    /// Where the blocks begin, among those waiting, that pass on to this one: they are the last.
    /// The places of their rows in the front are found.
    fn children(&mut self, index: usize) -> usize {
        let plan = self.plan;
        let is_child = |waiting: &&Waiting| plan.blocks()[waiting.block].parent == Some(index);
        let count = self.waiting.iter().rev().take_while(is_child).count();
        let first = self.waiting.len() - count;
        self.child_places.clear();
        for waiting in &self.waiting[first..] {
            let rows = plan.rows_below(&plan.blocks()[waiting.block]).iter();
            let places = rows.map(|&row| self.places[row as usize]);
            self.child_places.extend(places);
        }
        first
    }

    /// Calls with the places and the update of each of the blocks waiting from `first` on.
    fn for_each_child(&self, first: usize, mut call: impl FnMut(&[u32], Update<'_>)) {
        let mut rest = self.child_places.as_slice();
        for &child in &self.waiting[first..] {
            let depth = self.plan.blocks()[child.block].depth();
            let (places, after) = rest.split_at(depth);
            call(places, self.update(child));
            rest = after;
        }
    }

    fn update(&self, Waiting { block, start }: Waiting) -> Update<'_> {
        let block = &self.plan.blocks()[block];
        let range = start..start + packed_len(block.depth());
        if block.complex {
            Update::Complex(&self.complex.waiting[range])
        } else {
            Update::Real(&self.real.waiting[range])
        }
    }

    /// Drops the updates of the last blocks waiting.
    fn forget(&mut self, first: usize) {
        for Waiting { block, start } in self.waiting.drain(first..).rev() {
            if self.plan.blocks()[block].complex {
                self.complex.waiting.truncate(start);
            } else {
                self.real.waiting.truncate(start);
            }
        }
    }

    /// Puts the update just made on the stack.
    fn keep<T: Stacked>(&mut self, index: usize) -> Result<(), SolveError> {
        let depth = self.plan.blocks()[index].depth();
        let Stack {
            waiting, square, ..
        } = T::stack(self);
        let start = waiting.len();
        reserve(waiting, packed_len(depth))?;
        for (column, values) in square.chunks_exact(depth).take(depth).enumerate() {
            waiting.extend_from_slice(&values[column..]);
        }
        self.waiting.push(Waiting {
            block: index,
            start,
        });
        Ok(())
    }

    /// Takes over what the blocks of a part pass on, as if they had been eliminated here.
    pub(super) fn adopt(&mut self, passed_on: &PassedOn) -> Result<(), SolveError> {
        let (real, complex) = (&mut self.real.waiting, &mut self.complex.waiting);
        let starts = [real.len(), complex.len()];
        reserve(real, passed_on.real.len())?;
        reserve(complex, passed_on.complex.len())?;
        real.extend_from_slice(&passed_on.real);
        complex.extend_from_slice(&passed_on.complex);
        let blocks = self.plan.blocks();
        let moved = passed_on.waiting.iter().map(|&Waiting { block, start }| {
            let start = start + starts[usize::from(blocks[block].complex)];
            Waiting { block, start }
        });
        self.waiting.extend(moved);
        Ok(())
    }

    /// What no block that was eliminated here has taken.
    pub(super) fn passed_on(self) -> PassedOn {
        PassedOn {
            waiting: self.waiting,
            real: self.real.waiting,
            complex: self.complex.waiting,
        }
    }
}
