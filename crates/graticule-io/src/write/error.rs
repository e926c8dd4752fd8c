use std::io;
use std::path::PathBuf;

use glam::DVec3;
use graticule::Hint;
use graticule::mesh::{CornerAttribute, PolygonSoup};

use crate::Format;

/// Why a mesh was not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The system could not create or write the file.
    #[error("it cannot be written: {0}")]
    Io(#[from] io::Error),
    /// The file's name does not tell its format.
    #[error("the name {} does not tell the format", .path.display())]
    UnknownFormat {
        /// The name.
        path: PathBuf,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has the position ({}, {}, {})", .position[0], .position[1], .position[2])]
    NonFinitePosition {
        /// The vertex.
        vertex: usize,
        /// Its coordinates.
        position: [f64; 3],
    },
    /// A texture coordinate, normal or colour is NaN or infinite.
    #[error("value {index} of the {attribute} is not finite")]
    NonFiniteAttribute {
        /// The attribute.
        attribute: &'static str,
        /// Number of the value.
        index: usize,
    },
    /// A coordinate beyond the single-precision numbers of the format.
    #[error("vertex {vertex} has a coordinate of {coordinate:e}, too large for {format}")]
    OutOfRange {
        /// The vertex.
        vertex: usize,
        /// The coordinate.
        coordinate: f64,
        /// The format.
        format: Format,
    },
    /// An index names no vertex.
    #[error("{element} {number}: vertex index {index} is out of range ({vertices} vertices)")]
    IndexOutOfRange {
        /// Polygon or polyline.
        element: &'static str,
        /// Its number.
        number: usize,
        /// The index.
        index: u32,
        /// The number of vertices.
        vertices: usize,
    },
    /// The format has no way to hold something that cannot be left out.
    #[error("{format} cannot hold {what}")]
    UnsupportedByFormat {
        /// The format.
        format: Format,
        /// What it cannot hold.
        what: String,
    },
}

impl Hint for WriteError {
    fn hint(&self) -> Option<String> {
        let text = match self {
            Self::Io(_) => "check the folder, the rights and the space on the disk",
            Self::UnknownFormat { .. } => {
                "end the name on .obj, .ply, .off, .stl, .gltf or .glb, or name the format"
            }
            Self::NonFinitePosition { .. } | Self::NonFiniteAttribute { .. } => {
                "repair the mesh first"
            }
            Self::OutOfRange { .. } => "scale the mesh down, or write OBJ, PLY or OFF",
            Self::IndexOutOfRange { .. } => "repair the mesh first",
            Self::UnsupportedByFormat { .. } => "repair the mesh first, or write PLY",
        };
        Some(text.into())
    }
}

/// Refuses what would make a file that no one can read.
pub(super) fn check(soup: &PolygonSoup, format: Format) -> Result<(), WriteError> {
    let single = matches!(format, Format::Stl | Format::Gltf | Format::Glb);
    for (vertex, position) in soup.positions.iter().enumerate() {
        check_position(vertex, *position, single, format)?;
    }
    let vertices = soup.positions.len();
    for (number, corners) in soup.polygons.iter().enumerate() {
        check_indices("polygon", number, corners, vertices)?;
    }
    for (number, line) in soup.polylines.iter().enumerate() {
        check_indices("polyline", number, line, vertices)?;
    }
    if !matches!(format, Format::Ply | Format::Off)
        && let Some(number) = soup.polygons.iter().position(|corners| corners.len() < 3)
    {
        let corners = soup.polygons.vertices(number).len();
        let what = format!("polygon {number} with {corners} corners");
        return Err(WriteError::UnsupportedByFormat { format, what });
    }
    check_attributes(soup)
}

fn check_position(
    vertex: usize,
    position: DVec3,
    single: bool,
    format: Format,
) -> Result<(), WriteError> {
    if !position.is_finite() {
        let position = position.to_array();
        return Err(WriteError::NonFinitePosition { vertex, position });
    }
    let too_large = |coordinate: &f64| !(*coordinate as f32).is_finite();
    match position.to_array().into_iter().find(too_large) {
        Some(coordinate) if single => Err(WriteError::OutOfRange {
            vertex,
            coordinate,
            format,
        }),
        _ => Ok(()),
    }
}

fn check_indices(
    element: &'static str,
    number: usize,
    corners: &[u32],
    vertices: usize,
) -> Result<(), WriteError> {
    match corners.iter().find(|&&index| index as usize >= vertices) {
        None => Ok(()),
        Some(&index) => Err(WriteError::IndexOutOfRange {
            element,
            number,
            index,
            vertices,
        }),
    }
}

fn check_attributes(soup: &PolygonSoup) -> Result<(), WriteError> {
    let attributes = &soup.attributes;
    for set in &attributes.uv_sets {
        check_values("texture coordinates", set, |value| value.is_finite())?;
    }
    if let Some(normals) = &attributes.normals {
        check_values("normals", normals, |value| value.is_finite())?;
    }
    let colors = attributes.vertex_colors.iter().flatten();
    match colors
        .enumerate()
        .find(|(_, color)| color.iter().any(|part| !part.is_finite()))
    {
        None => Ok(()),
        Some((index, _)) => Err(WriteError::NonFiniteAttribute {
            attribute: "colours",
            index,
        }),
    }
}

fn check_values<T>(
    attribute: &'static str,
    set: &CornerAttribute<T>,
    sound: impl Fn(&T) -> bool,
) -> Result<(), WriteError> {
    match set.values.iter().position(|value| !sound(value)) {
        None => Ok(()),
        Some(index) => Err(WriteError::NonFiniteAttribute { attribute, index }),
    }
}
