//! Mesh files: reading and writing OBJ, PLY, OFF, STL and glTF.
//!
//! Reading gives a [`PolygonSoup`] as the file has it: indices are in range and there is at least
//! one polygon, but coordinates may be NaN and polygons degenerate; `graticule::mesh` names such
//! defects and repairs them. Anything that is not a sound file of its format is a [`ReadError`]
//! that tells the line or the element. Cost is linear in the size of the file, memory that of the
//! mesh; no count in a header is believed beyond what the file has room for.
//!
//! ```
//! use graticule_io::{Format, read_bytes, write_to};
//!
//! let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
//! let file = read_bytes(text, None)?;
//! assert_eq!(file.format, Format::Obj);
//! assert_eq!(file.soup.polygons.vertices(0), [0, 1, 2]);
//!
//! let mut bytes = Vec::new();
//! let losses = write_to(&mut bytes, &file.soup, Format::Ply)?;
//! assert!(losses.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What each format holds:
//!
//! | | polygons | polylines | UVs | normals | colours | names | numbers |
//! |---|---|---|---|---|---|---|---|
//! | OBJ | yes | yes | one set, per corner | per corner | per vertex | yes | double |
//! | PLY | yes | yes | one set, per corner | per vertex | per vertex | no | single or double, as needed |
//! | OFF | yes | no | one set, per vertex | per vertex | per vertex | no | double |
//! | STL | triangles | no | no | no | no | no | single |
//! | glTF, GLB | triangles | yes | any number, per corner | per corner | per vertex | objects, materials | single |
//!
//! Writing tells what was lost, as a list of [`Warning`]s.
//!
//! Images for textures are read and written as PNG, with 8 or 16 bits, and written as `OpenEXR`.
#![forbid(unsafe_code)]

mod error;
mod format;
mod gltf;
mod image;
mod number;
mod obj;
mod off;
mod ply;
mod read;
mod stl;
mod stream;
mod text;
mod weld;
mod write;

pub use error::{OtherKind, Place, Problem, ReadError, WithoutFaces};
pub use format::{Format, UnknownFormat};
pub use graticule::mesh::PolygonSoup;
pub use graticule::watch::Warning;
pub use image::{ImageDepth, ImageError, exr_bytes, png_bytes, read_png};
pub use read::{MeshFile, read_bytes, read_file, read_polylines};
pub use write::{
    WriteError, WriteOptions, has_uv_per_vertex, write_file, write_file_with, write_to,
    write_to_with,
};
