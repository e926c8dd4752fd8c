//! Every tolerance of the library, dimensionless, with its reason.
//!
//! A tolerance compares two quantities of the same kind, so that scaling a model changes nothing.
//! Code elsewhere names one of these constants; it never writes a small number of its own.

/// Largest relative residual `|Ax - b| / (|A| |x| + |b|)` accepted from a linear solver.
///
/// A backward stable factorisation of a mesh Laplacian with a million unknowns stays below 1e-13;
/// four digits of margin tell a broken solution from an ordinary one.
pub const LINEAR_RESIDUAL: f64 = 1e-9;
