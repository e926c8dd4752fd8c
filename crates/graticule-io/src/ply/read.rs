use glam::{DVec2, DVec3};
use graticule::mesh::NO_VALUE;

use super::header::{Element, Encoding, Header, Property, read_header};
use super::values::{Binary, Values};
use crate::Format;
use crate::error::{Place, Problem, ReadError, quoted};
use crate::read::{Draft, check_indices, push_polygon};
use crate::stream::ByteStream;
use crate::text::Text;
use crate::weld::{CornerCollector, chain_segments, vertex_attribute};

/// Reads a whole PLY file.
pub(crate) fn read(mut stream: ByteStream<'_>, draft: &mut Draft) -> Result<(), ReadError> {
    let header = read_header(&mut stream)?;
    match header.encoding {
        Encoding::Ascii => {
            let text = Text::new(stream, Format::Ply).from_line(header.lines + 1);
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
    for element in &header.elements {
        check_rows(element, header.encoding, &values)?;
        match element.name.as_str() {
            "vertex" => vertices = read_vertices(&mut values, element)?,
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

#[cold]
fn malformed(element: &Element, row: u64, problem: Problem) -> ReadError {
    let place = Place::element(element.name.clone(), row);
    ReadError::malformed(Format::Ply, place, problem)
}

#[cold]
fn truncated(element: &Element, row: u64) -> ReadError {
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
    if !(count >= 0.0 && count.fract() == 0.0) {
        let text = quoted(count.to_string().as_bytes());
        return Err(malformed(element, row, Problem::BadCount { text }));
    }
    let room = values.room(property.scalar);
    if count > room as f64 {
        let problem = Problem::CountBeyondFile {
            elements: format!("entries of {}", property.name),
            claimed: count as u64,
            room,
        };
        return Err(malformed(element, row, problem));
    }
    Ok(count as u64)
}

fn skip_property(
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

/// The vertex properties that are understood, as columns of a row.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Column {
    Position(usize),
    Normal(usize),
    Color(usize),
    Uv(usize),
    Other,
}

impl Column {
    fn named(name: &str) -> Self {
        match name {
            "x" => Self::Position(0),
            "y" => Self::Position(1),
            "z" => Self::Position(2),
            "nx" => Self::Normal(0),
            "ny" => Self::Normal(1),
            "nz" => Self::Normal(2),
            "red" | "r" | "diffuse_red" => Self::Color(0),
            "green" | "g" | "diffuse_green" => Self::Color(1),
            "blue" | "b" | "diffuse_blue" => Self::Color(2),
            "alpha" | "a" | "diffuse_alpha" => Self::Color(3),
            "s" | "u" | "texture_u" | "texture_s" => Self::Uv(0),
            "t" | "v" | "texture_v" | "texture_t" => Self::Uv(1),
            _ => Self::Other,
        }
    }
}

#[derive(Default)]
struct Vertices {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    colors: Vec<[f32; 4]>,
    uvs: Vec<DVec2>,
}

fn read_vertices(values: &mut impl Values, element: &Element) -> Result<Vertices, ReadError> {
    let columns: Vec<Column> = element.properties.iter().map(scalar_column).collect();
    for (axis, property) in ["x", "y", "z"].into_iter().enumerate() {
        if !columns.contains(&Column::Position(axis)) {
            let element = "vertex";
            let problem = Problem::MissingProperty { element, property };
            return Err(ReadError::malformed(Format::Ply, Place::Header, problem));
        }
    }
    let has = |parts: &[Column]| parts.iter().all(|part| columns.contains(part));
    let has_normals = has(&[Column::Normal(0), Column::Normal(1), Column::Normal(2)]);
    let has_colors = has(&[Column::Color(0), Column::Color(1), Column::Color(2)]);
    let has_uvs = has(&[Column::Uv(0), Column::Uv(1)]);
    let mut vertices = Vertices::default();
    vertices.positions.reserve_exact(element.rows as usize);
    let (mut position, mut normal, mut uv) = ([0.0; 3], [0.0; 3], [0.0; 2]);
    let mut color = [0.0, 0.0, 0.0, 1.0];
    for row in 0..element.rows {
        for (property, column) in element.properties.iter().zip(&columns) {
            if *column == Column::Other {
                skip_property(values, element, property, row)?;
                continue;
            }
            let value = values.next(property.scalar)?;
            let value = value.ok_or_else(|| truncated(element, row))?;
            match *column {
                Column::Position(axis) => position[axis] = value,
                Column::Normal(axis) => normal[axis] = value,
                Column::Color(part) => color[part] = (value / property.scalar.full()) as f32,
                Column::Uv(axis) => uv[axis] = value,
                Column::Other => {}
            }
        }
        vertices.positions.push(DVec3::from_array(position));
        if has_normals {
            vertices.normals.push(DVec3::from_array(normal));
        }
        if has_colors {
            vertices.colors.push(color);
        }
        if has_uvs {
            vertices.uvs.push(DVec2::from_array(uv));
        }
    }
    Ok(vertices)
}

fn scalar_column(property: &Property) -> Column {
    if property.count.is_some() {
        Column::Other
    } else {
        Column::named(&property.name)
    }
}

impl Vertices {
    fn store(self, draft: &mut Draft) {
        let soup = &mut draft.soup;
        let corners = soup.polygons.corner_vertices();
        if !self.normals.is_empty() {
            soup.attributes.normals = Some(vertex_attribute(self.normals, corners));
        }
        if !self.uvs.is_empty() {
            let set = vertex_attribute(self.uvs, corners);
            soup.attributes.uv_sets.push(set);
        }
        if !self.colors.is_empty() {
            soup.attributes.vertex_colors = Some(self.colors);
        }
        soup.positions = self.positions;
    }
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
        let index = value as u32;
        if f64::from(index) == value && index < NO_VALUE {
            list.push(index);
        } else if restart && value == -1.0 {
            list.push(NO_VALUE);
        } else {
            return Err(malformed(element, row, bad_index(value)));
        }
    }
    Ok(())
}

#[cold]
fn bad_index(value: f64) -> Problem {
    Problem::BadIndex {
        text: quoted(value.to_string().as_bytes()),
    }
}

fn index_list<'a>(element: &'a Element, property: &'static str) -> Result<&'a Property, ReadError> {
    let lists = element
        .properties
        .iter()
        .filter(|property| property.count.is_some());
    let mut named =
        lists.filter(|list| matches!(list.name.as_str(), "vertex_indices" | "vertex_index"));
    named.next().ok_or_else(|| {
        let element = "face";
        let problem = Problem::MissingProperty { element, property };
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
    let indices = index_list(element, "vertex_indices")?;
    let (mut corners, mut uvs) = (Vec::new(), Vec::new());
    let mut odd = 0_usize;
    for row in 0..element.rows {
        uvs.clear();
        for property in &element.properties {
            if std::ptr::eq(property, indices) {
                read_indices(values, (element, property, row), false, &mut corners)?;
            } else if property.name == "texcoord" && property.count.is_some() {
                for _ in 0..list_count(values, element, property, row)? {
                    let value = values.next(property.scalar)?;
                    uvs.push(value.ok_or_else(|| truncated(element, row))?);
                }
            } else {
                skip_property(values, element, property, row)?;
            }
        }
        if uvs.len() == 2 * corners.len() && !uvs.is_empty() {
            corner_uvs.skip_to(draft.soup.polygons.corner_count());
            for (&vertex, uv) in corners.iter().zip(uvs.chunks_exact(2)) {
                corner_uvs.push(vertex, DVec2::from_slice(uv));
            }
        } else {
            odd += usize::from(!uvs.is_empty());
        }
        push_polygon(&mut draft.soup.polygons, &corners)?;
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

/// Triangle strips with -1 between them. Triangles with a repeated vertex only turn the strip.
fn read_strips(
    values: &mut impl Values,
    element: &Element,
    draft: &mut Draft,
) -> Result<(), ReadError> {
    if element.rows == 0 {
        return Ok(());
    }
    let indices = index_list(element, "vertex_indices")?;
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
            ends[side] = value as u32;
            if f64::from(ends[side]) != value || ends[side] == NO_VALUE {
                return Err(malformed(element, row, bad_index(value)));
            }
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
