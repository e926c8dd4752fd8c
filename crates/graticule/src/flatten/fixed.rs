//! Maps with a given boundary: [DMA02] §4.1 with μ = 0, and the same system with other weights.
//!
//! [DMA02]: crate::papers::DMA02

use faer::c64;
use glam::DVec2;

use crate::geometry::{DirectedWeights, EdgeWeights, mean_value_weights, uniform_weights};
use crate::mesh::{BoundaryLoopId, Element, VertexId};
use crate::solve::{
    DirichletLu, DirichletSystem, Exchange, Placement, Solution, SolveError, SparseMatrix,
    SymmetricMatrix,
};
use crate::watch::Watch;

use super::domain::Domain;
use super::energy::complex;
use super::flat_map::MapDraft;
use super::{BoundaryPositions, FlatMap, FlattenError, Method, Patch};

/// How much each neighbour counts in the mean that a vertex is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weights {
    /// The discrete conformal map ([DMA02] Eq. 4), on the patch's own triangles. Weights opposite
    /// to obtuse angles may be negative; then triangles may flip.
    ///
    /// [DMA02]: crate::papers::DMA02
    #[default]
    Cotangent,
    /// The discrete conformal map on the intrinsic Delaunay triangulation of the same surface. No
    /// weight inside is negative: on a circle none of *its* triangles flips, except that what lies
    /// between two of its edges with the same ends (the tip of a thin spike) collapses onto them.
    /// Triangles of the patch that it does not share may flip, and on the straight side of a
    /// rectangle some of its own may collapse.
    DelaunayCotangent,
    /// Mean value weights (M. Floater, *Mean value coordinates*, 2003): all positive, and a flat
    /// patch is its own map.
    MeanValue,
    /// The same weight for all neighbours (W. T. Tutte, *How to draw a graph*, 1963): knows nothing
    /// of shapes.
    Uniform,
}

/// What becomes of holes that were given no places.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Holes {
    /// A cone over each hole takes part in the computation: one more vertex, joined to the hole's
    /// vertices by edges of one length. What theory says of patches without holes holds.
    #[default]
    Closed,
    /// Their vertices fulfil the equation of the triangles that are there: no flux leaves through a
    /// hole. For cotangent weights that is the energy's own boundary condition. Triangles at a hole
    /// may flip or collapse.
    Natural,
}

/// How a map with fixed boundary is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FixedOptions {
    /// The weights.
    pub weights: Weights,
    /// What becomes of holes.
    pub holes: Holes,
}

/// Lays a patch down with its boundary in the given places: each other vertex becomes a weighted
/// mean of its neighbours ([DMA02] §4.1).
///
/// Holes whose vertices all have places are fixed there; see [`Holes`] for the others. A patch
/// without interior vertices is decided by its boundary; a warning (`no-interior`) says so.
///
/// Cost: one sparse factorisation of the mesh's size; LU for mean value weights, which are not
/// symmetric, and about three times as dear.
///
/// # Errors
/// [`FlattenError`].
///
/// [DMA02]: crate::papers::DMA02
pub fn fixed_map(
    patch: &Patch,
    boundary: &BoundaryPositions,
    options: &FixedOptions,
    watch: &Watch,
) -> Result<FlatMap, FlattenError> {
    let _stage = watch.stage("map with fixed boundary");
    FixedSystem::new(patch, boundary, options, watch)?.map(boundary, watch)
}

/// The equations of a map with fixed boundary, factored: for one set of fixed vertices, the map for
/// any places of theirs costs two triangular solves.
#[derive(Debug)]
pub struct FixedSystem<'a> {
    patch: &'a Patch,
    domain: Domain,
    /// Ascending.
    fixed: Vec<VertexId>,
    factor: Factor,
    method: Method,
    flip_free_on_convex: bool,
}

