use std::ffi::OsStr;
use std::fmt;
use std::path::Path;
use std::str::FromStr;

use glam::DVec2;

use crate::ReadError;
use crate::error::{OtherKind, quoted};

/// A format of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Wavefront OBJ, text.
    Obj,
    /// Stanford PLY, text or binary of either byte order.
    Ply,
    /// Geomview OFF with its relatives COFF, NOFF, STOFF, 4OFF, text.
    Off,
    /// STL, text or binary.
    Stl,
    /// glTF 2 as JSON.
    Gltf,
    /// glTF 2 as one binary file.
    Glb,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 6] = [
        Self::Obj,
        Self::Ply,
        Self::Off,
        Self::Stl,
        Self::Gltf,
        Self::Glb,
    ];

    /// The usual ending of file names, without a dot.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Off => "off",
            Self::Stl => "stl",
            Self::Gltf => "gltf",
            Self::Glb => "glb",
        }
    }

    /// Texture coordinates as they come back from a file of this format: glTF holds them in single
    /// precision and counts v from the top; all others hold them as they are.
    #[must_use]
    pub fn stored_uv(self, uv: DVec2) -> DVec2 {
        match self {
            Self::Gltf | Self::Glb => {
                let [u, down] = [uv.x, 1.0 - uv.y].map(|part| f64::from(part as f32));
                DVec2::new(u, 1.0 - down)
            }
            Self::Obj | Self::Ply | Self::Off | Self::Stl => uv,
        }
    }

    /// The format that the ending of a file's name promises.
    #[must_use]
    pub fn of_path(path: &Path) -> Option<Self> {
        path.extension().and_then(OsStr::to_str)?.parse().ok()
    }
}

impl fmt::Display for Format {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Off => "OFF",
            Self::Stl => "STL",
            Self::Gltf => "glTF",
            Self::Glb => "GLB",
        })
    }
}

/// A word that is the ending of no format's file names.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is not one of obj, ply, off, stl, gltf, glb")]
pub struct UnknownFormat(pub String);

impl FromStr for Format {
    type Err = UnknownFormat;

    /// From the ending of file names, in any case.
    fn from_str(name: &str) -> Result<Self, UnknownFormat> {
        let mut formats = Self::ALL.into_iter();
        formats
            .find(|format| format.extension().eq_ignore_ascii_case(name))
            .ok_or_else(|| UnknownFormat(name.to_owned()))
    }
}

/// How many bytes [`detect`] wants to see.
pub(crate) const HEAD: usize = 4096;

/// Bytes of the header of a binary STL file, count included, and of one of its facets.
pub(crate) const STL_HEADER: u64 = 84;
pub(crate) const STL_FACET: u64 = 50;

/// The format of a file of `size` bytes that begins with `head`; `hint` is what its name promises.
pub(crate) fn detect(head: &[u8], size: u64, hint: Option<Format>) -> Result<Format, ReadError> {
    if head.is_empty() {
        return Err(ReadError::Empty);
    }
    if looks_like_utf16(head) {
        return Err(ReadError::Utf16);
    }
    // The header of a binary STL file may begin with anything.
    if let Some(kind) = other_kind(head).filter(|_| !is_binary_stl(head, size)) {
        return Err(ReadError::OtherKind { kind });
    }
    if let Some(format) = by_content(head, size) {
        return Ok(format);
    }
    match hint {
        Some(format @ (Format::Obj | Format::Off)) if is_text(head) => Ok(format),
        Some(Format::Obj) if begins_as_obj(head) => Ok(Format::Obj),
        Some(Format::Stl) if size >= STL_HEADER && !is_text(head) => Ok(Format::Stl),
        Some(format @ (Format::Gltf | Format::Glb)) if first_word(head).starts_with(b"{") => {
            Ok(format)
        }
        Some(format) => Err(ReadError::WrongContent {
            format,
            beginning: quoted(head),
        }),
        None => Err(ReadError::Unrecognized {
            beginning: quoted(head),
        }),
    }
}

/// The kind of a file that is known and holds no mesh that can be read.
fn other_kind(head: &[u8]) -> Option<OtherKind> {
    const KINDS: [(&[u8], OtherKind); 9] = [
        (b"\x1f\x8b", OtherKind::Packed("gzip")),
        (b"PK\x03\x04", OtherKind::Packed("ZIP archive")),
        (b"BZh", OtherKind::Packed("bzip2")),
        (b"\xfd7zXZ\0", OtherKind::Packed("xz")),
        (b"\x28\xb5\x2f\xfd", OtherKind::Packed("zstd")),
        (b"version https://git-lfs", OtherKind::LargeFilePointer),
        (b"BLENDER", OtherKind::Scene("Blender")),
        (b"Kaydara FBX", OtherKind::Scene("FBX")),
        (b"; FBX", OtherKind::Scene("FBX")),
    ];
    let text = head.trim_ascii_start();
    let is_page = [b"<!DOCTYPE html".as_slice(), b"<html"]
        .iter()
        .any(|start| {
            let beginning = text.get(..start.len());
            beginning.is_some_and(|beginning| beginning.eq_ignore_ascii_case(start))
        });
    let known = KINDS.iter().find(|(start, _)| head.starts_with(start));
    let known = known.map(|(_, kind)| *kind);
    known.or_else(|| is_page.then_some(OtherKind::WebPage))
}

