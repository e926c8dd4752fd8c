use crate::Hint;
use crate::geometry::GeometryError;
use crate::mesh::{MeshError, VertexId};
use crate::solve::SolveError;
use crate::watch::Stopped;

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
    /// The conformal energy of a very thin patch has lost all digits.
    #[error(
        "the patch is too thin for the precision of numbers: its area is {area:.1e} of its squared \
         extent"
    )]
    TooThin {
        /// Area over the square of the largest extent.
        area: f64,
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
            Self::TooThin { .. } => {
                "use the natural method with fewer vertices, which keeps twice the digits, or fix the \
                 boundary"
            }
            Self::OtherBoundary { .. } => "make a new system for these vertices",
            Self::Undetermined { .. } | Self::Collapsed { .. } => {
                "choose other pins, or use the spectral method"
            }
            Self::Geometry(error) => return error.hint(),
            Self::Mesh(error) => return error.hint(),
            Self::Solve(error) => return error.hint(),
            Self::Stopped(stopped) => return stopped.hint(),
        };
        Some(text.into())
    }
}
