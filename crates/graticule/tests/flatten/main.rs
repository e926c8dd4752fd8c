//! Flattening: what must hold for every patch, and known answers.

mod constraints;
mod editing;
mod fixed;
mod free;
mod intrinsic;
mod least_squares;
mod paper;
mod support;
mod target;
