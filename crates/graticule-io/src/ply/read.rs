use glam::DVec2;
use graticule::mesh::NO_VALUE;

use super::header::{Element, Encoding, Header, Property, read_header};
use super::values::{Binary, Values};
use super::vertices::{Vertices, is_known_of_vertex};
use crate::Format;
use crate::error::{Place, Problem, ReadError, quoted};
use crate::number::to_unsigned;
use crate::read::{Draft, check_indices, push_polygon};
use crate::stream::ByteStream;
use crate::text::Text;
use crate::weld::{CornerCollector, chain_segments};

/// Reads a whole PLY file.
pub(crate) fn read(mut stream: ByteStream<'_>, draft: &mut Draft) -> Result<(), ReadError> {
    let header = read_header(&mut stream)?;
    draft.ascii = header.encoding == Encoding::Ascii;
    match header.encoding {
        Encoding::Ascii => {
            let text = Text::new(stream, Format::Ply).with_first_line(header.lines + 1);
            read_body(text, &header, draft)
        }
        Encoding::LittleEndian => read_body(Binary::<false>(stream), &header, draft),
        Encoding::BigEndian => read_body(Binary::<true>(stream), &header, draft),
    }
}

fn read_body(mut values: impl Values, header: &Header, draft: &mut Draft) -> Result<(), ReadError> {
    let mut vertices = Vertices::default();
    let mut corner_uvs = CornerCollector::<DVec2>::default();
    let mut segments = Vec::new();
    let mut skipped = Vec::new();
    warn_of_ignored_properties(header, draft);
    for element in &header.elements {
        check_rows(element, header.encoding, &values)?;
        match element.name.as_str() {
            "vertex" => vertices = Vertices::read(&mut values, element)?,
            "face" => read_faces(&mut values, element, draft, &mut corner_uvs)?,
            "tristrips" => read_strips(&mut values, element, draft)?,
            "edge" => segments = read_edges(&mut values, element)?,
            name => {
                skip_rows(&mut values, element)?;
                skipped.push(name);
            }
        }
    }
    if values.remaining() > 0 && header.encoding != Encoding::Ascii {
        let rest = values.remaining();
        draft.warn(
            "trailing-data",
            format!("{rest} bytes behind the last element were ignored"),
        );
    }
    if !skipped.is_empty() {
        draft.warn(
            "elements-ignored",
            format!("unknown elements were ignored: {}", skipped.join(", ")),
        );
    }
    let count = vertices.positions.len();
    check_indices(&draft.soup.polygons, count, Format::Ply)?;
    check_segments(&segments, count)?;
    draft.soup.polylines = chain_segments(segments);
    let corners = draft.soup.polygons.corner_count();
    draft
        .soup
        .attributes
        .uv_sets
        .extend(corner_uvs.finish(corners));
    vertices.store(draft);
    Ok(())
}

/// The names of a face's lists that are understood.
const FACE_LISTS: [&str; 3] = ["vertex_indices", "vertex_index", "texcoord"];

/// Properties of vertices and faces that no attribute stands for.
fn warn_of_ignored_properties(header: &Header, draft: &mut Draft) {
    for element in &header.elements {
        let is_unknown = |property: &&Property| match element.name.as_str() {
            "vertex" => !is_known_of_vertex(property),
            "face" => property.count.is_none() || !FACE_LISTS.contains(&&*property.name),
            _ => false,
        };
        let unknown = element.properties.iter().filter(is_unknown);
        let names: Vec<&str> = unknown.map(|property| &property.name[..]).collect();
        if !names.is_empty() {
            let (element, names) = (&element.name, names.join(", "));
            let message = format!("properties of element {element} were ignored: {names}");
            draft.warn("properties-ignored", message);
        }
    }
}

#[cold]
pub(super) fn malformed(element: &Element, row: u64, problem: Problem) -> ReadError {
    let place = Place::element(element.name.clone(), row);
    ReadError::malformed(Format::Ply, place, problem)
}

#[cold]
pub(super) fn truncated(element: &Element, row: u64) -> ReadError {
    let problem = Problem::Truncated {
        expected: format!("{} {row} of {}", element.name, element.rows),
    };
    malformed(element, row, problem)
}

