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

/// Longest side over the mean edge below which a triangle is mollified as if it were this large,
/// lest the product of its lengths underflow. No sensible model has such triangles.
pub const SMALLEST_TRIANGLE: f64 = DEGENERATE_HEIGHT * DEGENERATE_HEIGHT;

/// Part of an edge at right angles to a vertex normal, over the edge's length, up to which the edge
/// gives no direction in the tangent plane: half the digits of the edge are left.
pub const TANGENT_SLANT: f64 = 1e-8;

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

/// How far below zero the sum of the cotangents across from an edge must be for it to be exchanged in
/// flat pieces of a triangle.
///
/// Pieces of a grid have sums of exactly zero but for the rounding of midpoints, and either diagonal
/// will do.
pub const COTANGENT_FLIP: f64 = 1e-9;

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

/// Entries to which the factors of a scaled matrix may grow before rows are exchanged without
/// restriction: half of all digits.
pub const FACTOR_GROWTH: f64 = 1e8;

/// Shift of an eigenvalue problem, relative to the ratio of its two matrices' norms: large enough to
/// make the shifted matrix definite in spite of rounding, small against any eigenvalue that a mesh
/// can resolve.
pub const EIGENVALUE_SHIFT: f64 = 1e-9;

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

/// Width over height that a rectangle may have, and the inverse of the least one: a thousand times
/// more than any patch is drawn with, while areas and squares of lengths keep their digits.
pub const LARGEST_ASPECT: f64 = 1e6;

/// The refinement ends where the next correction would be smaller than this share of the solution:
/// far below the 1e-10 to which maps are compared.
pub const REFINED: f64 = 1e-11;

/// Share of the last correction above which the next one is no progress: refinement that does not
/// halve its correction is at the end of its digits.
pub const REFINEMENT_GAIN: f64 = 0.5;

/// A last correction larger than this share of the solution says that the solution is not
/// determined: it is made of rounding errors.
///
/// Corrections of ordinary patches end below 1e-9 even with a million vertices.
pub const DETERMINED: f64 = 1e-6;

/// Area of a patch, over its squared extent, below which thinness explains that its conformal energy
/// has no digits left: that energy's condition grows with the fourth power of length over width.
pub const THIN_AREA: f64 = 1e-3;

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

/// Width of a hole, over its length, up to which it is a crack that repair closes: some roundings of
/// single precision, in which most files with such holes are written.
pub const CRACK_WIDTH: f64 = 1e-6;

/// Height of a triangle, over its longest side, up to which it counts as having no area.
///
/// Collinear points computed in double precision come out some 1e-16 off the line; scans and CAD
/// data in single precision hold true slivers down to about 1e-8.
pub const NO_AREA_HEIGHT: f64 = 1e-12;

/// Largest radius of the disk that a curvature is averaged over, in the mean lengths of the edges
/// around its middle.
///
/// An even sampling has some 60 vertices in such a disk, which average enough; where the sampling is
/// much finer than on average, the bound keeps the cost linear.
pub const FINE_DISK: f64 = 4.0;

/// Largest number of vertices in the disk that a curvature is averaged over.
///
/// A second bound, for triangles so uneven that the lengths of edges say little of their number.
pub const DISK_VERTEX_LIMIT: usize = 300;

/// Curvature, times the radius of gyration of the surface, at which a bend is trusted half.
///
/// Bends nearly as wide as the surface itself are seldom what lines should follow, and on scans
/// their directions are noise.
pub const FLAT_CURVATURE: f64 = 1.2;

/// Confidence in a direction of curvature, `(max - min)² / (max² + min²)`, up to which the surface
/// counts as umbilic.
///
/// Over disks of three edges the two curvatures of a sphere come out up to a twelfth apart on an even
/// sampling, which is a confidence of 0.004. Without this bound such errors add up on fine spheres to
/// dozens of singularities.
pub const UMBILIC_CONFIDENCE: f64 = 0.01;

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
pub const FAINT_GUIDANCE: f64 = 3e-2;

/// Mean change of unit vectors in one step below which a guided field is at rest.
///
/// A seventieth of a degree at the finest symmetry: no singularity moves any more.
pub const FIELD_AT_REST: f64 = 1e-3;

