//! The elimination: fronts in postorder, and what they pass on.

use faer::c64;
use faer::dyn_stack::MemBuffer;

use super::front::{Panel, Scalar, Update, factor_scratch, packed_len};
use super::plan::{Block, Plan};
use super::tree::sum_up;
use crate::solve::memory::{memory, reserve};
use crate::solve::{HermitianMatrix, SolveError};

/// The lower triangle of a matrix in elimination order, the diagonal included.
pub(super) struct Columns {
    starts: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<c64>,
}

impl Columns {
    pub(super) fn of(matrix: &HermitianMatrix, plan: &Plan) -> Self {
        let places = &plan.places;
        let mut starts = vec![0; places.len() + 1];
        matrix.for_each_entry(|row, column, _| {
            let place = places[row].min(places[column]);
            starts[place as usize + 1] += 1;
        });
        sum_up(&mut starts);
        let mut next = starts.clone();
        let entries = starts[places.len()] as usize;
        let mut rows = vec![0; entries];
        let mut values = vec![c64::ZERO; entries];
        matrix.for_each_entry(|row, column, value| {
            let [row, column] = [places[row], places[column]];
            let slot = &mut next[row.min(column) as usize];
            rows[*slot as usize] = row.max(column);
            values[*slot as usize] = if row < column { value.conj() } else { value };
            *slot += 1;
        });
        Self {
            starts,
            rows,
            values,
        }
    }

    fn of_column(&self, column: usize) -> impl Iterator<Item = (u32, c64)> + '_ {
        let range = self.starts[column] as usize..self.starts[column + 1] as usize;
        let rows = self.rows[range.clone()].iter();
        rows.copied().zip(self.values[range].iter().copied())
    }
}

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
        let widest = plan.blocks.iter().map(Block::width).max().unwrap_or(0);
        Ok(Self {
            waiting: Vec::new(),
            square: Vec::new(),
            scratch: memory(factor_scratch::<T>(widest))?,
        })
    }
}

/// A block whose parent has not come yet, and where its update starts on the stack of its kind.
#[derive(Clone, Copy)]
struct Waiting {
    block: usize,
    start: usize,
}

/// The state of an elimination.
pub(super) struct Elimination<'a> {
    plan: &'a Plan,
    columns: &'a Columns,
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
    fn stack<'a>(elimination: &'a mut Elimination<'_>) -> &'a mut Stack<Self>;
}

impl Stacked for f64 {
    fn stack<'a>(elimination: &'a mut Elimination<'_>) -> &'a mut Stack<Self> {
        &mut elimination.real
    }
}

impl Stacked for c64 {
    fn stack<'a>(elimination: &'a mut Elimination<'_>) -> &'a mut Stack<Self> {
        &mut elimination.complex
    }
}

impl<'a> Elimination<'a> {
    pub(super) fn new(plan: &'a Plan, columns: &'a Columns) -> Result<Self, SolveError> {
        Ok(Self {
            plan,
            columns,
            places: vec![0; plan.order.len()],
            child_places: Vec::new(),
            waiting: Vec::new(),
            real: Stack::new(plan)?,
            complex: Stack::new(plan)?,
        })
    }

    /// Eliminates the columns of a block, whose descendants have been eliminated, and leaves its
    /// part of the factor in `values`.
    pub(super) fn eliminate<T: Stacked>(
        &mut self,
        index: usize,
        values: &mut [T],
    ) -> Result<(), SolveError> {
        let block = &self.plan.blocks[index];
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
        done.map_err(|column| SolveError::NotPositiveDefinite {
            column: self.plan.order[block.columns.start + column] as usize,
            pivot: 0.0,
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
            for (row, value) in self.columns.of_column(column) {
                values[self.places[row as usize] as usize] = T::of(value);
            }
        }
    }

    /// Where the blocks begin, among those waiting, that pass on to this one: they are the last.
    /// The places of their rows in the front are found.
    fn children(&mut self, index: usize) -> usize {
        let plan = self.plan;
        let is_child = |waiting: &&Waiting| plan.blocks[waiting.block].parent == Some(index);
        let count = self.waiting.iter().rev().take_while(is_child).count();
        let first = self.waiting.len() - count;
        self.child_places.clear();
        for waiting in &self.waiting[first..] {
            let rows = plan.rows_below(&plan.blocks[waiting.block]).iter();
            let places = rows.map(|&row| self.places[row as usize]);
            self.child_places.extend(places);
        }
        first
    }

    /// Calls with the places and the update of each of the blocks waiting from `first` on.
    fn for_each_child(&self, first: usize, mut call: impl FnMut(&[u32], Update<'_>)) {
        let mut rest = self.child_places.as_slice();
        for &child in &self.waiting[first..] {
            let depth = self.plan.blocks[child.block].depth();
            let (places, after) = rest.split_at(depth);
            call(places, self.update(child));
            rest = after;
        }
    }

    fn update(&self, Waiting { block, start }: Waiting) -> Update<'_> {
        let block = &self.plan.blocks[block];
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
            if self.plan.blocks[block].complex {
                self.complex.waiting.truncate(start);
            } else {
                self.real.waiting.truncate(start);
            }
        }
    }

    /// Puts the update just made on the stack.
    fn keep<T: Stacked>(&mut self, index: usize) -> Result<(), SolveError> {
        let depth = self.plan.blocks[index].depth();
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
}
