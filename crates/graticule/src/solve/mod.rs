//! Sparse linear systems: assembly, orderings, factorisations held for reuse, checked solutions.

mod error;
mod hermitian;
mod ordering;
mod pattern;
mod sparse;

pub use error::SolveError;
pub use hermitian::{HermitianCholesky, HermitianMatrix};
pub use ordering::{Graph, Ordering};
pub use pattern::Pattern;
pub use sparse::{SparseMatrix, SymmetricMatrix};