/// The same where nothing guides the field: its singularities spread slowly over long distances.
pub const FREE_FIELD_AT_REST: f64 = 1e-4;

/// Mean change of unit vectors in one sweep over them below which a field is at rest: sweeps move it
/// by less than steps of diffusion do.
pub const SWEPT_FIELD_AT_REST: f64 = 3e-4;

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

/// Width of the interval of λ at which the search for the best combination of two maps ends.
///
/// A minimum is flat: values differ by the square of this, which is rounding.
pub const SEARCHED_LAMBDA: f64 = 1e-8;

/// Relative gain of a step below which a descent counts as resting.
///
/// What is left to gain is of the same size: no picture shows it.
pub const DESCENT_AT_REST: f64 = 1e-6;

/// Cosine of the angle between the normals of a quad and of the surface at its corners, 60°, beyond
/// which no quad is turned any further: it would begin to cut off a tip.
pub const FACING_QUAD: f64 = 0.5;

/// Cosine of the turn from which on a line has a corner: 45°. Below that, a vertex that slides past
/// cuts off less than a tenth of its step.
pub const LINE_CORNER_COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Scaled Jacobian below which a quad must never become worse, and is searched for a better place
/// vertex by vertex: what solvers ask of quads at least.
pub const POOR_QUAD: f64 = 0.3;

/// Scaled Jacobian below which the polygons around a quad are cut anew when moving vertices did not
/// help: solvers take a quad of 0.2, and every change costs irregular vertices.
pub const MENDED_QUAD: f64 = 0.2;

/// Length of an arc, over the side of a cell, up to which it is contracted to a feature or to the
/// boundary: what stays on either side of the line is larger than what went.
pub const SNAP_TO_LINE: f64 = 0.4;

/// Share of the triangles that rounding flips, from which on features are in the way of the net.
///
/// Maps that can be untangled have up to 0.02; where features have no room it is 0.08 and more.
pub const CRUMPLED_SHARE: f64 = 0.03;

/// The same share, no feature being left, from on which it is the field itself that has more
/// singularities than the net has room for.
pub const HOPELESS_SHARE: f64 = 0.05;

/// Scaled Jacobian below which the worst corner of a quad counts more than the mean.
pub const FAIR_QUAD: f64 = 0.6;

/// How far before the corner of a line a vertex stays that slides towards it, over the length of the
/// edge there: nothing beside a quad, yet off the corner, from where it could not leave.
pub const BEFORE_CORNER: f64 = 0.01;

/// Step of a vertex, over the mean length of its edges, below which it has found its place: far
/// below what shows in an angle.
pub const VERTEX_AT_REST: f64 = 5e-3;

/// Area of a corner over that of the rectangle on its sides at which it counts as inverted: an
/// angle of 1°.
pub const FLAT_CORNER: f64 = 0.02;

/// What the coordinates of a net may differ by between two triangles before they are made equal, in
/// line spacings.
///
/// Solvers leave 1e-9 of coordinates up to 1e4; a wrong transition misses by a good part of a line
/// spacing.
pub const GRID_AGREEMENT: f64 = 1e-4;

/// What the sum of barycentric coordinates may miss 1 by: they are often typed with a few digits.
pub const BARYCENTRIC_SUM: f64 = 1e-6;

/// What told turning angles may miss a full turn by, in radians: typed degrees with a few digits.
pub const ANGLE_SUM: f64 = 1e-6;

/// Share of its length below which closing a curve does not shorten an edge.
///
/// Shorter ones would crowd the triangles behind them; negative ones would fold the boundary.
pub const LEAST_CLOSING_SHARE: f64 = 0.1;

/// Least curvature of a triangle's energy, per area, for any change of its map's matrix.
///
/// Energies of isometric maps have curvatures of 2 to 8. This one is what keeps the Newton matrix
/// definite where the energy does not see a change, as a turn of the whole map.
pub const LEAST_CURVATURE: f64 = 1e-6;

/// Share of the way to the first collapse of a triangle that a step may go.
///
/// A tenth of the area is left at most ways; further shares only make the next step harder.
pub const SHARE_TO_COLLAPSE: f64 = 0.9;

