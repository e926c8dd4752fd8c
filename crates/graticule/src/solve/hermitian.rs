//! Hermitian systems: two coupled real unknowns per vertex as one complex one.
//!
//! A quadratic form in planar points that is invariant under rotations is a Hermitian matrix over
//! complex numbers. Against the real matrix of twice the order, its factor has half the numbers
//! and takes half the operations.

use std::sync::Arc;

use faer::c64;

use super::multifrontal::{Multifrontal, Plan};
use super::pattern::{Pattern, check_size};
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
        let values = lower.values().iter().map(|&v| c64::new(v, 0.0)).collect();
        Self { pattern, values }.with_antisymmetric(antisymmetric)
    }

    /// The matrix `L + iS` with `L` the graph Laplacian of weighted edges and `S` antisymmetric.
    ///
    /// The edges are pairs of different vertices, the smaller first, ascending, none twice; each
    /// triplet `(j, k, s)` adds `s` to `S` at `(j, k)` and `-s` at `(k, j)` and needs an edge there.
    /// Linear time, without sorting.
    ///
    /// # Errors
    /// [`SolveError::OutOfRange`] names a pair that breaks these rules, [`SolveError::NonFinite`] a
    /// value.
    pub fn laplacian(
        order: usize,
        edges: &[([usize; 2], f64)],
        antisymmetric: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Result<Self, SolveError> {
        check_size(edges.len() + order)?;
        check_edges(order, edges)?;
        let mut diagonal = vec![0.0; order];
        for &([a, b], weight) in edges {
            diagonal[a] += weight;
            diagonal[b] += weight;
        }
        let mut starts = Vec::with_capacity(order + 1);
        let mut rows = Vec::with_capacity(order + edges.len());
        let mut values = Vec::with_capacity(order + edges.len());
        let mut rest = edges;
        for (column, &sum) in diagonal.iter().enumerate() {
            starts.push(rows.len() as u32);
            rows.push(column as u32);
            values.push(c64::new(sum, 0.0));
            let here = rest.partition_point(|([a, _], _)| *a == column);
            let (in_column, after) = rest.split_at(here);
            rows.extend(in_column.iter().map(|([_, b], _)| *b as u32));
            values.extend(in_column.iter().map(|(_, weight)| c64::new(-weight, 0.0)));
            rest = after;
        }
        starts.push(rows.len() as u32);
        let pattern = Arc::new(Pattern::new(order, starts, rows));
        Self { pattern, values }.with_antisymmetric(antisymmetric)
    }

    fn with_antisymmetric(
        mut self,
        triplets: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Result<Self, SolveError> {
        let order = self.order();
        for (row, column, value) in triplets {
            if !value.is_finite() {
                return Err(SolveError::NonFinite { row, column, value });
            }
            let known = row.max(column) < order && row != column;
            let entry = known.then(|| self.pattern.find(row.max(column), row.min(column)));
            let entry = entry.flatten().ok_or(out_of_range(order, [row, column]))?;
            self.values[entry].im += if row > column { value } else { -value };
        }
        Ok(self)
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
        self.for_each_entry(|row, column, value| {
            output[row] += value * input[column];
            if row != column {
                output[column] += value.conj() * input[row];
            }
        });
        output
    }

    /// Largest sum of absolute values in a row.
    #[must_use]
    pub fn row_sum_norm(&self) -> f64 {
        let mut sums = vec![0.0; self.order()];
        self.for_each_entry(|row, column, value| {
            let size = if value.im == 0.0 {
                value.re.abs()
            } else {
                value.norm()
            };
            sums[row] += size;
            if row != column {
                sums[column] += size;
            }
        });
        sums.into_iter().fold(0.0, f64::max)
    }

    /// Calls with row, column and value for each entry of the lower triangle.
    pub(super) fn for_each_entry(&self, mut call: impl FnMut(usize, usize, c64)) {
        for column in 0..self.order() {
            for entry in self.pattern.range(column) {
                let row = self.pattern.row_indices()[entry] as usize;
                call(row, column, self.values[entry]);
            }
        }
    }

    /// Whether an equation has a coefficient that is not real, by unknown.
    pub(super) fn complex_unknowns(&self) -> Vec<bool> {
        let mut complex = vec![false; self.order()];
        self.for_each_entry(|row, column, value| {
            if value.im != 0.0 {
                complex[row] = true;
                complex[column] = true;
            }
        });
        complex
    }
}

/// A Cholesky factorisation `LLᴴ`, held for several right-hand sides.
///
/// What only real numbers reach is factored and kept in real numbers.
#[derive(Debug)]
pub struct HermitianCholesky {
    factor: Multifrontal,
}

impl HermitianCholesky {
    /// Factors a positive definite matrix, eliminating in the given order.
    ///
    /// # Errors
    /// [`SolveError::NotPositiveDefinite`] names the unknown whose pivot is not positive,
    /// [`SolveError::OutOfMemory`] the size that was too much.
    pub fn new(matrix: &HermitianMatrix, ordering: &Ordering) -> Result<Self, SolveError> {
        SolveError::check_length("unknowns in order", ordering.len(), matrix.order())?;
        let complex = matrix.complex_unknowns();
        let is_complex = |unknown: u32| complex[unknown as usize];
        let plan = Plan::new(matrix.pattern(), ordering, is_complex);
        let factor = Multifrontal::new(&Arc::new(plan), &matrix.values)?;
        Ok(Self { factor })
    }

    /// The solution of `matrix * x = right_side`, without refinement.
    ///
    /// # Panics
    /// Unless there is one number per row.
    ///
    /// # Errors
    /// [`SolveError::OutOfMemory`].
    pub fn solve(&self, right_side: &[c64]) -> Result<Vec<c64>, SolveError> {
        assert_eq!(right_side.len(), self.factor.order(), "one number per row");
        self.factor.solve(right_side)
    }

    /// Numbers stored in the factor: real ones of 8 bytes each, and complex ones of 16.
    #[must_use]
    pub fn factor_entries(&self) -> [usize; 2] {
        self.factor.entries()
    }
}

fn check_edges(order: usize, edges: &[([usize; 2], f64)]) -> Result<(), SolveError> {
    let mut last = [0, 0];
    for &([row, column], value) in edges {
        if row >= column || column >= order || [row, column] <= last {
            return Err(out_of_range(order, [row, column]));
        }
        if !value.is_finite() {
            return Err(SolveError::NonFinite { row, column, value });
        }
        last = [row, column];
    }
    Ok(())
}

fn out_of_range(order: usize, [row, column]: [usize; 2]) -> SolveError {
    SolveError::OutOfRange {
        row,
        column,
        rows: order,
        columns: order,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    /// A Laplacian with a small coupling on a ring with chords; every fifth unknown decoupled, which
    /// makes it positive definite.
    fn matrix(order: usize) -> HermitianMatrix {
        let chords = (0..order).flat_map(|k| [[k, (k + 1) % order], [k, (k + 4) % order]]);
        let mut noise = Noise::new(4);
        let mut edges: Vec<_> = chords
            .map(|[a, b]| ([a.min(b), a.max(b)], noise.unit() + 0.5))
            .collect();
        edges.sort_by_key(|(ends, _)| *ends);
        let skew = edges
            .iter()
            .map(|&([a, b], _)| (b, a, 0.1 * noise.signed()));
        let skew: Vec<_> = skew.collect();
        let matrix = HermitianMatrix::laplacian(order, &edges, skew).unwrap();
        matrix.decoupled(&(0..order).step_by(5).collect::<Vec<_>>())
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
    fn what_no_complex_number_reaches_is_kept_in_real_ones() {
        // A strip whose first vertices are coupled, eliminated from the other end.
        let order = 400;
        let edges = (0..order - 1).flat_map(|k| {
            let second = (k + 2 < order).then_some(([k, k + 2], 0.5));
            [([k, k + 1], 1.0)].into_iter().chain(second)
        });
        let edges: Vec<_> = edges.collect();
        let matrix = HermitianMatrix::laplacian(order, &edges, [(1, 0, 0.01)]).unwrap();
        let matrix = matrix.decoupled(&[200]);
        let mut reversed: Vec<u32> = (0..order as u32).collect();
        reversed.reverse();
        let orders = [reversed, (0..order as u32).collect()];
        let factors = orders.map(|places| {
            let ordering = Ordering::from_order(places).unwrap();
            let factor = HermitianCholesky::new(&matrix, &ordering).unwrap();
            let expected = vector(order);
            let found = factor.solve(&matrix.multiply(&expected)).unwrap();
            let error = expected.iter().zip(&found).map(|(a, b)| (a - b).norm());
            assert!(error.fold(0.0, f64::max) < 1e-9);
            factor.factor_entries()
        });
        let [late, early] = factors;
        assert!(late[1] < 30 && late[0] > 1000, "{late:?}");
        assert!(early[1] > 500, "{early:?}");
    }

    #[test]
    fn an_empty_and_a_single_equation_are_solved() {
        let empty = HermitianMatrix::laplacian(0, &[], []).unwrap();
        let factor = HermitianCholesky::new(&empty, &Ordering::natural(0)).unwrap();
        assert!(factor.solve(&[]).unwrap().is_empty());
        let real = SymmetricMatrix::from_triplets(1, [(0, 0, 4.0)]).unwrap();
        let single = HermitianMatrix::new(&real, []).unwrap();
        let factor = HermitianCholesky::new(&single, &Ordering::natural(1)).unwrap();
        let solution = factor.solve(&[c64::new(8.0, 4.0)]).unwrap();
        assert!((solution[0] - c64::new(2.0, 1.0)).norm() < 1e-15);
    }

    #[test]
    fn decoupled_unknowns_stand_alone() {
        let matrix = matrix(40).decoupled(&[3]);
        let mut unit = vec![c64::ZERO; 40];
        unit[3] = c64::ONE;
        let image = matrix.multiply(&unit);
        let mut entries = image.iter().enumerate();
        assert!(entries.all(|(k, value)| (k == 3) == (value.norm() > 0.0)));
    }

    #[test]
    fn an_indefinite_matrix_is_refused_by_its_column() {
        let edges = [([0, 1], 1.0), ([1, 2], 1.0)];
        let matrix = HermitianMatrix::laplacian(3, &edges, [(0, 1, 3.0)]).unwrap();
        let refusal = HermitianCholesky::new(&matrix, &Ordering::natural(3)).unwrap_err();
        assert!(matches!(
            refusal,
            SolveError::NotPositiveDefinite { column: 1, .. }
        ));
    }

    #[test]
    fn edges_and_couplings_out_of_place_are_refused() {
        let edges = [([0, 1], 1.0), ([1, 2], 1.0)];
        for place in [(0, 2), (1, 1), (0, 9)] {
            let coupling = [(place.0, place.1, 1.0)];
            let refusal = HermitianMatrix::laplacian(3, &edges, coupling).unwrap_err();
            assert!(matches!(refusal, SolveError::OutOfRange { .. }));
        }
        for ends in [[1, 0], [1, 1], [0, 3], [0, 1]] {
            let edges = [([0, 1], 1.0), (ends, 1.0)];
            let refusal = HermitianMatrix::laplacian(3, &edges, []).unwrap_err();
            assert!(matches!(refusal, SolveError::OutOfRange { .. }));
        }
    }
}
