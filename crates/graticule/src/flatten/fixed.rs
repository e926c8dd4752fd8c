//! Maps with a given boundary: [DMA02] §4.1 with μ = 0, and the same system with other weights.
//!
//! [DMA02]: crate::papers::DMA02

use faer::c64;
use glam::DVec2;

use crate::geometry::{
    DirectedWeights, EdgeWeights, cotangent_weights, mean_value_weights, uniform_weights,
};
use crate::mesh::{BoundaryLoopId, Element, VertexId};
use crate::solve::{Cholesky, Graph, Lu, Ordering, SparseMatrix, SymmetricMatrix};
use crate::watch::Watch;

use super::domain::Domain;
use super::flat_map::MapDraft;
use super::{BoundaryPositions, FlatMap, FlattenError, Method, Patch};

const FIXED: u32 = u32::MAX;

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
    /// weight inside is negative: on a convex curve none of *its* triangles flips. Triangles of the
    /// patch that it does not share may.
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
    unknowns: Unknowns,
    /// Weights between unknowns (rows) and fixed vertices (columns).
    coupling: SparseMatrix,
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
        let stage = watch.stage("assemble");
        let equations = Equations::new(&mut domain, options.weights, watch)?;
        let unknowns = Unknowns::new(domain.mesh.vertex_count(), boundary);
        if unknowns.free.is_empty() {
            let message = "the patch has no interior vertex: its boundary alone decides the map";
            watch.warn("no-interior", message);
        }
        let least = equations.least(&unknowns);
        let coupling = equations.coupling(&unknowns)?;
        drop(stage);
        Ok(Self {
            factor: equations.factor(&unknowns, &domain, watch)?,
            coupling,
            unknowns,
            patch,
            method: options.weights.method(),
            flip_free_on_convex: least > 0.0
                && options.weights != Weights::DelaunayCotangent
                && (closes || open_holes.is_empty()),
            domain,
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
        let fixed = self
            .unknowns
            .fixed_places(boundary, self.patch.unit_length())?;
        let stage = watch.stage("solve");
        let mut positions = vec![c64::ZERO; self.unknowns.places.len()];
        for (&vertex, place) in self.unknowns.fixed.iter().zip(&fixed) {
            positions[vertex.index()] = c64::new(place.x, place.y);
        }
        let [us, vs] = [|p: &DVec2| p.x, |p: &DVec2| p.y]
            .map(|coordinate| fixed.iter().map(coordinate).collect::<Vec<f64>>());
        let right_sides = [self.coupling.multiply(&us), self.coupling.multiply(&vs)];
        let (free, residual) = self.factor.solve(&right_sides.concat())?;
        let count = self.unknowns.free.len();
        for (unknown, vertex) in self.unknowns.free.iter().enumerate() {
            positions[vertex.index()] = c64::new(free[unknown], free[count + unknown]);
        }
        drop(stage);
        let intrinsic_flips = self.domain.intrinsic_flips(&positions);
        positions.truncate(self.patch.mesh().vertex_count());
        let draft = MapDraft {
            positions,
            method: self.method,
            residual,
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

/// Vertices with and without given places, each kind numbered by itself.
#[derive(Debug)]
struct Unknowns {
    /// Number of each vertex among the free ones, or `FIXED`.
    places: Vec<u32>,
    free: Vec<VertexId>,
    /// Ascending.
    fixed: Vec<VertexId>,
    /// Number of each vertex among the fixed ones, where it is one.
    fixed_places: Vec<u32>,
}

impl Unknowns {
    fn new(vertices: usize, boundary: &BoundaryPositions) -> Self {
        let mut places = vec![0; vertices];
        for (vertex, _) in boundary.places() {
            places[vertex.index()] = FIXED;
        }
        let mut fixed_places = vec![FIXED; vertices];
        let (mut free, mut fixed) = (Vec::new(), Vec::new());
        for index in 0..vertices {
            if places[index] == FIXED {
                fixed_places[index] = fixed.len() as u32;
                fixed.push(VertexId::from_index(index));
            } else {
                places[index] = free.len() as u32;
                free.push(VertexId::from_index(index));
            }
        }
        Self {
            places,
            free,
            fixed,
            fixed_places,
        }
    }

    fn free_place(&self, vertex: VertexId) -> Option<usize> {
        let place = self.places[vertex.index()];
        (place != FIXED).then_some(place as usize)
    }

    fn fixed_place(&self, vertex: VertexId) -> usize {
        self.fixed_places[vertex.index()] as usize
    }

    /// The places given, in the order of the fixed vertices and in unit lengths.
    fn fixed_places(
        &self,
        boundary: &BoundaryPositions,
        unit_length: f64,
    ) -> Result<Vec<DVec2>, FlattenError> {
        let mut places = boundary.places().to_vec();
        places.sort_unstable_by_key(|&(vertex, _)| vertex);
        if !places
            .iter()
            .map(|&(vertex, _)| vertex)
            .eq(self.fixed.iter().copied())
        {
            return Err(FlattenError::OtherBoundary {
                expected: self.fixed.len(),
                given: places.len(),
            });
        }
        Ok(places
            .iter()
            .map(|&(_, place)| place / unit_length)
            .collect())
    }
}

/// For each vertex: the sum over its neighbours of weights times differences is zero.
enum Equations {
    Symmetric(EdgeWeights),
    Directed(DirectedWeights),
}

impl Equations {
    fn new(domain: &mut Domain, weights: Weights, watch: &Watch) -> Result<Self, FlattenError> {
        match weights {
            Weights::Uniform => return Ok(Self::Symmetric(uniform_weights(&domain.mesh))),
            Weights::DelaunayCotangent => domain.make_delaunay(watch)?,
            Weights::Cotangent | Weights::MeanValue => domain.mollify(watch),
        }
        Ok(match weights {
            Weights::MeanValue => Self::Directed(mean_value_weights(&domain.triangulation)?),
            _ => Self::Symmetric(cotangent_weights(&domain.triangulation)?),
        })
    }

    /// Each weight `(i, j, w)` in the row of each free vertex `i`.
    fn terms<'b>(
        &'b self,
        unknowns: &'b Unknowns,
    ) -> Box<dyn Iterator<Item = (usize, VertexId, f64)> + 'b> {
        let in_row = |(i, j, weight)| Some((unknowns.free_place(i)?, j, weight));
        match self {
            Self::Symmetric(edges) => {
                let pairs = edges.ends.iter().zip(&edges.weights);
                let both_ways = pairs.flat_map(|(&[i, j], &w)| [(i, j, w), (j, i, w)]);
                Box::new(both_ways.filter_map(in_row))
            }
            Self::Directed(rows) => Box::new(unknowns.free.iter().flat_map(move |&i| {
                let row = rows.neighbors(i).iter().zip(rows.weights(i));
                row.filter_map(move |(&j, &w)| in_row((i, j, w)))
            })),
        }
    }

    fn least(&self, unknowns: &Unknowns) -> f64 {
        let weights = self.terms(unknowns).map(|(_, _, weight)| weight);
        weights.fold(f64::INFINITY, f64::min)
    }

    fn coupling(&self, unknowns: &Unknowns) -> Result<SparseMatrix, FlattenError> {
        let to_fixed = self.terms(unknowns).filter_map(|(row, j, weight)| {
            let is_fixed = unknowns.free_place(j).is_none();
            is_fixed.then(|| (row, unknowns.fixed_place(j), weight))
        });
        let [rows, columns] = [unknowns.free.len(), unknowns.fixed.len()];
        Ok(SparseMatrix::from_triplets(rows, columns, to_fixed)?)
    }

    /// Entries of the matrix between unknowns, diagonal included.
    fn entries<'b>(
        &'b self,
        unknowns: &'b Unknowns,
    ) -> impl Iterator<Item = (usize, usize, f64)> + 'b {
        self.terms(unknowns).flat_map(|(row, j, weight)| {
            let beside = unknowns.free_place(j).map(|column| (row, column, -weight));
            std::iter::once((row, row, weight)).chain(beside)
        })
    }

    fn factor(
        &self,
        unknowns: &Unknowns,
        domain: &Domain,
        watch: &Watch,
    ) -> Result<Factor, FlattenError> {
        let order = unknowns.free.len();
        if order == 0 {
            return Ok(Factor::Nothing);
        }
        watch.check()?;
        let _stage = watch.stage("order and factor");
        let place = |vertex: &VertexId| domain.coordinates[vertex.index()];
        let coordinates: Vec<_> = unknowns.free.iter().map(place).collect();
        if let Self::Directed(_) = self {
            let matrix = SparseMatrix::from_triplets(order, order, self.entries(unknowns))?;
            let graph = Graph::of_pattern(matrix.pattern());
            let ordering = Ordering::for_mesh(&graph, &coordinates);
            return Ok(Factor::Lu(Box::new(Lu::new(&matrix, &ordering)?)));
        }
        let lower = self
            .entries(unknowns)
            .filter(|(row, column, _)| row >= column);
        let matrix = SymmetricMatrix::from_triplets(order, lower)?;
        let graph = Graph::of_pattern(matrix.lower().pattern());
        let ordering = Ordering::for_mesh(&graph, &coordinates);
        watch.check()?;
        Ok(Factor::Cholesky(Box::new(Cholesky::new(
            &matrix, &ordering,
        )?)))
    }
}

#[derive(Debug)]
enum Factor {
    /// There are no unknowns.
    Nothing,
    Cholesky(Box<Cholesky>),
    Lu(Box<Lu>),
}

impl Factor {
    /// Solutions for several right-hand sides, one after the other, and the largest relative
    /// residual.
    fn solve(&self, right_sides: &[f64]) -> Result<(Vec<f64>, f64), FlattenError> {
        let solution = match self {
            Self::Nothing => return Ok((Vec::new(), 0.0)),
            Self::Cholesky(factor) => factor.solve(right_sides)?,
            Self::Lu(factor) => factor.solve(right_sides)?,
        };
        Ok((solution.values, solution.residual))
    }
}