/// What a step must gain of the decrease that the gradient foretells (Armijo's rule).
pub const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Damping of a Newton matrix that is not definite to rounding, as a share of its diagonal; raised
/// a thousandfold until it is.
pub const NEWTON_DAMPING: f64 = 1e-12;

/// Side, at unit extent, given to a triangle all of whose corners fell together when a patch was
/// made coarse: shorter than anything that shows, with squares far from underflow.
pub const SHORTEST_SIDE: f64 = 1e-9;

/// How much a triangle that closes a hole counts beside one of the surface.
///
/// Only its sign matters; at a hundredth it does not pull at the rim.
pub const HOLE_IMPORTANCE: f64 = 1e-2;

/// Share of the energy that the next Newton step must promise for the descent to go on.
///
/// Half a millionth: the fifth digit of a mean distortion stands.
pub const INJECTIVE_GAIN: f64 = 1e-6;

/// Share of the length of boundary edges within which boundaries push each other away.
///
/// Neighbouring vertices, an edge apart, do not notice each other; a gap of this width shows at the
/// scale of single triangles only.
pub const BARRIER_REACH: f64 = 0.25;

/// How stiff the distance to an obstacle is that a step is led around, beside the Newton matrix at
/// its vertices.
///
/// Enough for the distance to shrink by about what it is asked to; a thousand would cost digits.
pub const OBSTACLE_STIFFNESS: f64 = 10.0;

/// What the push of boundaries counts beside the distortion of an area as wide as their gap.
pub const BARRIER_WEIGHT: f64 = 1.0;

/// Weight, against those of edges near 1, with which an angle keeps its value where nothing else
/// determines it: the common angle of a component that nothing guides.
///
/// It bends a field by a millionth of its turns, and leaves the solution ten digits.
pub const ANGLE_ANCHOR: f64 = 1e-6;

/// Least and greatest weight of an edge where directions are carried along the surface's own
/// triangles. The weights of good triangles are near one half; that of an obtuse corner is negative,
/// that of a needle has no bound.
pub const EDGE_WEIGHT_RANGE: [f64; 2] = [0.02, 50.0];

/// Share of a step by which a field may turn along an edge where its jumps are prescribed. At half
/// a step the jump would be another one; the margin is for those who compute it again.
pub const WIDEST_TURN: f64 = 0.49;

/// Step of a field's diffusion, in mean vertex areas: long enough to carry directions over some ten
/// edges a step, short enough that the normalisation keeps up.
pub const DIFFUSION_STEP: f64 = 0.02;

/// How much longer than its radius the paths along edges may be that make up a geodesic disk.
///
/// They are up to 15 % longer than the surface's own distances on good triangles, and longer still
/// on slanted ones; the way round the rim of a wall as thin as the radius is twice as long.
pub const DISK_DETOUR: f64 = 1.3;

/// Distance of a stroke from a vertex, in mean edge lengths, up to which it says something of the
/// field there. One on the surface is within one edge length even of coarse places.
pub const STROKE_REACH: f64 = 2.0;

/// Distance from the ends of an edge, over its length, that lines crossing it keep, so that they
/// cross one edge at a time and never meet a vertex: invisible, and far above rounding.
pub const EDGE_END: f64 = 1e-9;

/// Relative difference up to which two paths on a surface count as equally long: those of mirror
/// images differ by rounding, far less, and others by chance hardly ever so little.
pub const LIKE_LENGTHS: f64 = 1e-9;

/// Vertices of the surface per quad from which on its curvature counts less for the field: with all
/// its weight a field turns from one direction to another over some two edges, and so does it over the
/// same part of a quad's side then, however fine the triangles. Details smaller than quads only make
/// singularities that these have no room for. From 5 on, scans of 100 000 triangles and more would
/// keep a third more of them; from 1 on, a torus of long thin triangles would get some that it does
/// not need.
pub const FOLLOWING_VERTICES_PER_QUAD: f64 = 2.5;

/// The angle, in radians, that a change of lengths adds at most to how a field turns along an edge. The
/// sides of quads change by a quarter from one to the next where they change fast, and edges are no
/// longer than sides: they turn by less.
pub const WIDEST_GRADED_TURN: f64 = std::f64::consts::FRAC_PI_8;

