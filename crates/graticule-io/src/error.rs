use std::fmt;
use std::io;

use graticule::Hint;

use crate::Format;

/// Why no mesh could be read. The message does not repeat the file's name: the caller has it.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The system could not open or read the file.
    #[error("it cannot be read: {0}")]
    Io(#[from] io::Error),
    /// There is not one byte.
    #[error("no mesh data: the file is empty")]
    Empty,
    /// Neither the content nor the name tells of a format that can be read.
    #[error("not a mesh format that can be read: the file begins with {beginning}")]
    Unrecognized {
        /// The first bytes, in quotes.
        beginning: String,
    },
    /// The name promises a format that the content is not.
    #[error("not a {} file: it begins with {beginning}", .format)]
    WrongContent {
        /// The format that the name promises.
        format: Format,
        /// The first bytes, in quotes.
        beginning: String,
    },
    /// A file of another kind, which is known by its first bytes.
    #[error("the file is {}", .kind)]
    OtherKind {
        /// What it is.
        kind: OtherKind,
    },
    /// Text in 16-bit characters.
    #[error("the file looks like UTF-16 text")]
    Utf16,
    /// The file is sound, but needs something that this crate does not read.
    #[error("{format}: {feature} is not supported")]
    Unsupported {
        /// The format of the file.
        format: Format,
        /// What it needs.
        feature: String,
    },
    /// There is no polygon.
    #[error("the mesh has no faces{}", .holds)]
    NoFaces {
        /// What there is instead.
        holds: WithoutFaces,
    },
    /// More elements than 32-bit numbers can name.
    #[error("the mesh has more than {limit} {elements}")]
    TooLarge {
        /// What there is too much of.
        elements: &'static str,
        /// Largest number that can be held.
        limit: u64,
    },
    /// A part of the file breaks a rule of its format.
    #[error("{format}, {place}: {problem}")]
    Malformed {
        /// The format of the file.
        format: Format,
        /// Where.
        place: Place,
        /// What.
        problem: Problem,
    },
}

impl ReadError {
    #[cold]
    pub(crate) fn malformed(format: Format, place: Place, problem: Problem) -> Self {
        Self::Malformed {
            format,
            place,
            problem,
        }
    }
}

/// A kind of file that takes the place of meshes now and then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OtherKind {
    /// Packed by gzip, bzip2, xz or zstd, or an archive of several files.
    Packed(&'static str),
    /// A page that tells of the download instead of the download.
    WebPage,
    /// The placeholder of a file that Git keeps elsewhere.
    LargeFilePointer,
    /// A scene in a format of other tools.
    Scene(&'static str),
}

impl fmt::Display for OtherKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Packed(by) => write!(formatter, "packed ({by})"),
            Self::WebPage => write!(formatter, "a web page"),
            Self::LargeFilePointer => write!(formatter, "a pointer of Git LFS and not the mesh"),
            Self::Scene(of) => write!(formatter, "a scene of {of}"),
        }
    }
}

impl OtherKind {
    fn hint(self) -> &'static str {
        match self {
            Self::Packed(_) => "unpack it first",
            Self::WebPage => "download the file itself",
            Self::LargeFilePointer => "fetch the mesh: git lfs pull",
            Self::Scene(_) => "export the mesh from there as OBJ, PLY, OFF, STL or GLB",
        }
    }
}

/// What a file without polygons holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WithoutFaces {
    /// Vertices.
    pub points: usize,
    /// Polylines.
    pub polylines: usize,
    /// Statements of free-form curves and surfaces.
    pub freeform: usize,
}

impl fmt::Display for WithoutFaces {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.freeform > 0 {
            write!(
                formatter,
                " (free-form curves and surfaces are not supported)"
            )
        } else if self.polylines > 0 {
            write!(formatter, " ({} line elements ignored)", self.polylines)
        } else if self.points > 0 {
            write!(formatter, ": a point cloud of {} vertices", self.points)
        } else {
            Ok(())
        }
    }
}

/// Where in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of text, from 1.
    Line(u64),
    /// The header.
    Header,
    /// An element of a list, from 0, such as face 11.
    Element {
        /// What the element is called.
        name: String,
        /// Its number.
        index: u64,
    },
    /// A primitive of a glTF mesh, both from 0.
    Primitive {
        /// The mesh.
        mesh: usize,
        /// The primitive in the mesh.
        primitive: usize,
    },
    /// The container around the content of a binary glTF file.
    Container,
}

