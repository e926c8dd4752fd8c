//! Points of a patch that are to lie at given places: [DMA02] §4.1.
//!
//! [DMA02]: crate::papers::DMA02

use faer::c64;
use glam::{DVec2, DVec3};

use crate::mesh::{Element, HalfedgeId, SurfacePoint, VertexId};
use crate::solve::{
    BorderedSystem, Placement, SaddleSolution, SaddleSystem, SolveError, SparseMatrix,
    SymmetricMatrix,
};
use crate::tolerance::{BARYCENTRIC_SUM, DEPENDENT_CONSTRAINT};
use crate::watch::Watch;

use super::conformal::Triangulation;
use super::domain::Domain;
use super::energy::complex;
use super::equations::{Equations, index_pairs};
use super::fixed::{open_holes, sorted};
use super::flat_map::MapDraft;
use super::{
    BoundaryPositions, FixedOptions, FlatMap, FlattenError, Holes, Method, Patch, PatchPointError,
};

/// How strictly a constraint is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Strength {
    /// Exactly: by a Lagrange multiplier.
    #[default]
    Hard,
    /// By a spring with this weight, over the mean weight that a vertex has in the equations.
    Soft(f64),
}

/// A point of the patch that is to lie at a place of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointConstraint {
    /// The point.
    pub point: SurfacePoint,
    /// Its place, in the surface's unit of length.
    pub place: DVec2,
    /// How strictly.
    pub strength: Strength,
}

impl PointConstraint {
    /// A hard constraint.
    #[must_use]
    pub fn hard(point: SurfacePoint, place: DVec2) -> Self {
        Self {
            point,
            place,
            strength: Strength::Hard,
        }
    }

    /// A hard constraint on a vertex.
    ///
    /// # Errors
    /// [`FlattenError::NoSuchPin`].
    pub fn at_vertex(patch: &Patch, vertex: VertexId, place: DVec2) -> Result<Self, FlattenError> {
        let vertices = patch.mesh().vertex_count();
        if vertex.index() >= vertices {
            return Err(FlattenError::NoSuchPin { vertex, vertices });
        }
        let corner = patch.mesh().vertex_halfedge(vertex);
        Ok(Self::hard(SurfacePoint::at_corner(corner), place))
    }
}

/// A map under constraints.
#[derive(Clone, Debug)]
pub struct ConstrainedMap {
    /// The map.
    pub map: FlatMap,
    /// Numbers of the hard constraints that follow from others and from the boundary.
    pub redundant: Vec<usize>,
    /// How far each point lies from its place, in the surface's unit of length.
    pub misses: Vec<f64>,
}

/// The map with this boundary ([`fixed_map`](super::fixed_map)) in which given points come to given
/// places ([DMA02] §4.1, constraints).
///
/// The equations of the vertices are bent by one multiplier per coordinate of each hard constraint,
/// which acts on the corners of its triangle by their barycentric coordinates. Constraints that
/// follow from others are left out, contradictory ones refused. Flips are not excluded; the result
/// counts them.
///
/// Cost: one factorisation of the mesh's size.
///
/// # Errors
/// [`FlattenError`]; [`FlattenError::ContradictoryConstraint`] and
/// [`FlattenError::BadPoint`] name the constraint.
///
/// [DMA02]: crate::papers::DMA02
pub fn constrained_fixed_map(
    patch: &Patch,
    boundary: &BoundaryPositions,
    constraints: &[PointConstraint],
    options: &FixedOptions,
    watch: &Watch,
) -> Result<ConstrainedMap, FlattenError> {
    let _stage = watch.stage("constrained map with fixed boundary");
    let rows = Rows::new(patch, constraints)?;
    let open = open_holes(patch, boundary);
    let closed = if options.holes == Holes::Closed {
        &open[..]
    } else {
        &[]
    };
    let mut domain = Domain::with_cones(patch, closed)?;
    let equations = Equations::new(&mut domain, options.weights, watch)?;
    watch.check()?;
    let stage = watch.stage("order, factor and solve");
    let (vertices, places) = sorted(boundary);
    let fixed = vertices.iter().zip(&places);
    let fixed = fixed.map(|(vertex, place)| (vertex.index(), *place / patch.unit_length()));
    let system = FreeSystem::new(&domain, &equations, fixed.collect(), &rows);
    let (positions, solved, redundant) = system.solve(equations.is_symmetric(), &rows)?;
    drop(stage);
    let positions: Vec<c64> = positions.into_iter().map(complex).collect();
    let intrinsic_flips = domain.intrinsic_flips(&positions);
    let draft = MapDraft {
        positions,
        method: options.weights.method(),
        residual: solved.residual,
        flip_free_in_theory: false,
        intrinsic_flips,
    };
    rows.finish(patch, draft, redundant, watch)
}

