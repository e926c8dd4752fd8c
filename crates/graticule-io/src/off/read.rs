use glam::{DVec2, DVec3};
use graticule::mesh::NO_VALUE;

use crate::Format;
use crate::error::{Place, Problem, ReadError, quoted};
use crate::format::off_prefix;
use crate::read::{Draft, push_polygon};
use crate::stream::ByteStream;
use crate::text::Text;
use crate::weld::vertex_attribute;

/// Reads a whole OFF file.
pub(crate) fn read(stream: ByteStream<'_>, draft: &mut Draft) -> Result<(), ReadError> {
    let mut text = Text::new(stream, Format::Off).with_comments();
    let header = read_header(&mut text)?;
    let vertices = read_vertices(&mut text, &header)?;
    read_faces(&mut text, &header, draft)?;
    if text.any_word()?.is_some() {
        let line = text.line();
        draft.warn(
            "trailing-data",
            format!("line {line}: the faces are complete here; the rest of the file was ignored"),
        );
    }
    vertices.store(draft);
    Ok(())
}

/// What stands behind the position of each vertex, and how many elements there are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Header {
    weight: bool,
    normal: bool,
    color: bool,
    uv: bool,
    vertices: u64,
    faces: u64,
}

fn read_header(text: &mut Text<'_>) -> Result<Header, ReadError> {
    let Some(mut word) = text.any_word()? else {
        return Err(text.error(Problem::MissingCounts));
    };
    let mut header = Header::default();
    if let Some(prefix) = off_prefix(text.bytes(&word)) {
        header = announced(prefix)?;
        word = text
            .any_word()?
            .ok_or_else(|| text.error(Problem::MissingCounts))?;
    }
    if text.bytes(&word).eq_ignore_ascii_case(b"BINARY") {
        return Err(unsupported("the binary variant"));
    }
    let line = text.line();
    header.vertices = to_count(text, &word)?;
    let Some(word) = text.any_word()? else {
        return Err(text.error(Problem::MissingCounts));
    };
    header.faces = to_count(text, &word)?;
    // The number of edges may be missing, but only from a line that has the other two.
    let edges = if text.line() == line {
        text.word()?
    } else {
        text.any_word()?
    };
    if let Some(word) = edges {
        to_count(text, &word)?;
    }
    check_room(text, &header)?;
    Ok(header)
}

fn announced(prefix: &[u8]) -> Result<Header, ReadError> {
    if prefix.contains(&b'n') {
        return Err(unsupported("nOFF (n-dimensional vertices)"));
    }
    Ok(Header {
        weight: prefix.contains(&b'4'),
        normal: prefix.contains(&b'N'),
        color: prefix.contains(&b'C'),
        uv: prefix.contains(&b'S') || prefix.contains(&b'T'),
        ..Header::default()
    })
}

fn unsupported(feature: &str) -> ReadError {
    ReadError::Unsupported {
        format: Format::Off,
        feature: feature.to_owned(),
    }
}

fn to_count(text: &Text<'_>, word: &std::ops::Range<usize>) -> Result<u64, ReadError> {
    let bytes = text.bytes(word);
    let count = crate::number::parse_integer(bytes).and_then(|count| u64::try_from(count).ok());
    count.ok_or_else(|| {
        text.error(Problem::BadCount {
            text: quoted(bytes),
        })
    })
}

/// Each word takes two bytes at least, with the blank behind it.
fn check_room(text: &Text<'_>, header: &Header) -> Result<(), ReadError> {
    let room = text.remaining().div_ceil(2);
    for (elements, claimed, words) in [
        ("vertices", header.vertices, header.words_per_vertex()),
        ("faces", header.faces, 1),
    ] {
        if claimed > room / words {
            let problem = Problem::CountBeyondFile {
                elements: elements.to_owned(),
                claimed,
                room: room / words,
            };
            return Err(ReadError::malformed(Format::Off, Place::Header, problem));
        }
    }
    if header.vertices >= u64::from(NO_VALUE) {
        return Err(ReadError::TooLarge {
            elements: "vertices",
            limit: u64::from(NO_VALUE) - 1,
        });
    }
    Ok(())
}

impl Header {
    fn words_per_vertex(&self) -> u64 {
        3 + u64::from(self.weight)
            + 3 * u64::from(self.normal)
            + 3 * u64::from(self.color)
            + 2 * u64::from(self.uv)
    }
}

#[derive(Default)]
struct Vertices {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    colors: Vec<[f32; 4]>,
    uvs: Vec<DVec2>,
}

