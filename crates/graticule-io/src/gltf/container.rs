use crate::Format;
use crate::error::{Place, Problem, ReadError, quoted};

const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
pub(super) const JSON_CHUNK: u32 = 0x4e4f_534a;
pub(super) const BINARY_CHUNK: u32 = 0x004e_4942;

/// The two parts of a GLB file.
#[derive(Debug, PartialEq)]
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
}

/// Splits a GLB file into its chunks (glTF 2.0 §4.4).
pub(super) fn split(file: &[u8]) -> Result<Container<'_>, ReadError> {
    let short = |claimed| {
        malformed(Problem::ShortFile {
            holds: file.len() as u64,
            claimed,
        })
    };
    let word = |at| little_endian(file, at).ok_or_else(|| short((HEADER + CHUNK_HEADER) as u64));
    let (version, length) = (word(4)?, word(8)? as usize);
    if version != 2 {
        return Err(ReadError::Unsupported {
            format: Format::Glb,
            feature: format!("glTF {version}"),
        });
    }
    if length > file.len() {
        return Err(short(length as u64));
    }
    if length < HEADER {
        return Err(malformed(Problem::BadCount {
            text: quoted(length.to_string().as_bytes()),
        }));
    }
    let mut chunks = Chunks(&file[HEADER..length]);
    let Some((JSON_CHUNK, json)) = chunks.next_chunk()? else {
        return Err(malformed(Problem::Unexpected {
            expected: "a JSON chunk first",
            found: quoted(&file[HEADER..length]),
        }));
    };
    let mut binary = None;
    while let Some((kind, chunk)) = chunks.next_chunk()? {
        // Chunks of other kinds are to be skipped.
        if kind == BINARY_CHUNK {
            binary.get_or_insert(chunk);
        }
    }
    Ok(Container { json, binary })
}

struct Chunks<'a>(&'a [u8]);

impl<'a> Chunks<'a> {
    fn next_chunk(&mut self) -> Result<Option<(u32, &'a [u8])>, ReadError> {
        let (Some(length), Some(kind)) = (little_endian(self.0, 0), little_endian(self.0, 4))
        else {
            return Ok(None);
        };
        let content = &self.0[CHUNK_HEADER..];
        let Some(chunk) = content.get(..length as usize) else {
            return Err(malformed(Problem::BeyondBuffer {
                needed: u64::from(length),
                source_kind: "file",
                available: content.len() as u64,
            }));
        };
        self.0 = &content[length as usize..];
        Ok(Some((kind, chunk)))
    }
}

fn malformed(problem: Problem) -> ReadError {
    ReadError::malformed(Format::Glb, Place::Container, problem)
}

fn little_endian(bytes: &[u8], at: usize) -> Option<u32> {
    let bytes = bytes.get(at..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*bytes))
}
