//! The largest eigenvector of a self-adjoint operator (Lanczos 1950), every vector made orthogonal
//! to all earlier ones.

use faer::{Mat, Side, c64};

/// Steps after which the iteration gives up.
const MOST_STEPS: usize = 150;

/// An operator that is self-adjoint in an inner product of its own.
pub(super) trait Operator {
    /// What may go wrong.
    type Error;

    /// The image of a vector.
    fn apply(&self, vector: &[c64]) -> Result<Vec<c64>, Self::Error>;

    /// The inner product, conjugate in its first argument.
    fn inner(&self, a: &[c64], b: &[c64]) -> c64;

    /// The error that says that the iteration did not converge.
    fn not_converged(&self, iterations: usize, residual: f64) -> Self::Error;
}

/// The space spanned by a vector and its images, with the operator's matrix in it: real, symmetric,
/// tridiagonal.
pub(super) struct Krylov {
    basis: Vec<Vec<c64>>,
    next: Vec<c64>,
    diagonal: Vec<f64>,
    beside: Vec<f64>,
}

impl Krylov {
    /// Nothing but a first vector.
    pub(super) fn from(start: Vec<c64>) -> Self {
        Self {
            basis: Vec::new(),
            next: start,
            diagonal: Vec::new(),
            beside: Vec::new(),
        }
    }

    /// The eigenvector of the eigenvalue farthest above 0, to a relative accuracy of `tolerance`.
    pub(super) fn largest_eigenvector<O: Operator>(
        mut self,
        operator: &O,
        tolerance: f64,
    ) -> Result<Vec<c64>, O::Error> {
        let mut error = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let left = self.extend(operator)?;
            let (eigenvalue, coefficients) = self.largest_pair();
            let last = coefficients.last().map_or(0.0, |c| c.abs());
            error = left * last / eigenvalue.abs();
            // Also met when the space is exhausted, with `left` at rounding level.
            if error <= tolerance {
                return Ok(self.combination(&coefficients));
            }
        }
        Err(operator.not_converged(MOST_STEPS, error))
    }

    /// One step: adds the next vector to the basis and returns the length of the part of its image
    /// that is not in the space.
    fn extend<O: Operator>(&mut self, operator: &O) -> Result<f64, O::Error> {
        let mut vector = std::mem::take(&mut self.next);
        let length = operator.inner(&vector, &vector).re.sqrt();
        for value in &mut vector {
            *value /= length;
        }
        if !self.basis.is_empty() {
            self.beside.push(length);
        }
        let mut image = operator.apply(&vector)?;
        self.diagonal.push(operator.inner(&vector, &image).re);
        self.basis.push(vector);
        // Twice is enough (Kahan and Parlett).
        for _ in 0..2 {
            for earlier in &self.basis {
                let share = operator.inner(earlier, &image);
                for (value, earlier) in image.iter_mut().zip(earlier) {
                    *value -= earlier * share;
                }
            }
        }
        let left = operator.inner(&image, &image).re.sqrt();
        self.next = image;
        Ok(left)
    }

    fn largest_pair(&self) -> (f64, Vec<f64>) {
        let size = self.diagonal.len();
        let matrix = Mat::from_fn(size, size, |row, column| match row.abs_diff(column) {
            0 => self.diagonal[row],
            1 => self.beside[row.min(column)],
            _ => 0.0,
        });
        let Ok(pairs) = matrix.self_adjoint_eigen(Side::Lower) else {
            return (0.0, vec![1.0; size]);
        };
        let last = size - 1; // ascending
        let coefficients = (0..size).map(|row| pairs.U()[(row, last)]).collect();
        (pairs.S()[last], coefficients)
    }

    fn combination(&self, coefficients: &[f64]) -> Vec<c64> {
        let mut sum = vec![c64::ZERO; self.basis[0].len()];
        for (vector, &coefficient) in self.basis.iter().zip(coefficients) {
            for (sum, value) in sum.iter_mut().zip(vector) {
                *sum += value * coefficient;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    struct Diagonal(Vec<f64>);

    impl Operator for Diagonal {
        type Error = (usize, f64);

        fn apply(&self, vector: &[c64]) -> Result<Vec<c64>, Self::Error> {
            Ok(vector.iter().zip(&self.0).map(|(v, d)| v * d).collect())
        }

        fn inner(&self, a: &[c64], b: &[c64]) -> c64 {
            a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
        }

        fn not_converged(&self, iterations: usize, residual: f64) -> Self::Error {
            (iterations, residual)
        }
    }

    #[test]
    fn the_largest_eigenvector_is_found_also_where_the_space_is_soon_exhausted() {
        for size in [1, 2, 5, 400] {
            let values = (0..size).map(|k| 1.0 / f64::from(k + 1)).collect();
            let mut noise = Noise::new(2);
            let start = (0..size).map(|_| c64::new(noise.signed(), noise.signed()));
            let found = Krylov::from(start.collect())
                .largest_eigenvector(&Diagonal(values), 1e-12)
                .unwrap();
            let others = found[1..].iter().map(|v| v.norm()).fold(0.0, f64::max);
            assert!(others < 1e-9 * found[0].norm(), "{size}: {others}");
        }
    }
}
