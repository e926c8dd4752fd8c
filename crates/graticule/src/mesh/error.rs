use super::VertexId;

/// Why triangles do not form a sound, oriented, manifold surface.
///
/// Triangles are numbered as given, before any is accepted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// There is no triangle.
    #[error("the mesh has no faces")]
    NoFaces,
    /// More elements than 32-bit numbers can name.
    #[error("the mesh has {corners} corners; at most {limit} can be numbered")]
    TooLarge {
        /// Corners of all triangles together.
        corners: usize,
        /// Largest number of corners.
        limit: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("face {face}: vertex index {index} is out of range ({vertices} vertices)")]
    IndexOutOfRange {
        /// The triangle.
        face: usize,
        /// The index it names.
        index: u32,
        /// The number of vertices.
        vertices: usize,
    },
    /// A triangle has the same vertex at two corners.
    #[error("face {face} has {vertex} at two corners")]
    RepeatedVertex {
        /// The triangle.
        face: usize,
        /// The vertex.
        vertex: VertexId,
    },
    /// More than two triangles share an edge.
    #[error("the edge between {} and {} has {faces} faces", .ends[0], .ends[1])]
    NonManifoldEdge {
        /// The ends of the edge.
        ends: [VertexId; 2],
        /// Number of triangles there.
        faces: usize,
    },
    /// Two triangles run along their common edge in the same direction.
    #[error("faces {} and {} run in the same direction along the edge from {} to {}",
        .faces[0], .faces[1], .ends[0], .ends[1])]
    InconsistentOrientation {
        /// The ends of the edge, in the direction that both triangles take.
        ends: [VertexId; 2],
        /// The triangles.
        faces: [usize; 2],
    },
    /// The triangles at a vertex form more than one fan.
    #[error("{vertex} joins separate fans of faces (a bow-tie)")]
    NonManifoldVertex {
        /// The vertex.
        vertex: VertexId,
    },
    /// A vertex has no triangle.
    #[error("{vertex} belongs to no face")]
    IsolatedVertex {
        /// The vertex.
        vertex: VertexId,
    },
    /// There is not one position for each vertex.
    #[error("{positions} positions were given for {vertices} vertices")]
    PositionCount {
        /// Positions given.
        positions: usize,
        /// Vertices of the mesh.
        vertices: usize,
    },
    /// A coordinate is not a finite number.
    #[error("{vertex} has the position ({}, {}, {})", .position[0], .position[1], .position[2])]
    NonFinitePosition {
        /// The vertex.
        vertex: VertexId,
        /// Its coordinates.
        position: [f64; 3],
    },
    /// All vertices coincide.
    #[error("the mesh has zero extent: all vertices coincide")]
    ZeroExtent,
    /// Coordinates so large that their differences overflow.
    #[error("the extent of the mesh overflows: {vertex} has a coordinate of {coordinate:e}")]
    ExtentOverflow {
        /// The vertex.
        vertex: VertexId,
        /// Its largest coordinate in magnitude.
        coordinate: f64,
    },
}

impl crate::Hint for MeshError {
    fn hint(&self) -> Option<String> {
        let text = match self {
            Self::NoFaces => "a surface is needed: point clouds and lines cannot be used",
            Self::TooLarge { .. } => "simplify or split the mesh",
            Self::ZeroExtent | Self::ExtentOverflow { .. } => {
                "check the units and the scale with which the file was exported"
            }
            Self::NonFinitePosition { .. } => "export the mesh again, without NaN and infinity",
            Self::PositionCount { .. } | Self::IndexOutOfRange { .. } => {
                "the file or the arrays are damaged: export the mesh again"
            }
            _ => "repair the mesh first",
        };
        Some(text.into())
    }
}
