//! Every tolerance of the library, dimensionless, with its reason.
//!
//! A tolerance compares two quantities of the same kind, so that scaling a model changes nothing.
//! Code elsewhere names one of these constants; it never writes a small number of its own.

/// Largest relative residual `|Ax - b| / (|A| |x| + |b|)` accepted from a linear solver.
///
/// A backward stable factorisation of a mesh Laplacian with a million unknowns stays below 1e-13;
/// four digits of margin tell a broken solution from an ordinary one.
pub const LINEAR_RESIDUAL: f64 = 1e-9;

/// Height of a triangle, over its longest side, up to which it counts as having no area.
///
/// Collinear points computed in double precision come out some 1e-16 off the line; scans and CAD
/// data in single precision hold true slivers down to about 1e-8.
pub const NO_AREA_HEIGHT: f64 = 1e-12;

/// Height of a triangle, over its longest side, below which it is noted as a sliver.
pub const SLIVER_HEIGHT: f64 = 1e-3;

/// Volume of a closed component, over its extent cubed, up to which it has no inside.
///
/// The sum of a million signed tetrahedra is good to about 1e-13.
pub const FLAT_VOLUME: f64 = 1e-12;

/// Extent of a component, over that of the whole, below which it is noted as tiny.
pub const TINY_COMPONENT: f64 = 1e-3;

/// Distance of a vertex from an edge, over the edge's length, up to which it counts as lying on it:
/// above the rounding of single precision files.
pub const ON_EDGE: f64 = 1e-6;

/// Least gain in shape (mean ratio, `0.0..=1.0`) for which a diagonal is exchanged. Below it lies
/// rounding, which must not decide between equals.
pub const SHAPE_GAIN: f64 = 1e-9;

/// Bound on the rounding of a product of two differences of coordinates within `-2.0..=2.0`.
pub const UNIT_ROUNDING: f64 = 1e-14;
