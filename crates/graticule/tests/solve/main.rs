//! Sparse solvers against dense ones, identities and hostile input.

#![expect(
    clippy::float_cmp,
    reason = "what is compared exactly is exact by construction"
)]

mod common;
mod constrained;
mod factorisations;
mod iterations;
mod matrices;
mod orderings;
