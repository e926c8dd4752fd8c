//! Flattening: what must hold for every patch, and known answers.

mod atlas;
mod constraints;
mod editing;
mod fixed;
mod free;
mod injective;
mod intrinsic;
mod least_squares;
mod paper;
mod support;
mod target;
