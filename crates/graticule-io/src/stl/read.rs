use std::ops::Range;

use glam::DVec3;

use crate::Format;
use crate::error::{Place, Problem, ReadError, quoted};
use crate::format::{HEAD, STL_FACET, STL_HEADER, is_control};
use crate::obj::LabelRuns;
use crate::read::{Draft, push_polygon};
use crate::stream::ByteStream;
use crate::text::Text;
use crate::weld::{Bits, Numbering};

/// Reads a whole STL file, text or binary.
pub(crate) fn read(stream: ByteStream<'_>, draft: &mut Draft) -> Result<(), ReadError> {
    draft.ascii = is_text_variant(&stream);
    if draft.ascii {
        read_text(Text::new(stream, Format::Stl), draft)
    } else {
        read_binary(stream, draft)
    }
}

/// Binary files may begin with "solid" too, but their facets are not text.
fn is_text_variant(stream: &ByteStream<'_>) -> bool {
    let head = &stream.available()[..stream.available().len().min(HEAD)];
    let count = head.get(80..84).and_then(|bytes| bytes.first_chunk::<4>());
    let count = count.map_or(0, |bytes| u64::from(u32::from_le_bytes(*bytes)));
    let fits = count > 0 && STL_HEADER + STL_FACET * count == stream.size();
    !fits && !head.iter().any(|&byte| is_control(byte))
}

/// Joins vertices with the same coordinates.
struct Welder<K> {
    positions: Vec<DVec3>,
    numbering: Numbering<K>,
}

impl<K: std::hash::Hash + Eq> Welder<K> {
    fn new() -> Self {
        Self {
            positions: Vec::new(),
            numbering: Numbering::default(),
        }
    }

    #[inline]
    fn vertex(&mut self, key: K, position: impl FnOnce() -> DVec3) -> u32 {
        let (vertex, new) = self.numbering.number(key);
        if new {
            self.positions.push(position());
        }
        vertex
    }
}

fn read_binary(mut stream: ByteStream<'_>, draft: &mut Draft) -> Result<(), ReadError> {
    let size = stream.size();
    let short = |claimed| {
        let problem = Problem::ShortFile {
            holds: size,
            claimed,
        };
        ReadError::malformed(Format::Stl, Place::Header, problem)
    };
    if !stream.skip(STL_HEADER - 4)? {
        return Err(short(STL_HEADER));
    }
    let count = stream.take::<4>()?.ok_or_else(|| short(STL_HEADER))?;
    let claimed = u64::from(u32::from_le_bytes(count));
    let facets = facet_count(claimed, stream.remaining(), draft)?;
    let mut welder = Welder::<[u32; 3]>::new();
    let mut attributes = 0_usize;
    for facet in 0..facets {
        let Some(bytes) = stream.take::<{ STL_FACET as usize }>()? else {
            let problem = Problem::Truncated {
                expected: format!("facet {facet} of {facets}"),
            };
            return Err(ReadError::malformed(
                Format::Stl,
                Place::element("facet", facet),
                problem,
            ));
        };
        let corners = [12, 24, 36].map(|start| weld_single(&mut welder, &bytes, start));
        push_polygon(&mut draft.soup.polygons, &corners)?;
        attributes += usize::from(bytes[48..] != [0, 0]);
    }
    if attributes > 0 {
        draft.warn(
            "facet-attributes-ignored",
            format!("the attribute words (colours) of {attributes} facets were ignored"),
        );
    }
    draft.soup.positions = welder.positions;
    Ok(())
}

/// Number of facets to read: never more than the file holds.
fn facet_count(claimed: u64, bytes: u64, draft: &mut Draft) -> Result<u64, ReadError> {
    let room = bytes / STL_FACET;
    if claimed > room {
        let problem = Problem::CountBeyondFile {
            elements: "facets".to_owned(),
            claimed,
            room,
        };
        return Err(ReadError::malformed(Format::Stl, Place::Header, problem));
    }
    if claimed == room && bytes.is_multiple_of(STL_FACET) {
        return Ok(claimed);
    }
    // Whole facets behind the last one counted: the count is wrong, as in files that were
    // written to a pipe. Anything else is not STL data.
    let facets = if bytes.is_multiple_of(STL_FACET) {
        room
    } else {
        claimed
    };
    draft.warn(
        "facet-count",
        format!(
            "the header counts {claimed} facets, the file has {bytes} bytes of them: read {facets}"
        ),
    );
    Ok(facets)
}

