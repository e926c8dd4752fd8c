//! Stanford PLY: a header that describes tables of numbers and lists, in text or binary.

mod header;
mod read;
mod values;
mod write;

pub(crate) use read::read;
pub(crate) use write::write;
