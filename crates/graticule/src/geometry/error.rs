use crate::mesh::{EdgeId, FaceId};
use crate::watch::Stopped;

/// Why a geometric quantity cannot be given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// A triangle is so thin that a quotient by its area is not a finite number.
    #[error("{face} is degenerate: its height is {height_ratio:e} of its longest side")]
    DegenerateFace {
        /// The triangle.
        face: FaceId,
        /// Smallest height over longest side, in `0.0..=0.87`.
        height_ratio: f64,
    },
    /// A length is negative or not a finite number.
    #[error("{edge} has the length {length:e}")]
    InvalidLength {
        /// The edge.
        edge: EdgeId,
        /// Its length.
        length: f64,
    },
    /// There is not one length for each edge.
    #[error("{lengths} lengths were given for {edges} edges")]
    LengthCount {
        /// Lengths given.
        lengths: usize,
        /// Edges of the mesh.
        edges: usize,
    },
    /// One side of a triangle is longer than the two others together.
    #[error("the sides of {face} break the triangle inequality: {:e}, {:e}, {:e}",
        .lengths[0], .lengths[1], .lengths[2])]
    TriangleInequality {
        /// The triangle.
        face: FaceId,
        /// The lengths of its sides.
        lengths: [f64; 3],
    },
    /// Lengths outside the range in which fourth powers are ordinary numbers.
    #[error("the longest edge, {edge}, has the length {length:e}, outside 1e-70 to 1e70")]
    Scale {
        /// The longest edge.
        edge: EdgeId,
        /// Its length.
        length: f64,
    },
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl crate::Hint for GeometryError {
    fn hint(&self) -> Option<String> {
        let text = match self {
            Self::DegenerateFace { .. } => {
                "use the intrinsic Delaunay triangulation, which mollifies degenerate triangles"
            }
            Self::TriangleInequality { .. } => "mollify the lengths first",
            Self::InvalidLength { .. } | Self::LengthCount { .. } => {
                "give one finite length that is not negative for each edge"
            }
            Self::Scale { .. } => "normalize the surface first",
            Self::Stopped(stopped) => return stopped.hint(),
        };
        Some(text.into())
    }
}
