use crate::Hint;
use crate::geometry::GeometryError;
use crate::mesh::{ComponentId, MeshError, VertexId};

use crate::solve::SolveError;
use crate::watch::Stopped;

use super::NotAPatch;

/// Why a patch could not be flattened.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlattenError {
    /// A pin is no vertex of the patch.
    #[error("{vertex} was to be pinned; the patch has {vertices} vertices, counted from 0")]
    NoSuchPin {
        /// The vertex asked for.
        vertex: VertexId,
        /// Vertices of the patch.
        vertices: usize,
    },
    /// Two pins are one.
    #[error("{vertex} was to be pinned twice; two different vertices are needed")]
    SamePin {
        /// The vertex.
        vertex: VertexId,
    },
    /// Pins without a distance, or with an infinite one, do not fix the scale.
    #[error("the pins' places are {distance:e} apart")]
    PinDistance {
        /// Distance of the places.
        distance: f64,
    },
    /// Rounding errors alone change the map.
    #[error("the pins do not determine the map: refining moves it by {change:e} of its size")]
    Undetermined {
        /// The last correction over the size of the map.
        change: f64,
    },
    /// A system made for some fixed vertices is given places of others.
    #[error(
        "places of {given} boundary vertices were given; the system was made for {expected}, not all the same"
    )]
    OtherBoundary {
        /// Fixed vertices of the system.
        expected: usize,
        /// Places given.
        given: usize,
    },
    /// The solution lies on a line or in a point.
    #[error("the map collapses: it has an area of {area:e} of its energy")]
    Collapsed {
        /// Area of the map over its Dirichlet energy.
        area: f64,
    },
    /// The map to improve has flips.
    #[error("the map to start from has {flipped} triangles turned over or collapsed")]
    StartFlipped {
        /// Number of such triangles.
        flipped: usize,
    },
    /// The map to improve without overlaps has some.
    #[error("the boundary of the map to start from meets itself")]
    StartOverlaps,
    /// A component of a surface is no patch.
    #[error("{component}: {reason}")]
    Component {
        /// The component.
        component: ComponentId,
        /// What is in the way.
        reason: NotAPatch,
    },
    /// Double precision has no place for a vertex among its neighbours.
    #[error("no place is left for one more vertex in a map of {vertices}, to double precision")]
    NoRoom {
        /// Vertices laid down so far.
        vertices: usize,
    },
    /// Triangles are too thin to compute with.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The patch with its holes closed is not a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The linear system was not solved.
    #[error(transparent)]
    Solve(SolveError),
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl From<SolveError> for FlattenError {
    fn from(error: SolveError) -> Self {
        match error {
            SolveError::Stopped(stopped) => Self::Stopped(stopped),
            error => Self::Solve(error),
        }
    }
}

impl Hint for FlattenError {
    fn hint(&self) -> Option<String> {
        let text = match self {
            Self::NoSuchPin { .. } | Self::SamePin { .. } => {
                "name two different vertices of the patch, or let the pins be chosen"
            }
            Self::PinDistance { .. } => "give the pins finite places apart from each other",
            Self::OtherBoundary { .. } => "make a new system for these vertices",
            Self::Undetermined { .. } | Self::Collapsed { .. } => {
                "choose other pins, or use the spectral method"
            }
            Self::StartOverlaps => "start from a convex boundary, or let the start be made",
            Self::Component { reason, .. } => return reason.hint(),
            Self::StartFlipped { .. } => {
                "start from mean value weights on a convex curve, or let the start be made"
            }
            Self::NoRoom { .. } => "remesh the thinnest parts of the patch more evenly",
            Self::Geometry(error) => return error.hint(),
            Self::Mesh(error) => return error.hint(),
            Self::Solve(error) => return error.hint(),
            Self::Stopped(stopped) => return stopped.hint(),
        };
        Some(text.into())
    }
}
