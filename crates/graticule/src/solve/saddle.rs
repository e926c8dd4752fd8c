//! Minimisation under linear constraints: saddle point systems.

use super::constraints::Independence;
use super::solution::{count_columns, power_of_two};
use super::{Ldlt, Ordering, Placement, SolveError, SparseMatrix, Symbolic, SymmetricMatrix};

/// Constraints with more coefficients than this do not shape the elimination order: no order
/// could keep the unknowns that they join apart.
const LONGEST_LOCAL_CONSTRAINT: usize = 16;

/// The system of `min ½ xᵀ K x − fᵀ x` under `B x = g`:
///
/// ```text
/// [ K  Bᵀ ] [ x ]   [ f ]
/// [ B  0  ] [ λ ] = [ g ]
/// ```
///
/// `K` is symmetric, not negative on any direction, and positive on those that `B` leaves free; it
/// may be singular by itself, as a Laplacian is. Redundant constraints are left out, contradictory
/// ones refused by number.
#[derive(Clone, Debug)]
pub struct SaddleSystem {
    factor: Ldlt,
    independence: Independence,
    /// Numbers of the constraints in the system.
    kept: Vec<usize>,
    unknowns: usize,
    /// The power of two by which `K` was divided; the constraints were by their own.
    scale: f64,
}

/// What minimises under the constraints.
#[derive(Clone, Debug, PartialEq)]
pub struct SaddleSolution {
    /// The unknowns of each right-hand side, one column after the other.
    pub values: Vec<f64>,
    /// The multiplier of each constraint, likewise; zero for redundant ones.
    pub multipliers: Vec<f64>,
    /// Largest relative residual of the whole, scaled, system; see [`Ldlt::solve`].
    pub residual: f64,
}

impl SaddleSystem {
    /// Factors the system of `matrix` (`K`) and `constraints` (`B`, one row each).
    ///
    /// `placement` is that of the unknowns alone.
    ///
    /// # Errors
    /// [`SolveError::LengthMismatch`] unless constraints and matrix have equally many columns,
    /// [`SolveError::Singular`], [`SolveError::OutOfMemory`].
    pub fn new(
        matrix: &SymmetricMatrix,
        constraints: &SparseMatrix,
        placement: Placement<'_>,
    ) -> Result<Self, SolveError> {
        let unknowns = matrix.order();
        SolveError::check_length("constrained unknowns", constraints.columns(), unknowns)?;
        let by_row = constraints.transpose();
        let independence = Independence::of_columns(&by_row);
        let kept: Vec<usize> = (0..constraints.rows())
            .filter(|&row| independence.is_independent(row))
            .collect();
        let ordering = ordering(matrix, &by_row, &kept, placement)?;
        let scale = power_of_two(matrix.lower().largest_entry());
        let kept_rows = kept.iter().map(|&row| (row, independence.scales()[row]));
        let whole = assembled((matrix, scale), &by_row, kept_rows)?;
        let mut signs = vec![1; unknowns];
        signs.resize(unknowns + kept.len(), -1);
        let symbolic = Symbolic::new(&whole, &ordering)?;
        Ok(Self {
            factor: Ldlt::factor(&symbolic, &whole, Some(&signs))?,
            independence,
            kept,
            unknowns,
            scale,
        })
    }

    /// Numbers of the constraints that follow from earlier ones and were left out.
    #[must_use]
    pub fn redundant(&self) -> Vec<usize> {
        let all = 0..self.independence.rows();
        all.filter(|&row| !self.independence.is_independent(row))
            .collect()
    }

