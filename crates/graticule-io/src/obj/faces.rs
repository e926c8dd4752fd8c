use std::ops::Range;

use graticule::mesh::{CornerAttribute, NO_VALUE, Polygons};

use crate::ReadError;
use crate::error::{Problem, quoted};
use crate::read::push_polygon;
use crate::text::Text;

/// How many of each kind of value stand in the file so far.
#[derive(Clone, Copy)]
pub(super) struct Counts {
    pub(super) vertices: usize,
    pub(super) uvs: usize,
    pub(super) normals: usize,
}

/// One word of a face: numbers as in the file, 0 for none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Corner {
    vertex: i64,
    uv: i64,
    normal: i64,
}

/// The vertices of polygons and polylines, which may stand in the file after these.
#[derive(Default)]
pub(super) struct Faces {
    pub(super) polygons: Polygons,
    pub(super) polylines: Vec<Vec<u32>>,
    uvs: OptionalIndices,
    normals: OptionalIndices,
    /// The largest vertex index beyond the vertices read at that time, and its line.
    ahead: Option<(u32, u64)>,
    corners: Vec<u32>,
}

impl Faces {
    /// Reads what stands behind `f`.
    #[inline]
    pub(super) fn polygon(&mut self, text: &mut Text<'_>, counts: Counts) -> Result<(), ReadError> {
        let first = self.polygons.corner_count();
        self.corners.clear();
        while let Some(word) = text.word()? {
            let corner = corner(text, &word)?;
            let position = first + self.corners.len();
            let vertex = self.vertex(text, corner.vertex, counts.vertices)?;
            self.corners.push(vertex);
            self.uvs.set(position, corner.uv, counts.uvs, text.line());
            self.normals
                .set(position, corner.normal, counts.normals, text.line());
        }
        let corners = self.corners.len();
        if corners < 3 {
            return Err(text.error(Problem::TooFewCorners { corners }));
        }
        push_polygon(&mut self.polygons, &self.corners)
    }

    /// Reads what stands behind `l`. Lines of a single point span nothing and are left out.
    pub(super) fn polyline(
        &mut self,
        text: &mut Text<'_>,
        counts: Counts,
    ) -> Result<(), ReadError> {
        let mut line = Vec::new();
        while let Some(word) = text.word()? {
            let corner = corner(text, &word)?;
            line.push(self.vertex(text, corner.vertex, counts.vertices)?);
        }
        if line.len() > 1 {
            line.shrink_to_fit();
            self.polylines.push(line);
        }
        Ok(())
    }

    #[inline]
    fn vertex(&mut self, text: &Text<'_>, index: i64, count: usize) -> Result<u32, ReadError> {
        let resolved = resolve(index, count);
        let Some(vertex) = resolved.filter(|&vertex| vertex < NO_VALUE) else {
            return Err(out_of_range(text, index, count));
        };
        if vertex as usize >= count && self.ahead.is_none_or(|(largest, _)| vertex > largest) {
            self.ahead = Some((vertex, text.line()));
        }
        Ok(vertex)
    }

    /// The index that no vertex came up to, counted from 1, and its line.
    pub(super) fn missing_vertex(&self, vertices: usize) -> Option<(i64, u64)> {
        let (vertex, line) = self.ahead?;
        (vertex as usize >= vertices).then_some((i64::from(vertex) + 1, line))
    }

    /// Texture coordinates of the corners, and how many corners name some that are not there.
    pub(super) fn take_uvs<T>(&mut self, values: Vec<T>) -> (Option<CornerAttribute<T>>, Missing) {
        std::mem::take(&mut self.uvs).finish(values, self.polygons.corner_count())
    }

    /// Normals of the corners, and how many corners name some that are not there.
    pub(super) fn take_normals<T>(
        &mut self,
        values: Vec<T>,
    ) -> (Option<CornerAttribute<T>>, Missing) {
        std::mem::take(&mut self.normals).finish(values, self.polygons.corner_count())
    }
}

#[cold]
fn out_of_range(text: &Text<'_>, index: i64, count: usize) -> ReadError {
    text.error(Problem::IndexOutOfRange {
        kind: "vertex",
        index,
        count,
    })
}

/// References to values that are not there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Missing {
    /// Number of corners.
    pub(super) corners: usize,
    /// Line of one of them.
    pub(super) line: u64,
}

/// Indices that corners may have or not; no memory is used until the first corner has one.
#[derive(Default)]
struct OptionalIndices {
    indices: Vec<u32>,
    missing: Missing,
    ahead: Option<(u32, u64)>,
}

