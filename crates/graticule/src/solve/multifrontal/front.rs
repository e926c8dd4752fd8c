//! Dense work on one block: its panel of columns, and the update that it passes on.

use std::ops::{AddAssign, Range};

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::{
    LltError, LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::traits::ComplexField;
use faer::{Accum, MatMut, Par, Spec, c64};

/// A number that a block is made of.
pub(super) trait Scalar:
    ComplexField<Real = f64> + Copy + Default + AddAssign + From<f64>
{
    /// A complex number that is known to be of this kind.
    fn of(value: c64) -> Self;
}

impl Scalar for f64 {
    fn of(value: c64) -> Self {
        value.re
    }
}

impl Scalar for c64 {
    fn of(value: c64) -> Self {
        value
    }
}

/// What a child passes on: the lower triangle of a Hermitian matrix on its rows below, column by
/// column.
#[derive(Clone, Copy)]
pub(super) enum Update<'a> {
    Real(&'a [f64]),
    Complex(&'a [c64]),
}

/// Numbers in the lower triangle of a matrix.
pub(super) fn packed_len(order: usize) -> usize {
    order * (order + 1) / 2
}

/// Memory that factoring a panel of this width takes.
pub(super) fn factor_scratch<T: Scalar>(width: usize) -> StackReq {
    cholesky_in_place_scratch::<T>(width, Par::Seq, Spec::default())
}

/// The columns of a block while they are assembled and factored.
pub(super) struct Panel<'a, T> {
    /// `width + depth` rows and `width` columns.
    pub(super) values: &'a mut [T],
    pub(super) width: usize,
    pub(super) depth: usize,
}

impl<T: Scalar> Panel<'_, T> {
    fn height(&self) -> usize {
        self.width + self.depth
    }

    /// Adds those columns of a child's update that stand in this panel. `places` are those of the
    /// child's rows in this front.
    pub(super) fn add(&mut self, places: &[u32], update: Update<'_>) {
        let own = places.partition_point(|&place| (place as usize) < self.width);
        let mut window = Window {
            height: self.height(),
            values: self.values,
            first: 0,
        };
        window.add(places, 0..own, update);
    }

    /// Divides the panel by the square root of its own block. The error is the first column whose
    /// pivot is not positive, and that pivot.
    pub(super) fn factor(&mut self, scratch: &mut MemBuffer) -> Result<(), (usize, f64)> {
        let (width, height) = (self.width, self.height());
        let panel = MatMut::from_column_major_slice_mut(self.values, height, width);
        let (mut own, below) = panel.split_at_row_mut(width);
        let done = cholesky_in_place(
            own.as_mut(),
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(scratch),
            Spec::default(),
        );
        if let Err(LltError::NonPositivePivot { index }) = done {
            return Err((index, T::real_part_impl(&own[(index, index)])));
        }
        let own = own.as_ref();
        solve_lower_triangular_in_place(own.conjugate(), below.transpose_mut(), Par::Seq);
        Ok(())
    }

    /// Minus the product of the rows below with their own transpose: what this block takes from
    /// the rest of the matrix. Fills the lower triangle of the square matrix `update`.
    pub(super) fn update_into(&mut self, update: &mut [T]) {
        let panel = MatMut::from_column_major_slice_mut(self.values, self.height(), self.width);
        let (_, below) = panel.split_at_row_mut(self.width);
        let below = below.as_ref();
        matmul(
            MatMut::from_column_major_slice_mut(update, self.depth, self.depth),
            BlockStructure::TriangularLower,
            Accum::Replace,
            below,
            BlockStructure::Rectangular,
            below.adjoint(),
            BlockStructure::Rectangular,
            T::from(-1.0),
            Par::Seq,
        );
    }

    /// Adds the other columns of a child's update to the square matrix that this block passes on.
    pub(super) fn pass_on(&self, square: &mut [T], places: &[u32], update: Update<'_>) {
        let own = places.partition_point(|&place| (place as usize) < self.width);
        let mut window = Window {
            values: square,
            height: self.depth,
            first: self.width,
        };
        window.add(places, own..places.len(), update);
    }
}

/// A matrix of `height` rows in columns, whose first row and column have the place `first` in a front.
struct Window<'a, T> {
    values: &'a mut [T],
    height: usize,
    first: usize,
}

impl<T: Scalar> Window<'_, T> {
    /// Adds a range of an update's columns, whose rows have these places.
    fn add(&mut self, places: &[u32], columns: Range<usize>, update: Update<'_>) {
        let skipped = packed_len(places.len()) - packed_len(places.len() - columns.start);
        match update {
            Update::Real(values) => self.add_packed(places, columns, &values[skipped..], T::from),
            Update::Complex(values) => self.add_packed(places, columns, &values[skipped..], T::of),
        }
    }

    fn add_packed<S: Copy>(
        &mut self,
        places: &[u32],
        columns: Range<usize>,
        values: &[S],
        convert: impl Fn(S) -> T,
    ) {
        let mut rest = values;
        for column in columns {
            let rows = &places[column..];
            let (values, after) = rest.split_at(rows.len());
            let start = (rows[0] as usize - self.first) * self.height;
            let target = &mut self.values[start..][..self.height];
            for (&row, &value) in rows.iter().zip(values) {
                target[row as usize - self.first] += convert(value);
            }
            rest = after;
        }
    }
}
