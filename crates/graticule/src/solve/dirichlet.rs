//! Systems in which some unknowns are given: elimination of fixed unknowns.

use super::solution::count_columns;
use super::{
    Cholesky, Ldlt, Lu, LuSymbolic, Placement, Solution, SolveError, SparseMatrix, Symbolic,
    SymmetricMatrix,
};

/// The unknowns of a system, parted in free and fixed ones.
#[derive(Clone, Debug)]
struct Partition {
    /// Free unknowns, ascending.
    free: Vec<u32>,
    /// Fixed unknowns, in the order given.
    fixed: Vec<u32>,
    /// Place of each unknown among the free or the fixed ones.
    places: Vec<Place>,
}

#[derive(Clone, Copy, Debug)]
enum Place {
    Free(usize),
    Fixed(usize),
}

impl Partition {
    fn new(unknowns: usize, fixed: &[usize]) -> Result<Self, SolveError> {
        let mut places = vec![None; unknowns];
        for (place, &unknown) in fixed.iter().enumerate() {
            let slot = places.get_mut(unknown);
            let slot = slot.ok_or(SolveError::BadFixedUnknown {
                unknown,
                reason: "there is no such unknown",
            })?;
            if slot.replace(Place::Fixed(place)).is_some() {
                let reason = "it is fixed twice";
                return Err(SolveError::BadFixedUnknown { unknown, reason });
            }
        }
        let mut free = Vec::with_capacity(unknowns - fixed.len());
        let places = (0..)
            .zip(places)
            .map(|(unknown, place)| {
                place.unwrap_or_else(|| {
                    free.push(unknown);
                    Place::Free(free.len() - 1)
                })
            })
            .collect();
        let fixed = fixed.iter().map(|&unknown| unknown as u32).collect();
        Ok(Self {
            free,
            fixed,
            places,
        })
    }

    /// What the equations of the free unknowns have on the right once the fixed ones are known.
    fn right_sides(
        &self,
        coupling: &SparseMatrix,
        fixed_values: &[f64],
        loads: Option<&[f64]>,
    ) -> Result<Vec<f64>, SolveError> {
        let [all, free, fixed] = [self.places.len(), self.free.len(), self.fixed.len()];
        let columns = match loads {
            Some(loads) => count_columns(loads, all)?,
            None => count_columns(fixed_values, fixed)?,
        };
        SolveError::check_length("fixed values", fixed_values.len(), columns * fixed)?;
        count_columns(fixed_values, fixed)?;
        let mut right_sides = Vec::with_capacity(columns * free);
        for column in 0..columns {
            let from_fixed = coupling.multiply(&fixed_values[column * fixed..][..fixed]);
            let load = |unknown: u32| loads.map_or(0.0, |l| l[column * all + unknown as usize]);
            let entries = self.free.iter().zip(from_fixed);
            right_sides.extend(entries.map(|(&unknown, known)| load(unknown) - known));
        }
        Ok(right_sides)
    }

    /// The entries of the free unknowns of each column.
    fn of_free(&self, columns: &[f64]) -> Result<Vec<f64>, SolveError> {
        count_columns(columns, self.places.len())?;
        let columns = columns.chunks_exact(self.places.len().max(1));
        let free = |column: &'_ [f64]| -> Vec<f64> {
            let own = self.free.iter();
            own.map(|&unknown| column[unknown as usize]).collect()
        };
        Ok(columns.flat_map(free).collect())
    }

    /// Gradients by the fixed values, from those by all unknowns and the adjoint solution.
    fn pulled_back(
        &self,
        coupling: &SparseMatrix,
        gradients: &[f64],
        mut adjoint: Solution,
    ) -> Solution {
        let free = self.free.len();
        let mut values = Vec::new();
        for (column, gradient) in gradients.chunks_exact(self.places.len().max(1)).enumerate() {
            let adjoint = &adjoint.values[column * free..][..free];
            let through_free = coupling.multiply_transposed(adjoint);
            let direct = self.fixed.iter().map(|&unknown| gradient[unknown as usize]);
            values.extend(
                direct
                    .zip(through_free)
                    .map(|(direct, through)| direct - through),
            );
        }
        adjoint.values = values;
        adjoint
    }

    /// All unknowns of each column, from the fixed values and the solved free ones.
    fn merged(&self, fixed_values: &[f64], mut solved: Solution) -> Solution {
        let [free, fixed] = [self.free.len(), self.fixed.len()];
        let of_free = solved.values.len().checked_div(free);
        let of_fixed = fixed_values.len().checked_div(fixed);
        let columns = of_free.or(of_fixed).unwrap_or(0);
        let mut values = Vec::with_capacity(columns * self.places.len());
        for column in 0..columns {
            values.extend(self.places.iter().map(|place| match *place {
                Place::Free(place) => solved.values[column * free + place],
                Place::Fixed(place) => fixed_values[column * fixed + place],
            }));
        }
        solved.values = values;
        solved
    }
}

