//! Multifrontal `L U` of matrices that are not symmetric, with rows exchanged within blocks only.
//!
//! The matrices of mean value and authalic maps have a symmetric pattern and large diagonals. Row
//! exchanges over the whole matrix, which a general solver makes, would then cost several times the
//! fill and buy nothing. Here the order and the blocks (supernodes) are those of the Cholesky
//! factor of the symmetric pattern; each block gathers a dense front, eliminates its own columns
//! with row exchanges among its own rows, and passes the rest on to its parent (Duff and Reid
//! 1983). A pivot that comes out too small is reported; the caller then falls back on a general
//! factorisation.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve as triangular;
use faer::{Accum, MatMut, MatRef, Par, Spec};

use super::memory::zeros;
use super::multifrontal::Plan;
use super::solution::largest;
use super::{SolveError, SparseMatrix};
use crate::tolerance;

/// The factors of one block of columns.
#[derive(Clone, Debug)]
struct Block {
    /// First column of the block, in elimination order.
    begin: usize,
    /// Columns of the block.
    columns: usize,
    /// Rows below the block that it acts on, in elimination order, ascending.
    below: Vec<u32>,
    /// `columns + below` rows, `columns` columns: `L` and the block's own part of `U`.
    lower: Vec<f64>,
    /// `columns` rows, one column for each row below: the rest of `U`.
    upper: Vec<f64>,
    /// Row of the block that goes to each place.
    exchange: Vec<u32>,
}

/// The factors of a matrix.
#[derive(Clone, Debug)]
pub(super) struct FrontalLu {
    blocks: Vec<Block>,
}

/// What a front is put together from.
struct Assembly<'a> {
    /// The matrix in elimination order, by columns and by rows.
    columns: &'a SparseMatrix,
    rows: &'a SparseMatrix,
    /// Place of each row in the current front.
    places: Vec<u32>,
    /// What eliminated blocks pass on: for each one the square matrix of its rows below.
    updates: Vec<Vec<f64>>,
    /// Blocks that pass on to each block.
    children: Vec<Vec<usize>>,
}

/// Why the factorisation stopped.
pub(super) enum FrontError {
    /// A pivot is too small to go on without exchanging rows across blocks.
    WeakPivot,
    Other(SolveError),
}

impl From<SolveError> for FrontError {
    fn from(error: SolveError) -> Self {
        Self::Other(error)
    }
}

impl FrontalLu {
    /// Factors `matrix`, whose rows and columns stand in elimination order and whose largest
    /// entries are near one in every row and column.
    pub(super) fn factor(plan: &Plan, matrix: &SparseMatrix) -> Result<Self, FrontError> {
        let count = plan.blocks().len();
        let mut assembly = Assembly {
            columns: matrix,
            rows: &matrix.transpose(),
            places: vec![0; matrix.rows()],
            updates: vec![Vec::new(); count],
            children: children(plan),
        };
        let mut blocks = Vec::with_capacity(count);
        for index in 0..count {
            let (block, update) = assembly.eliminate(plan, index, &blocks)?;
            blocks.push(block);
            assembly.updates[index] = update;
        }
        Ok(Self { blocks })
    }

    /// Overwrites columns, in elimination order, by the solutions of `A x = b`.
    pub(super) fn solve_in_place(&self, columns: &mut [f64], order: usize) {
        for block in &self.blocks {
            block.act(columns, order, Step::Lower);
        }
        for block in self.blocks.iter().rev() {
            block.act(columns, order, Step::Upper);
        }
    }

    /// Overwrites columns, in elimination order, by the solutions of `Aᵀ x = b`.
    pub(super) fn solve_transposed_in_place(&self, columns: &mut [f64], order: usize) {
        for block in &self.blocks {
            block.act(columns, order, Step::UpperTransposed);
        }
        for block in self.blocks.iter().rev() {
            block.act(columns, order, Step::LowerTransposed);
        }
    }
}

/// The blocks that pass on to each block.
fn children(plan: &Plan) -> Vec<Vec<usize>> {
    let mut children = vec![Vec::new(); plan.blocks().len()];
    for (index, block) in plan.blocks().iter().enumerate() {
        if let Some(parent) = block.parent {
            children[parent].push(index);
        }
    }
    children
}

