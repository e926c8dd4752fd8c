//! `L U` of matrices that are not symmetric, held for reuse.

use std::sync::Arc;

use faer::dyn_stack::MemStack;
use faer::perm::PermRef;
use faer::sparse::linalg::lu::simplicial;
use faer::sparse::linalg::{LuError, colamd};
use faer::{Conj, MatMut, Par};

use super::fronts::{FrontError, FrontalLu, has_grown};
use super::ldlt::scale_columns;
use super::memory::memory;
use super::solution::{Factored, Solution, power_of_two, solve_checked};
use super::{Ordering, SolveError, SparseMatrix, Symbolic, SymmetricMatrix};
use crate::tolerance;

/// Refinement steps allowed: exchanging rows within blocks only may cost some digits.
const REFINEMENTS: usize = 4;

/// The elimination of matrices of one pattern, planned.
#[derive(Debug)]
pub struct LuSymbolic {
    /// Of the symmetric pattern that contains the matrix's.
    symmetric: Symbolic,
    pattern: Arc<super::Pattern>,
}

impl LuSymbolic {
    /// Plans the elimination of matrices with the pattern of `matrix`, in the given order.
    ///
    /// # Errors
    /// [`SolveError::NotSquare`], [`SolveError::LengthMismatch`] unless the ordering is one of the
    /// matrix's unknowns, [`SolveError::OutOfMemory`].
    pub fn new(matrix: &SparseMatrix, ordering: &Ordering) -> Result<Arc<Self>, SolveError> {
        SolveError::check_square(matrix.rows(), matrix.columns())?;
        let places = matrix.triplets().map(|(row, column, _)| (row, column, 0.0));
        let both = SymmetricMatrix::from_triplets(matrix.rows(), places)?;
        let pattern = Arc::clone(both.lower().pattern());
        Ok(Arc::new(Self {
            symmetric: Symbolic::of_lower_pattern(pattern, ordering)?,
            pattern: Arc::clone(matrix.pattern()),
        }))
    }

    /// Entries of both factors together, where rows are exchanged within blocks only.
    #[must_use]
    pub fn factor_entries(&self) -> usize {
        2 * self.symmetric.factor_entries()
    }
}

/// How far rows were exchanged to find good pivots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exchange {
    /// Within blocks of columns: no fill beyond that of the symmetric pattern.
    WithinBlocks,
    /// Over the whole matrix, since some block had no good pivot of its own: slower, more fill.
    Unrestricted,
}

/// `R A C = L U` for a square matrix `A`, up to the order of rows and columns.
///
/// `R` and `C` are diagonal, powers of two, and bring the largest entry of every row and column
/// near one.
#[derive(Clone, Debug)]
pub struct Lu {
    symbolic: Arc<LuSymbolic>,
    factors: Factors,
    scaled: SparseMatrix,
    row_scales: Vec<f64>,
    column_scales: Vec<f64>,
    row_norm: f64,
    column_norm: f64,
}

#[derive(Clone, Debug)]
enum Factors {
    Frontal(FrontalLu),
    General(Box<GeneralLu>),
}

impl Lu {
    /// Orders, plans and factors in one go.
    ///
    /// # Errors
    /// As [`LuSymbolic::new`] and [`factor`](Self::factor).
    pub fn new(matrix: &SparseMatrix, ordering: &Ordering) -> Result<Self, SolveError> {
        Self::factor(&LuSymbolic::new(matrix, ordering)?, matrix)
    }

    /// Factors a matrix with the pattern for which `symbolic` was made.
    ///
    /// # Errors
    /// [`SolveError::Singular`] names the column without pivot. [`SolveError::PatternMismatch`],
    /// [`SolveError::OutOfMemory`].
    pub fn factor(symbolic: &Arc<LuSymbolic>, matrix: &SparseMatrix) -> Result<Self, SolveError> {
        if symbolic.pattern != *matrix.pattern() {
            return Err(SolveError::PatternMismatch);
        }
        let (scaled, row_scales, column_scales) = equilibrated(matrix)?;
        let plan = symbolic.symmetric.plan();
        let permuted = permuted(&scaled, plan.places())?;
        let factors = match FrontalLu::factor(plan, &permuted) {
            Ok(factors) if !has_grown(&factors, tolerance::FACTOR_GROWTH) => {
                Factors::Frontal(factors)
            }
            Ok(_) | Err(FrontError::WeakPivot) => {
                Factors::General(Box::new(GeneralLu::factor(&scaled)?))
            }
            Err(FrontError::Other(error)) => return Err(error),
        };
        Ok(Self {
            symbolic: Arc::clone(symbolic),
            factors,
            row_norm: scaled.row_sum_norm(),
            column_norm: scaled.column_sum_norm(),
            scaled,
            row_scales,
            column_scales,
        })
    }

