//! Maps without flips, whatever the patch, with little distortion.
//!
//! A map that is injective by construction ([`mod@start`]) goes down to a minimum of an energy that
//! grows beyond all bounds where a triangle collapses, by a Newton method ([`newton`]) whose steps
//! are led around what is in their way and end before the first collapse. The energy of triangles ([`energy`]), the linear system
//! ([`system`]) and the line search know nothing of each other.

mod boundary;
mod collapse;
mod contacts;
mod convex;
mod energy;
mod insertion;
mod newton;
mod objective;
mod rim;
mod start;
mod system;

use glam::DVec2;
use serde::Serialize;

use self::boundary::Boundary;
use self::contacts::Apart;
use self::newton::{Goal, descend};
use self::objective::{Objective, Triangles};
use self::start::{Demand, Disk, start};
use self::system::NewtonSystem;
use super::conformal::Triangulation;
use super::domain::Domain;
use super::energy::complex;
use super::flat_map::MapDraft;
use super::{FlatMap, FlattenError, FlipCount, Method, Patch};
use crate::measure::SourceTriangle;
use crate::mesh::{BoundaryLoopId, PerFace, PerVertex, VertexId};
use crate::tolerance::{HOLE_IMPORTANCE, INJECTIVE_GAIN};
use crate::watch::Watch;

pub use convex::convex_map;
pub use energy::DistortionEnergy;
pub use newton::{Descent, NewtonStep};
pub(super) use objective::is_upright;

/// How a map without flips is made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InjectiveOptions {
    /// What is made small.
    pub energy: DistortionEnergy,
    /// The descent ends when the next step promises to gain less than this share of the energy.
    pub least_gain: f64,
    /// Whether parts of the map may lie over each other.
    pub overlap: Overlap,
    /// Most steps of the descent of the whole map. A map stopped early has no flips either.
    pub iterations: usize,
}

impl Default for InjectiveOptions {
    fn default() -> Self {
        Self {
            energy: DistortionEnergy::default(),
            least_gain: INJECTIVE_GAIN,
            overlap: Overlap::default(),
            iterations: 100,
        }
    }
}

/// Whether parts of a map without flips may lie over each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Overlap {
    /// As it comes: each triangle has its own place beside its neighbours, but parts of the boundary
    /// may reach over others.
    #[default]
    Allowed,
    /// The map is one to one.
    Forbidden,
}

/// What may move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoundaryFreedom {
    /// Every vertex.
    #[default]
    Free,
    /// Vertices inside only.
    Fixed,
}

/// A map without flips, and how it was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InjectiveMap {
    /// The map, at the scale at which its energy is least.
    pub map: FlatMap,
    /// The mean energy by area, at least [`DistortionEnergy::least`].
    pub energy: f64,
    /// The descent of the whole map.
    pub descent: Descent,
}

/// Lays a patch down without a flipped or collapsed triangle, with its boundary free and the energy
/// at a minimum. Holes are left open.
///
/// With [`Overlap::Forbidden`] the map is one to one. It is first made as if overlaps were allowed;
/// only if there are some, it is made again from the start with boundaries that push each other
/// away.
///
/// Cost: near-linear. Some ten Newton steps on the whole mesh, each a Cholesky factorisation with two
/// unknowns for each vertex, and about half as much for the coarser maps before.
///
/// # Errors
/// [`FlattenError::NoRoom`] where double precision does not suffice; never a map with flips.
pub fn injective_map(
    patch: &Patch,
    options: &InjectiveOptions,
    watch: &Watch,
) -> Result<InjectiveMap, FlattenError> {
    let _stage = watch.stage("map without flips");
    let free = InjectiveOptions {
        overlap: Overlap::Allowed,
        ..*options
    };
    let map = laid(patch, &free, Patience::ENDLESS, watch)?;
    if options.overlap == Overlap::Allowed || is_one_to_one(patch, &map.map.uv) {
        return Ok(map);
    }
    laid(patch, options, Patience::ENDLESS, watch)
}