fn read_vertices(text: &mut Text<'_>, header: &Header) -> Result<Vertices, ReadError> {
    let count = header.vertices as usize;
    let room = |present| if present { count } else { 0 };
    let mut vertices = Vertices {
        positions: Vec::with_capacity(count),
        normals: Vec::with_capacity(room(header.normal)),
        colors: Vec::with_capacity(room(header.color)),
        uvs: Vec::with_capacity(room(header.uv)),
    };
    let mut color_words = None;
    for vertex in 0..count {
        let mut next = || number(text, vertex);
        let mut position = DVec3::new(next()?, next()?, next()?);
        if header.weight {
            let weight = next()?;
            if weight == 0.0 {
                return Err(text.error(Problem::ZeroWeight));
            }
            position /= weight;
        }
        vertices.positions.push(position);
        if header.normal {
            let mut next = || number(text, vertex);
            vertices.normals.push(DVec3::new(next()?, next()?, next()?));
        }
        if header.color {
            let color = read_color(text, vertex, header.uv, &mut color_words)?;
            vertices.colors.push(color);
        }
        if header.uv {
            let mut next = || number(text, vertex);
            vertices.uvs.push(DVec2::new(next()?, next()?));
        }
    }
    scale_colors(&mut vertices.colors);
    Ok(vertices)
}

#[inline]
fn number(text: &mut Text<'_>, vertex: usize) -> Result<f64, ReadError> {
    match text.any_word()? {
        Some(word) => text.to_float(&word),
        None => Err(truncated("vertex", vertex)),
    }
}

#[cold]
fn truncated(element: &'static str, index: usize) -> ReadError {
    let problem = Problem::Truncated {
        expected: format!("{element} {index} is not complete"),
    };
    ReadError::malformed(Format::Off, Place::element(element, index), problem)
}

/// Three or four numbers: the line of the first vertex tells which, for all.
fn read_color(
    text: &mut Text<'_>,
    vertex: usize,
    has_uv: bool,
    words: &mut Option<usize>,
) -> Result<[f32; 4], ReadError> {
    let mut color = [0.0, 0.0, 0.0, 1.0];
    for part in &mut color[..3] {
        *part = number(text, vertex)? as f32;
    }
    if let Some(words) = *words {
        if words == 4 {
            color[3] = number(text, vertex)? as f32;
        }
        return Ok(color);
    }
    *words = Some(3);
    // With texture coordinates behind it the line cannot tell; the format asks for four.
    let fourth = if has_uv {
        text.any_word()?
    } else {
        text.word()?
    };
    if let Some(word) = fourth {
        color[3] = text.to_float(&word)? as f32;
        *words = Some(4);
    }
    Ok(color)
}

/// Whole numbers up to 255 are as common as parts of 1.
fn scale_colors(colors: &mut [[f32; 4]]) {
    let largest = colors.iter().flatten().copied().fold(0.0, f32::max);
    if largest > 1.0 {
        let opaque = colors.iter().all(|color| color[3] <= 1.0);
        for color in colors {
            let alpha = if opaque { color[3] } else { color[3] / 255.0 };
            *color = [color[0] / 255.0, color[1] / 255.0, color[2] / 255.0, alpha];
        }
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

fn read_faces(text: &mut Text<'_>, header: &Header, draft: &mut Draft) -> Result<(), ReadError> {
    let mut corners = Vec::new();
    let mut colored = 0_usize;
    let mut line_before = text.line();
    for face in 0..header.faces as usize {
        let Some(word) = text.any_word()? else {
            return Err(truncated("face", face));
        };
        let line = text.line();
        let count = corner_count(text, &word, face)?;
        corners.clear();
        for _ in 0..count {
            corners.push(index(text, face, header.vertices)?);
        }
        push_polygon(&mut draft.soup.polygons, &corners)?;
        // A colour may stand behind a face that has a line of its own.
        if line > line_before && line == text.line() && text.word()?.is_some() {
            colored += 1;
            skip_color(text)?;
        }
        line_before = text.line();
    }
    if colored > 0 {
        draft.warn(
            "face-colors-ignored",
            format!("the colours of {colored} faces were ignored"),
        );
    }
    Ok(())
}

fn corner_count(
    text: &Text<'_>,
    word: &std::ops::Range<usize>,
    face: usize,
) -> Result<u64, ReadError> {
    let count = to_count(text, word)?;
    let room = text.remaining().div_ceil(2);
    if count > room {
        let problem = Problem::CountBeyondFile {
            elements: "corners".to_owned(),
            claimed: count,
            room,
        };
        return Err(ReadError::malformed(
            Format::Off,
            Place::element("face", face),
            problem,
        ));
    }
    Ok(count)
}

#[inline]
fn index(text: &mut Text<'_>, face: usize, vertices: u64) -> Result<u32, ReadError> {
    let Some(word) = text.any_word()? else {
        return Err(truncated("face", face));
    };
    let index = text.to_integer(&word)?;
    match u32::try_from(index) {
        Ok(index) if u64::from(index) < vertices => Ok(index),
        _ => {
            let problem = Problem::IndexOutOfRange {
                kind: "vertex",
                index,
                count: vertices as usize,
            };
            Err(ReadError::malformed(
                Format::Off,
                Place::element("face", face),
                problem,
            ))
        }
    }
}

/// One to four numbers, of which one is read already; more on the line is no colour.
fn skip_color(text: &mut Text<'_>) -> Result<(), ReadError> {
    for _ in 0..3 {
        if text.word()?.is_none() {
            return Ok(());
        }
    }
    match text.word()? {
        None => Ok(()),
        Some(word) => Err(text.error(Problem::Unexpected {
            expected: "a face with at most four numbers of a colour on its line",
            found: quoted(text.bytes(&word)),
        })),
    }
}