impl<'a> FixedSystem<'a> {
    /// Assembles and factors the equations for the vertices that `boundary` places; the places
    /// themselves do not matter yet.
    ///
    /// # Errors
    /// [`FlattenError`].
    pub fn new(
        patch: &'a Patch,
        boundary: &BoundaryPositions,
        options: &FixedOptions,
        watch: &Watch,
    ) -> Result<Self, FlattenError> {
        let open_holes = open_holes(patch, boundary);
        let closes = options.holes == Holes::Closed;
        let cones: &[BoundaryLoopId] = if closes { &open_holes } else { &[] };
        let mut domain = Domain::with_cones(patch, cones)?;
        let (fixed, _) = sorted(boundary);
        if fixed.len() == domain.mesh.vertex_count() {
            let message = "the patch has no interior vertex: its boundary alone decides the map";
            watch.warn("no-interior", message);
        }
        let equations = Equations::new(&mut domain, options.weights, watch)?;
        watch.check()?;
        let flip_free_on_convex = equations.are_positive(&fixed)
            && options.weights != Weights::DelaunayCotangent
            && (closes || open_holes.is_empty());
        let stage = watch.stage("order and factor");
        let factor = equations.factor(&fixed, &domain)?;
        factor.warn_of_exchange(watch);
        drop(stage);
        Ok(Self {
            patch,
            domain,
            fixed,
            factor,
            method: options.weights.method(),
            flip_free_on_convex,
        })
    }

    /// The map for these places of the vertices that the system was made for.
    ///
    /// # Errors
    /// [`FlattenError::OtherBoundary`] if these are other vertices, or [`FlattenError::Solve`].
    pub fn map(
        &self,
        boundary: &BoundaryPositions,
        watch: &Watch,
    ) -> Result<FlatMap, FlattenError> {
        let (vertices, places) = sorted(boundary);
        if vertices != self.fixed {
            return Err(FlattenError::OtherBoundary {
                expected: self.fixed.len(),
                given: vertices.len(),
            });
        }
        let stage = watch.stage("solve");
        // Places far from the origin would cost the differences between them their digits.
        let unit = self.patch.unit_length();
        let middle = places.iter().sum::<DVec2>() / places.len() as f64;
        let us = places.iter().map(|place| (place.x - middle.x) / unit);
        let vs = places.iter().map(|place| (place.y - middle.y) / unit);
        let solution = self.factor.solve(&us.chain(vs).collect::<Vec<f64>>())?;
        let (us, vs) = solution.values.split_at(self.domain.mesh.vertex_count());
        let moved = middle / unit;
        let values = us.iter().zip(vs);
        let mut positions: Vec<_> = values
            .map(|(&u, &v)| c64::new(u + moved.x, v + moved.y))
            .collect();
        for (vertex, place) in vertices.iter().zip(&places) {
            positions[vertex.index()] = complex(*place / unit);
        }
        drop(stage);
        let intrinsic_flips = self.domain.intrinsic_flips(&positions);
        positions.truncate(self.patch.mesh().vertex_count());
        let draft = MapDraft {
            positions,
            method: self.method,
            residual: solution.residual,
            flip_free_in_theory: self.flip_free_on_convex && boundary.is_flip_free(),
            intrinsic_flips,
        };
        draft.finish(self.patch, watch)
    }
}

impl Weights {
    fn method(self) -> Method {
        match self {
            Self::Cotangent => Method::FixedConformal,
            Self::DelaunayCotangent => Method::FixedConformalDelaunay,
            Self::MeanValue => Method::FixedMeanValue,
            Self::Uniform => Method::FixedUniform,
        }
    }
}

/// Holes that have a vertex without a place.
fn open_holes(patch: &Patch, boundary: &BoundaryPositions) -> Vec<BoundaryLoopId> {
    let mut placed = vec![false; patch.mesh().vertex_count()];
    for (vertex, _) in boundary.places() {
        placed[vertex.index()] = true;
    }
    let is_open = |&hole: &BoundaryLoopId| patch.loop_vertices(hole).any(|v| !placed[v.index()]);
    patch.holes().filter(is_open).collect()
}