/// By how much the side of a quad grows over its own length at most, however fast the sizes asked
/// for grow: four rows from one size to twice as much.
pub const GROWTH_OF_SIDES: f64 = 0.25;

/// Share of a step by which a field may turn along an edge for its jump to be read off its angles:
/// above what is aimed at, below half a step by far more than rounding.
pub const WIDEST_TURN_READ: f64 = 0.499;

/// Height over longest side below which an optimised map lets no triangle fall.
///
/// Moving and scaling the coordinates, or writing ten digits of them, turns flatter triangles over.
pub const FLATTENED_HEIGHT: f64 = 1e-9;

/// Similarity of a triangle to its image, 1 for a similar one and 0 for a collapsed one, below which
/// an optimised boundary is kept from squeezing it further.
///
/// Triangles three times as bad are seldom wanted; those better than this cost nothing.
pub const GUARDED_SHAPE: f64 = 0.1;

/// Weight of what keeps triangles from being squeezed, beside a mean over edges or triangles.
///
/// Small enough to leave minima where they are to two digits.
pub const GUARD_WEIGHT: f64 = 1e-2;

/// Distance of two maps, over their extent, up to which they count as one.
///
/// Ten times what solves of ill-conditioned patches leave; combining maps that differ by less would
/// only multiply rounding.
pub const ONE_MAP: f64 = 1e-10;

/// Share of the energy of a chart on its square that a step promises to gain for the descent to go on:
/// a tenth of what is seen in a texture.
pub const CHART_GAIN: f64 = 1e-3;

/// A chart on which the mean symmetric Dirichlet energy of the net's coordinates, 4 at least, is more is
/// laid anew on its rectangle: as much as if all of it were stretched to twice its length.
pub const SQUEEZED_CHART: f64 = 8.0;

/// An arc along which the net's coordinates are so much squeezed and stretched gets its length as
/// parameter: the mean of the squares of both, 1 at least, of steps three times too short and too long.
pub const SQUEEZED_ARC: f64 = 5.0;

/// Area of a cell of the net over that of the polygon round it above which the cell is cut up.
///
/// A half sphere has 2: the end of a round limb is shown well enough by its rim. A finger that sticks
/// out by more than its width is not.
pub const BULGING_CELL: f64 = 2.5;

/// Area of the parts of a cell that was cut up, at most, in ordinary cells.
pub const SPLIT_CELL_AREA: f64 = 1.3;

/// What an arc may lead along its line, in line spacings, to count as leading nowhere.
///
/// Between lattice points it is a whole number, up to rounding of a thousand pieces.
pub const NO_ADVANCE: f64 = 0.25;

/// How far an arc along the boundary or a feature may leave the straight line between its ends, over
/// the length of that line.
///
/// The height of an arc of a circle that turns by 90° is 0.21 of its chord.
pub const ARC_HEIGHT: f64 = 0.2;

/// The same for an arc that is a side of the net, between two lattice points: its place in the middle
/// makes two pentagons of two quads. A bend of 60° stays one side, a right angle does not.
pub const SIDE_HEIGHT: f64 = 0.35;

/// Cosine of the turn at a node between two arcs up to which they are one line: 45°.
pub const STRAIGHT_COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The number of parts, at least, that a cell is cut into which is no disk or stands out of the net.
///
/// Three round and four along a limb show its direction and its length.
pub const FEWEST_PARTS: f64 = 12.0;

/// Cotangent above which a triangle counts less in the energy of a net, so that none exceeds it.
///
/// Needles down to an angle of a hundredth of a degree count in full; thinner ones would only eat up
/// the digits of their neighbours.
pub const NEEDLE_COTANGENT: f64 = 1e4;

/// Weight in the energy of a net that the sides of thinner triangles have beside that of their
/// cotangents.
///
/// A ring of such triangles round a neck of no width couples what is on either side of it by less than
/// the rounding of [`NEEDLE_COTANGENT`], 1e-12, and the matrix is singular; this is far above that, and
/// far below what a needle of a hundredth of a degree has across, 1e-4.
pub const LEAST_NEEDLE_WEIGHT: f64 = 1e-8;

