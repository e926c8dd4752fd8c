use gltf::json::accessor::sparse::Sparse;
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};

use super::buffers::Buffers;
use crate::Format;
use crate::error::{Place, Problem, ReadError};

/// Reads numbers out of buffers; every reach is checked against the buffer's true length.
pub(super) struct Accessors<'a> {
    pub(super) root: &'a Root,
    pub(super) buffers: &'a Buffers<'a>,
}

/// Equal pieces of bytes at equal distances.
struct Pieces<'a> {
    bytes: &'a [u8],
    stride: usize,
    length: usize,
}

impl<'a> Pieces<'a> {
    fn get(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..][..self.length]
    }
}

impl Accessors<'_> {
    /// Number of values, before any of them is read; refused if the buffer cannot hold them.
    pub(super) fn count(&self, index: Index<Accessor>) -> Result<u64, ReadError> {
        let accessor = self.accessor(index)?;
        let count = accessor.count.0;
        if let (Some(view), Checked::Valid(component), Checked::Valid(kind)) = (
            accessor.buffer_view,
            &accessor.component_type,
            &accessor.type_,
        ) {
            let offset = accessor.byte_offset.unwrap_or_default().0;
            let length = component.0.size() * kind.multiplicity();
            self.pieces(view, offset, count, length)
                .map_err(|problem| Self::error(index, problem))?;
        }
        Ok(count)
    }

    fn accessor(&self, index: Index<Accessor>) -> Result<&Accessor, ReadError> {
        let accessors = &self.root.accessors;
        accessors.get(index.value()).ok_or_else(|| {
            ReadError::malformed(
                Format::Gltf,
                Place::element("accessor", index.value()),
                Problem::MissingObject {
                    kind: "accessor",
                    index: index.value(),
                    count: accessors.len(),
                },
            )
        })
    }

    /// Vectors with `N` components, as floating point; integers are scaled where the accessor
    /// says that they are normalized.
    pub(super) fn vectors<const N: usize>(
        &self,
        index: Index<Accessor>,
        attribute: &'static str,
    ) -> Result<Vec<[f64; N]>, ReadError> {
        let (accessor, component) = self.checked(index, N, attribute)?;
        let normalized = accessor.normalized && component != ComponentType::F32;
        let convert = |piece: &[u8]| {
            std::array::from_fn(|k| {
                let value = to_float(component, &piece[k * component.size()..]);
                if normalized {
                    (value / full(component)).max(-1.0)
                } else {
                    value
                }
            })
        };
        self.collect(index, accessor, component.size() * N, [0.0; N], convert)
    }

    /// Colours with three or four components.
    pub(super) fn colors(&self, index: Index<Accessor>) -> Result<Vec<[f64; 4]>, ReadError> {
        let three = matches!(self.accessor(index)?.type_, Checked::Valid(Type::Vec3));
        if !three {
            return self.vectors::<4>(index, "COLOR_0");
        }
        let colors = self.vectors::<3>(index, "COLOR_0")?;
        Ok(colors.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
    }

    /// Whole numbers, as for indices.
    pub(super) fn integers(&self, index: Index<Accessor>) -> Result<Vec<u32>, ReadError> {
        let (accessor, component) = self.checked(index, 1, "indices")?;
        if !matches!(
            component,
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32
        ) {
            return Err(Self::error(
                index,
                Problem::WrongType {
                    attribute: "indices",
                },
            ));
        }
        let convert = |piece: &[u8]| to_integer(component, piece);
        self.collect(index, accessor, component.size(), 0, convert)
    }

    fn error(index: Index<Accessor>, problem: Problem) -> ReadError {
        ReadError::malformed(
            Format::Gltf,
            Place::element("accessor", index.value()),
            problem,
        )
    }

    fn checked(
        &self,
        index: Index<Accessor>,
        components: usize,
        attribute: &'static str,
    ) -> Result<(&Accessor, ComponentType), ReadError> {
        let accessor = self.accessor(index)?;
        match (&accessor.component_type, &accessor.type_) {
            (Checked::Valid(component), Checked::Valid(kind))
                if kind.multiplicity() == components =>
            {
                Ok((accessor, component.0))
            }
            _ => Err(Self::error(index, Problem::WrongType { attribute })),
        }
    }

    fn collect<T: Copy>(
        &self,
        index: Index<Accessor>,
        accessor: &Accessor,
        length: usize,
        blank: T,
        convert: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, ReadError> {
        let pieced = |pieces: Pieces<'_>| {
            let all = 0..accessor.count.0 as usize;
            all.map(|k| convert(pieces.get(k))).collect()
        };
        let dense = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                self.pieces(view, offset, accessor.count.0, length)
                    .map(pieced)
            }
            None => self.blanks(accessor.count.0, blank),
        };
        let values = dense.and_then(|values| match &accessor.sparse {
            Some(sparse) => self.with_sparse(values, sparse, length, convert),
            None => Ok(values),
        });
        values.map_err(|problem| Self::error(index, problem))
    }

    /// Zeros cost no bytes in the file; more of them than it has bytes make no sense.
    fn blanks<T: Copy>(&self, count: u64, blank: T) -> Result<Vec<T>, Problem> {
        let available = self.buffers.size();
        if count > available {
            return Err(Problem::BeyondBuffer {
                needed: count,
                source_kind: "file",
                available,
            });
        }
        Ok(vec![blank; count as usize])
    }

    fn with_sparse<T>(
        &self,
        mut values: Vec<T>,
        sparse: &Sparse,
        length: usize,
        convert: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, Problem> {
        let Checked::Valid(index_type) = sparse.indices.component_type else {
            let attribute = "sparse indices";
            return Err(Problem::WrongType { attribute });
        };
        let (size, changed) = (index_type.0.size(), sparse.count.0);
        let (at, new) = (&sparse.indices, &sparse.values);
        let places = self.pieces(at.buffer_view, at.byte_offset.0, changed, size)?;
        let news = self.pieces(new.buffer_view, new.byte_offset.0, changed, length)?;
        let count = values.len();
        for k in 0..changed as usize {
            let place = to_integer(index_type.0, places.get(k));
            let value = values.get_mut(place as usize);
            *value.ok_or(Problem::IndexOutOfRange {
                kind: "sparse",
                index: i64::from(place),
                count,
            })? = convert(news.get(k));
        }
        Ok(values)
    }

    /// `count` pieces of `length` bytes from `offset` on in a buffer view.
    fn pieces(
        &self,
        view: Index<gltf::json::buffer::View>,
        offset: u64,
        count: u64,
        length: usize,
    ) -> Result<Pieces<'_>, Problem> {
        let missing = |kind, index: usize, count| Problem::MissingObject { kind, index, count };
        let views = &self.root.buffer_views;
        let index = view.value();
        let view = views
            .get(index)
            .ok_or_else(|| missing("buffer view", index, views.len()))?;
        let buffer = view.buffer.value();
        let bytes = self
            .buffers
            .get(buffer)
            .ok_or_else(|| missing("buffer", buffer, self.root.buffers.len()))?;
        let start = view.byte_offset.unwrap_or_default().0;
        let bytes = slice(bytes, start, view.byte_length.0, "buffer")?;
        let stride = view.byte_stride.map_or(0, |stride| stride.0);
        let stride = if stride == 0 { length } else { stride };
        // `count` pieces end `stride - length` before the last stride does.
        let strides = (stride as u64).saturating_mul(count.saturating_sub(1));
        let needed = if count == 0 {
            0
        } else {
            strides.saturating_add(length as u64)
        };
        let bytes = slice(bytes, offset, needed, "buffer view")?;
        Ok(Pieces {
            bytes,
            stride,
            length,
        })
    }
}