impl OptionalIndices {
    #[inline]
    fn set(&mut self, corner: usize, index: i64, count: usize, line: u64) {
        if index == 0 {
            return;
        }
        self.indices.resize(corner, NO_VALUE);
        let resolved = resolve(index, count).filter(|&value| value < NO_VALUE);
        self.indices.push(resolved.unwrap_or(NO_VALUE));
        match resolved {
            None => {
                self.missing.corners += 1;
                self.missing.line = line;
            }
            Some(value) if value as usize >= count => {
                if self.ahead.is_none_or(|(largest, _)| value > largest) {
                    self.ahead = Some((value, line));
                }
            }
            Some(_) => {}
        }
    }

    fn finish<T>(
        mut self,
        values: Vec<T>,
        corners: usize,
    ) -> (Option<CornerAttribute<T>>, Missing) {
        if self.indices.is_empty() {
            return (None, self.missing);
        }
        self.indices.resize(corners, NO_VALUE);
        if let Some((largest, line)) = self.ahead
            && largest as usize >= values.len()
        {
            self.missing.line = line;
            let beyond = |index: &&mut u32| **index != NO_VALUE && **index as usize >= values.len();
            for index in self.indices.iter_mut().filter(beyond) {
                *index = NO_VALUE;
                self.missing.corners += 1;
            }
        }
        let attribute = CornerAttribute {
            name: String::new(),
            values,
            corner_values: self.indices,
        };
        let used = attribute
            .corner_values
            .iter()
            .any(|&index| index != NO_VALUE);
        (used.then_some(attribute), self.missing)
    }
}

/// Index from 0 for one that counts from 1 forward, or from the last value backward.
#[inline]
fn resolve(index: i64, count: usize) -> Option<u32> {
    let from_zero = if index < 0 {
        count as i64 + index
    } else {
        index - 1
    };
    u32::try_from(from_zero).ok()
}

/// Reads `v`, `v/vt`, `v//vn` or `v/vt/vn`; slashes at the end may be left over.
#[inline]
fn corner(text: &Text<'_>, word: &Range<usize>) -> Result<Corner, ReadError> {
    let bytes = text.bytes(word);
    parse_corner(bytes).ok_or_else(|| {
        text.error(Problem::BadIndex {
            text: quoted(bytes),
        })
    })
}

#[inline]
fn parse_corner(word: &[u8]) -> Option<Corner> {
    let (vertex, rest) = leading_index(word)?;
    if vertex == 0 {
        return None;
    }
    let (uv, rest) = index_behind_slash(rest)?;
    let (normal, rest) = index_behind_slash(rest)?;
    rest.is_empty().then_some(Corner { vertex, uv, normal })
}

#[inline]
fn index_behind_slash(word: &[u8]) -> Option<(i64, &[u8])> {
    match word {
        [b'/', rest @ ..] if rest.first().is_none_or(|&byte| byte == b'/') => Some((0, rest)),
        // An explicit 0 is no index either.
        [b'/', rest @ ..] => leading_index(rest).filter(|(index, _)| *index != 0),
        [] => Some((0, word)),
        _ => None,
    }
}

/// The integer at the start of a word, and what stands behind it.
#[inline]
fn leading_index(word: &[u8]) -> Option<(i64, &[u8])> {
    let (negative, mut rest) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    let mut magnitude = 0_i64;
    let before = rest.len();
    while let [byte @ b'0'..=b'9', tail @ ..] = rest {
        magnitude = magnitude
            .saturating_mul(10)
            .saturating_add(i64::from(byte - b'0'));
        rest = tail;
    }
    (rest.len() < before).then_some((if negative { -magnitude } else { magnitude }, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_all_forms_are_read() {
        let corner = |vertex, uv, normal| Some(Corner { vertex, uv, normal });
        assert_eq!(parse_corner(b"7"), corner(7, 0, 0));
        assert_eq!(parse_corner(b"7/"), corner(7, 0, 0));
        assert_eq!(parse_corner(b"7//"), corner(7, 0, 0));
        assert_eq!(parse_corner(b"7/-2"), corner(7, -2, 0));
        assert_eq!(parse_corner(b"-7//3"), corner(-7, 0, 3));
        assert_eq!(parse_corner(b"+7/2/3"), corner(7, 2, 3));
    }

    #[test]
    fn other_words_are_no_corners() {
        for word in [
            "", "/1", "0", "1/0", "1///", "1/2/3/4", "1.5", "x", "1/x", "-", "1 ",
        ] {
            assert_eq!(parse_corner(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn indices_resolve_from_both_ends() {
        assert_eq!(resolve(1, 5), Some(0));
        assert_eq!(resolve(9, 5), Some(8));
        assert_eq!(resolve(-5, 5), Some(0));
        assert_eq!(resolve(-6, 5), None);
        assert_eq!(resolve(i64::MAX, 5), None);
    }
}
