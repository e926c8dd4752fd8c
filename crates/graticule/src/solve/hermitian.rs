//! Hermitian systems: two coupled real unknowns per vertex as one complex one.
//!
//! A quadratic form in planar points that is invariant under rotations is a Hermitian matrix over
//! complex numbers. Against the real matrix of twice the order, its factor has half the numbers
//! and takes half the operations.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::sparse::linalg::cholesky::{
    LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::{Conj, MatMut, Par, Side, c64};

use super::pattern::Pattern;
use super::{Ordering, SolveError, SymmetricMatrix};

/// A Hermitian sparse matrix, of which the lower triangle is stored.
#[derive(Clone, Debug, PartialEq)]
pub struct HermitianMatrix {
    pattern: Arc<Pattern>,
    values: Vec<c64>,
}

impl HermitianMatrix {
    /// The matrix `R + iS` with `R` symmetric and `S` antisymmetric: each triplet `(j, k, s)` adds
    /// `s` to `S` at `(j, k)` and `-s` at `(k, j)`.
    ///
    /// # Errors
    /// [`SolveError::OutOfRange`] for a place where `R` has no entry, [`SolveError::NonFinite`].
    pub fn new(
        real: &SymmetricMatrix,
        antisymmetric: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Result<Self, SolveError> {
        let lower = real.lower();
        let pattern = Arc::clone(lower.pattern());
        let mut values: Vec<_> = lower.values().iter().map(|&v| c64::new(v, 0.0)).collect();
        for (row, column, value) in antisymmetric {
            if !value.is_finite() {
                return Err(SolveError::NonFinite { row, column, value });
            }
            let order = real.order();
            let known = row.max(column) < order && row != column;
            let entry = known.then(|| pattern.find(row.max(column), row.min(column)));
            let Some(entry) = entry.flatten() else {
                let (rows, columns) = (order, order);
                return Err(SolveError::OutOfRange {
                    row,
                    column,
                    rows,
                    columns,
                });
            };
            values[entry].im += if row > column { value } else { -value };
        }
        Ok(Self { pattern, values })
    }

    /// Number of rows and columns.
    #[must_use]
    pub fn order(&self) -> usize {
        self.pattern.columns()
    }

    /// The places of the lower triangle's entries.
    #[must_use]
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// The same matrix with the rows and columns of some unknowns replaced by those of the identity
    /// times a number of the diagonal's size, so that these unknowns stand alone. The pattern stays.
    ///
    /// # Panics
    /// If an unknown is out of range.
    #[must_use]
    pub fn decoupled(&self, unknowns: &[usize]) -> Self {
        let mut alone = vec![false; self.order()];
        for &unknown in unknowns {
            alone[unknown] = true;
        }
        let mut values = self.values.clone();
        for column in 0..self.order() {
            for entry in self.pattern.range(column) {
                let row = self.pattern.row_indices()[entry] as usize;
                if row != column && (alone[row] || alone[column]) {
                    values[entry] = c64::new(0.0, 0.0);
                }
            }
        }
        Self {
            pattern: Arc::clone(&self.pattern),
            values,
        }
    }

    /// `self * input`.
    ///
    /// # Panics
    /// Unless there is one number per row.
    #[must_use]
    pub fn multiply(&self, input: &[c64]) -> Vec<c64> {
        assert_eq!(input.len(), self.order(), "one number per column");
        let mut output = vec![c64::new(0.0, 0.0); self.order()];
        for column in 0..self.order() {
            for entry in self.pattern.range(column) {
                let row = self.pattern.row_indices()[entry] as usize;
                output[row] += self.values[entry] * input[column];
                if row != column {
                    output[column] += self.values[entry].conj() * input[row];
                }
            }
        }
        output
    }

    /// Largest sum of absolute values in a row.
    #[must_use]
    pub fn row_sum_norm(&self) -> f64 {
        let mut sums = vec![0.0; self.order()];
        for column in 0..self.order() {
            for entry in self.pattern.range(column) {
                let row = self.pattern.row_indices()[entry] as usize;
                sums[row] += self.values[entry].norm();
                if row != column {
                    sums[column] += self.values[entry].norm();
                }
            }
        }
        sums.into_iter().fold(0.0, f64::max)
    }

    fn faer(&self) -> faer::sparse::SparseColMatRef<'_, u32, c64> {
        faer::sparse::SparseColMatRef::new(self.pattern.faer(), &self.values)
    }
}

