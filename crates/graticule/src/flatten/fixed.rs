//! Maps with a given boundary: [DMA02] §4.1, and the same system with other weights.
//!
//! [DMA02]: crate::papers::DMA02

use glam::DVec2;

use crate::mesh::{BoundaryLoopId, Element, VertexId};
use crate::solve::{Solution, SolveError};
use crate::watch::Watch;

use super::domain::Domain;
use super::energy::complex;
use super::equations::{Equations, Factor};
use super::flat_map::MapDraft;
use super::{BoundaryPositions, FlatMap, FlattenError, Method, Patch, Weights};

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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
/// Cost: one sparse factorisation of the mesh's size; LU for mean value and authalic weights, which
/// are not symmetric, and about three times as dear.
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
pub struct FixedSystem {
    patch: Patch,
    domain: Domain,
    /// Ascending.
    fixed: Vec<VertexId>,
    factor: Factor,
    method: Method,
    flip_free_on_convex: bool,
}

impl FixedSystem {
    /// Assembles and factors the equations for the vertices that `boundary` places; the places
    /// themselves do not matter yet.
    ///
    /// # Errors
    /// [`FlattenError`].
    pub fn new(
        patch: &Patch,
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
            patch: patch.clone(),
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
        let places = self.unit_places(boundary)?;
        let extended = {
            let _stage = watch.stage("solve");
            self.extended(&places)?
        };
        let flip_free = boundary.is_flip_free();
        self.finished(&extended, flip_free, watch)
    }

    /// The patch.
    #[must_use]
    pub fn patch(&self) -> &Patch {
        &self.patch
    }

    /// The vertices whose places decide the map, ascending.
    #[must_use]
    pub fn fixed(&self) -> &[VertexId] {
        &self.fixed
    }

    /// The places in unit lengths, in the order of [`fixed`](Self::fixed).
    pub(super) fn unit_places(
        &self,
        boundary: &BoundaryPositions,
    ) -> Result<Vec<DVec2>, FlattenError> {
        let (vertices, places) = sorted(boundary);
        if vertices != self.fixed {
            return Err(FlattenError::OtherBoundary {
                expected: self.fixed.len(),
                given: vertices.len(),
            });
        }
        let unit = self.patch.unit_length();
        Ok(places.into_iter().map(|place| place / unit).collect())
    }

    /// The positions of all vertices of the domain, in unit lengths, cones of closed holes last.
    pub(super) fn extended(&self, places: &[DVec2]) -> Result<Extended, SolveError> {
        // Places far from the origin would cost the differences between them their digits.
        let middle = places.iter().sum::<DVec2>() / places.len() as f64;
        let us = places.iter().map(|place| place.x - middle.x);
        let vs = places.iter().map(|place| place.y - middle.y);
        let solution = self.factor.solve(&us.chain(vs).collect::<Vec<f64>>())?;
        let (us, vs) = solution.values.split_at(self.domain.mesh.vertex_count());
        let values = us.iter().zip(vs);
        let mut positions: Vec<_> = values.map(|(&u, &v)| DVec2::new(u, v) + middle).collect();
        for (vertex, place) in self.fixed.iter().zip(places) {
            positions[vertex.index()] = *place;
        }
        Ok(Extended {
            positions,
            residual: solution.residual,
        })
    }

    /// The impulse response of each of these fixed vertices, given by their places in
    /// [`fixed`](Self::fixed): what one unit of a coordinate of it adds to that coordinate of every
    /// vertex of the domain. One column after the other ([DMA02] §4.2).
    ///
    /// [DMA02]: crate::papers::DMA02
    pub(super) fn impulse_responses(&self, handles: &[usize]) -> Result<Solution, SolveError> {
        let mut impulses = vec![0.0; handles.len() * self.fixed.len()];
        for (column, &handle) in handles.iter().enumerate() {
            impulses[column * self.fixed.len() + handle] = 1.0;
        }
        self.factor.solve(&impulses)
    }

    /// The gradient of a function by the places of the fixed vertices, from its gradient by the
    /// positions of the patch's vertices: one solve with the transposed matrix.
    pub(super) fn pull_back(&self, gradient: &[DVec2]) -> Result<Vec<DVec2>, SolveError> {
        let order = self.domain.mesh.vertex_count();
        let mut columns = vec![0.0; 2 * order];
        for (vertex, gradient) in gradient.iter().enumerate() {
            columns[vertex] = gradient.x;
            columns[order + vertex] = gradient.y;
        }
        let pulled = self.factor.pull_back(&columns)?.values;
        let (us, vs) = pulled.split_at(self.fixed.len());
        let pairs = us.iter().zip(vs);
        Ok(pairs.map(|(&u, &v)| DVec2::new(u, v)).collect())
    }

    /// Checks and measures positions of the domain's vertices.
    pub(super) fn finished(
        &self,
        extended: &Extended,
        flip_free_outline: bool,
        watch: &Watch,
    ) -> Result<FlatMap, FlattenError> {
        let mut positions: Vec<_> = extended.positions.iter().map(|p| complex(*p)).collect();
        let intrinsic_flips = self.domain.intrinsic_flips(&positions);
        positions.truncate(self.patch.mesh().vertex_count());
        let draft = MapDraft {
            positions,
            method: self.method,
            residual: extended.residual,
            flip_free_in_theory: self.flip_free_on_convex && flip_free_outline,
            intrinsic_flips,
        };
        draft.finish(&self.patch, watch)
    }
}

/// Positions of all vertices of the domain, in unit lengths, and the relative residual of the
/// equations that they solve.
#[derive(Clone, Debug)]
pub(super) struct Extended {
    pub(super) positions: Vec<DVec2>,
    pub(super) residual: f64,
}

/// Holes that have a vertex without a place.
pub(super) fn open_holes(patch: &Patch, boundary: &BoundaryPositions) -> Vec<BoundaryLoopId> {
    let mut placed = vec![false; patch.mesh().vertex_count()];
    for (vertex, _) in boundary.places() {
        placed[vertex.index()] = true;
    }
    let is_open = |&hole: &BoundaryLoopId| patch.loop_vertices(hole).any(|v| !placed[v.index()]);
    patch.holes().filter(is_open).collect()
}

/// The placed vertices, ascending, and their places.
pub(super) fn sorted(boundary: &BoundaryPositions) -> (Vec<VertexId>, Vec<DVec2>) {
    let mut places = boundary.places().to_vec();
    places.sort_unstable_by_key(|&(vertex, _)| vertex);
    places.into_iter().unzip()
}
