//! Every tolerance of the library, dimensionless, with its reason.
//!
//! A tolerance compares two quantities of the same kind, so that scaling a model changes nothing.
//! Code elsewhere names one of these constants; it never writes a small number of its own.

/// Largest relative residual `|Ax - b| / (|A| |x| + |b|)` accepted from a linear solver.
///
/// A backward stable factorisation of a mesh Laplacian with a million unknowns stays below 1e-13;
/// four digits of margin tell a broken solution from an ordinary one.
pub const LINEAR_RESIDUAL: f64 = 1e-9;

/// Relative residual above which a solution is refined: a few units in the last place times the
/// growth of an ordinary elimination. Below it a refinement step gains nothing.
pub const REFINED_RESIDUAL: f64 = 1e-14;

/// A pivot smaller than this share of the diagonal entry it came from has lost all its digits: the
/// matrix is singular to working precision. Rounding leaves 1e-15 to 1e-14 where the exact pivot
/// is zero; pivots of definite systems of needle triangles stay above 1e-12.
pub const SINGULAR_PIVOT: f64 = 1e-13;

/// Pivots below this are replaced in the regularised factorisation of an indefinite matrix whose
/// largest entries are near one: rounding errors of such a factorisation.
pub const REGULARISED_PIVOT: f64 = 1e-12;

/// What replaces them: the square root of the rounding unit, half the digits for the
/// factorisation and half for the refinement.
pub const PIVOT_REPLACEMENT: f64 = 1e-8;

/// A constraint whose part independent of the earlier ones is below this share of it is implied by
/// them, and agrees with them if its value does to this share of the values involved.
pub const DEPENDENT_CONSTRAINT: f64 = 1e-10;
