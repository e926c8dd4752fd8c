//! Conformal maps that choose their own boundary.
//!
//! [DMA02] §4.2: the boundary vertices join the unknowns, with the equation that interior vertices
//! fulfil anyhow (Eq. 7). Two vertices are pinned to fix place, rotation and scale. The map is that
//! of least squares conformal mapping (B. Lévy et al., *Least Squares Conformal Maps for Automatic
//! Texture Atlas Generation*, 2002) with the same pins: both minimise Σ (σ₁ − σ₂)² × area.
//!
//! [DMA02]: crate::papers::DMA02

use faer::c64;
use glam::DVec2;

use crate::mesh::{Element, VertexId};
use crate::solve::SolveError;
use crate::watch::{Stopped, Watch};

use super::conformal::{PinnedForm, PinnedSolution, Triangulation};
use super::diameter::farthest_pair;
use super::domain::Domain;
use super::energy::complex;
use super::flat_map::MapDraft;
use super::spectral::thin_patch_told;
use super::{FlatMap, FlattenError, Method, Patch, least_squares};

/// Which two vertices are pinned, and where.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Pins {
    /// The two boundary vertices with the largest distance in space, as the paper proposes. The one
    /// that comes first along the boundary loops lies at the origin, the other to the right of it,
    /// and the map is scaled to the area of the patch.
    #[default]
    Farthest,
    /// These vertices at these places, in the surface's unit of length. The map is not scaled.
    At([(VertexId, DVec2); 2]),
}

/// How a natural conformal map is made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NaturalOptions {
    /// The pinned vertices.
    pub pins: Pins,
    /// The triangles that weights are taken from.
    pub triangulation: Triangulation,
}

/// The natural conformal map of a patch: as conformal as a piecewise linear map with two pinned
/// vertices can be, the boundary left free ([DMA02] Eq. 7). Holes are free too.
///
/// Flips are not excluded by theory; the result counts them. The map depends on the pins, more so
/// the more area distortion it has; [`spectral_map`](super::spectral_map) does not.
///
/// Cost: one sparse complex factorisation of the mesh's size, about twice that of its Laplacian. A
/// patch a hundred thousand times as long as wide takes an orthogonal factorisation after it, which a
/// warning tells, if it has no more than 60 000 vertices.
///
/// # Errors
/// [`FlattenError`] for pins that cannot be used, [`FlattenError::Solve`] where a conformal map
/// takes both pins to one point.
///
/// [DMA02]: crate::papers::DMA02
pub fn natural_map(
    patch: &Patch,
    options: &NaturalOptions,
    watch: &Watch,
) -> Result<FlatMap, FlattenError> {
    let _stage = watch.stage("natural conformal map");
    let pins = match options.pins {
        Pins::Farthest => farthest_pins(patch, watch)?,
        Pins::At(pins) => checked_pins(patch, pins)?,
    };
    let domain = Domain::conformal(patch, options.triangulation, watch)?;
    let solution = pinned_map(
        patch,
        &domain,
        pins.map(|(v, place)| (v, complex(place))),
        watch,
    )?;
    let intrinsic_flips = domain.intrinsic_flips(&solution.positions);
    let draft = MapDraft {
        positions: solution.positions,
        method: Method::NaturalConformal,
        residual: solution.residual,
        flip_free_in_theory: false,
        intrinsic_flips,
    };
    match options.pins {
        Pins::Farthest => draft.scaled_to_patch(patch)?.finish(patch, watch),
        Pins::At(_) => draft.finish(patch, watch),
    }
}

/// The map of least conformal energy with two vertices at these places: from the factored form, or
/// where that has lost its digits from the triangles' equations themselves.
pub(super) fn pinned_map(
    patch: &Patch,
    domain: &Domain,
    pins: [(VertexId, c64); 2],
    watch: &Watch,
) -> Result<PinnedSolution, FlattenError> {
    let vertices = pins.map(|(vertex, _)| vertex);
    let places = pins.map(|(_, place)| place);
    let nothing = vec![c64::ZERO; domain.mesh.vertex_count()];
    let solved = PinnedForm::new(domain, vertices, watch)
        .and_then(|system| system.solve(&nothing, places, watch));
    let lost = match &solved {
        Err(FlattenError::Undetermined { change }) => {
            format!("refining the map moves it by {change:.0e} of its size")
        }
        Err(FlattenError::Solve(SolveError::NotPositiveDefinite { .. })) => {
            "the conformal energy has no positive pivot left".into()
        }
        _ => return solved,
    };
    if domain.mesh.vertex_count() > least_squares::MOST_VERTICES {
        return solved.map_err(|error| thin_patch_told(error, patch));
    }
    let message = format!("{lost}: the patch is thin; solved by orthogonal factorisation instead");
    watch.warn("orthogonal-factorisation", message);
    least_squares::pinned_map(domain, pins, watch)
}

/// The default pins, as far apart in the plane as in space, in unit lengths.
pub(super) fn farthest_pins(
    patch: &Patch,
    watch: &Watch,
) -> Result<[(VertexId, DVec2); 2], Stopped> {
    let vertices: Vec<_> = patch.boundary_vertices().collect();
    let position = |&vertex| patch.unit_surface().position(vertex);
    let points: Vec<_> = vertices.iter().map(position).collect();
    // A boundary loop has three vertices at least, and the patch has an extent.
    let [first, second] = farthest_pair(&points, watch)?.unwrap_or([0, 1]);
    let distance = points[first].distance(points[second]);
    let distance = if distance > 0.0 { distance } else { 1.0 };
    Ok([
        (vertices[first], DVec2::ZERO),
        (vertices[second], DVec2::new(distance, 0.0)),
    ])
}

/// Pins in unit lengths.
fn checked_pins(
    patch: &Patch,
    pins: [(VertexId, DVec2); 2],
) -> Result<[(VertexId, DVec2); 2], FlattenError> {
    let vertices = patch.mesh().vertex_count();
    let [(first, from), (second, to)] = pins;
    for vertex in [first, second] {
        if vertex.index() >= vertices {
            return Err(FlattenError::NoSuchPin { vertex, vertices });
        }
    }
    if first == second {
        return Err(FlattenError::SamePin { vertex: first });
    }
    let distance = from.distance(to);
    if distance.is_nan() || distance <= 0.0 || distance.is_infinite() {
        return Err(FlattenError::PinDistance { distance });
    }
    Ok(pins.map(|(vertex, place)| (vertex, place / patch.unit_length())))
}
