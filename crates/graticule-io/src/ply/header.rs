use crate::Format;
use crate::error::{Place, Problem, ReadError, quoted};
use crate::stream::{ByteStream, LONGEST_PIECE};
use crate::text::decode;

/// How the body is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Its name in a header.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::I8 => "char",
            Self::U8 => "uchar",
            Self::I16 => "short",
            Self::U16 => "ushort",
            Self::I32 => "int",
            Self::U32 => "uint",
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }

    /// Bytes in a binary file.
    pub(super) fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// What full intensity is in a colour of this type.
    pub(super) fn full(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32_767.0,
            Self::U16 => 65_535.0,
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::F32 | Self::F64 => 1.0,
        }
    }
}

/// A number or a list of numbers in each row of an element.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) scalar: Scalar,
    /// Type of the count, for lists.
    pub(super) count: Option<Scalar>,
}

/// A table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) rows: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// Fewest bytes that a row can take.
    pub(super) fn smallest_row(&self, encoding: Encoding) -> u64 {
        let smallest = |property: &Property| match encoding {
            // One digit and what divides it from the next.
            Encoding::Ascii => 2,
            _ => property.count.unwrap_or(property.scalar).size(),
        };
        self.properties.iter().map(smallest).sum()
    }

    pub(super) fn property(&self, name: &str) -> Option<&Property> {
        self.properties
            .iter()
            .find(|property| property.name == name)
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Lines of the header.
    pub(super) lines: u64,
}

/// Reads up to and including the line `end_header`.
pub(super) fn read_header(stream: &mut ByteStream<'_>) -> Result<Header, ReadError> {
    let mut parser = Parser::default();
    let mut lines = Lines::default();
    loop {
        let line = lines.next(stream)?;
        let problem = match parser.line(&line) {
            Ok(Progress::More) => continue,
            Ok(Progress::Complete) => return parser.finish(lines.read),
            Err(problem) => problem,
        };
        return Err(ReadError::malformed(
            Format::Ply,
            Place::Line(lines.read),
            problem,
        ));
    }
}

/// Lines of the header; how the first one ends tells how all do, so that a binary body may begin
/// with any byte.
#[derive(Default)]
struct Lines {
    read: u64,
    end: Option<&'static [u8]>,
}

impl Lines {
    fn next(&mut self, stream: &mut ByteStream<'_>) -> Result<String, ReadError> {
        stream.ensure(LONGEST_PIECE)?;
        let bytes = stream.available();
        let end: &[u8] = match self.end {
            Some(end) => end,
            None => first_line_end(bytes),
        };
        self.end = Some(if end == b"\r\n" {
            b"\r\n"
        } else if end == b"\r" {
            b"\r"
        } else {
            b"\n"
        });
        let Some(length) = bytes.windows(end.len()).position(|window| window == end) else {
            return Err(ReadError::malformed(
                Format::Ply,
                Place::Header,
                Problem::EndlessHeader,
            ));
        };
        let line = decode(bytes[..length].trim_ascii());
        let length = length + end.len();
        stream.advance(length);
        self.read += 1;
        Ok(line)
    }
}

fn first_line_end(bytes: &[u8]) -> &'static [u8] {
    match memchr::memchr2(b'\r', b'\n', bytes).map(|at| &bytes[at..]) {
        Some([b'\r', b'\n', ..]) => b"\r\n",
        Some([b'\r', ..]) => b"\r",
        _ => b"\n",
    }
}

enum Progress {
    More,
    Complete,
}

#[derive(Default)]
struct Parser {
    started: bool,
    encoding: Option<Encoding>,
    elements: Vec<Element>,
}

impl Parser {
    fn line(&mut self, line: &str) -> Result<Progress, Problem> {
        if !std::mem::replace(&mut self.started, true) {
            return Ok(Progress::More);
        }
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            None | Some("comment" | "obj_info") => {}
            Some("format") => self.format(words)?,
            Some("element") => self.element(words)?,
            Some("property") => self.property(words)?,
            Some("end_header") => return Ok(Progress::Complete),
            Some(word) => {
                return Err(Problem::Unexpected {
                    expected: "a line of a PLY header",
                    found: quoted(word.as_bytes()),
                });
            }
        }
        Ok(Progress::More)
    }

    fn format<'a>(&mut self, mut words: impl Iterator<Item = &'a str>) -> Result<(), Problem> {
        let encoding = words.next().unwrap_or_default();
        let version = words.next().unwrap_or_default();
        self.encoding = match (encoding, version) {
            ("ascii", "1.0") => Some(Encoding::Ascii),
            ("binary_little_endian", "1.0") => Some(Encoding::LittleEndian),
            ("binary_big_endian", "1.0") => Some(Encoding::BigEndian),
            _ => {
                return Err(Problem::Unexpected {
                    expected: "format ascii, binary_little_endian or binary_big_endian 1.0",
                    found: quoted(format!("{encoding} {version}").as_bytes()),
                });
            }
        };
        Ok(())
    }

    fn element<'a>(&mut self, mut words: impl Iterator<Item = &'a str>) -> Result<(), Problem> {
        let name = name(words.next())?;
        let count = words.next().unwrap_or_default();
        let Ok(rows) = count.parse() else {
            return Err(Problem::BadCount {
                text: quoted(count.as_bytes()),
            });
        };
        if self.elements.iter().any(|element| element.name == name) {
            return Err(Problem::Unexpected {
                expected: "an element of another name",
                found: quoted(name.as_bytes()),
            });
        }
        self.elements.push(Element {
            name,
            rows,
            properties: Vec::new(),
        });
        Ok(())
    }

    fn property<'a>(&mut self, mut words: impl Iterator<Item = &'a str>) -> Result<(), Problem> {
        let first = words.next().unwrap_or_default();
        let (count, scalar) = if first == "list" {
            (Some(scalar(words.next())?), scalar(words.next())?)
        } else {
            (None, scalar(Some(first))?)
        };
        let name = name(words.next())?;
        let Some(element) = self.elements.last_mut() else {
            return Err(Problem::Unexpected {
                expected: "an element before its properties",
                found: quoted(name.as_bytes()),
            });
        };
        element.properties.push(Property {
            name,
            scalar,
            count,
        });
        Ok(())
    }

    fn finish(self, lines: u64) -> Result<Header, ReadError> {
        let missing = || {
            let problem = Problem::Unexpected {
                expected: "a format line",
                found: quoted(b"end_header"),
            };
            ReadError::malformed(Format::Ply, Place::Line(lines), problem)
        };
        Ok(Header {
            encoding: self.encoding.ok_or_else(missing)?,
            elements: self.elements,
            lines,
        })
    }
}

fn scalar(word: Option<&str>) -> Result<Scalar, Problem> {
    let name = word.unwrap_or_default();
    Scalar::parse(name).ok_or_else(|| Problem::UnknownType {
        name: quoted(name.as_bytes()),
    })
}

fn name(word: Option<&str>) -> Result<String, Problem> {
    word.map(str::to_owned).ok_or(Problem::Unexpected {
        expected: "a name",
        found: quoted(b""),
    })
}