fn check_rows(
    element: &Element,
    encoding: Encoding,
    values: &impl Values,
) -> Result<(), ReadError> {
    let smallest = element.smallest_row(encoding);
    // The last word of a text needs nothing behind it.
    let bytes = values.remaining() + u64::from(encoding == Encoding::Ascii);
    let room = bytes.checked_div(smallest).unwrap_or(u64::MAX);
    if element.rows > room {
        let problem = Problem::CountBeyondFile {
            elements: format!("rows of element {}", element.name),
            claimed: element.rows,
            room,
        };
        return Err(ReadError::malformed(Format::Ply, Place::Header, problem));
    }
    if element.rows >= u64::from(NO_VALUE) && smallest > 0 {
        return Err(ReadError::TooLarge {
            elements: "rows in one element",
            limit: u64::from(NO_VALUE) - 1,
        });
    }
    Ok(())
}

/// Number of entries of the list that comes next; never more than the file has room for.
#[inline]
fn list_count(
    values: &mut impl Values,
    element: &Element,
    property: &Property,
    row: u64,
) -> Result<u64, ReadError> {
    let Some(scalar) = property.count else {
        return Ok(1);
    };
    let count = values
        .next(scalar)?
        .ok_or_else(|| truncated(element, row))?;
    let Some(entries) = to_unsigned(count).map(u64::from) else {
        let text = quoted(count.to_string().as_bytes());
        return Err(malformed(element, row, Problem::BadCount { text }));
    };
    let room = values.room(property.scalar);
    if entries > room {
        let problem = Problem::CountBeyondFile {
            elements: format!("entries of {}", property.name),
            claimed: entries,
            room,
        };
        return Err(malformed(element, row, problem));
    }
    Ok(entries)
}

pub(super) fn skip_property(
    values: &mut impl Values,
    element: &Element,
    property: &Property,
    row: u64,
) -> Result<(), ReadError> {
    let count = list_count(values, element, property, row)?;
    if values.skip(property.scalar, count)? {
        Ok(())
    } else {
        Err(truncated(element, row))
    }
}

fn skip_rows(values: &mut impl Values, element: &Element) -> Result<(), ReadError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for row in 0..element.rows {
        for property in &element.properties {
            skip_property(values, element, property, row)?;
        }
    }
    Ok(())
}

/// Adds a list of indices to `list`; `restart` allows -1, which ends a strip.
#[inline]
fn read_indices(
    values: &mut impl Values,
    (element, property, row): (&Element, &Property, u64),
    restart: bool,
    list: &mut Vec<u32>,
) -> Result<(), ReadError> {
    list.clear();
    for _ in 0..list_count(values, element, property, row)? {
        let value = values.next(property.scalar)?;
        let value = value.ok_or_else(|| truncated(element, row))?;
        match to_index(value) {
            Some(index) => list.push(index),
            None if restart && to_unsigned(-value) == Some(1) => list.push(NO_VALUE),
            None => return Err(malformed(element, row, bad_index(value))),
        }
    }
    Ok(())
}

#[inline]
fn to_index(value: f64) -> Option<u32> {
    to_unsigned(value).filter(|&index| index < NO_VALUE)
}

#[cold]
fn bad_index(value: f64) -> Problem {
    Problem::BadIndex {
        text: quoted(value.to_string().as_bytes()),
    }
}

/// The list that holds the vertices of faces and strips.
fn index_list(element: &Element) -> Result<&Property, ReadError> {
    let mut named = element.properties.iter().filter(|property| {
        property.count.is_some()
            && matches!(property.name.as_str(), "vertex_indices" | "vertex_index")
    });
    named.next().ok_or_else(|| {
        let problem = Problem::MissingProperty {
            element: "face",
            property: "vertex_indices",
        };
        ReadError::malformed(Format::Ply, Place::Header, problem)
    })
}

