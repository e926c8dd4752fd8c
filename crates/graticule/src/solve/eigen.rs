//! The smallest eigenvector of a symmetric pencil, by inverse iteration.

use super::iterative::dot;
use super::solution::{largest, relative_to};
use super::{Cholesky, Ordering, SolveError, Symbolic, SymmetricMatrix};
use crate::tolerance::EIGENVALUE_SHIFT;
use crate::watch::Watch;

/// When to stop the iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EigenOptions {
    /// Residual `‖A x − λ B x‖ / ((‖A‖ + |λ| ‖B‖) ‖x‖)`, in the maximum norm, at which to stop.
    pub tolerance: f64,
    /// Most iterations.
    pub most_iterations: usize,
}

impl Default for EigenOptions {
    fn default() -> Self {
        Self {
            tolerance: 1e-12,
            most_iterations: 200,
        }
    }
}

/// An eigenvector of `A x = λ B x`.
#[derive(Clone, Debug, PartialEq)]
pub struct Eigenpair {
    /// `x`, with `xᵀ B x = 1`.
    pub vector: Vec<f64>,
    /// `λ = xᵀ A x`.
    pub value: f64,
    /// Relative residual, as in [`EigenOptions::tolerance`].
    pub residual: f64,
    /// Iterations done.
    pub iterations: usize,
}

/// The problem `A x = λ B x`, restricted to the complement of known eigenvectors.
#[derive(Clone, Copy, Debug)]
pub struct Pencil<'a> {
    /// `A`: symmetric, not negative on any direction.
    pub stiffness: &'a SymmetricMatrix,
    /// `B`: likewise. It may have few entries; no direction may have zero energy in both.
    pub mass: &'a SymmetricMatrix,
    /// Vectors to which the result is `B`-orthogonal, such as the constants.
    pub deflated: &'a [Vec<f64>],
}

/// The eigenvector of `A x = λ B x` with the smallest `λ` of a pencil, as a spectral conformal map
/// (Mullen et al. 2008) is one with the mass of the boundary and the constants deflated.
///
/// Where the smallest eigenvalue is multiple, the result is
/// one of its eigenvectors, which one depends on the fixed start. One factorisation of `A + σ B`, two
/// triangular solves per iteration.
///
/// # Errors
/// [`SolveError::NotConverged`] with the residual reached; [`SolveError::NotPositiveDefinite`] where
/// a direction has no energy in either matrix; [`SolveError::LengthMismatch`],
/// [`SolveError::Stopped`].
pub fn smallest_eigenvector(
    pencil: Pencil<'_>,
    ordering: &Ordering,
    options: EigenOptions,
    watch: &Watch,
) -> Result<Eigenpair, SolveError> {
    let Pencil {
        stiffness,
        mass,
        deflated,
    } = pencil;
    let order = stiffness.order();
    SolveError::check_length("rows of the mass matrix", mass.order(), order)?;
    for vector in deflated {
        SolveError::check_length("entries of a deflated vector", vector.len(), order)?;
    }
    let mut iteration = InverseIteration {
        factor: shifted(stiffness, mass, ordering)?,
        stiffness,
        mass,
        deflated: Vec::new(),
        norms: [stiffness.row_sum_norm(), mass.row_sum_norm()],
    };
    for vector in deflated {
        let mut vector = vector.clone();
        if iteration.normalise(&mut vector) {
            iteration.deflated.push(vector);
        }
    }
    iteration.iterate(options, watch)
}

struct InverseIteration<'a> {
    factor: Cholesky,
    stiffness: &'a SymmetricMatrix,
    mass: &'a SymmetricMatrix,
    /// `B`-orthonormal.
    deflated: Vec<Vec<f64>>,
    norms: [f64; 2],
}

impl InverseIteration<'_> {
    /// Makes a vector `B`-orthogonal to the deflated ones and gives it length one; whether
    /// anything was left of it.
    fn normalise(&self, vector: &mut [f64]) -> bool {
        let scale = largest(vector);
        if scale == 0.0 || !scale.is_finite() {
            return false;
        }
        divide(vector, scale);
        // Twice is enough (Kahan, in Parlett 1980).
        for _ in 0..2 {
            let image = self.mass.multiply(vector);
            for other in &self.deflated {
                let share = dot(&image, other);
                vector
                    .iter_mut()
                    .zip(other)
                    .for_each(|(x, o)| *x -= share * o);
            }
        }
        let length = dot(vector, &self.mass.multiply(vector)).sqrt();
        let something = length > 0.0 && length.is_finite();
        if something {
            divide(vector, length);
        }
        something
    }

    fn iterate(&self, options: EigenOptions, watch: &Watch) -> Result<Eigenpair, SolveError> {
        let mut vector = start(self.stiffness.order());
        let mut best: Option<Eigenpair> = None;
        for iterations in 1..=options.most_iterations {
            watch.check()?;
            let image = self.mass.multiply(&vector);
            vector = self.factor.solve(&image)?.values;
            if !self.normalise(&mut vector) {
                break;
            }
            let pair = self.judged(&vector, iterations);
            let done = pair.residual <= options.tolerance;
            if best
                .as_ref()
                .is_none_or(|best| pair.residual < best.residual)
            {
                best = Some(pair);
            }
            if done {
                break;
            }
        }
        match best {
            Some(pair) if pair.residual <= options.tolerance => Ok(pair),
            unfinished => Err(SolveError::NotConverged {
                iterations: options.most_iterations,
                residual: unfinished.map_or(f64::INFINITY, |pair| pair.residual),
                tolerance: options.tolerance,
            }),
        }
    }

    fn judged(&self, vector: &[f64], iterations: usize) -> Eigenpair {
        let image = self.stiffness.multiply(vector);
        let value = dot(vector, &image);
        let weighed = self.mass.multiply(vector);
        let left = image.iter().zip(&weighed).map(|(a, b)| a - value * b);
        let left: Vec<f64> = left.collect();
        let whole = (self.norms[0] + value.abs() * self.norms[1]) * largest(vector);
        Eigenpair {
            vector: vector.to_vec(),
            value,
            residual: relative_to(largest(&left), whole),
            iterations,
        }
    }
}

fn divide(vector: &mut [f64], divisor: f64) {
    for x in vector {
        *x /= divisor;
    }
}

/// The Cholesky factor of `A + σ B`.
fn shifted(
    stiffness: &SymmetricMatrix,
    mass: &SymmetricMatrix,
    ordering: &Ordering,
) -> Result<Cholesky, SolveError> {
    let norm = mass.row_sum_norm();
    let sigma = if norm > 0.0 {
        EIGENVALUE_SHIFT * stiffness.row_sum_norm() / norm
    } else {
        0.0
    };
    let shift = mass.lower().triplets().map(|(r, c, v)| (r, c, sigma * v));
    let entries = stiffness.lower().triplets().chain(shift);
    let sum = SymmetricMatrix::from_triplets(stiffness.order(), entries)?;
    Cholesky::factor(&Symbolic::new(&sum, ordering)?, &sum)
}

/// A fixed vector without any symmetry (Weyl's sequence of the golden ratio).
fn start(order: usize) -> Vec<f64> {
    let golden = 0.618_033_988_749_894_9;
    (1..=order)
        .map(|index| (index as f64 * golden).fract() - 0.5)
        .collect()
}