#[inline]
fn weld_single(
    welder: &mut Welder<[u32; 3]>,
    facet: &[u8; STL_FACET as usize],
    start: usize,
) -> u32 {
    let coordinates = [0, 4, 8].map(|offset| {
        let at = start + offset;
        f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]])
    });
    // Adding 0 makes -0 and +0 the same.
    let key = coordinates.map(|coordinate| (coordinate + 0.0).to_bits());
    welder.vertex(key, || DVec3::from_array(coordinates.map(f64::from)))
}

fn read_text(text: Text<'_>, draft: &mut Draft) -> Result<(), ReadError> {
    let mut reader = TextReader {
        text,
        welder: Welder::new(),
        names: LabelRuns::default(),
    };
    let mut open = false;
    let mut larger = 0_usize;
    while let Some(word) = reader.text.any_word()? {
        let polygons = draft.soup.polygons.len();
        if reader.is(&word, b"facet") {
            let corners = reader.facet(polygons)?;
            larger += usize::from(corners.len() > 3);
            push_polygon(&mut draft.soup.polygons, &corners)?;
        } else if reader.is(&word, b"solid") {
            let name = reader.text.rest_of_line()?;
            reader.names.begin(polygons, name);
            open = true;
        } else if reader.is(&word, b"endsolid") {
            reader.text.next_line()?;
            open = false;
        } else {
            return Err(reader.unexpected("facet, solid or endsolid", &word));
        }
    }
    if larger > 0 {
        draft.warn(
            "facets-not-triangles",
            format!("{larger} facets have more than three vertices, which STL does not allow"),
        );
    }
    if open {
        draft.warn(
            "endsolid-missing",
            "endsolid is missing at the end of the file",
        );
    }
    draft.soup.attributes.objects = reader.names.finish(draft.soup.polygons.len());
    draft.soup.positions = reader.welder.positions;
    Ok(())
}

struct TextReader<'a> {
    text: Text<'a>,
    welder: Welder<[u64; 3]>,
    names: LabelRuns,
}

impl TextReader<'_> {
    fn is(&self, word: &Range<usize>, keyword: &[u8]) -> bool {
        self.text.bytes(word).eq_ignore_ascii_case(keyword)
    }

    fn unexpected(&self, expected: &'static str, word: &Range<usize>) -> ReadError {
        self.text.error(Problem::Unexpected {
            expected,
            found: quoted(self.text.bytes(word)),
        })
    }

    fn required(&mut self, facet: usize) -> Result<Range<usize>, ReadError> {
        self.text.any_word()?.ok_or_else(|| {
            self.text.error(Problem::Truncated {
                expected: format!("facet {facet} is not complete"),
            })
        })
    }

    fn keyword(&mut self, facet: usize, keyword: &'static str) -> Result<(), ReadError> {
        let word = self.required(facet)?;
        if self.is(&word, keyword.as_bytes()) {
            Ok(())
        } else {
            Err(self.unexpected(keyword, &word))
        }
    }

    /// Reads from behind `facet` to `endfacet`. The normal is not used: it follows from the
    /// vertices, and is often wrong.
    fn facet(&mut self, facet: usize) -> Result<Vec<u32>, ReadError> {
        let mut word = self.required(facet)?;
        while !self.is(&word, b"outer") {
            if self.is(&word, b"endfacet") || self.is(&word, b"vertex") {
                return Err(self.unexpected("outer loop", &word));
            }
            word = self.required(facet)?;
        }
        self.keyword(facet, "loop")?;
        let mut corners = Vec::with_capacity(3);
        loop {
            let word = self.required(facet)?;
            if self.is(&word, b"vertex") {
                corners.push(self.vertex(facet)?);
            } else if self.is(&word, b"endloop") {
                break;
            } else {
                return Err(self.unexpected("vertex or endloop", &word));
            }
        }
        self.keyword(facet, "endfacet")?;
        if corners.len() < 3 {
            let corners = corners.len();
            return Err(self.text.error(Problem::TooFewCorners { corners }));
        }
        Ok(corners)
    }

    fn vertex(&mut self, facet: usize) -> Result<u32, ReadError> {
        let mut position = DVec3::ZERO;
        for axis in 0..3 {
            let word = self.required(facet)?;
            position[axis] = self.text.to_float(&word)?;
        }
        if self.welder.positions.len() >= (u32::MAX - 1) as usize {
            return Err(ReadError::TooLarge {
                elements: "vertices",
                limit: u64::from(u32::MAX - 1),
            });
        }
        Ok(self.welder.vertex(position.bits(), || position))
    }
}