/// The energies above which a map is given up.
#[derive(Clone, Copy)]
pub(super) struct Patience {
    /// Of a coarse map at rest, and of any on its way; what keeps the boundary apart included.
    pub(super) coarse: f64,
    /// Of the map of the whole patch at rest.
    pub(super) whole: f64,
}

impl Patience {
    pub(super) const ENDLESS: Self = Self {
        coarse: f64::INFINITY,
        whole: f64::INFINITY,
    };
}

/// The map that the options ask for, from the start.
///
/// # Errors
/// [`FlattenError::Jammed`] as soon as patience is lost; else as [`injective_map`].
pub(super) fn laid(
    patch: &Patch,
    options: &InjectiveOptions,
    patience: Patience,
    watch: &Watch,
) -> Result<InjectiveMap, FlattenError> {
    let demand = Demand {
        energy: options.energy,
        overlap: options.overlap,
        patience: patience.coarse,
    };
    let mut places = start(&filled_disk(patch)?, demand, watch)?;
    places.truncate(patch.mesh().vertex_count());
    let fixed = vec![false; places.len()];
    finish(patch, places, fixed, (options, patience), watch)
}

/// Whether a map without flips is one to one. Exact.
pub(super) fn is_one_to_one(patch: &Patch, uv: &PerVertex<DVec2>) -> bool {
    let corners: Vec<_> = triangle_corners(patch).collect();
    Boundary::new(&corners).is_simple(uv.as_slice())
}

/// The pairs of boundary edges that meet in a map, each edge by its ends with the surface to its
/// left. Exact; the same order in every run.
pub(super) fn boundary_meetings(patch: &Patch, uv: &PerVertex<DVec2>) -> Vec<[[VertexId; 2]; 2]> {
    let corners: Vec<_> = triangle_corners(patch).collect();
    let boundary = Boundary::new(&corners);
    let edge = |number: usize| boundary.edges()[number].map(VertexId);
    let pairs = boundary.self_meetings(uv.as_slice()).into_iter();
    pairs.map(|pair| pair.map(edge)).collect()
}

/// By how much the energy of each triangle is above the least, times its share of the area.
pub(super) fn strains(
    patch: &Patch,
    uv: &PerVertex<DVec2>,
    energy: DistortionEnergy,
    watch: &Watch,
) -> Result<PerFace<f64>, FlattenError> {
    let places: Vec<DVec2> = uv.iter().map(|&p| p / patch.unit_length()).collect();
    let triangles = triangles_of(patch, energy, watch)?;
    Ok(PerFace::new(triangles.strains(&places).collect()))
}

/// Lowers the energy of a map without flips, which stays so; with [`Overlap::Forbidden`] also one
/// that is one to one.
///
/// # Errors
/// [`FlattenError::StartFlipped`] if the map has flips, [`FlattenError::StartOverlaps`] if overlaps
/// are forbidden and it has some; else as [`injective_map`].
pub fn improve_map(
    patch: &Patch,
    uv: &PerVertex<DVec2>,
    boundary: BoundaryFreedom,
    options: &InjectiveOptions,
    watch: &Watch,
) -> Result<InjectiveMap, FlattenError> {
    let _stage = watch.stage("improve map");
    let flips = FlipCount::of(patch.mesh(), uv);
    if !flips.is_zero() {
        let flipped = flips.flipped + flips.degenerate;
        return Err(FlattenError::StartFlipped { flipped });
    }
    let mesh = patch.mesh();
    let is_fixed = |vertex| boundary == BoundaryFreedom::Fixed && mesh.is_boundary_vertex(vertex);
    let fixed = mesh.vertices().map(is_fixed).collect();
    let places = uv.iter().map(|&place| place / patch.unit_length());
    finish(
        patch,
        places.collect(),
        fixed,
        (options, Patience::ENDLESS),
        watch,
    )
}

