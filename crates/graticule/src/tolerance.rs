//! Every tolerance of the library, dimensionless, with its reason.
//!
//! A tolerance compares two quantities of the same kind, so that scaling a model changes nothing.
//! Code elsewhere names one of these constants; it never writes a small number of its own.

/// Largest relative residual `|Ax - b| / (|A| |x| + |b|)` accepted from a linear solver.
///
/// A backward stable factorisation of a mesh Laplacian with a million unknowns stays below 1e-13;
/// four digits of margin tell a broken solution from an ordinary one.
pub const LINEAR_RESIDUAL: f64 = 1e-9;

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

/// Height over longest side below which a triangle counts as degenerate and is not to be divided by.
///
/// Coordinates in double precision give the height of a triangle to about 1e-16 of its longest
/// side, so at this bound the cotangents still have six digits; real models reach 1e-6.
pub const DEGENERATE_HEIGHT: f64 = 1e-10;

/// What mollification makes sure of: two sides of a triangle are longer than the third by this
/// share of the longest.
///
/// The height of a flat triangle becomes 7e-6 of its longest side, while no length changes by more
/// than 1e-10 of the longest side of the worst triangle.
pub const MOLLIFICATION_MARGIN: f64 = 1e-10;

/// An edge is flipped only if the sine of the sum of the angles opposite to it is below minus this.
///
/// Sines are known to a few 1e-16 at best; without the margin, four points on a circle could be
/// flipped to and fro for ever.
pub const FLIP_SINE: f64 = 1e-14;

/// An edge is flipped only if its two cotangents sum to less than minus this share of the sum of the
/// inverse sines.
///
/// For angles that are not tiny the sharper of the two margins: it leaves the cells of a regular grid
/// as they are although their corners are rounded. A weight that stays negative by less is that
/// share of its cotangents at most, and is set to 0.
pub const FLIP_SHARE: f64 = 1e-12;

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

/// Share of the mean step below which a boundary edge is laid down as if it were that long.
///
/// Two boundary vertices at one place of the curve would make a triangle collapse; 1e-4 of a step
/// shows nowhere and is a million times the precision of the coordinates of a long boundary.
pub const BOUNDARY_STEP: f64 = 1e-4;

/// Height over length of the bow that a stretch of a rectangle's side gets where an inner edge cuts
/// it off.
///
/// A triangle there gets a height of a sixteenth of its base: flat to the eye, far from degenerate.
pub const SIDE_BOW: f64 = 1.0 / 16.0;

/// Share of the boundary's length over which its turning is averaged to find corners, either way,
/// and the least distance of two corners.
///
/// Long enough to see past the zigzag of single edges, short enough for a strip of 1 to 18.
pub const CORNER_WINDOW: f64 = 1.0 / 40.0;

/// Turning, in radians, that four corners must hold together to count as corners.
///
/// Half a turn: a rectangle's hold a whole one, any four stretches of a circle a tenth of it.
pub const CORNER_TURNING: f64 = std::f64::consts::PI;

/// A correction smaller than this share of the solution ends the refinement.
///
/// Corrections shrink by the condition number times rounding, so that the next one would be far
/// below the 1e-10 to which maps are compared.
pub const REFINED: f64 = 1e-11;

/// A last correction larger than this share of the solution says that the solution is not
/// determined: it is made of rounding errors.
///
/// Corrections of ordinary patches end below 1e-9 even with a million vertices.
pub const DETERMINED: f64 = 1e-6;

/// Relative accuracy of an eigenvector at which the iteration ends.
///
/// The step after it gains further digits; the residual is checked against [`LINEAR_RESIDUAL`].
pub const EIGENVECTOR: f64 = 1e-12;

/// What rounding leaves of a difference that should be zero, relative to its terms.
pub const ROUNDING: f64 = f64::EPSILON;

/// Area of a map over its Dirichlet energy below which it counts as collapsed to a line.
///
/// The share is 1 for a conformal map. Scaling such a map to a given area would only blow up
/// rounding errors.
pub const COLLAPSED_AREA: f64 = 1e-9;

/// Height of a triangle, over its longest side, up to which it counts as having no area.
///
/// Collinear points computed in double precision come out some 1e-16 off the line; scans and CAD
/// data in single precision hold true slivers down to about 1e-8.
pub const NO_AREA_HEIGHT: f64 = 1e-12;

/// Largest number of vertices in the disk that a curvature is averaged over.
///
/// An even sampling has some 40 within three mean edge lengths. Where the sampling is much finer
/// than on average, a bound keeps the cost linear; a disk of 300 vertices averages enough.
pub const DISK_VERTEX_LIMIT: usize = 300;

/// Curvature, times the radius of gyration of the surface, at which a bend is trusted half.
///
/// Bends nearly as wide as the surface itself are seldom what lines should follow, and on scans
/// their directions are noise.
pub const FLAT_CURVATURE: f64 = 1.2;

/// Length of the mean of unit vectors above which edges that meet agree on a direction.
///
/// Two edges of a smooth line that bends by 60° still agree as lines; three edges of a box corner
/// do not as crosses.
pub const AGREEING_EDGES: f64 = 0.5;

/// Length of a vector, diffused from unit vectors, below which it carries no direction.
///
/// Far below what guidance a hundred edges away leaves, far above rounding.
pub const NO_DIRECTION: f64 = 1e-12;

/// Mean weight of guidance up to which a field counts as unguided: that of curvature on a finely
/// sampled sphere, where it is nothing but the triangles.
pub const FAINT_GUIDANCE: f64 = 1e-2;

/// Mean change of unit vectors in one step below which a field is at rest.
///
/// A hundredth of a degree at the finest symmetry: no singularity moves any more.
pub const FIELD_AT_REST: f64 = 1e-4;

/// Length of the part along the surface of a unit vector at or below which it has no direction
/// there.
///
/// Below it the direction would be made of the rounding of a typed number or of a vertex normal.
pub const GUIDE_SLANT: f64 = 1e-6;

/// What the sum of a field's indices may miss the Euler characteristic by.
///
/// Rounding of the turns along a boundary of a million edges stays below 1e-9; the smallest real
/// miss is a quarter.
pub const INDEX_ROUNDING: f64 = 1e-6;

/// What the coordinates of a net may differ by between two triangles before they are made equal, in
/// line spacings.
///
/// Solvers leave 1e-9 of coordinates up to 1e4; a wrong transition misses by a good part of a line
/// spacing.
pub const GRID_AGREEMENT: f64 = 1e-4;

/// Area of a triangle in periodic coordinates, over the area wanted, below which it counts as nearly
/// inverted and is untangled.
///
/// At a half a triangle is squeezed as no field without singularities asks for; a few such triangles
/// rule the L² stretch of a whole map.
pub const NEARLY_INVERTED: f64 = 0.5;
