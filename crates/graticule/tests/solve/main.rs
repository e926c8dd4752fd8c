//! Sparse solvers against dense ones, identities and hostile input.

mod common;
mod constrained;
mod factorisations;
mod iterations;
mod matrices;
mod orderings;