/// A Cholesky factorisation `LLᴴ`, held for several right-hand sides.
pub struct HermitianCholesky {
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<c64>,
}

impl HermitianCholesky {
    /// Factors a positive definite matrix, eliminating in the given order.
    ///
    /// # Errors
    /// [`SolveError::NotPositiveDefinite`] names the unknown whose pivot is not positive,
    /// [`SolveError::OutOfMemory`] the size that was too much.
    pub fn new(matrix: &HermitianMatrix, ordering: &Ordering) -> Result<Self, SolveError> {
        SolveError::check_length("unknowns in order", ordering.len(), matrix.order())?;
        let symbolic = factorize_symbolic_cholesky(
            matrix.pattern.faer(),
            Side::Lower,
            SymmetricOrdering::Custom(ordering.faer()),
            faer::sparse::linalg::cholesky::CholeskySymbolicParams::default(),
        );
        let symbolic = symbolic.map_err(|_| out_of_memory(matrix.order()))?;
        let mut factor = zeros(symbolic.len_val())?;
        let scratch =
            symbolic.factorize_numeric_llt_scratch::<c64>(Par::Seq, faer::Spec::default());
        let mut memory = MemBuffer::try_new(scratch)
            .map_err(|_| out_of_memory(scratch.unaligned_bytes_required()))?;
        let result = symbolic.factorize_numeric_llt(
            &mut factor,
            matrix.faer(),
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            faer::Spec::default(),
        );
        if let Err(LltError::NonPositivePivot { index }) = result {
            // The simplicial code counts from 1.
            let simplicial = matches!(symbolic.raw(), SymbolicCholeskyRaw::Simplicial(_));
            let place = index.saturating_sub(usize::from(simplicial));
            let column = ordering.order().get(place).map_or(place, |&c| c as usize);
            return Err(SolveError::NotPositiveDefinite { column, pivot: 0.0 });
        }
        Ok(Self { symbolic, factor })
    }

    /// The solution of `matrix * x = right_side`, without refinement.
    ///
    /// # Panics
    /// Unless there is one number per row.
    ///
    /// # Errors
    /// [`SolveError::OutOfMemory`].
    pub fn solve(&self, right_side: &[c64]) -> Result<Vec<c64>, SolveError> {
        let order = self.symbolic.nrows();
        assert_eq!(right_side.len(), order, "one number per row");
        let mut solution = right_side.to_vec();
        let scratch = self.symbolic.solve_in_place_scratch::<c64>(1, Par::Seq);
        let mut memory = MemBuffer::try_new(scratch)
            .map_err(|_| out_of_memory(scratch.unaligned_bytes_required()))?;
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(&mut solution, order, 1),
            Par::Seq,
            MemStack::new(&mut memory),
        );
        Ok(solution)
    }

    /// Numbers stored in the factor, 16 bytes each.
    #[must_use]
    pub fn factor_entries(&self) -> usize {
        self.factor.len()
    }
}

impl std::fmt::Debug for HermitianCholesky {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("HermitianCholesky")
            .field("order", &self.symbolic.nrows())
            .field("factor_entries", &self.factor.len())
            .finish()
    }
}

fn zeros(count: usize) -> Result<Vec<c64>, SolveError> {
    let mut values = Vec::new();
    values
        .try_reserve_exact(count)
        .map_err(|_| out_of_memory(count.saturating_mul(size_of::<c64>())))?;
    values.resize(count, c64::new(0.0, 0.0));
    Ok(values)
}