impl Assembly<'_> {
    fn eliminate(
        &mut self,
        plan: &Plan,
        index: usize,
        blocks: &[Block],
    ) -> Result<(Block, Vec<f64>), FrontError> {
        let planned = &plan.blocks()[index];
        let below = plan.rows_below(planned).to_vec();
        let begin = planned.columns.start;
        let columns = planned.width();
        let mut block = Block {
            lower: zeros(columns * (columns + below.len()))?,
            upper: zeros(columns * below.len())?,
            exchange: vec![0; columns],
            begin,
            columns,
            below,
        };
        let mut update = zeros(block.below.len() * block.below.len())?;
        self.gather(&mut block);
        for child in std::mem::take(&mut self.children[index]) {
            let passed = std::mem::take(&mut self.updates[child]);
            self.extend(&mut block, &mut update, &blocks[child].below, &passed);
        }
        block.eliminate(&mut update)?;
        Ok((block, update))
    }

    /// Puts the matrix's own entries into the front and numbers its rows.
    fn gather(&mut self, block: &mut Block) {
        let Block { begin, columns, .. } = *block;
        let end = begin + columns;
        let height = columns + block.below.len();
        for (place, row) in (begin as u32..end as u32)
            .chain(block.below.iter().copied())
            .enumerate()
        {
            self.places[row as usize] = place as u32;
        }
        for local in 0..columns {
            for (row, value) in self.columns.column(begin + local) {
                if row >= begin {
                    block.lower[local * height + self.places[row] as usize] = value;
                }
            }
            for (column, value) in self.rows.column(begin + local) {
                if column >= end {
                    let place = self.places[column] as usize - columns;
                    block.upper[place * columns + local] = value;
                }
            }
        }
    }

    /// Adds what a child passes on, a square matrix on `rows`.
    fn extend(&self, block: &mut Block, update: &mut [f64], rows: &[u32], passed: &[f64]) {
        let (columns, below) = (block.columns, block.below.len());
        let places: Vec<usize> = rows
            .iter()
            .map(|&row| self.places[row as usize] as usize)
            .collect();
        let own = places.partition_point(|&place| place < columns);
        for (&column, values) in places.iter().zip(passed.chunks_exact(rows.len())) {
            if column < columns {
                let target = &mut block.lower[column * (columns + below)..];
                for (&row, value) in places.iter().zip(values) {
                    target[row] += value;
                }
                continue;
            }
            let column = column - columns;
            let target = &mut block.upper[column * columns..];
            for (&row, value) in places[..own].iter().zip(values) {
                target[row] += value;
            }
            let target = &mut update[column * below..];
            for (&row, value) in places[own..].iter().zip(&values[own..]) {
                target[row - columns] += value;
            }
        }
    }
}

/// One of the four triangular solves.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Step {
    Lower,
    Upper,
    UpperTransposed,
    LowerTransposed,
}

impl Block {
    /// Factors the front; what is left for the rows below comes into `update`.
    fn eliminate(&mut self, update: &mut [f64]) -> Result<(), FrontError> {
        let (columns, below) = (self.columns, self.below.len());
        let lower = MatMut::from_column_major_slice_mut(&mut self.lower, columns + below, columns);
        let (mut own, _) = lower.split_at_row_mut(columns);
        let mut inverse = vec![0; columns];
        let scratch = lu_in_place_scratch::<u32, f64>(columns, columns, Par::Seq, Spec::default());
        lu_in_place(
            own.as_mut(),
            &mut self.exchange,
            &mut inverse,
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Spec::default(),
        );
        // Not `<=`: a pivot that is not a number is weak too.
        let strong = |pivot: f64| pivot.abs() > tolerance::SINGULAR_PIVOT;
        if !(0..columns).all(|k| strong(own[(k, k)])) {
            return Err(FrontError::WeakPivot);
        }
        if below > 0 {
            self.exchange_upper();
            self.pass_on(update);
        }
        Ok(())
    }

    /// Brings the upper part's rows into the order of the block's own.
    fn exchange_upper(&mut self) {
        for column in self.upper.chunks_exact_mut(self.columns) {
            let unordered = column.to_vec();
            for (value, &row) in column.iter_mut().zip(&self.exchange) {
                *value = unordered[row as usize];
            }
        }
    }