/// The placed vertices, ascending, and their places.
fn sorted(boundary: &BoundaryPositions) -> (Vec<VertexId>, Vec<DVec2>) {
    let mut places = boundary.places().to_vec();
    places.sort_unstable_by_key(|&(vertex, _)| vertex);
    places.into_iter().unzip()
}

/// For each vertex: the sum over its neighbours of weights times differences is zero.
enum Equations {
    Symmetric(EdgeWeights),
    Directed(DirectedWeights),
}

impl Equations {
    fn new(domain: &mut Domain, weights: Weights, watch: &Watch) -> Result<Self, FlattenError> {
        let _stage = watch.stage("weights");
        match weights {
            Weights::Uniform => return Ok(Self::Symmetric(uniform_weights(&domain.mesh))),
            Weights::DelaunayCotangent => domain.make_delaunay(watch)?,
            Weights::Cotangent | Weights::MeanValue => domain.mollify(watch),
        }
        Ok(match weights {
            Weights::MeanValue => Self::Directed(mean_value_weights(&domain.triangulation())?),
            _ => Self::Symmetric(domain.cotangent_weights()?),
        })
    }

    /// Whether every weight in the equation of a free vertex is above 0.
    fn are_positive(&self, fixed: &[VertexId]) -> bool {
        let is_fixed = |vertex: &VertexId| fixed.binary_search(vertex).is_ok();
        match self {
            Self::Symmetric(edges) => {
                let mut pairs = edges.ends.iter().zip(&edges.weights);
                pairs.all(|(ends, &weight)| weight > 0.0 || ends.iter().all(is_fixed))
            }
            Self::Directed(rows) => {
                let mut vertices = (0..rows.vertex_count()).map(VertexId::from_index);
                vertices.all(|v| is_fixed(&v) || rows.weights(v).iter().all(|&w| w > 0.0))
            }
        }
    }

    fn factor(&self, fixed: &[VertexId], domain: &Domain) -> Result<Factor, SolveError> {
        let placement = Placement::at(&domain.coordinates);
        let fixed: Vec<usize> = fixed.iter().map(|vertex| vertex.index()).collect();
        let order = domain.mesh.vertex_count();
        match self {
            Self::Symmetric(edges) => {
                let pairs = edges.ends.iter().zip(&edges.weights);
                let pairs = pairs.map(|(ends, &weight)| (ends.map(Element::index), weight));
                let matrix = SymmetricMatrix::laplacian(order, pairs)?;
                let system = DirichletSystem::new(&matrix, &fixed, placement)?;
                Ok(Factor::Symmetric(Box::new(system)))
            }
            Self::Directed(rows) => {
                let matrix = SparseMatrix::from_triplets(order, order, laplacian(rows))?;
                let system = DirichletLu::new(&matrix, &fixed, placement)?;
                Ok(Factor::General(Box::new(system)))
            }
        }
    }
}

/// The entries of the matrix `L` with `(L u)ᵢ = Σⱼ wᵢⱼ (uᵢ - uⱼ)`.
fn laplacian(rows: &DirectedWeights) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
    let vertices = (0..rows.vertex_count()).map(VertexId::from_index);
    vertices.flat_map(move |i| {
        let row = rows.neighbors(i).iter().zip(rows.weights(i));
        row.flat_map(move |(j, &weight)| {
            [
                (i.index(), i.index(), weight),
                (i.index(), j.index(), -weight),
            ]
        })
    })
}

#[derive(Debug)]
enum Factor {
    Symmetric(Box<DirichletSystem>),
    General(Box<DirichletLu>),
}

impl Factor {
    fn warn_of_exchange(&self, watch: &Watch) {
        if let Self::General(system) = self
            && system.factor().exchange() == Exchange::Unrestricted
        {
            let message = "the equations have no good pivots near the diagonal: factored with \
                           exchanges over the whole matrix, which takes more time and memory";
            watch.warn("unrestricted-pivoting", message);
        }
    }

    fn solve(&self, fixed_values: &[f64]) -> Result<Solution, SolveError> {
        match self {
            Self::Symmetric(system) => system.solve(fixed_values),
            Self::General(system) => system.solve(fixed_values),
        }
    }
}