fn by_content(head: &[u8], size: u64) -> Option<Format> {
    let word = first_word(head);
    if head.starts_with(b"glTF") {
        return Some(Format::Glb);
    }
    if head.starts_with(b"ply") && word == b"ply" {
        return Some(Format::Ply);
    }
    if is_binary_stl(head, size) {
        return Some(Format::Stl);
    }
    if !is_text(head) {
        return None;
    }
    if word.starts_with(b"{") {
        Some(Format::Gltf)
    } else if word.eq_ignore_ascii_case(b"solid") {
        Some(Format::Stl)
    } else if off_prefix(word).is_some() {
        Some(Format::Off)
    } else if begins_as_obj(head) {
        Some(Format::Obj)
    } else {
        begins_with_counts(head).then_some(Format::Off)
    }
}

/// Whether the count of facets in the header fits the size exactly. Text has blanks and digits
/// there, which make counts of hundreds of millions.
fn is_binary_stl(head: &[u8], size: u64) -> bool {
    let count = head.get(80..84).and_then(|bytes| bytes.first_chunk::<4>());
    let count = count.map_or(0, |bytes| u64::from(u32::from_le_bytes(*bytes)));
    count > 0 && STL_HEADER + STL_FACET * count == size
}

/// The letters before `OFF` in the first word of an OFF file.
pub(crate) fn off_prefix(word: &[u8]) -> Option<&[u8]> {
    let prefix = word.strip_suffix(b"OFF")?;
    let known = |letter: &u8| matches!(letter, b'S' | b'T' | b'C' | b'N' | b'4' | b'n');
    prefix.iter().all(known).then_some(prefix)
}

/// Whether the first statement that is no comment has a keyword of OBJ.
fn begins_as_obj(head: &[u8]) -> bool {
    const KEYWORDS: [&[u8]; 16] = [
        b"v", b"vt", b"vn", b"vp", b"f", b"fo", b"l", b"p", b"o", b"g", b"s", b"usemtl", b"mtllib",
        b"cstype", b"deg", b"usemap",
    ];
    KEYWORDS.contains(&first_word(head))
}

/// Whether the first line that is no comment is two or three whole numbers: OFF without its name.
fn begins_with_counts(head: &[u8]) -> bool {
    let is_number = |word: &[u8]| word.iter().all(u8::is_ascii_digit);
    let Some(line) = statements(head).next() else {
        return false;
    };
    let mut words = line
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty());
    matches!(words.clone().count(), 2 | 3) && words.all(is_number)
}

/// The first word of the first line that is neither blank nor a comment.
fn first_word(head: &[u8]) -> &[u8] {
    let line = statements(head).next().unwrap_or_default();
    let end = line.iter().position(u8::is_ascii_whitespace);
    &line[..end.unwrap_or(line.len())]
}

fn statements(head: &[u8]) -> impl Iterator<Item = &[u8]> {
    let text = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head);
    let lines = text.split(|byte| matches!(byte, b'\n' | b'\r'));
    lines
        .map(<[u8]>::trim_ascii)
        .filter(|line| !line.is_empty() && !line.starts_with(b"#"))
}

/// UTF-8 for U+FEFF, which some editors put before text.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

fn is_text(head: &[u8]) -> bool {
    !head.iter().any(|&byte| is_control(byte))
}

/// Whether no text contains this byte.
pub(crate) fn is_control(byte: u8) -> bool {
    byte < b' ' && !matches!(byte, b'\t' | b'\n' | b'\r' | 0x0b | 0x0c | 0x1a)
}

/// A byte order mark of UTF-16, or every other byte zero as in Latin text.
fn looks_like_utf16(head: &[u8]) -> bool {
    let marked = head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff");
    let pairs = &head[..head.len().min(64) & !1];
    let zeros = |side: usize| {
        pairs
            .iter()
            .skip(side)
            .step_by(2)
            .filter(|&&byte| byte == 0)
            .count()
    };
    let count = pairs.len() / 2;
    let alternating =
        count >= 4 && (zeros(1) == count && zeros(0) == 0 || zeros(0) == count && zeros(1) == 0);
    alternating || marked && head.iter().take(64).any(|&byte| byte == 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_comes_before_the_name() {
        let cases: [(&[u8], Format); 9] = [
            (b"ply\r\nformat ascii 1.0\n", Format::Ply),
            (b"\xef\xbb\xbf# a\nv 0 0 0\n", Format::Obj),
            (b"\n\n  SOLID x\n facet", Format::Stl),
            (b"# c\nSTCN4OFF # x\n", Format::Off),
            (b"8 12 0\n0 0 0\n", Format::Off),
            (b"  {\"asset\":", Format::Gltf),
            (b"glTF\x02\0\0\0", Format::Glb),
            (b"# Gr\xf6\xdfe\rmtllib a\r", Format::Obj),
            (b"f 1 2 3", Format::Obj),
        ];
        for (head, format) in cases {
            for hint in Format::ALL {
                assert_eq!(detect(head, head.len() as u64, Some(hint)).unwrap(), format);
            }
        }
    }

    #[test]
    fn binary_stl_is_told_by_its_size_and_not_by_its_first_word() {
        let mut bytes = b"solid of SolidWorks".to_vec();
        bytes.resize(84 + 100, 0);
        bytes[80] = 2;
        assert_eq!(detect(&bytes, 184, None).unwrap(), Format::Stl);
    }

    #[test]
    fn other_content_is_refused_by_name() {
        let html = b"<!DOCTYPE html><html>";
        let error = detect(html, 21, Some(Format::Ply)).unwrap_err();
        assert_eq!(error.to_string(), "the file is a web page");
        assert!(matches!(
            detect(html, 21, None),
            Err(ReadError::OtherKind { .. })
        ));
        assert!(matches!(detect(b"", 0, None), Err(ReadError::Empty)));
        assert!(matches!(
            detect(b"v\0 \x001\0 \0", 8, None),
            Err(ReadError::Utf16)
        ));
    }
}
