//! glTF 2 and its binary form GLB. The `gltf` crate reads the JSON; everything that reaches into
//! the buffers is checked here.

mod accessor;
mod buffers;
mod container;
mod primitive;
mod read;
mod scene;
mod write;

pub(crate) use read::read;
pub(crate) use write::{write_glb, write_gltf};

/// Most texture coordinate sets that are read and written.
const UV_SETS: usize = 16;
