use crate::mesh::MeshError;
use crate::watch::Stopped;

/// Why a polygon soup gives no surface.
///
/// Vertices and polygons go by their numbers in the soup.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RepairError {
    /// There is no polygon.
    #[error("the mesh has no faces{}", points(*.vertices))]
    NoFaces {
        /// Number of vertices.
        vertices: usize,
    },
    /// There are polygons, but none spans a face.
    #[error("none of the {polygons} polygons spans a face")]
    NoUsableFaces {
        /// Number of polygons.
        polygons: usize,
    },
    /// Every triangle was dropped.
    #[error("no face is left: none of the polygons has an area")]
    NothingLeft,
    /// A polygon names a vertex that is not there.
    #[error("polygon {polygon}: vertex index {index} is out of range ({vertices} vertices)")]
    IndexOutOfRange {
        /// The polygon.
        polygon: u32,
        /// The index it names.
        index: u32,
        /// The number of vertices.
        vertices: usize,
    },
    /// A vertex of a polygon has a position that is not finite.
    #[error("vertex {vertex} of polygon {polygon} has the position ({}, {}, {})",
        .position[0], .position[1], .position[2])]
    NonFinitePosition {
        /// The vertex.
        vertex: u32,
        /// Its coordinates.
        position: [f64; 3],
        /// A polygon that uses it.
        polygon: u32,
    },
    /// All vertices of polygons coincide.
    #[error("the mesh has zero extent: all vertices coincide")]
    ZeroExtent,
    /// Coordinates so large that their differences overflow.
    #[error("the extent of the mesh overflows: vertex {vertex} has a coordinate of {coordinate:e}")]
    ExtentOverflow {
        /// The vertex.
        vertex: u32,
        /// Its largest coordinate in magnitude.
        coordinate: f64,
    },
    /// A piece of the surface has one side only.
    #[error(
        "non-orientable: the orientations of the piece with polygon {polygon} clash at the edge \
         between vertices {} and {}", .edge[0], .edge[1])]
    NonOrientable {
        /// A polygon of the piece.
        polygon: u32,
        /// An edge at which its orientation does not close.
        edge: [u32; 2],
    },
    /// What is left is no sound mesh, or too large; elements go by their numbers there.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The watch stopped the repair.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

fn points(vertices: usize) -> String {
    match vertices {
        0 => String::new(),
        _ => format!(" (a point cloud of {vertices} vertices)"),
    }
}

impl crate::Hint for RepairError {
    fn hint(&self) -> Option<String> {
        let text = match self {
            Self::NoFaces { .. } => "a surface is needed: point clouds and lines cannot be used",
            Self::NoUsableFaces { .. } | Self::IndexOutOfRange { .. } => {
                "the file or the arrays are damaged: export the mesh again"
            }
            Self::NonFinitePosition { .. } => {
                "export the mesh again without NaN and infinity, or drop the polygons there"
            }
            Self::NothingLeft | Self::ZeroExtent | Self::ExtentOverflow { .. } => {
                "check the units and the scale with which the file was exported"
            }
            Self::NonOrientable { .. } => "let the repair cut it open, or cut it by hand",
            Self::Mesh(error) => return error.hint(),
            Self::Stopped(stopped) => return stopped.hint(),
        };
        Some(text.into())
    }
}
