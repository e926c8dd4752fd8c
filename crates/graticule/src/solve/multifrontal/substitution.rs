//! Forward and backward substitution with a multifrontal factor.

use std::iter::Sum;
use std::ops::{AddAssign, Div, Mul, Sub, SubAssign};

use faer::c64;

use super::plan::Block;
use super::{Multifrontal, PanelValues};
use crate::solve::SolveError;
use crate::solve::memory::zeros;

impl Multifrontal {
    /// The solution of `L Lᴴ x = b`; real only for a factor that is real everywhere.
    pub(in crate::solve) fn solve<N: Number>(
        &self,
        right_side: &[N],
    ) -> Result<Vec<N>, SolveError> {
        let mut x: Vec<N> = zeros(self.order())?;
        for (x, &unknown) in x.iter_mut().zip(self.plan.order()) {
            *x = right_side[unknown as usize];
        }
        let mut front = Vec::new();
        for (index, block) in self.plan.blocks().iter().enumerate() {
            self.take(block, &x, &mut front);
            N::forward(self.values(index), block.width(), &mut front);
            self.put(block, &mut x, &front);
        }
        for (index, block) in self.plan.blocks().iter().enumerate().rev() {
            self.take(block, &x, &mut front);
            N::backward(self.values(index), block.width(), &mut front);
            x[block.columns.clone()].copy_from_slice(&front[..block.width()]);
        }
        let place_of = |&place: &u32| x[place as usize];
        Ok(self.plan.places().iter().map(place_of).collect())
    }

    /// The numbers of a block's rows.
    fn take<N: Copy>(&self, block: &Block, all: &[N], front: &mut Vec<N>) {
        front.clear();
        front.extend_from_slice(&all[block.columns.clone()]);
        let below = self.plan.rows_below(block).iter();
        front.extend(below.map(|&row| all[row as usize]));
    }

    fn put<N: Copy>(&self, block: &Block, all: &mut [N], front: &[N]) {
        let (own, below) = front.split_at(block.width());
        all[block.columns.clone()].copy_from_slice(own);
        for (&row, &value) in self.plan.rows_below(block).iter().zip(below) {
            all[row as usize] = value;
        }
    }
}

/// A number of a right-hand side.
pub(in crate::solve) trait Number:
    Copy + Default + AddAssign + SubAssign + Sub<Output = Self> + Div<f64, Output = Self> + Sum + Send
{
    /// Solves with the columns of a block, and takes what they say from the rows below.
    fn forward(panel: PanelValues<'_>, width: usize, front: &mut [Self]);

    /// Solves with the rows of the block's transpose, those below known.
    fn backward(panel: PanelValues<'_>, width: usize, front: &mut [Self]);
}

impl Number for f64 {
    fn forward(panel: PanelValues<'_>, width: usize, front: &mut [Self]) {
        forward(real(&panel), width, front);
    }

    fn backward(panel: PanelValues<'_>, width: usize, front: &mut [Self]) {
        backward(real(&panel), width, front);
    }
}

impl Number for c64 {
    fn forward(panel: PanelValues<'_>, width: usize, front: &mut [Self]) {
        match panel {
            PanelValues::Real(panel) => forward(panel, width, front),
            PanelValues::Complex(panel) => forward(panel, width, front),
        }
    }

    fn backward(panel: PanelValues<'_>, width: usize, front: &mut [Self]) {
        match panel {
            PanelValues::Real(panel) => backward(panel, width, front),
            PanelValues::Complex(panel) => backward(panel, width, front),
        }
    }
}

fn real<'a>(panel: &PanelValues<'a>) -> &'a [f64] {
    match panel {
        PanelValues::Real(panel) => panel,
        PanelValues::Complex(_) => unreachable!("a real solution was asked of a complex factor"),
    }
}

/// An entry of a factor, times numbers of a right-hand side.
trait Entry<N>: Copy + Mul<N, Output = N> {
    fn conjugate(self) -> Self;
    /// The real part: diagonal entries are real.
    fn real(self) -> f64;
}

impl<N> Entry<N> for f64
where
    f64: Mul<N, Output = N>,
{
    fn conjugate(self) -> Self {
        self
    }

    fn real(self) -> f64 {
        self
    }
}

impl Entry<Self> for c64 {
    fn conjugate(self) -> Self {
        self.conj()
    }

    fn real(self) -> f64 {
        self.re
    }
}

fn forward<N: Number, E: Entry<N>>(panel: &[E], width: usize, front: &mut [N]) {
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

fn backward<N: Number, E: Entry<N>>(panel: &[E], width: usize, front: &mut [N]) {
    let height = front.len();
    for (place, column) in panel.chunks_exact(height).enumerate().take(width).rev() {
        let known = product(&column[place + 1..], &front[place + 1..]);
        front[place] = (front[place] - known) / column[place].real();
    }
}

/// Sums kept side by side, so that an addition need not wait for the one before.
const LANES: usize = 4;

/// The sum of conjugate entries times numbers.
fn product<N: Number, E: Entry<N>>(entries: &[E], numbers: &[N]) -> N {
    let mut sums = [N::default(); LANES];
    let several = entries.chunks_exact(LANES).zip(numbers.chunks_exact(LANES));
    for (entries, numbers) in several {
        for lane in 0..LANES {
            sums[lane] += entries[lane].conjugate() * numbers[lane];
        }
    }
    let done = entries.len() - entries.len() % LANES;
    let last = entries[done..].iter().zip(&numbers[done..]);
    let last = last.map(|(&entry, &number)| entry.conjugate() * number);
    sums.into_iter().chain(last).sum()
}
