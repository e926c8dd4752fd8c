//! Every tolerance of the library, dimensionless, with its reason.
//!
//! A tolerance compares two quantities of the same kind, so that scaling a model changes nothing.
//! Code elsewhere names one of these constants; it never writes a small number of its own.

/// Largest relative residual `|Ax - b| / (|A| |x| + |b|)` accepted from a linear solver.
///
/// A backward stable factorisation of a mesh Laplacian with a million unknowns stays below 1e-13;
/// four digits of margin tell a broken solution from an ordinary one.
pub const LINEAR_RESIDUAL: f64 = 1e-9;

/// Height over longest side at or below which a triangle in space has no measurable shape.
///
/// A coordinate of the size of the triangle is rounded by up to 2^-53; a triangle this thin is
/// known to no more than a few bits, and the distortion of a map of it would be noise. Needles with
/// sides in the ratio 1e6 stay far above.
pub const FLAT_TRIANGLE: f64 = 1.0 / (1_u64 << 46) as f64;

/// Share of the area that a triangle should have in a map, by its area in space and the area of
/// the whole map, below which it counts as degenerate and is left out of distortion figures.
///
/// Measured maps come from files with as few as six digits: a triangle meant to be a line or a point
/// has an area of rounding noise, and figures like the stretch would follow that noise.
pub const DEGENERATE_MAP_AREA: f64 = 1e-10;