fn out_of_memory(bytes: usize) -> SolveError {
    SolveError::OutOfMemory { bytes }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    /// A diagonally dominant Hermitian matrix on a ring with chords.
    fn matrix(order: usize) -> HermitianMatrix {
        let mut noise = Noise::new(4);
        let edges: Vec<_> = (0..order)
            .flat_map(|k| [[k, (k + 1) % order], [k, (k + 7) % order]])
            .collect();
        let weighted = edges.iter().map(|&ends| (ends, noise.unit() + 0.1));
        let ones = (0..order).map(|k| (k, k, 1.0));
        let laplacian = weighted.flat_map(|([a, b], w)| [(a, a, w), (b, b, w), (a, b, -w)]);
        let real = SymmetricMatrix::from_triplets(order, laplacian.chain(ones)).unwrap();
        let mut noise = Noise::new(5);
        let skew = edges.iter().map(|&[a, b]| (a, b, 0.1 * noise.signed()));
        HermitianMatrix::new(&real, skew).unwrap()
    }

    fn vector(order: usize) -> Vec<c64> {
        let mut noise = Noise::new(6);
        (0..order)
            .map(|_| c64::new(noise.signed(), noise.signed()))
            .collect()
    }

    fn dot(a: &[c64], b: &[c64]) -> c64 {
        a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
    }

    #[test]
    fn the_form_of_a_hermitian_matrix_is_real_and_symmetric() {
        let matrix = matrix(40);
        let (x, y) = (vector(40), vector(80)[40..].to_vec());
        assert!(dot(&x, &matrix.multiply(&x)).im.abs() < 1e-14);
        let difference = dot(&x, &matrix.multiply(&y)) - dot(&matrix.multiply(&x), &y);
        assert!(difference.norm() < 1e-13);
    }

    #[test]
    fn solving_undoes_multiplying() {
        for order in [9, 40, 3000] {
            let matrix = matrix(order);
            let mut reversed: Vec<u32> = (0..order as u32).collect();
            reversed.reverse();
            let ordering = Ordering::from_order(reversed).unwrap();
            let expected = vector(order);
            let factor = HermitianCholesky::new(&matrix, &ordering).unwrap();
            let found = factor.solve(&matrix.multiply(&expected)).unwrap();
            let error = expected.iter().zip(&found).map(|(a, b)| (a - b).norm());
            assert!(error.fold(0.0, f64::max) < 1e-12);
        }
    }

    #[test]
    fn decoupled_unknowns_stand_alone() {
        let matrix = matrix(40).decoupled(&[3, 20]);
        let mut unit = vec![c64::new(0.0, 0.0); 40];
        unit[3] = c64::new(1.0, 0.0);
        let image = matrix.multiply(&unit);
        let alone = image
            .iter()
            .enumerate()
            .all(|(k, v)| (k == 3) == (v.norm() > 0.0));
        assert!(alone);
    }

    #[test]
    fn an_indefinite_matrix_is_refused_by_its_column() {
        let real =
            SymmetricMatrix::from_triplets(3, [(0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0), (1, 0, 0.0)]);
        let matrix = HermitianMatrix::new(&real.unwrap(), [(0, 1, 2.0)]).unwrap();
        let refusal = HermitianCholesky::new(&matrix, &Ordering::natural(3)).unwrap_err();
        assert!(matches!(
            refusal,
            SolveError::NotPositiveDefinite { column: 1, .. }
        ));
    }

    #[test]
    fn a_coupling_without_a_place_is_refused() {
        let real = SymmetricMatrix::from_triplets(3, [(0, 0, 1.0)]).unwrap();
        for place in [(0, 1), (1, 1), (0, 9)] {
            let refusal = HermitianMatrix::new(&real, [(place.0, place.1, 1.0)]).unwrap_err();
            assert!(matches!(refusal, SolveError::OutOfRange { .. }));
        }
    }
}
