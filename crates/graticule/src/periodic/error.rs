use super::grid_map::GRID_EXTENT;
use crate::Hint;
use crate::mesh::{FaceId, VertexId};

/// Why coordinates do not form a [`GridMap`](super::GridMap).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GridMapError {
    /// An array has another size than the mesh.
    #[error("{given} {what} were given, {needed} are needed")]
    Count {
        /// "coordinates", "transitions" or "marks".
        what: &'static str,
        /// Their number.
        given: usize,
        /// The number for this mesh.
        needed: usize,
    },
    /// A coordinate is not a finite number.
    #[error("{vertex} has no finite coordinates in {face}")]
    NonFinite {
        /// The triangle.
        face: FaceId,
        /// The vertex.
        vertex: VertexId,
    },
    /// A coordinate is too large to be exact.
    #[error("{vertex} has the coordinate {coordinate} in {face}; the limit is {GRID_EXTENT}")]
    TooLarge {
        /// The triangle.
        face: FaceId,
        /// The vertex.
        vertex: VertexId,
        /// The larger of its coordinates in magnitude.
        coordinate: f64,
    },
    /// A transition is missing, leads nowhere, or is not undone by the one back.
    #[error("the transition from {face} across the edge between {} and {} {rule}", .ends[0], .ends[1])]
    Transition {
        /// The triangle it leaves from.
        face: FaceId,
        /// The ends of the edge.
        ends: [VertexId; 2],
        /// What is wrong with it.
        rule: &'static str,
    },
    /// The coordinates of a vertex in two triangles, or its coordinates and the fixed point of the
    /// turn round it, are too far apart.
    #[error("{vertex} misses its place by {distance} line spacings between {} and {}", .faces[0], .faces[1])]
    Disagreement {
        /// The triangles; twice the same where a fixed point is missed.
        faces: [FaceId; 2],
        /// The vertex.
        vertex: VertexId,
        /// How far apart, in line spacings.
        distance: f64,
    },
    /// The transitions round a vertex compose to a shift: lines end there.
    #[error("round {vertex} coordinates shift by ({}, {})", .shift[0], .shift[1])]
    Dislocation {
        /// The vertex.
        vertex: VertexId,
        /// The shift, in line spacings.
        shift: [i32; 2],
    },
    /// Subdivision by zero.
    #[error("a map cannot be given 0 lines for each one")]
    Subdivision,
}

impl Hint for GridMapError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::TooLarge { .. } => Some("ask for fewer lines".into()),
            Self::Dislocation { .. } => {
                Some("leave a triangle at that vertex out of the map".into())
            }
            _ => None,
        }
    }
}