/// The natural conformal map ([`natural_map`](super::natural_map)) in which given points come to
/// given places: the map of least conformal energy under these constraints.
///
/// Two points at least must be told their places, or nothing fixes rotation and scale. The map is
/// not scaled.
///
/// Cost: one symmetric indefinite factorisation with two unknowns per vertex.
///
/// # Errors
/// As [`constrained_fixed_map`]; [`FlattenError::TooFewConstraints`].
pub fn constrained_natural_map(
    patch: &Patch,
    constraints: &[PointConstraint],
    triangulation: Triangulation,
    watch: &Watch,
) -> Result<ConstrainedMap, FlattenError> {
    let _stage = watch.stage("constrained natural map");
    let rows = Rows::new(patch, constraints)?;
    let domain = Domain::conformal(patch, triangulation, watch)?;
    let (matrix, loads) = conformal_system(&domain, &rows)?;
    watch.check()?;
    let stage = watch.stage("order, factor and solve");
    let hard = rows.interleaved();
    let border = SparseMatrix::from_triplets(2 * rows.hard.len(), matrix.order(), hard.entries)?;
    let placement = Placement::at(&domain.coordinates).with_block(2);
    let system = SaddleSystem::new(&matrix, &border, placement)?;
    let redundant = system.redundant();
    rows.check_enough(redundant.len() / 2)?;
    let solved = system.solve(&loads, &hard.targets);
    let solved = solved.map_err(|error| rows.named(error, |row| row / 2))?;
    drop(stage);
    let positions = solved.values.chunks_exact(2);
    let positions: Vec<c64> = positions.map(|uv| c64::new(uv[0], uv[1])).collect();
    let intrinsic_flips = domain.intrinsic_flips(&positions);
    let draft = MapDraft {
        positions,
        method: Method::NaturalConformal,
        residual: solved.residual,
        flip_free_in_theory: false,
        intrinsic_flips,
    };
    let redundant = redundant.iter().filter(|row| *row % 2 == 0);
    let redundant = redundant.map(|row| rows.hard[row / 2]).collect();
    rows.finish(patch, draft, redundant, watch)
}

/// The points of constraints as rows over vertices, in unit lengths.
struct Rows {
    points: Vec<Row>,
    /// Numbers of the hard constraints.
    hard: Vec<usize>,
    unit_length: f64,
}

struct Row {
    /// The vertices whose mean the point is, with their weights; none is 0.
    weights: Vec<(usize, f64)>,
    place: DVec2,
    strength: Strength,
}

/// Hard rows of both coordinates in one system: rows and unknowns by vertex, then by coordinate.
struct Interleaved {
    entries: Vec<(usize, usize, f64)>,
    targets: Vec<f64>,
}

impl Rows {
    fn new(patch: &Patch, constraints: &[PointConstraint]) -> Result<Self, FlattenError> {
        let mut rows = Vec::with_capacity(constraints.len());
        for (number, constraint) in constraints.iter().enumerate() {
            let bad = |reason| FlattenError::BadPoint {
                constraint: number,
                reason,
            };
            check(patch, constraint).map_err(bad)?;
            let corners = patch.mesh().triangle(constraint.point.face);
            let weights = corners.map(Element::index).into_iter();
            let weights = weights.zip(constraint.point.barycentric);
            rows.push(Row {
                weights: weights.filter(|(_, weight)| *weight != 0.0).collect(),
                place: constraint.place / patch.unit_length(),
                strength: constraint.strength,
            });
        }
        let is_hard = |row: &usize| rows[*row].strength == Strength::Hard;
        let hard = (0..rows.len()).filter(is_hard).collect();
        let unit_length = patch.unit_length();
        Ok(Self {
            points: rows,
            hard,
            unit_length,
        })
    }