    /// The plan, for other matrices of the same pattern.
    #[must_use]
    pub fn symbolic(&self) -> &Arc<LuSymbolic> {
        &self.symbolic
    }

    /// How far rows were exchanged.
    #[must_use]
    pub fn exchange(&self) -> Exchange {
        match self.factors {
            Factors::Frontal(_) => Exchange::WithinBlocks,
            Factors::General(_) => Exchange::Unrestricted,
        }
    }

    /// Solves `A x = b` for one or several right-hand sides, one column after the other.
    ///
    /// The residual is that of the scaled system `R A C`.
    ///
    /// # Errors
    /// As [`Cholesky::solve`](super::Cholesky::solve).
    pub fn solve(&self, right_sides: &[f64]) -> Result<Solution, SolveError> {
        let scaled = scale_columns(right_sides, &self.row_scales);
        let mut solution = solve_checked(&Straight(self), &scaled, REFINEMENTS)?;
        solution.values = scale_columns(&solution.values, &self.column_scales);
        Ok(solution)
    }

    /// Solves `Aᵀ x = b`, as adjoints need it.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_transposed(&self, right_sides: &[f64]) -> Result<Solution, SolveError> {
        let scaled = scale_columns(right_sides, &self.column_scales);
        let mut solution = solve_checked(&Transposed(self), &scaled, REFINEMENTS)?;
        solution.values = scale_columns(&solution.values, &self.row_scales);
        Ok(solution)
    }

    fn apply_inverse(&self, columns: &mut [f64], transposed: bool) -> Result<(), SolveError> {
        let order = self.scaled.rows();
        if order == 0 {
            return Ok(());
        }
        match &self.factors {
            Factors::General(general) => general.solve_in_place(columns, transposed)?,
            Factors::Frontal(frontal) => {
                let places = self.symbolic.symmetric.plan().places();
                let mut ordered = vec![0.0; columns.len()];
                for (to, from) in ordered
                    .chunks_exact_mut(order)
                    .zip(columns.chunks_exact(order))
                {
                    for (&place, &value) in places.iter().zip(from) {
                        to[place as usize] = value;
                    }
                }
                if transposed {
                    frontal.solve_transposed_in_place(&mut ordered, order);
                } else {
                    frontal.solve_in_place(&mut ordered, order);
                }
                for (from, to) in ordered
                    .chunks_exact(order)
                    .zip(columns.chunks_exact_mut(order))
                {
                    for (&place, value) in places.iter().zip(to) {
                        *value = from[place as usize];
                    }
                }
            }
        }
        Ok(())
    }
}

struct Straight<'a>(&'a Lu);
struct Transposed<'a>(&'a Lu);

impl Factored for Straight<'_> {
    fn order(&self) -> usize {
        self.0.scaled.rows()
    }

    fn norm(&self) -> f64 {
        self.0.row_norm
    }

    fn multiply_into(&self, input: &[f64], output: &mut [f64]) {
        self.0.scaled.multiply_into(input, output);
    }

    fn solve_in_place(&self, columns: &mut [f64]) -> Result<(), SolveError> {
        self.0.apply_inverse(columns, false)
    }
}

impl Factored for Transposed<'_> {
    fn order(&self) -> usize {
        self.0.scaled.rows()
    }

    // Rows of the transposed matrix are columns of this one.
    fn norm(&self) -> f64 {
        self.0.column_norm
    }

    fn multiply_into(&self, input: &[f64], output: &mut [f64]) {
        output.copy_from_slice(&self.0.scaled.multiply_transposed(input));
    }

    fn solve_in_place(&self, columns: &mut [f64]) -> Result<(), SolveError> {
        self.0.apply_inverse(columns, true)
    }
}

/// `R A C` and the diagonals of `R` and `C`. A row or column of zeros stays one.
fn equilibrated(matrix: &SparseMatrix) -> Result<(SparseMatrix, Vec<f64>, Vec<f64>), SolveError> {
    let mut row_scales = vec![0.0_f64; matrix.rows()];
    for (row, _, value) in matrix.triplets() {
        row_scales[row] = row_scales[row].max(value.abs());
    }
    for scale in &mut row_scales {
        *scale = power_of_two(*scale).recip();
    }
    let column_scales: Vec<f64> = (0..matrix.columns())
        .map(|column| {
            let entries = matrix.column(column);
            let most = entries.fold(0.0_f64, |m, (row, v)| m.max((v * row_scales[row]).abs()));
            power_of_two(most).recip()
        })
        .collect();
    let values = matrix
        .triplets()
        .map(|(row, column, value)| value * row_scales[row] * column_scales[column])
        .collect();
    let scaled = SparseMatrix::new(Arc::clone(matrix.pattern()), values)?;
    Ok((scaled, row_scales, column_scales))
}