/// Distance over the size of a polygon below which two points of it are one: rounding of positions
/// of single precision is a hundred times smaller.
pub const SAME_POINT: f64 = 1e-5;

/// Difference of two values of a corner attribute, over the largest value, below which they are
/// one: less than files of six digits keep.
pub const SAME_VALUE: f64 = 1e-6;

/// Distance of two singularities of opposite sign, in sides of the quads to come, up to which they
/// cancel.
///
/// The net rounds their difference to whole sides: so close to each other they are drawn apart or
/// pushed together by a large share of it, and quads between them suffer.
pub const CLOSE_PAIR_IN_QUADS: f64 = 2.0;

/// Length of a line of sharp edges, in sides of the quads wanted, below which it is no feature of
/// theirs: not even the shortest loop would go round with four quads on either side.
pub const SHORTEST_FEATURE_IN_QUADS: f64 = 4.0;

/// Length of a line of sharp edges, in sides of the quads wanted, from which on it is a feature
/// however few edges it has.
pub const LONG_FEATURE_IN_QUADS: f64 = 8.0;

/// Angle at an edge beside a line of sharp edges, over the angle at which edges are sharp, from which
/// on it puts the line in doubt.
pub const FOLD_BESIDE_FEATURE: f64 = 0.5;

/// Length of a line of sharp edges over that of the same with the folded edges beside it, from which
/// on it is a feature. Lines on parts drawn by engineers have 0.8 and more, those that come by chance
/// on animals of few triangles 0.4 to 0.7.
pub const CLEAR_FEATURE: f64 = 0.75;

/// Longest edge of a triangle, in sides of the quads wanted, that is not cut before they are laid.
///
/// Field and map are linear in a triangle: quads much smaller than it could only be sheared copies of
/// each other, and corners of a cube of twelve triangles would have no room for a singularity.
pub const LONGEST_EDGE_IN_QUADS: f64 = 1.0;

/// Shortest side over the mean one for whose sake triangles are cut: below it the triangles of the
/// other quads would be more than all others.
pub const SHORTEST_SIDE_REFINED: f64 = 0.25;

/// The angle in radians that counts of what a surface bends by over the side of a quad: quads know
/// nothing of sharper bends.
pub const SHARPEST_BEND_IN_QUADS: f64 = 1.0;

/// Twice the distance, in sides of quads, over which these change size where the surface bends: each
/// change takes irregular vertices or shear, and two quads leave room for either.
pub const FADING_IN_QUADS: f64 = 4.0;

/// What the confidence in a direction of curvature is multiplied by for quads that are stretched along
/// it: on a tube, where nothing is clearer, it is a little above a half.
pub const SURE_DIRECTION: f64 = 2.0;

/// Times the least energy above which a map without overlaps is taken to be jammed. Maps of real
/// models along seams of any length stay below 1.2; jammed ones reach tens and thousands.
pub const JAMMED_ENERGY: f64 = 1.5;

/// Times the least energy above which a coarse map without overlaps is not refined where the patch may be
/// cut instead. On real models the coarse maps of those that come to rest stay below 2.
pub const JAMMED_COARSE_ENERGY: f64 = 3.0;

/// Times the least energy above which the seam of a map that may overlap is led on to the places of
/// most distortion. Maps of real models stay below 1.2; only those of a few triangles, whose corners
/// the curvature of conformal maps sees too late, reach it.
pub const STRAINED_ENERGY: f64 = 1.25;

/// How often a seam is made shorter, each time by doubling the change of lengths that is let be, for a
/// map that is jammed.
pub const SHORTER_SEAMS: usize = 3;

/// The most that fins may have of a surface's area to be dropped: with more, they are what it is made
/// of, as the leaves of a tree are.
pub const MOST_FINS: f64 = 0.01;

/// A component with poor quads gets its triangles, each cut into three, if it has no more quads and
/// no more triangles than this: few enough that no net is seen in them.
pub const SMALL_COMPONENT: usize = 12;

/// The same where the net has inverted quads: a few hundred quads more than asked for are better than
/// one that no solver can use.
pub const CRUMPLED_COMPONENT: usize = 100;