    /// Solves for one or several right-hand sides: `loads` (`f`) has one number per unknown,
    /// `targets` (`g`) one per constraint, one column after the other.
    ///
    /// # Errors
    /// [`SolveError::ContradictoryConstraint`] and [`SolveError::EmptyConstraint`] name the
    /// constraint; otherwise as [`Ldlt::solve`].
    pub fn solve(&self, loads: &[f64], targets: &[f64]) -> Result<SaddleSolution, SolveError> {
        let columns = count_columns(loads, self.unknowns)?;
        let rows = self.independence.rows();
        SolveError::check_length("targets", targets.len(), columns * rows)?;
        count_columns(targets, rows)?;
        let mut right_sides = Vec::with_capacity(columns * (self.unknowns + self.kept.len()));
        for column in 0..columns {
            let targets = &targets[column * rows..][..rows];
            self.independence.check_targets(targets)?;
            let loads = &loads[column * self.unknowns..][..self.unknowns];
            right_sides.extend(loads.iter().map(|load| load / self.scale));
            let scales = self.independence.scales();
            right_sides.extend(self.kept.iter().map(|&row| targets[row] / scales[row]));
        }
        let solved = self.factor.solve(&right_sides)?;
        Ok(self.parted(&solved.values, solved.residual))
    }

    fn parted(&self, columns: &[f64], residual: f64) -> SaddleSolution {
        let (mut values, mut multipliers) = (Vec::new(), Vec::new());
        for column in columns.chunks_exact((self.unknowns + self.kept.len()).max(1)) {
            let (own, of_kept) = column.split_at(self.unknowns);
            values.extend(own);
            let start = multipliers.len();
            multipliers.resize(start + self.independence.rows(), 0.0);
            for (&row, &value) in self.kept.iter().zip(of_kept) {
                multipliers[start + row] = value * self.scale / self.independence.scales()[row];
            }
        }
        SaddleSolution {
            values,
            multipliers,
            residual,
        }
    }
}

/// The whole matrix, `K` and each constraint divided by their scales: what is of different kind
/// comes to the same size.
fn assembled(
    (matrix, scale): (&SymmetricMatrix, f64),
    by_row: &SparseMatrix,
    kept: impl ExactSizeIterator<Item = (usize, f64)>,
) -> Result<SymmetricMatrix, SolveError> {
    let unknowns = matrix.order();
    let order = unknowns + kept.len();
    let rows = kept.enumerate().flat_map(|(place, (row, scale))| {
        let entries = by_row.column(row);
        entries.map(move |(unknown, value)| (unknowns + place, unknown, value / scale))
    });
    let own = matrix.lower().triplets();
    let own = own.map(|(row, column, value)| (row, column, value / scale));
    SymmetricMatrix::from_triplets(order, own.chain(rows))
}

/// Unknowns by their placement, each constraint right after the last of its unknowns, so that
/// elimination has given it a pivot by then.
fn ordering(
    matrix: &SymmetricMatrix,
    by_row: &SparseMatrix,
    kept: &[usize],
    placement: Placement<'_>,
) -> Result<Ordering, SolveError> {
    let local = kept
        .iter()
        .map(|&row| by_row.pattern().column(row))
        .filter(|unknowns| unknowns.len() <= LONGEST_LOCAL_CONSTRAINT);
    let joined = local.flat_map(|unknowns| {
        let others = |a: u32| unknowns.iter().map(move |&b| (a as usize, b as usize, 0.0));
        unknowns.iter().flat_map(move |&a| others(a))
    });
    let pattern = matrix.lower().triplets().chain(joined);
    let pattern = SymmetricMatrix::from_triplets(matrix.order(), pattern)?;
    let of_unknowns = placement.ordering(pattern.lower().pattern())?;
    let mut followers = vec![Vec::new(); matrix.order()];
    for (place, &row) in kept.iter().enumerate() {
        let places = by_row.pattern().column(row).iter();
        let last = places
            .map(|&unknown| of_unknowns.places()[unknown as usize])
            .max();
        // Independent constraints have at least one unknown.
        followers[last.unwrap_or(0) as usize].push((matrix.order() + place) as u32);
    }
    let order = of_unknowns.order().iter().zip(followers);
    let order = order.flat_map(|(&unknown, after)| std::iter::once(unknown).chain(after));
    Ok(Ordering::from_permutation(order.collect()))
}