    /// The soft rows, their weights multiplied by `stiffness`.
    fn springs(&self, stiffness: f64) -> impl Iterator<Item = Spring<'_>> {
        self.points
            .iter()
            .filter_map(move |row| match row.strength {
                Strength::Soft(weight) => Some(Spring {
                    row,
                    stiffness: weight * stiffness,
                }),
                Strength::Hard => None,
            })
    }

    fn interleaved(&self) -> Interleaved {
        let (mut entries, mut targets) = (Vec::new(), Vec::new());
        for (place, &number) in self.hard.iter().enumerate() {
            let row = &self.points[number];
            for axis in 0..2 {
                let weights = row.weights.iter();
                entries.extend(weights.map(|&(v, w)| (2 * place + axis, 2 * v + axis, w)));
                targets.push(row.place[axis]);
            }
        }
        Interleaved { entries, targets }
    }

    /// Whether rotation and scale of a natural map are fixed.
    fn check_enough(&self, redundant: usize) -> Result<(), FlattenError> {
        let different = self.points.len() - redundant;
        if different >= 2 {
            return Ok(());
        }
        Err(FlattenError::TooFewConstraints { different })
    }

    /// The error with the number that the caller gave the constraint.
    fn named(&self, error: SolveError, place: impl Fn(usize) -> usize) -> FlattenError {
        match error {
            SolveError::ContradictoryConstraint {
                row,
                implied,
                asked,
            } => FlattenError::ContradictoryConstraint {
                constraint: self.hard[place(row)],
                distance: (implied - asked).abs() * self.unit_length,
            },
            SolveError::EmptyConstraint { row, asked } => FlattenError::ContradictoryConstraint {
                constraint: self.hard[place(row)],
                distance: asked.abs() * self.unit_length,
            },
            other => other.into(),
        }
    }

    fn finish(
        &self,
        patch: &Patch,
        mut draft: MapDraft,
        redundant: Vec<usize>,
        watch: &Watch,
    ) -> Result<ConstrainedMap, FlattenError> {
        draft.positions.truncate(patch.mesh().vertex_count());
        let misses = self.points.iter().map(|row| {
            let weights = row.weights.iter();
            let point: c64 = weights.map(|&(v, w)| draft.positions[v] * w).sum();
            (point - complex(row.place)).norm() * patch.unit_length()
        });
        Ok(ConstrainedMap {
            misses: misses.collect(),
            redundant,
            map: draft.finish(patch, watch)?,
        })
    }
}

fn check(patch: &Patch, constraint: &PointConstraint) -> Result<(), PatchPointError> {
    let SurfacePoint { face, barycentric } = constraint.point;
    let faces = patch.mesh().face_count();
    if face.index() >= faces {
        return Err(PatchPointError::NoSuchTriangle { face, faces });
    }
    let sum: f64 = barycentric.iter().sum();
    if (sum - 1.0).abs() > BARYCENTRIC_SUM || barycentric.iter().any(|b| !b.is_finite()) {
        return Err(PatchPointError::NotBarycentric { barycentric });
    }
    if !constraint.place.is_finite() {
        let place = constraint.place.to_array();
        return Err(PatchPointError::NonFinitePlace { place });
    }
    match constraint.strength {
        Strength::Soft(weight) if !(weight > 0.0 && weight.is_finite()) => {
            Err(PatchPointError::BadWeight { weight })
        }
        _ => Ok(()),
    }
}

/// A spring between a point and its place.
struct Spring<'a> {
    row: &'a Row,
    stiffness: f64,
}

