//! Minimisation under linear constraints: saddle point systems.

use super::constraints::Independence;
use super::solution::{count_columns, power_of_two};
use super::{
    Factorization, Ldlt, Lu, Ordering, Placement, SolveError, SparseMatrix, SymmetricMatrix,
};

/// Constraints with more coefficients than this do not shape the elimination order: no order
/// could keep the unknowns that they join apart.
const LONGEST_LOCAL_CONSTRAINT: usize = 16;

/// A factored system bordered by linear constraints. Redundant constraints are left out,
/// contradictory ones refused by number.
#[derive(Clone, Debug)]
pub struct Constrained<F> {
    factor: F,
    border: Border,
}

/// The system of `min ½ xᵀ K x − fᵀ x` under `B x = g`:
///
/// ```text
/// [ K  Bᵀ ] [ x ]   [ f ]
/// [ B  0  ] [ λ ] = [ g ]
/// ```
///
/// `K` is symmetric, not negative on any direction, and positive on those that `B` leaves free; it
/// may be singular by itself, as a Laplacian is.
pub type SaddleSystem = Constrained<Ldlt>;

/// The system
///
/// ```text
/// [ A  Bᵀ ] [ x ]   [ f ]
/// [ B  0  ] [ λ ] = [ g ]
/// ```
///
/// for an `A` that need not be symmetric: the equations `A x = f`, bent as much as the constraints
/// `B x = g` ask for.
pub type BorderedSystem = Constrained<Lu>;

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

impl<F: Factorization> Constrained<F> {
    /// Numbers of the constraints that follow from earlier ones and were left out.
    #[must_use]
    pub fn redundant(&self) -> Vec<usize> {
        self.border.redundant()
    }

    /// Solves for one or several right-hand sides: `loads` (`f`) has one number per unknown,
    /// `targets` (`g`) one per constraint, one column after the other.
    ///
    /// # Errors
    /// [`SolveError::ContradictoryConstraint`] and [`SolveError::EmptyConstraint`] name the
    /// constraint; otherwise as [`Factorization::solve`].
    pub fn solve(&self, loads: &[f64], targets: &[f64]) -> Result<SaddleSolution, SolveError> {
        let right_sides = self.border.right_sides(loads, targets)?;
        let solved = self.factor.solve(&right_sides)?;
        Ok(self.border.parted(&solved.values, solved.residual))
    }
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
        let border = Border::new(matrix.lower(), constraints)?;
        let ordering = border.ordering(matrix, placement)?;
        let whole = SymmetricMatrix::from_triplets(border.order(), border.entries(matrix.lower()))?;
        let mut signs = vec![1; border.unknowns];
        signs.resize(border.order(), -1);
        Ok(Self {
            factor: Ldlt::new(&whole, &ordering, Some(&signs))?,
            border,
        })
    }
}

impl BorderedSystem {
    /// Factors the system of `matrix` (`A`) and `constraints` (`B`, one row each).
    ///
    /// `placement` is that of the unknowns alone.
    ///
    /// # Errors
    /// As [`SaddleSystem::new`].
    pub fn new(
        matrix: &SparseMatrix,
        constraints: &SparseMatrix,
        placement: Placement<'_>,
    ) -> Result<Self, SolveError> {
        SolveError::check_square(matrix.rows(), matrix.columns())?;
        let border = Border::new(matrix, constraints)?;
        let pattern = SymmetricMatrix::from_triplets(matrix.rows(), matrix.triplets())?;
        let ordering = border.ordering(&pattern, placement)?;
        let below = border.entries(matrix).skip(matrix.pattern().entries());
        let mirrored = below.map(|(row, column, value)| (column, row, value));
        let entries = border.entries(matrix).chain(mirrored);
        let whole = SparseMatrix::from_triplets(border.order(), border.order(), entries)?;
        Ok(Self {
            factor: Lu::new(&whole, &ordering)?,
            border,
        })
    }
}

/// The independent constraints that stand beside and below a matrix.
#[derive(Clone, Debug)]
struct Border {
    by_row: SparseMatrix,
    independence: Independence,
    /// Numbers of the constraints in the system.
    kept: Vec<usize>,
    unknowns: usize,
    /// The power of two by which the matrix is divided; the constraints are by their own.
    scale: f64,
}