/// Descends with all triangles of the patch and wraps up.
fn finish(
    patch: &Patch,
    mut places: Vec<DVec2>,
    fixed: Vec<bool>,
    (options, patience): (&InjectiveOptions, Patience),
    watch: &Watch,
) -> Result<InjectiveMap, FlattenError> {
    let triangles = triangles_of(patch, options.energy, watch)?;
    if !fixed.contains(&true) {
        let scale = triangles.best_scale(&places);
        for place in &mut places {
            *place *= scale;
        }
    }
    let goal = Goal {
        gain: options.least_gain,
        iterations: options.iterations,
        patience: patience.coarse,
    };
    let demand = (options.overlap, goal);
    let descent = descended(patch, &triangles, &mut places, fixed, demand, watch)?;
    let energy = triangles.value(&places);
    let last = descent.history.last().map_or(0.0, |step| step.energy);
    if energy > patience.whole || last > patience.coarse {
        return Err(FlattenError::Jammed { energy });
    }
    if !descent.converged {
        let message = format!(
            "the energy could still be lowered after {} steps",
            options.iterations
        );
        watch.warn("not-converged", message);
    }
    let draft = MapDraft {
        positions: places.into_iter().map(complex).collect(),
        method: Method::Injective,
        residual: descent.residual,
        flip_free_in_theory: true,
        intrinsic_flips: None,
    };
    Ok(InjectiveMap {
        map: draft.finish(patch, watch)?,
        energy,
        descent,
    })
}

fn descended(
    patch: &Patch,
    triangles: &Triangles,
    places: &mut Vec<DVec2>,
    fixed: Vec<bool>,
    (overlap, goal): (Overlap, Goal),
    watch: &Watch,
) -> Result<Descent, FlattenError> {
    let _stage = watch.stage("descend");
    let points = patch.unit_surface().positions().as_slice();
    let mut system = NewtonSystem::new(triangles.corners(), points, fixed)?;
    if overlap == Overlap::Allowed {
        return Ok(descend(triangles, &mut system, places, goal, watch)?);
    }
    let apart = Apart::new(triangles, points);
    if !apart.is_simple(places) {
        return Err(FlattenError::StartOverlaps);
    }
    Ok(descend(&apart, &mut system, places, goal, watch)?)
}

/// The patch with its holes closed.
fn filled_disk(patch: &Patch) -> Result<Disk, FlattenError> {
    let holes: Vec<BoundaryLoopId> = patch.holes().collect();
    let domain = Domain::with_cones(patch, &holes)?;
    let mesh = &domain.mesh;
    let importance = |face: usize| {
        let of_patch = face < patch.mesh().face_count();
        if of_patch { 1.0 } else { HOLE_IMPORTANCE }
    };
    Ok(Disk {
        triangles: mesh
            .faces()
            .map(|face| mesh.triangle(face).map(|v| v.0))
            .collect(),
        on_boundary: mesh
            .vertices()
            .map(|v| mesh.is_boundary_vertex(v))
            .collect(),
        importance: (0..mesh.face_count()).map(importance).collect(),
        points: domain.coordinates,
    })
}

/// The energy of the patch's triangles, each with a shape.
fn triangles_of(
    patch: &Patch,
    energy: DistortionEnergy,
    watch: &Watch,
) -> Result<Triangles, FlattenError> {
    let domain = Domain::conformal(patch, Triangulation::Given, watch)?;
    let (sources, weights): (Vec<_>, Vec<_>) = domain
        .triangulation()
        .shapes()
        .iter()
        .filter_map(|shape| SourceTriangle::from_lengths(shape.lengths()))
        .map(|source| (source, source.area()))
        .unzip();
    let corners: Vec<_> = triangle_corners(patch).collect();
    debug_assert_eq!(
        corners.len(),
        sources.len(),
        "mollified triangles have shapes"
    );
    Ok(Triangles::new(energy, corners, sources, weights))
}

fn triangle_corners(patch: &Patch) -> impl Iterator<Item = [u32; 3]> {
    let mesh = patch.mesh();
    mesh.faces()
        .map(|face| mesh.triangle(face).map(|VertexId(vertex)| vertex))
}