/// Rows and columns in elimination order.
fn permuted(matrix: &SparseMatrix, places: &[u32]) -> Result<SparseMatrix, SolveError> {
    let moved = matrix
        .triplets()
        .map(|(row, column, value)| (places[row] as usize, places[column] as usize, value));
    SparseMatrix::from_triplets(matrix.rows(), matrix.columns(), moved)
}

/// A general factorisation with row exchanges over the whole matrix.
#[derive(Clone, Debug)]
struct GeneralLu {
    factors: simplicial::SimplicialLu<u32, f64>,
    row_order: [Vec<u32>; 2],
    column_order: [Vec<u32>; 2],
}

impl GeneralLu {
    fn factor(matrix: &SparseMatrix) -> Result<Self, SolveError> {
        let order = matrix.rows();
        let column_order = column_order(matrix)?;
        let mut row_order = [vec![0; order], vec![0; order]];
        let mut factors = simplicial::SimplicialLu::new();
        let scratch = simplicial::factorize_simplicial_numeric_lu_scratch::<u32, f64>(order, order);
        let [forward, inverse] = &mut row_order;
        simplicial::factorize_simplicial_numeric_lu(
            forward,
            inverse,
            &mut factors,
            matrix.faer(),
            PermRef::new_checked(&column_order[0], &column_order[1], order),
            MemStack::new(&mut memory(scratch)?),
        )
        .map_err(|error| match error {
            LuError::SymbolicSingular { index } => SolveError::Singular {
                column: column_order[0][index] as usize,
                pivot: 0.0,
            },
            LuError::Generic(_) => SolveError::OutOfMemory {
                bytes: matrix.pattern().entries() * size_of::<f64>(),
            },
        })?;
        let upper = factors.u_factor_unsorted();
        for (place, &column) in column_order[0].iter().enumerate() {
            // The pivot is the last entry of its column.
            let pivot = upper.val_of_col(place).last().copied().unwrap_or(0.0);
            let strong = pivot.abs() > tolerance::SINGULAR_PIVOT && pivot.is_finite();
            if !strong {
                return Err(SolveError::Singular {
                    column: column as usize,
                    pivot,
                });
            }
        }
        Ok(Self {
            factors,
            row_order,
            column_order,
        })
    }

    fn solve_in_place(&self, columns: &mut [f64], transposed: bool) -> Result<(), SolveError> {
        let order = self.row_order[0].len();
        let count = columns.len() / order;
        let scratch = simplicial::solve_in_place_scratch::<u32, f64>(order, count, Par::Seq);
        let mut memory = memory(scratch)?;
        let stack = MemStack::new(&mut memory);
        let rows = PermRef::new_checked(&self.row_order[0], &self.row_order[1], order);
        let own = PermRef::new_checked(&self.column_order[0], &self.column_order[1], order);
        let x = MatMut::from_column_major_slice_mut(columns, order, count);
        if transposed {
            let solve = simplicial::SimplicialLu::solve_transpose_in_place_with_conj;
            solve(&self.factors, rows, own, Conj::No, x, Par::Seq, stack);
        } else {
            let solve = simplicial::SimplicialLu::solve_in_place_with_conj;
            solve(&self.factors, rows, own, Conj::No, x, Par::Seq, stack);
        }
        Ok(())
    }
}

/// A column order that keeps the factors sparse whatever rows are exchanged.
fn column_order(matrix: &SparseMatrix) -> Result<[Vec<u32>; 2], SolveError> {
    let order = matrix.rows();
    let entries = matrix.pattern().entries();
    let mut columns = [vec![0; order], vec![0; order]];
    let [forward, inverse] = &mut columns;
    colamd::order(
        forward,
        inverse,
        matrix.pattern().faer(),
        colamd::Control::default(),
        MemStack::new(&mut memory(colamd::order_scratch::<u32>(
            order, order, entries,
        ))?),
    )
    .map_err(|_| SolveError::OutOfMemory {
        bytes: entries * size_of::<u32>(),
    })?;
    Ok(columns)
}