/// A system `A x = b` with some unknowns fixed, factored once for many values of them.
///
/// Only the rows of free unknowns are equations.
#[derive(Clone, Debug)]
pub struct Eliminated<F> {
    partition: Partition,
    coupling: SparseMatrix,
    factor: F,
}

/// An [`Eliminated`] symmetric system. The matrix of its free unknowns must be positive definite:
/// true for a Laplacian with positive weights and a fixed unknown in every component.
pub type DirichletSystem = Eliminated<Cholesky>;

/// An [`Eliminated`] system that need not be symmetric.
pub type DirichletLu = Eliminated<Lu>;

/// A factored square matrix that solves for right-hand sides and checks its solutions.
pub trait Factorization {
    /// Solves `A x = b` for one or several right-hand sides, one column after the other.
    ///
    /// # Errors
    /// [`SolveError::Inaccurate`], [`SolveError::NonFiniteRightSide`],
    /// [`SolveError::LengthMismatch`].
    fn solve(&self, right_sides: &[f64]) -> Result<Solution, SolveError>;

    /// The same with the transpose of the matrix.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    fn solve_transposed(&self, right_sides: &[f64]) -> Result<Solution, SolveError>;
}

impl Factorization for Cholesky {
    fn solve(&self, right_sides: &[f64]) -> Result<Solution, SolveError> {
        Self::solve(self, right_sides)
    }

    fn solve_transposed(&self, right_sides: &[f64]) -> Result<Solution, SolveError> {
        Self::solve(self, right_sides)
    }
}

impl Factorization for Ldlt {
    fn solve(&self, right_sides: &[f64]) -> Result<Solution, SolveError> {
        Self::solve(self, right_sides)
    }

    fn solve_transposed(&self, right_sides: &[f64]) -> Result<Solution, SolveError> {
        Self::solve(self, right_sides)
    }
}

impl Factorization for Lu {
    fn solve(&self, right_sides: &[f64]) -> Result<Solution, SolveError> {
        Self::solve(self, right_sides)
    }

    fn solve_transposed(&self, right_sides: &[f64]) -> Result<Solution, SolveError> {
        Self::solve_transposed(self, right_sides)
    }
}

impl<F: Factorization> Eliminated<F> {
    /// Free unknowns, ascending.
    #[must_use]
    pub fn free(&self) -> &[u32] {
        &self.partition.free
    }

    /// The factored matrix of the free unknowns.
    #[must_use]
    pub fn factor(&self) -> &F {
        &self.factor
    }

    /// Solves with nothing on the right. `fixed_values` has one number per fixed unknown, in the
    /// order in which they were given, for one or several columns; the solution has all unknowns.
    ///
    /// # Errors
    /// As [`Factorization::solve`].
    pub fn solve(&self, fixed_values: &[f64]) -> Result<Solution, SolveError> {
        self.solve_for(fixed_values, None)
    }

    /// The same with `loads` on the right: one number per unknown and column, of which those of
    /// fixed unknowns are not used.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_with_loads(
        &self,
        fixed_values: &[f64],
        loads: &[f64],
    ) -> Result<Solution, SolveError> {
        self.solve_for(fixed_values, Some(loads))
    }

    fn solve_for(&self, fixed: &[f64], loads: Option<&[f64]>) -> Result<Solution, SolveError> {
        let right_sides = self.partition.right_sides(&self.coupling, fixed, loads)?;
        let solved = self.factor.solve(&right_sides)?;
        Ok(self.partition.merged(fixed, solved))
    }

    /// The gradient with respect to the fixed values of a function of all unknowns, given its
    /// gradient with respect to each unknown: one transposed solve for any number of fixed values.
    ///
    /// One or several columns; the result has one number per fixed unknown and column.
    ///
    /// # Errors
    /// As [`Factorization::solve_transposed`].
    pub fn pull_back(&self, gradients: &[f64]) -> Result<Solution, SolveError> {
        let of_free = self.partition.of_free(gradients)?;
        let adjoint = self.factor.solve_transposed(&of_free)?;
        Ok(self
            .partition
            .pulled_back(&self.coupling, gradients, adjoint))
    }
}