    /// Divides the outer parts by the block's own factors and subtracts their product from
    /// `update`.
    fn pass_on(&mut self, update: &mut [f64]) {
        let (columns, below) = (self.columns, self.below.len());
        let lower = MatMut::from_column_major_slice_mut(&mut self.lower, columns + below, columns);
        let (own, mut under) = lower.split_at_row_mut(columns);
        let own = own.as_ref();
        triangular::solve_lower_triangular_in_place(
            own.transpose(),
            under.as_mut().transpose_mut(),
            Par::Seq,
        );
        let mut upper = MatMut::from_column_major_slice_mut(&mut self.upper, columns, below);
        triangular::solve_unit_lower_triangular_in_place(own, upper.as_mut(), Par::Seq);
        let update = MatMut::from_column_major_slice_mut(update, below, below);
        subtract_product(update, under.as_ref(), upper.as_ref());
    }

    /// Carries out this block's part of a triangular solve.
    fn act(&self, all: &mut [f64], order: usize, step: Step) {
        let (columns, below) = (self.columns, self.below.len());
        let count = all.len() / order;
        let lower = MatRef::from_column_major_slice(&self.lower, columns + below, columns);
        let (own, under) = lower.split_at_row(columns);
        let upper = MatRef::from_column_major_slice(&self.upper, columns, below);
        let mut top = self.take_own(all, order, step == Step::Lower);
        let mut bottom = self.take_below(all, order);
        let mut x = MatMut::from_column_major_slice_mut(&mut top, columns, count);
        let y = MatMut::from_column_major_slice_mut(&mut bottom, below, count);
        match step {
            Step::Lower => {
                triangular::solve_unit_lower_triangular_in_place(own, x.as_mut(), Par::Seq);
                subtract_product(y, under, x.as_ref());
            }
            Step::Upper => {
                subtract_product(x.as_mut(), upper, y.as_ref());
                triangular::solve_upper_triangular_in_place(own, x, Par::Seq);
            }
            Step::UpperTransposed => {
                triangular::solve_lower_triangular_in_place(own.transpose(), x.as_mut(), Par::Seq);
                subtract_product(y, upper.transpose(), x.as_ref());
            }
            Step::LowerTransposed => {
                subtract_product(x.as_mut(), under.transpose(), y.as_ref());
                triangular::solve_unit_upper_triangular_in_place(own.transpose(), x, Par::Seq);
            }
        }
        self.put_own(all, order, &top, step == Step::LowerTransposed);
        if matches!(step, Step::Lower | Step::UpperTransposed) {
            self.put_below(all, order, &bottom);
        }
    }

    /// The block's own rows of every column, exchanged or as they stand.
    fn take_own(&self, all: &[f64], order: usize, exchanged: bool) -> Vec<f64> {
        let own = |column: &[f64], local: usize| {
            let local = if exchanged {
                self.exchange[local] as usize
            } else {
                local
            };
            column[self.begin + local]
        };
        all.chunks_exact(order)
            .flat_map(|column| (0..self.columns).map(move |local| own(column, local)))
            .collect()
    }

    fn put_own(&self, all: &mut [f64], order: usize, top: &[f64], exchanged: bool) {
        for (column, values) in all
            .chunks_exact_mut(order)
            .zip(top.chunks_exact(self.columns))
        {
            for (local, &value) in values.iter().enumerate() {
                let local = if exchanged {
                    self.exchange[local] as usize
                } else {
                    local
                };
                column[self.begin + local] = value;
            }
        }
    }

    fn take_below(&self, all: &[f64], order: usize) -> Vec<f64> {
        all.chunks_exact(order)
            .flat_map(|column| self.below.iter().map(|&row| column[row as usize]))
            .collect()
    }

    fn put_below(&self, all: &mut [f64], order: usize, bottom: &[f64]) {
        if self.below.is_empty() {
            return;
        }
        let values = bottom.chunks_exact(self.below.len());
        for (column, values) in all.chunks_exact_mut(order).zip(values) {
            for (&row, &value) in self.below.iter().zip(values) {
                column[row as usize] = value;
            }
        }
    }
}

/// `target -= left * right`.
fn subtract_product(target: MatMut<'_, f64>, left: MatRef<'_, f64>, right: MatRef<'_, f64>) {
    matmul(target, Accum::Add, left, right, -1.0, Par::Seq);
}

/// Whether all factors are finite and have not grown far beyond the entries near one.
pub(super) fn has_grown(factors: &FrontalLu, limit: f64) -> bool {
    factors.blocks.iter().any(|block| {
        let most = largest(&block.lower).max(largest(&block.upper));
        most.is_nan() || most > limit
    })
}
