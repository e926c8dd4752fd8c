use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::Accessors;
use crate::Format;
use crate::error::{Place, Problem, ReadError};
use crate::weld::strip_triangles;

/// The arrays of one primitive, in its own vertex numbers.
pub(super) struct Arrays {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) normals: Option<Vec<[f64; 3]>>,
    /// Set number and values, in the order of the numbers.
    pub(super) uv_sets: Vec<(usize, Vec<[f64; 2]>)>,
    pub(super) colors: Option<Vec<[f64; 4]>>,
    pub(super) shapes: Shapes,
}

/// What the indices of a primitive make.
pub(super) enum Shapes {
    Triangles(Vec<[u32; 3]>),
    Segments(Vec<[u32; 2]>),
    Points,
}

/// Vertices and corners that a primitive has, before any is read.
pub(super) fn size(accessors: &Accessors<'_>, primitive: &Primitive) -> Result<u64, ReadError> {
    let mut size = 0_u64;
    for &attribute in primitive.attributes.values() {
        size = size.saturating_add(accessors.count(attribute)?);
    }
    if let Some(indices) = primitive.indices {
        size = size.saturating_add(accessors.count(indices)?);
    }
    Ok(size)
}

/// Reads a primitive; `place` says which one it is.
pub(super) fn read(
    accessors: &Accessors<'_>,
    primitive: &Primitive,
    place: &Place,
) -> Result<Option<Arrays>, ReadError> {
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let Some(positions) = attribute(Semantic::Positions) else {
        return Ok(None);
    };
    let positions = accessors.vectors::<3>(positions, "POSITION")?;
    let vertices = positions.len();
    let normals = attribute(Semantic::Normals)
        .map(|index| accessors.vectors::<3>(index, "NORMAL"))
        .transpose()?;
    let colors = attribute(Semantic::Colors(0))
        .map(|index| accessors.colors(index))
        .transpose()?;
    let mut uv_sets = Vec::new();
    for (semantic, &index) in &primitive.attributes {
        if let Checked::Valid(Semantic::TexCoords(set)) = semantic {
            uv_sets.push((*set as usize, accessors.vectors::<2>(index, "TEXCOORD")?));
        }
    }
    let lengths = [
        ("NORMAL", normals.as_ref().map(Vec::len)),
        ("COLOR_0", colors.as_ref().map(Vec::len)),
    ];
    let uv_lengths = uv_sets.iter().map(|(_, uvs)| ("TEXCOORD", Some(uvs.len())));
    for (attribute, length) in lengths.into_iter().chain(uv_lengths) {
        check_length(attribute, length, vertices, place)?;
    }
    let indices = match primitive.indices {
        Some(index) => accessors.integers(index)?,
        None => (0..vertices as u32).collect(),
    };
    check_indices(&indices, vertices, place)?;
    Ok(Some(Arrays {
        positions,
        normals,
        uv_sets,
        colors,
        shapes: shapes(primitive, &indices, place)?,
    }))
}

fn malformed(place: &Place, problem: Problem) -> ReadError {
    ReadError::malformed(Format::Gltf, place.clone(), problem)
}

fn check_length(
    attribute: &'static str,
    length: Option<usize>,
    vertices: usize,
    place: &Place,
) -> Result<(), ReadError> {
    match length {
        Some(found) if found != vertices => Err(malformed(
            place,
            Problem::ValueCount {
                attribute,
                found,
                expected: vertices,
            },
        )),
        _ => Ok(()),
    }
}

fn check_indices(indices: &[u32], vertices: usize, place: &Place) -> Result<(), ReadError> {
    match indices.iter().find(|&&index| index as usize >= vertices) {
        None => Ok(()),
        Some(&index) => Err(malformed(
            place,
            Problem::IndexOutOfRange {
                kind: "vertex",
                index: i64::from(index),
                count: vertices,
            },
        )),
    }
}

fn shapes(primitive: &Primitive, indices: &[u32], place: &Place) -> Result<Shapes, ReadError> {
    let whole = |size: usize, shapes| {
        if indices.len().is_multiple_of(size) {
            Ok(())
        } else {
            let count = indices.len();
            Err(malformed(place, Problem::PartialShape { count, shapes }))
        }
    };
    let Checked::Valid(mode) = primitive.mode else {
        return Err(malformed(place, Problem::WrongType { attribute: "mode" }));
    };
    Ok(match mode {
        Mode::Points => Shapes::Points,
        Mode::Lines => {
            let (ends, _) = indices.as_chunks();
            whole(2, "lines")?;
            Shapes::Segments(ends.to_vec())
        }
        Mode::LineStrip => Shapes::Segments(line_strip(indices).collect()),
        Mode::LineLoop => {
            let closing = indices.last().zip(indices.first());
            let closing = closing.map(|(&last, &first)| [last, first]);
            let closing = closing.filter(|_| indices.len() > 1);
            Shapes::Segments(line_strip(indices).chain(closing).collect())
        }
        Mode::Triangles => {
            let (triangles, _) = indices.as_chunks();
            whole(3, "triangles")?;
            Shapes::Triangles(triangles.to_vec())
        }
        Mode::TriangleStrip => Shapes::Triangles(strip_triangles(indices).collect()),
        Mode::TriangleFan => Shapes::Triangles(fan_triangles(indices)),
    })
}

fn line_strip(indices: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    indices.windows(2).map(|ends| [ends[0], ends[1]])
}

fn fan_triangles(indices: &[u32]) -> Vec<[u32; 3]> {
    let Some((&center, rim)) = indices.split_first() else {
        return Vec::new();
    };
    let sides = rim.windows(2);
    sides.map(|side| [center, side[0], side[1]]).collect()
}
