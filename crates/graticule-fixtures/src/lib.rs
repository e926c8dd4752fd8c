//! Surfaces with known answers, as plain arrays, for tests of every crate.