/// Triangles that cutting may add for each quad wanted.
///
/// Round triangles need about 5; this leaves room for slender ones, and keeps a model of long
/// needles from taking all memory.
pub const TRIANGLES_PER_QUAD: f64 = 20.0;

/// Share by which the number of quads may miss the number asked for.
pub const COUNT_MISS: f64 = 0.03;

/// Maps that are made, at most, to meet the number of quads asked for.
///
/// Cells of a map come near the number at once; what is cut or joined after that is a share that
/// hardly changes, so that one correction does it. Few cells come in steps that may step over the
/// number.
pub const FAIR_COUNT_ROUNDS: usize = 4;

/// Area of a triangle in a net, over that wished for, up to which it counts as flipped.
///
/// Coordinates of a net are rounded to 2^-32 of a line spacing; triangles of a thousandth of a cell
/// keep their orientation with a wide margin.
pub const FLAT_IN_NET: f64 = 1e-5;

/// Distortion of a triangle in a net above which it is squeezed: (|J|² + det² + 1) / det is 4 where it is
/// as wished, and this where it has a tenth of its width.
pub const SQUEEZED_IN_NET: f64 = 20.0;

/// Area of a triangle in periodic coordinates, over the area wanted, below which it counts as nearly
/// inverted and is untangled.
///
/// At a half a triangle is squeezed as no field without singularities asks for; a few such triangles
/// rule the L² stretch of a whole map.
pub const NEARLY_INVERTED: f64 = 0.5;

/// Areas of refined triangles miss those of the input by this share at most: rounding of positions
/// interpolated, over a million triangles.
pub const LAYOUT_AREA: f64 = 1e-9;

/// Coordinates of a chart laid out triangle by triangle agree to this, in sides of a chart: far above
/// rounding over a million triangles, far below the size of any triangle.
pub const CHART_AGREEMENT: f64 = 1e-8;

/// Lines of a layout that pass by a vertex at this share of an edge or less pass through it: small
/// beside a chart, large enough that triangles cut off by arcs are no needles.
pub const SNAPPED_SHARE: f64 = 0.02;

/// A triangle of which less than this share would be left in the map is a reason not to move a vertex
/// onto a line: what it is squeezed by counts in stretch.
pub const LEAST_SNAPPED_AREA: f64 = 0.25;

/// Nodes on an edge are this share of its length apart at least, where there is room. As coordinates on
/// lines stay whole where nodes are moved apart, the triangles between are squeezed: it is as small as
/// triangles that are no needles to double precision allow.
pub const SPREAD_SHARE: f64 = 1e-3;

/// Lines of a layout move by this share of a chart's side at most to pass through a vertex, where
/// triangles are larger than charts.
pub const SNAPPED_CHART: f64 = 0.05;

/// Nodes on an edge are this share of their mean distance apart, at least, where many lines cross it.
pub const NODE_GAP: f64 = 0.1;

/// How near to a vertex of an arc the corner of a square may lie to be put on it, in lengths of the arc:
/// above rounding, and far below what both sides of the arc may disagree by.
pub const SAME_ARC_PLACE: f64 = 1e-10;

/// The shortest step along an arc, over its length: a step of no length in space still gets room for
/// the triangles beside it.
pub const SHORTEST_ARC_STEP: f64 = 1e-7;

/// What a length in spacings of the net may miss a whole number by: above the rounding of lines cut
/// at a thousand edges, far below the smallest part of a spacing that a chart is cut at.
pub const WHOLE_LENGTH: f64 = 1e-6;

/// Weight of a whole equation of a net where it is a spring, beside cotangent weights.
///
/// What it gives way by is a hundred-thousandth of a line spacing: no matter for rounding, and the
/// matrix keeps ten of its sixteen digits.
pub const STIFF_EQUATION: f64 = 1e5;

/// Extents whose squares and inverse squares are far from overflow.
pub const MEASURABLE_EXTENTS: std::ops::RangeInclusive<f64> = 1e-140..=1e140;

/// The least extent of a component over that of the surface for it to be remeshed with the others:
/// four of sixteen digits are left for it.
pub const LEAST_COMPONENT_EXTENT: f64 = 1e-12;