impl Place {
    pub(crate) fn element(name: impl Into<String>, index: impl TryInto<u64>) -> Self {
        Self::Element {
            name: name.into(),
            index: index.try_into().unwrap_or(u64::MAX),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(formatter, "line {line}"),
            Self::Header => write!(formatter, "header"),
            Self::Element { name, index } => write!(formatter, "{name} {index}"),
            Self::Primitive { mesh, primitive } => {
                write!(formatter, "mesh {mesh}, primitive {primitive}")
            }
            Self::Container => write!(formatter, "container"),
        }
    }
}

/// Which rule a part of a file breaks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// A word that should be a number.
    #[error("bad number {text}")]
    BadNumber {
        /// The word, in quotes.
        text: String,
    },
    /// A word that should be a corner of a face.
    #[error("bad index {text}")]
    BadIndex {
        /// The word, in quotes.
        text: String,
    },
    /// A count that is no whole number, or negative.
    #[error("invalid count {text}")]
    BadCount {
        /// The count, in quotes.
        text: String,
    },
    /// A count that is missing.
    #[error("the counts are missing")]
    MissingCounts,
    /// An index that names nothing.
    #[error("{kind} index {index} is out of range (the file has {count})")]
    IndexOutOfRange {
        /// What the index should name.
        kind: &'static str,
        /// The index, counted as the format does.
        index: i64,
        /// How many there are.
        count: usize,
    },
    /// A vertex with too few or too many numbers.
    #[error("a {kind} needs {needed} numbers, found {found}")]
    NumberCount {
        /// What the numbers describe.
        kind: &'static str,
        /// How many it needs.
        needed: &'static str,
        /// How many there are.
        found: usize,
    },
    /// A homogeneous coordinate of zero: a point at infinity.
    #[error("the homogeneous coordinate w is 0")]
    ZeroWeight,
    /// A face without an area to span.
    #[error("a face with fewer than 3 corners ({corners})")]
    TooFewCorners {
        /// Its corners.
        corners: usize,
    },
    /// The file ends too early.
    #[error("unexpected end of file: {expected}")]
    Truncated {
        /// What should still come.
        expected: String,
    },
    /// A count for which the file has no room.
    #[error(
        "{claimed} {elements} are claimed, but the rest of the file has room for {room} at most"
    )]
    CountBeyondFile {
        /// What is counted.
        elements: String,
        /// The count.
        claimed: u64,
        /// The most that could follow.
        room: u64,
    },
    /// A word that does not belong there.
    #[error("expected {expected}, found {found}")]
    Unexpected {
        /// What belongs there.
        expected: &'static str,
        /// What stands there, in quotes.
        found: String,
    },
    /// A PLY element without a property that it needs.
    #[error("{element} has no property {property}")]
    MissingProperty {
        /// The element.
        element: &'static str,
        /// The property.
        property: &'static str,
    },
    /// A PLY type that does not exist.
    #[error("unknown type {name}")]
    UnknownType {
        /// Its name, in quotes.
        name: String,
    },
    /// A PLY header without its last line.
    #[error("end_header is missing")]
    EndlessHeader,
    /// A byte that no text contains.
    #[error("the byte {byte:#04x} in text: the file is damaged or binary")]
    ControlByte {
        /// The byte.
        byte: u8,
    },
    /// A word or name beyond all measure.
    #[error("a word of more than {limit} bytes")]
    LongWord {
        /// The longest that is read.
        limit: usize,
    },
    /// JSON that is not well-formed, or not of the form that glTF asks for.
    #[error("JSON error: {message}")]
    Json {
        /// What the parser says, with line and column.
        message: String,
    },
    /// A file shorter than it says.
    #[error("the file has {holds} bytes, fewer than the {claimed} that its header says")]
    ShortFile {
        /// Bytes there are.
        holds: u64,
        /// Bytes there should be.
        claimed: u64,
    },
    /// A glTF object that refers to another one that is not there.
    #[error("it names {kind} {index}, which does not exist ({count} there)")]
    MissingObject {
        /// What kind of object.
        kind: &'static str,
        /// Its number.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// Data that reaches beyond its buffer.
    #[error("it needs {needed} bytes, but its {source_kind} has {available}")]
    BeyondBuffer {
        /// Bytes needed.
        needed: u64,
        /// What should hold them.
        source_kind: &'static str,
        /// Bytes there are.
        available: u64,
    },
    /// A buffer that cannot be had.
    #[error("the buffer at {uri} is refused: {reason}")]
    BufferRefused {
        /// The address, in quotes.
        uri: String,
        /// Why.
        reason: String,
    },
    /// A glTF node that can be reached in two ways.
    #[error("the node is reached twice: the nodes form a cycle, not a tree")]
    NodeCycle,
    /// Data of a type that the rules do not allow there.
    #[error("{attribute} has a type that is not allowed")]
    WrongType {
        /// The attribute.
        attribute: &'static str,
    },
    /// Attribute arrays of different lengths.
    #[error("{attribute} has {found} values for {expected} vertices")]
    ValueCount {
        /// The attribute.
        attribute: &'static str,
        /// Values there are.
        found: usize,
        /// Values there should be.
        expected: usize,
    },
    /// Indices that do not make whole triangles or lines.
    #[error("{count} indices do not make whole {shapes}")]
    PartialShape {
        /// Number of indices.
        count: usize,
        /// What they should make.
        shapes: &'static str,
    },
    /// Instances that blow a small file up beyond measure.
    #[error(
        "its instances have more than {limit} vertices and corners: too many for a file of this size"
    )]
    TooManyInstances {
        /// The bound.
        limit: u64,
    },
}