impl Spring<'_> {
    /// What it adds to the matrix.
    fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let weights = &self.row.weights;
        weights.iter().flat_map(move |&(i, a)| {
            let others = weights.iter();
            others.map(move |&(j, b)| (i, j, self.stiffness * a * b))
        })
    }

    /// What it adds on the right.
    fn loads(&self) -> impl Iterator<Item = (usize, DVec2)> + '_ {
        let weights = self.row.weights.iter();
        weights.map(|&(i, a)| (i, self.row.place * (self.stiffness * a)))
    }
}

/// The equations of the free vertices once the fixed ones have their places.
struct FreeSystem {
    /// Free vertices, ascending, and where they lie in space.
    free: Vec<usize>,
    coordinates: Vec<DVec3>,
    entries: Vec<(usize, usize, f64)>,
    /// Both coordinates, one after the other.
    loads: Vec<f64>,
    constraints: Vec<(usize, usize, f64)>,
    targets: Vec<f64>,
    /// The positions of the fixed vertices; those of the free ones are zero.
    positions: Vec<DVec2>,
}

impl FreeSystem {
    fn new(
        domain: &Domain,
        equations: &Equations,
        fixed: Vec<(usize, DVec2)>,
        rows: &Rows,
    ) -> Self {
        let order = domain.mesh.vertex_count();
        let mut positions = vec![DVec2::ZERO; order];
        let mut is_fixed = vec![false; order];
        for (vertex, place) in fixed {
            positions[vertex] = place;
            is_fixed[vertex] = true;
        }
        let free: Vec<usize> = (0..order).filter(|&v| !is_fixed[v]).collect();
        let mut place_of = vec![None; order];
        for (place, &vertex) in free.iter().enumerate() {
            place_of[vertex] = Some(place);
        }
        let mut entries = equations.entries();
        let stiffness = mean_diagonal(order, entries.iter().copied());
        let mut forces = vec![DVec2::ZERO; order];
        for spring in rows.springs(stiffness) {
            entries.extend(spring.entries());
            for (vertex, load) in spring.loads() {
                forces[vertex] += load;
            }
        }
        let mut inner = Vec::with_capacity(entries.len());
        for (row, column, value) in entries {
            match (place_of[row], place_of[column]) {
                (Some(row), Some(column)) => inner.push((row, column, value)),
                (Some(_), None) => forces[row] -= positions[column] * value,
                (None, _) => {}
            }
        }
        let [us, vs] = [0, 1].map(|axis| free.iter().map(move |&v| (v, axis)));
        let loads = us.chain(vs).map(|(vertex, axis)| forces[vertex][axis]);
        let mut system = Self {
            coordinates: free.iter().map(|&v| domain.coordinates[v]).collect(),
            entries: inner,
            loads: loads.collect(),
            constraints: Vec::new(),
            targets: Vec::new(),
            free,
            positions,
        };
        system.constrain(rows, &place_of);
        system
    }

    /// The hard rows, without the fixed vertices' share.
    fn constrain(&mut self, rows: &Rows, place_of: &[Option<usize>]) {
        let mut targets = Vec::with_capacity(rows.hard.len());
        for (number, &hard) in rows.hard.iter().enumerate() {
            let row = &rows.points[hard];
            let mut target = row.place;
            for &(vertex, weight) in &row.weights {
                match place_of[vertex] {
                    Some(place) => self.constraints.push((number, place, weight)),
                    None => target -= self.positions[vertex] * weight,
                }
            }
            // What rounding leaves of a difference must not contradict.
            let size = row.place.abs().max_element() * DEPENDENT_CONSTRAINT;
            targets.push(target.map(|t| if t.abs() <= size { 0.0 } else { t }));
        }
        self.targets = targets.iter().map(|t| t.x).collect();
        self.targets.extend(targets.iter().map(|t| t.y));
    }

