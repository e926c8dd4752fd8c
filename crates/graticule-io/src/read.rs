use std::fs::File;
use std::io::Read;
use std::path::Path;

use glam::{DVec2, DVec3};
use graticule::mesh::{CornerAttribute, NO_VALUE, PolygonSoup, Polygons};
use graticule::watch::Warning;

use crate::error::{Place, Problem, ReadError, WithoutFaces};
use crate::format::{BYTE_ORDER_MARK, Format, HEAD, detect};
use crate::stream::ByteStream;
use crate::{gltf, obj, off, ply, stl};

/// What was read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// The content. All indices are in range, and there is at least one polygon.
    pub soup: PolygonSoup,
    /// The format that the content is of, whatever the name says.
    pub format: Format,
    /// Whether a PLY or STL file is in its text form rather than a binary one.
    pub ascii: bool,
    /// What the file has that the soup has not, and what was odd about it.
    pub warnings: Vec<Warning>,
}

/// Reads a mesh file. The format is found by content first, then by name.
///
/// OBJ, PLY, OFF and STL are streamed: beside the result, memory is a few hundred kilobytes. The
/// buffers of a `.gltf` file are read only from its own folder and the folders below it. What is
/// not a regular file, such as a pipe, is read whole first.
///
/// # Errors
/// [`ReadError`] tells what is wrong and where.
pub fn read_file(path: impl AsRef<Path>) -> Result<MeshFile, ReadError> {
    draft_of_file(path.as_ref())?.finish()
}

/// Reads the polylines of a file as points; an OBJ or PLY file needs no faces for that.
///
/// # Errors
/// [`ReadError`], but for [`ReadError::NoFaces`].
pub fn read_polylines(path: impl AsRef<Path>) -> Result<Vec<Vec<DVec3>>, ReadError> {
    let soup = draft_of_file(path.as_ref())?.soup;
    let points = |line: &Vec<u32>| line.iter().map(|&v| soup.positions[v as usize]).collect();
    Ok(soup.polylines.iter().map(points).collect())
}

fn draft_of_file(path: &Path) -> Result<Draft, ReadError> {
    let mut file = File::open(path)?;
    let metadata = file.metadata()?;
    let hint = Format::of_path(path);
    let source = if metadata.is_file() {
        ByteStream::new(file, metadata.len())
    } else {
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        let size = bytes.len() as u64;
        ByteStream::new(std::io::Cursor::new(bytes), size)
    };
    read_stream(source, hint, Some(path))
}

/// Reads a mesh from bytes in memory, by the same code as [`read_file`].
///
/// `hint` counts where the content does not tell the format. A `.gltf` with buffers in other
/// files is refused.
///
/// # Errors
/// [`ReadError`] tells what is wrong and where.
pub fn read_bytes(bytes: &[u8], hint: Option<Format>) -> Result<MeshFile, ReadError> {
    read_stream(ByteStream::new(bytes, bytes.len() as u64), hint, None)?.finish()
}

fn read_stream(
    mut stream: ByteStream<'_>,
    hint: Option<Format>,
    path: Option<&Path>,
) -> Result<Draft, ReadError> {
    stream.ensure(HEAD)?;
    let head = &stream.available()[..stream.available().len().min(HEAD)];
    let format = detect(head, stream.size(), hint)?;
    if head.starts_with(BYTE_ORDER_MARK) {
        stream.advance(BYTE_ORDER_MARK.len());
    }
    let mut draft = Draft::new(format);
    if let Some(hint) = hint.filter(|&hint| !same_family(hint, format)) {
        draft.warn(
            "format-by-content",
            format!("the name says {hint}, the content is {format}: read as {format}"),
        );
    }
    match format {
        Format::Obj => obj::read(stream, &mut draft)?,
        Format::Ply => ply::read(stream, &mut draft)?,
        Format::Off => off::read(stream, &mut draft)?,
        Format::Stl => stl::read(stream, &mut draft)?,
        Format::Gltf | Format::Glb => gltf::read(stream, path, &mut draft)?,
    }
    Ok(draft)
}

fn same_family(a: Format, b: Format) -> bool {
    let is_gltf = |format| matches!(format, Format::Gltf | Format::Glb);
    a == b || is_gltf(a) && is_gltf(b)
}

/// A mesh file while it is read.
pub(crate) struct Draft {
    pub(crate) soup: PolygonSoup,
    pub(crate) freeform: usize,
    pub(crate) ascii: bool,
    format: Format,
    warnings: Vec<Warning>,
}

impl Draft {
    fn new(format: Format) -> Self {
        Self {
            soup: PolygonSoup::default(),
            freeform: 0,
            ascii: false,
            format,
            warnings: Vec::new(),
        }
    }