fn read_faces(
    values: &mut impl Values,
    element: &Element,
    draft: &mut Draft,
    corner_uvs: &mut CornerCollector<DVec2>,
) -> Result<(), ReadError> {
    if element.rows == 0 {
        return Ok(());
    }
    let indices = index_list(element)?;
    let mut face = Face::default();
    let mut odd = 0_usize;
    for row in 0..element.rows {
        face.read(values, element, indices, row)?;
        if face.uvs.len() == 2 * face.corners.len() && !face.uvs.is_empty() {
            corner_uvs.skip_to(draft.soup.polygons.corner_count());
            for (&vertex, uv) in face.corners.iter().zip(face.uvs.chunks_exact(2)) {
                corner_uvs.push(vertex, DVec2::from_slice(uv));
            }
        } else {
            odd += usize::from(!face.uvs.is_empty());
        }
        push_polygon(&mut draft.soup.polygons, &face.corners)?;
    }
    if odd > 0 {
        draft.warn(
            "texcoord-ignored",
            format!(
                "{odd} faces have a texcoord list that is not two numbers for each corner: ignored"
            ),
        );
    }
    Ok(())
}

/// A row of the element `face`; its memory is used again for each row.
#[derive(Default)]
struct Face {
    corners: Vec<u32>,
    uvs: Vec<f64>,
}

impl Face {
    #[inline]
    fn read(
        &mut self,
        values: &mut impl Values,
        element: &Element,
        indices: &Property,
        row: u64,
    ) -> Result<(), ReadError> {
        self.uvs.clear();
        for property in &element.properties {
            if std::ptr::eq(property, indices) {
                read_indices(values, (element, property, row), false, &mut self.corners)?;
            } else if property.name == "texcoord" && property.count.is_some() {
                self.uvs.clear();
                for _ in 0..list_count(values, element, property, row)? {
                    let value = values.next(property.scalar)?;
                    self.uvs.push(value.ok_or_else(|| truncated(element, row))?);
                }
            } else {
                skip_property(values, element, property, row)?;
            }
        }
        Ok(())
    }
}

/// Triangle strips with -1 between them. Triangles with a repeated vertex only turn the strip.
fn read_strips(
    values: &mut impl Values,
    element: &Element,
    draft: &mut Draft,
) -> Result<(), ReadError> {
    if element.rows == 0 {
        return Ok(());
    }
    let indices = index_list(element)?;
    let mut strip = Vec::new();
    for row in 0..element.rows {
        for property in &element.properties {
            if std::ptr::eq(property, indices) {
                read_indices(values, (element, property, row), true, &mut strip)?;
            } else {
                skip_property(values, element, property, row)?;
            }
        }
        for part in strip.split(|&index| index == NO_VALUE) {
            for triangle in crate::weld::strip_triangles(part) {
                push_polygon(&mut draft.soup.polygons, &triangle)?;
            }
        }
    }
    Ok(())
}

fn read_edges(values: &mut impl Values, element: &Element) -> Result<Vec<[u32; 2]>, ReadError> {
    let is_end = |name| {
        element
            .property(name)
            .is_some_and(|property| property.count.is_none())
    };
    if !is_end("vertex1") || !is_end("vertex2") {
        skip_rows(values, element)?;
        return Ok(Vec::new());
    }
    let mut segments = Vec::new();
    for row in 0..element.rows {
        let mut ends = [0; 2];
        for property in &element.properties {
            let side = match property.name.as_str() {
                "vertex1" => 0,
                "vertex2" => 1,
                _ => {
                    skip_property(values, element, property, row)?;
                    continue;
                }
            };
            let value = values.next(property.scalar)?;
            let value = value.ok_or_else(|| truncated(element, row))?;
            ends[side] =
                to_index(value).ok_or_else(|| malformed(element, row, bad_index(value)))?;
        }
        segments.push(ends);
    }
    Ok(segments)
}

fn check_segments(segments: &[[u32; 2]], vertices: usize) -> Result<(), ReadError> {
    for (row, ends) in segments.iter().enumerate() {
        if let Some(&index) = ends.iter().find(|&&index| index as usize >= vertices) {
            let problem = Problem::IndexOutOfRange {
                kind: "vertex",
                index: i64::from(index),
                count: vertices,
            };
            return Err(ReadError::malformed(
                Format::Ply,
                Place::element("edge", row),
                problem,
            ));
        }
    }
    Ok(())
}