    /// All positions, the solution they come from, and the constraints left out.
    fn solve(
        mut self,
        symmetric: bool,
        rows: &Rows,
    ) -> Result<(Vec<DVec2>, SaddleSolution, Vec<usize>), FlattenError> {
        let order = self.free.len();
        let border =
            SparseMatrix::from_triplets(rows.hard.len(), order, self.constraints.drain(..))?;
        let placement = Placement::at(&self.coordinates);
        let entries = self.entries.drain(..);
        let (solved, redundant) = if symmetric {
            let lower = entries.filter(|(row, column, _)| row >= column);
            let matrix = SymmetricMatrix::from_triplets(order, lower)?;
            let system = SaddleSystem::new(&matrix, &border, placement)?;
            (system.solve(&self.loads, &self.targets), system.redundant())
        } else {
            let matrix = SparseMatrix::from_triplets(order, order, entries)?;
            let system = BorderedSystem::new(&matrix, &border, placement)?;
            (system.solve(&self.loads, &self.targets), system.redundant())
        };
        let solved = solved.map_err(|error| self.named(error, rows))?;
        for (place, &vertex) in self.free.iter().enumerate() {
            self.positions[vertex] = DVec2::new(solved.values[place], solved.values[order + place]);
        }
        let redundant = redundant.iter().map(|&row| rows.hard[row]).collect();
        Ok((self.positions, solved, redundant))
    }

    fn named(&self, error: SolveError, rows: &Rows) -> FlattenError {
        match error {
            SolveError::Singular { column, pivot } => {
                let column = self.free.get(column).copied().unwrap_or(column);
                SolveError::Singular { column, pivot }.into()
            }
            other => rows.named(other, |row| row),
        }
    }
}

/// The mean of the diagonal of a matrix given by terms.
fn mean_diagonal(order: usize, entries: impl Iterator<Item = (usize, usize, f64)>) -> f64 {
    let diagonal = entries.filter(|(row, column, _)| row == column);
    diagonal.map(|entry| entry.2).sum::<f64>() / order.max(1) as f64
}

/// The matrix of the conformal energy with the springs, and what stands on the right; coordinates
/// interleaved.
fn conformal_system(
    domain: &Domain,
    rows: &Rows,
) -> Result<(SymmetricMatrix, Vec<f64>), FlattenError> {
    let order = 2 * domain.mesh.vertex_count();
    let mut entries = conformal_entries(domain)?;
    let mut loads = vec![0.0; order];
    let stiffness = mean_diagonal(order, entries.iter().copied());
    for spring in rows.springs(stiffness) {
        for axis in 0..2 {
            let unknown = |vertex: usize| 2 * vertex + axis;
            let own = spring.entries();
            entries.extend(own.map(|(i, j, weight)| (unknown(i), unknown(j), weight)));
            for (vertex, load) in spring.loads() {
                loads[unknown(vertex)] += load[axis];
            }
        }
    }
    // Of a symmetric matrix each pair off the diagonal is given once.
    let lower = entries.into_iter().filter(|(row, column, _)| row >= column);
    Ok((SymmetricMatrix::from_triplets(order, lower)?, loads))
}

/// The conformal energy as a quadratic form of the coordinates, interleaved: the cotangent
/// Laplacian of each, less the area, which the boundary's coordinates decide ([DMA02] Eq. 7).
///
/// [DMA02]: crate::papers::DMA02
fn conformal_entries(domain: &Domain) -> Result<Vec<(usize, usize, f64)>, FlattenError> {
    let weights = domain.cotangent_weights()?;
    let mut entries = Vec::new();
    for ([i, j], weight) in index_pairs(&weights) {
        for axis in 0..2 {
            let (i, j) = (2 * i + axis, 2 * j + axis);
            entries.extend([
                (i, i, weight),
                (j, j, weight),
                (i, j, -weight),
                (j, i, -weight),
            ]);
        }
    }
    let mesh = &domain.mesh;
    let is_boundary = |&halfedge: &HalfedgeId| mesh.twin(halfedge).is_none();
    for halfedge in mesh.halfedges().filter(is_boundary) {
        let [a, b] = mesh.ends(halfedge).map(|vertex| 2 * vertex.index());
        let both =
            |row: usize, column: usize, value: f64| [(row, column, value), (column, row, value)];
        entries.extend(both(a, b + 1, -0.5));
        entries.extend(both(b, a + 1, 0.5));
    }
    Ok(entries)
}