impl DirichletSystem {
    /// Eliminates the `fixed` unknowns and factors the rest.
    ///
    /// # Errors
    /// [`SolveError::BadFixedUnknown`], [`SolveError::NotPositiveDefinite`] with the unknown's
    /// number in `matrix`, and as [`Cholesky::new`].
    pub fn new(
        matrix: &SymmetricMatrix,
        fixed: &[usize],
        placement: Placement<'_>,
    ) -> Result<Self, SolveError> {
        let partition = Partition::new(matrix.order(), fixed)?;
        let [mut inner, mut coupling] = [Vec::new(), Vec::new()];
        for (row, column, value) in matrix.lower().triplets() {
            match (partition.places[row], partition.places[column]) {
                (Place::Free(row), Place::Free(column)) => inner.push((row, column, value)),
                (Place::Free(free), Place::Fixed(fixed))
                | (Place::Fixed(fixed), Place::Free(free)) => coupling.push((free, fixed, value)),
                (Place::Fixed(_), Place::Fixed(_)) => {}
            }
        }
        let free = partition.free.len();
        let coupling = SparseMatrix::from_triplets(free, fixed.len(), coupling)?;
        let inner = SymmetricMatrix::from_triplets(free, inner)?;
        let ordering = placement.ordering_of(inner.lower().pattern(), &partition.free)?;
        let symbolic = Symbolic::new(&inner, &ordering)?;
        let factor = Cholesky::factor(&symbolic, &inner);
        Ok(Self {
            factor: factor.map_err(|error| in_caller_numbers(error, &partition.free))?,
            partition,
            coupling,
        })
    }
}

impl DirichletLu {
    /// Eliminates the `fixed` unknowns and factors the rest.
    ///
    /// # Errors
    /// [`SolveError::BadFixedUnknown`], [`SolveError::Singular`] with the unknown's number in
    /// `matrix`, and as [`Lu::new`].
    pub fn new(
        matrix: &SparseMatrix,
        fixed: &[usize],
        placement: Placement<'_>,
    ) -> Result<Self, SolveError> {
        SolveError::check_square(matrix.rows(), matrix.columns())?;
        let partition = Partition::new(matrix.rows(), fixed)?;
        let [mut inner, mut coupling] = [Vec::new(), Vec::new()];
        for (row, column, value) in matrix.triplets() {
            let Place::Free(row) = partition.places[row] else {
                continue;
            };
            match partition.places[column] {
                Place::Free(column) => inner.push((row, column, value)),
                Place::Fixed(column) => coupling.push((row, column, value)),
            }
        }
        let free = partition.free.len();
        let coupling = SparseMatrix::from_triplets(free, fixed.len(), coupling)?;
        let inner = SparseMatrix::from_triplets(free, free, inner)?;
        let ordering = placement.ordering_of(inner.pattern(), &partition.free)?;
        let factor = Lu::factor(&LuSymbolic::new(&inner, &ordering)?, &inner);
        Ok(Self {
            factor: factor.map_err(|error| in_caller_numbers(error, &partition.free))?,
            partition,
            coupling,
        })
    }
}

/// Column numbers of the free unknowns' matrix as the caller knows them.
fn in_caller_numbers(error: SolveError, free: &[u32]) -> SolveError {
    let number = |column: usize| free.get(column).map_or(column, |&unknown| unknown as usize);
    match error {
        SolveError::NotPositiveDefinite { column, pivot } => SolveError::NotPositiveDefinite {
            column: number(column),
            pivot,
        },
        SolveError::Singular { column, pivot } => SolveError::Singular {
            column: number(column),
            pivot,
        },
        other => other,
    }
}
