//! Sparse linear systems: assembly, orderings, factorisations held for reuse, checked solutions.

mod cholesky;
mod error;
mod fronts;
mod ldlt;
mod lu;
mod ordering;
mod pattern;
mod solution;
mod sparse;
mod symbolic;

pub use cholesky::Cholesky;
pub use error::SolveError;
pub use ldlt::Ldlt;
pub use lu::{Exchange, Lu, LuSymbolic};
pub use ordering::{Graph, Ordering, Placement};
pub use pattern::Pattern;
pub use solution::Solution;
pub use sparse::{SparseMatrix, SymmetricMatrix};
pub use symbolic::Symbolic;