impl Hint for ReadError {
    fn hint(&self) -> Option<String> {
        let text = match self {
            Self::Io(error) if error.kind() == io::ErrorKind::NotFound => "check the path",
            Self::Io(error) if error.kind() == io::ErrorKind::IsADirectory => {
                "name a mesh file in that folder"
            }
            Self::Io(_) => "check that it is a file that you may read",
            Self::Unrecognized { .. } => "export the mesh as OBJ, PLY, OFF, STL, glTF or GLB",
            Self::WrongContent { .. } => {
                "the name and the content disagree: check how the file came about"
            }
            Self::OtherKind { kind } => kind.hint(),
            Self::Utf16 => "save the file as UTF-8 or plain ASCII",
            Self::Unsupported { .. } => "export the mesh without it, or as another format",
            Self::NoFaces { holds } if holds.points > 0 => {
                "a surface is needed: export it with its polygons"
            }
            Self::Empty | Self::NoFaces { .. } => "export the mesh again",
            Self::TooLarge { .. } => "simplify or split the mesh",
            Self::Malformed { problem, .. } => return Some(problem.hint().into()),
        };
        Some(text.into())
    }
}

impl Problem {
    fn hint(&self) -> &'static str {
        match self {
            Self::BadNumber { text } if text.contains(',') => {
                "numbers need a decimal point and blanks between them: export in an English locale"
            }
            Self::BadNumber { text } if text.contains("1.#") => {
                "the exporter wrote NaN or infinity: mend the mesh there and export it again"
            }
            Self::IndexOutOfRange { .. } | Self::Truncated { .. } | Self::ShortFile { .. } => {
                "the file is cut short or damaged: export or download it again"
            }
            Self::CountBeyondFile { .. } => "the count is wrong or the file is cut short",
            Self::BufferRefused { .. } => {
                "export as GLB, or put the buffer beside the file under a plain name"
            }
            Self::TooManyInstances { .. } => "export the mesh with its instances made real",
            _ => "export the mesh again, perhaps in another format",
        }
    }
}

/// `bytes` in quotes, made printable and of bounded length.
pub(crate) fn quoted(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    let shown = bytes.get(..LONGEST).unwrap_or(bytes);
    let text: String = crate::text::decode(shown)
        .chars()
        .map(|letter| {
            if letter.is_control() {
                '\u{fffd}'
            } else {
                letter
            }
        })
        .collect();
    let ellipsis = if shown.len() < bytes.len() { "…" } else { "" };
    format!("'{text}{ellipsis}'")
}