fn slice<'a>(
    bytes: &'a [u8],
    start: u64,
    length: u64,
    source_kind: &'static str,
) -> Result<&'a [u8], Problem> {
    let needed = start.saturating_add(length);
    let available = bytes.len() as u64;
    if needed > available {
        return Err(Problem::BeyondBuffer {
            needed,
            source_kind,
            available,
        });
    }
    Ok(&bytes[start as usize..needed as usize])
}

fn bytes_of<const N: usize>(piece: &[u8]) -> [u8; N] {
    piece.first_chunk::<N>().copied().unwrap_or([0; N])
}

fn to_float(component: ComponentType, piece: &[u8]) -> f64 {
    match component {
        ComponentType::I8 => f64::from(i8::from_le_bytes(bytes_of(piece))),
        ComponentType::U8 => f64::from(u8::from_le_bytes(bytes_of(piece))),
        ComponentType::I16 => f64::from(i16::from_le_bytes(bytes_of(piece))),
        ComponentType::U16 => f64::from(u16::from_le_bytes(bytes_of(piece))),
        ComponentType::U32 => f64::from(u32::from_le_bytes(bytes_of(piece))),
        ComponentType::F32 => f64::from(f32::from_le_bytes(bytes_of(piece))),
    }
}

fn to_integer(component: ComponentType, piece: &[u8]) -> u32 {
    match component {
        ComponentType::U8 => u32::from(u8::from_le_bytes(bytes_of(piece))),
        ComponentType::U16 => u32::from(u16::from_le_bytes(bytes_of(piece))),
        _ => u32::from_le_bytes(bytes_of(piece)),
    }
}

/// What stands for 1 in normalized integers (glTF 2.0 §3.6.2.2).
fn full(component: ComponentType) -> f64 {
    match component {
        ComponentType::I8 => 127.0,
        ComponentType::U8 => 255.0,
        ComponentType::I16 => 32_767.0,
        ComponentType::U16 => 65_535.0,
        ComponentType::U32 => f64::from(u32::MAX),
        ComponentType::F32 => 1.0,
    }
}