impl Border {
    fn new(matrix: &SparseMatrix, constraints: &SparseMatrix) -> Result<Self, SolveError> {
        let unknowns = matrix.rows();
        SolveError::check_length("constrained unknowns", constraints.columns(), unknowns)?;
        let by_row = constraints.transpose();
        let independence = Independence::of_columns(&by_row);
        let rows = 0..constraints.rows();
        Ok(Self {
            kept: rows
                .filter(|&row| independence.is_independent(row))
                .collect(),
            by_row,
            independence,
            unknowns,
            scale: power_of_two(matrix.largest_entry()),
        })
    }

    fn order(&self) -> usize {
        self.unknowns + self.kept.len()
    }

    fn redundant(&self) -> Vec<usize> {
        let all = 0..self.independence.rows();
        all.filter(|&row| !self.independence.is_independent(row))
            .collect()
    }

    /// The entries of the matrix and of the rows below it, both divided by their scales: what is of
    /// different kind comes to the same size.
    fn entries<'a>(
        &'a self,
        matrix: &'a SparseMatrix,
    ) -> impl Iterator<Item = (usize, usize, f64)> + 'a {
        let rows = self.kept.iter().enumerate().flat_map(move |(place, &row)| {
            let scale = self.independence.scales()[row];
            let entries = self.by_row.column(row);
            entries.map(move |(unknown, value)| (self.unknowns + place, unknown, value / scale))
        });
        let own = matrix.triplets();
        own.map(move |(row, column, value)| (row, column, value / self.scale))
            .chain(rows)
    }

    /// Unknowns by their placement, each constraint right after the last of its unknowns, so that
    /// elimination has given it a pivot by then.
    fn ordering(
        &self,
        matrix: &SymmetricMatrix,
        placement: Placement<'_>,
    ) -> Result<Ordering, SolveError> {
        let local = self
            .kept
            .iter()
            .map(|&row| self.by_row.pattern().column(row))
            .filter(|unknowns| unknowns.len() <= LONGEST_LOCAL_CONSTRAINT);
        let joined = local.flat_map(|unknowns| {
            let others = |a: u32| unknowns.iter().map(move |&b| (a as usize, b as usize, 0.0));
            unknowns.iter().flat_map(move |&a| others(a))
        });
        let pattern = matrix.lower().triplets().chain(joined);
        let pattern = SymmetricMatrix::from_triplets(matrix.order(), pattern)?;
        let of_unknowns = placement.ordering(pattern.lower().pattern())?;
        let mut followers = vec![Vec::new(); matrix.order()];
        for (place, &row) in self.kept.iter().enumerate() {
            let places = self.by_row.pattern().column(row).iter();
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

    /// The right-hand sides of the whole system, if the targets agree with each other.
    fn right_sides(&self, loads: &[f64], targets: &[f64]) -> Result<Vec<f64>, SolveError> {
        let rows = self.independence.rows();
        // Without unknowns the targets alone tell the number of columns, and are checked all the
        // same.
        let columns = match self.unknowns {
            0 => count_columns(targets, rows)?,
            unknowns => count_columns(loads, unknowns)?,
        };
        SolveError::check_length("targets", targets.len(), columns * rows)?;
        count_columns(targets, rows)?;
        let mut right_sides = Vec::with_capacity(columns * self.order());
        for column in 0..columns {
            let targets = &targets[column * rows..][..rows];
            self.independence.check_targets(targets)?;
            let loads = &loads[column * self.unknowns..][..self.unknowns];
            right_sides.extend(loads.iter().map(|load| load / self.scale));
            let scales = self.independence.scales();
            right_sides.extend(self.kept.iter().map(|&row| targets[row] / scales[row]));
        }
        Ok(right_sides)
    }

    fn parted(&self, columns: &[f64], residual: f64) -> SaddleSolution {
        let (mut values, mut multipliers) = (Vec::new(), Vec::new());
        for column in columns.chunks_exact(self.order().max(1)) {
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
