//! Sparse linear systems: assembly, orderings, factorisations held for reuse, checked solutions.

mod cholesky;
mod constraints;
mod dirichlet;
mod eigen;
mod error;
mod fronts;
mod hermitian;
mod iterative;
mod ldlt;
mod lu;
mod ordering;
mod pattern;
mod preconditioner;
mod saddle;
mod solution;
mod sparse;
mod symbolic;

pub use cholesky::Cholesky;
pub use dirichlet::{DirichletLu, DirichletSystem};
pub use eigen::{EigenOptions, Eigenpair, Pencil, smallest_eigenvector};
pub use error::SolveError;
pub use hermitian::{HermitianCholesky, HermitianMatrix};
pub use iterative::{
    ConjugateGradientOptions, ConjugateGradientSolution, LinearOperator, ParallelMatrix,
    conjugate_gradients,
};
pub use ldlt::Ldlt;
pub use lu::{Exchange, Lu, LuSymbolic};
pub use ordering::{Graph, Ordering, Placement};
pub use pattern::Pattern;
pub use preconditioner::{Identity, IncompleteCholesky, Jacobi, Preconditioner};
pub use saddle::{SaddleSolution, SaddleSystem};
pub use solution::Solution;
pub use sparse::{SparseMatrix, SymmetricMatrix};
pub use symbolic::Symbolic;
