//! Sparse linear systems: assembly, orderings, factorisations held for reuse, checked solutions.
//!
//! | system | solved by |
//! |---|---|
//! | symmetric positive definite | [`Cholesky`], planned once by [`Symbolic`] |
//! | the same with some unknowns given | [`DirichletSystem`] |
//! | not symmetric (mean value, authalic) | [`Lu`], [`DirichletLu`]; transposed for adjoints |
//! | a minimum under linear constraints | [`SaddleSystem`] |
//! | equations that need not be symmetric, under linear constraints | [`BorderedSystem`] |
//! | symmetric indefinite | [`Ldlt`] |
//! | more equations than unknowns | [`LeastSquares`] |
//! | definite with a large diagonal, or known by its products only | [`conjugate_gradients`] |
//! | the smallest eigenvector | [`smallest_eigenvector`] |
//!
//! All give the same bits for any number of threads. Every solution carries its relative residual,
//! computed from the matrix itself; one above [`LINEAR_RESIDUAL`](crate::tolerance::LINEAR_RESIDUAL)
//! is an error. Scaling a matrix changes nothing. Several right-hand sides stand in one slice, one
//! column after the other; two cost little more than one.
//!
//! What takes time on a mesh with n vertices is the fill of the factor: an [`Ordering`] made from the
//! vertices' coordinates ([`Placement`]) keeps it at O(n log n).
//!
//! ```
//! use graticule::solve::{DirichletSystem, Placement, SymmetricMatrix};
//!
//! // A chain of four vertices whose ends are held at 0 and 3.
//! let edges = [([0, 1], 1.0), ([1, 2], 1.0), ([2, 3], 1.0)];
//! let laplacian = SymmetricMatrix::laplacian(4, edges)?;
//! let system = DirichletSystem::new(&laplacian, &[0, 3], Placement::unknown())?;
//! let solution = system.solve(&[0.0, 3.0])?;
//! assert!((solution.values[2] - 2.0).abs() < 1e-15);
//! assert!(solution.residual < 1e-15);
//! # Ok::<(), graticule::solve::SolveError>(())
//! ```

mod cholesky;
mod constraints;
mod dirichlet;
mod eigen;
mod error;
mod fronts;
mod hermitian;
mod iterative;
mod last_block;
mod ldlt;
mod least_squares;
mod lu;
mod memory;
mod multifrontal;
mod ordering;
mod pattern;
mod preconditioner;
mod saddle;
mod solution;
mod sparse;
mod symbolic;

pub use cholesky::Cholesky;
pub use dirichlet::{DirichletLu, DirichletSystem, Eliminated, Factorization};
pub use eigen::{EigenOptions, Eigenpair, Pencil, smallest_eigenvector};
pub use error::SolveError;
pub use hermitian::{HermitianCholesky, HermitianMatrix};
pub use iterative::{
    ConjugateGradientOptions, ConjugateGradientSolution, LinearOperator, ParallelMatrix,
    conjugate_gradients,
};
pub use ldlt::Ldlt;
pub use least_squares::LeastSquares;
pub use lu::{Exchange, Lu, LuSymbolic};
pub(crate) use ordering::along_curve;
pub use ordering::{Graph, Ordering, Placement};
pub use pattern::Pattern;
pub use preconditioner::{Identity, IncompleteCholesky, Jacobi, Preconditioner};
pub use saddle::{BorderedSystem, Constrained, SaddleSolution, SaddleSystem};
pub use solution::Solution;
pub use sparse::{SparseMatrix, SymmetricMatrix};
pub use symbolic::Symbolic;
