//! Forward and backward substitution with a multifrontal factor.

use std::ops::Mul;

use faer::c64;

use super::plan::Block;
use super::{Multifrontal, PanelValues};
use crate::solve::SolveError;
use crate::solve::memory::zeros;

impl Multifrontal {
    /// The solution of `L Lᴴ x = b`.
    pub(in crate::solve) fn solve(&self, right_side: &[c64]) -> Result<Vec<c64>, SolveError> {
        let mut x: Vec<c64> = zeros(self.order())?;
        for (x, &unknown) in x.iter_mut().zip(self.plan.order()) {
            *x = right_side[unknown as usize];
        }
        let mut front = Vec::new();
        for (index, block) in self.plan.blocks().iter().enumerate() {
            self.take(block, &x, &mut front);
            match self.values(index) {
                PanelValues::Real(panel) => forward(panel, block.width(), &mut front),
                PanelValues::Complex(panel) => forward(panel, block.width(), &mut front),
            }
            self.put(block, &mut x, &front);
        }
        for (index, block) in self.plan.blocks().iter().enumerate().rev() {
            self.take(block, &x, &mut front);
            match self.values(index) {
                PanelValues::Real(panel) => backward(panel, block.width(), &mut front),
                PanelValues::Complex(panel) => backward(panel, block.width(), &mut front),
            }
            x[block.columns.clone()].copy_from_slice(&front[..block.width()]);
        }
        let place_of = |&place: &u32| x[place as usize];
        Ok(self.plan.places().iter().map(place_of).collect())
    }

    /// The numbers of a block's rows.
    fn take(&self, block: &Block, all: &[c64], front: &mut Vec<c64>) {
        front.clear();
        front.extend_from_slice(&all[block.columns.clone()]);
        let below = self.plan.rows_below(block).iter();
        front.extend(below.map(|&row| all[row as usize]));
    }

    fn put(&self, block: &Block, all: &mut [c64], front: &[c64]) {
        let (own, below) = front.split_at(block.width());
        all[block.columns.clone()].copy_from_slice(own);
        for (&row, &value) in self.plan.rows_below(block).iter().zip(below) {
            all[row as usize] = value;
        }
    }
}

/// An entry of a factor, times complex numbers.
trait Entry: Copy + Mul<c64, Output = c64> {
    fn conjugate(self) -> Self;
    /// The real part: diagonal entries are real.
    fn real(self) -> f64;
}

impl Entry for f64 {
    fn conjugate(self) -> Self {
        self
    }

    fn real(self) -> f64 {
        self
    }
}

impl Entry for c64 {
    fn conjugate(self) -> Self {
        self.conj()
    }

    fn real(self) -> f64 {
        self.re
    }
}

fn forward<T: Entry>(panel: &[T], width: usize, front: &mut [c64]) {
    let height = front.len();
    for (place, column) in panel.chunks_exact(height).enumerate().take(width) {
        let value = front[place] / column[place].real();
        front[place] = value;
        let rest = column[place + 1..].iter().zip(&mut front[place + 1..]);
        for (&entry, target) in rest {
            *target -= entry * value;
        }
    }
}

fn backward<T: Entry>(panel: &[T], width: usize, front: &mut [c64]) {
    let height = front.len();
    for (place, column) in panel.chunks_exact(height).enumerate().take(width).rev() {
        let known = column[place + 1..].iter().zip(&front[place + 1..]);
        let sum: c64 = known
            .map(|(&entry, &value)| entry.conjugate() * value)
            .sum();
        front[place] = (front[place] - sum) / column[place].real();
    }
}
