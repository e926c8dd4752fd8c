//! STL: triangles without connectivity, in text or binary. Vertices with exactly the same
//! coordinates are joined.

mod read;
mod write;

pub(crate) use read::read;
pub(crate) use write::write;
