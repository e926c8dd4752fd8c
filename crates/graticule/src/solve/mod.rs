//! Sparse linear systems: assembly, orderings, factorisations held for reuse, checked solutions.

mod cholesky;
mod constraints;
mod dirichlet;
mod error;
mod fronts;
mod hermitian;
mod ldlt;
mod lu;
mod ordering;
mod pattern;
mod saddle;
mod solution;
mod sparse;
mod symbolic;

pub use cholesky::Cholesky;
pub use dirichlet::{DirichletLu, DirichletSystem};
pub use error::SolveError;
pub use hermitian::{HermitianCholesky, HermitianMatrix};
pub use ldlt::Ldlt;
pub use lu::{Exchange, Lu, LuSymbolic};
pub use ordering::{Graph, Ordering, Placement};
pub use pattern::Pattern;
pub use saddle::{SaddleSolution, SaddleSystem};
pub use solution::Solution;
pub use sparse::{SparseMatrix, SymmetricMatrix};
pub use symbolic::Symbolic;