    pub(crate) fn format(&self) -> Format {
        self.format
    }

    pub(crate) fn warn(&mut self, code: &'static str, message: impl Into<String>) {
        let message = message.into();
        self.warnings.push(Warning { code, message });
    }

    fn finish(mut self) -> Result<MeshFile, ReadError> {
        if self.soup.polygons.is_empty() {
            let holds = WithoutFaces {
                points: self.soup.positions.len(),
                polylines: self.soup.polylines.len(),
                freeform: self.freeform,
            };
            return Err(ReadError::NoFaces { holds });
        }
        self.warn_of_non_finite_positions();
        self.drop_non_finite_attributes();
        Ok(MeshFile {
            soup: self.soup,
            format: self.format,
            ascii: self.ascii,
            warnings: self.warnings,
        })
    }

    fn warn_of_non_finite_positions(&mut self) {
        let positions = self.soup.positions.iter().enumerate();
        let mut broken = positions.filter(|(_, position)| !position.is_finite());
        if let Some((first, _)) = broken.next() {
            let count = 1 + broken.count();
            self.warn(
                "non-finite-positions",
                format!("vertices with a coordinate that is not finite: {count}, the first is vertex {first}"),
            );
        }
    }

    /// Positions that are not finite are a defect to be named; attributes can be done without.
    fn drop_non_finite_attributes(&mut self) {
        let attributes = &mut self.soup.attributes;
        let mut uvs = 0;
        for set in &mut attributes.uv_sets {
            uvs += drop_values(set, DVec2::ZERO, |value| value.is_finite());
        }
        let mut normals = 0;
        if let Some(set) = &mut attributes.normals {
            normals = drop_values(set, DVec3::ZERO, |value| value.is_finite());
        }
        let colors = attributes
            .vertex_colors
            .as_mut()
            .map_or(0, |colors| bound_colors(colors));
        for (count, kind) in [(uvs, "texture coordinates"), (normals, "normals")] {
            if count > 0 {
                self.warn(
                    "non-finite-attributes",
                    format!("{count} corners have {kind} that are not finite: dropped there"),
                );
            }
        }
        if colors > 0 {
            self.warn(
                "colors-out-of-range",
                format!("{colors} vertices have colours outside of 0..1: cut to that range"),
            );
        }
    }
}

/// Takes values that are not `sound` from their corners; returns how many corners that were.
fn drop_values<T: Copy>(
    set: &mut CornerAttribute<T>,
    blank: T,
    sound: impl Fn(&T) -> bool,
) -> usize {
    if set.values.iter().all(&sound) {
        return 0;
    }
    let mut dropped = 0;
    for index in &mut set.corner_values {
        let value = set.values.get(*index as usize);
        if value.is_some_and(|value| !sound(value)) {
            *index = NO_VALUE;
            dropped += 1;
        }
    }
    for value in &mut set.values {
        if !sound(value) {
            *value = blank;
        }
    }
    dropped
}

fn bound_colors(colors: &mut [[f32; 4]]) -> usize {
    let mut changed = 0;
    for color in colors {
        let bounded = color.map(|part| {
            if part.is_nan() {
                0.0
            } else {
                part.clamp(0.0, 1.0)
            }
        });
        changed += usize::from(bounded.map(f32::to_bits) != color.map(f32::to_bits));
        *color = bounded;
    }
    changed
}

/// Adds a polygon, or refuses it where corners can no longer be numbered.
#[inline]
pub(crate) fn push_polygon(polygons: &mut Polygons, corners: &[u32]) -> Result<(), ReadError> {
    // The last number is NO_VALUE.
    const LIMIT: usize = u32::MAX as usize - 1;
    if polygons.corner_count() + corners.len() > LIMIT {
        return Err(ReadError::TooLarge {
            elements: "corners",
            limit: LIMIT as u64,
        });
    }
    polygons.push(corners);
    Ok(())
}

/// Refuses the first index that is not below the number of vertices.
pub(crate) fn check_indices(
    polygons: &Polygons,
    vertices: usize,
    format: Format,
) -> Result<(), ReadError> {
    let in_range = |&index: &u32| (index as usize) < vertices;
    if polygons.corner_vertices().iter().all(in_range) {
        return Ok(());
    }
    let mut faces = polygons.iter().enumerate();
    let broken = faces.find_map(|(face, corners)| {
        let index = corners.iter().find(|index| !in_range(index))?;
        Some((face, *index))
    });
    broken.map_or(Ok(()), |(face, index)| {
        Err(ReadError::malformed(
            format,
            Place::element("face", face),
            Problem::IndexOutOfRange {
                kind: "vertex",
                index: i64::from(index),
                count: vertices,
            },
        ))
    })
}
