//! Flattening: what must hold for every patch, and known answers.

mod atlas;
mod fixed;
mod free;
mod injective;
mod least_squares;
mod paper;
mod support;
