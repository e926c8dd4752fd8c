//! Geomview OFF: `[ST][C][N][4][n]OFF`, counts, vertices, faces, all as blank-separated words.

mod read;
mod write;

pub(crate) use read::read;
pub(crate) use write::write;
