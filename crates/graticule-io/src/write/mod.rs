//! Writing: what all formats share.

mod error;
mod file;
mod losses;
mod shape;
mod sink;

use std::io::Write;
use std::path::Path;

use graticule::mesh::PolygonSoup;
use graticule::watch::Warning;

use crate::Format;
use crate::{gltf, obj, off, ply, stl};

pub use error::WriteError;
pub(crate) use losses::{Losses, vertex_normals};
pub use shape::has_uv_per_vertex;
pub(crate) use shape::{facets, fits_single, per_vertex, triangles};
pub(crate) use sink::Sink;

/// How to write.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Text where the format has a binary form too: PLY and STL.
    pub ascii: bool,
}

/// Writes a mesh to a file, in `format` or else the one that its name ends on.
///
/// The file appears whole or not at all: it is written beside its place and then renamed. A place
/// that is no regular file, such as a pipe, is written to directly. Polygons are kept where the
/// format has polygons, and cut into triangles elsewhere.
///
/// Returns what the format could not hold.
///
/// # Errors
/// [`WriteError`]: the system's, or what keeps the mesh from being written in that format.
pub fn write_file(
    path: impl AsRef<Path>,
    soup: &PolygonSoup,
    format: Option<Format>,
) -> Result<Vec<Warning>, WriteError> {
    write_file_with(path, soup, format, WriteOptions::default())
}

/// As [`write_file`], with options.
///
/// # Errors
/// As [`write_file`].
pub fn write_file_with(
    path: impl AsRef<Path>,
    soup: &PolygonSoup,
    format: Option<Format>,
    options: WriteOptions,
) -> Result<Vec<Warning>, WriteError> {
    let path = path.as_ref();
    let format =
        format
            .or_else(|| Format::of_path(path))
            .ok_or_else(|| WriteError::UnknownFormat {
                path: path.to_owned(),
            })?;
    file::write_whole(path, |file| write_to_with(file, soup, format, options))
}

/// Writes a mesh to anything that takes bytes, such as the standard output. It need not be
/// buffered.
///
/// # Errors
/// As [`write_file`].
pub fn write_to(
    writer: &mut dyn Write,
    soup: &PolygonSoup,
    format: Format,
) -> Result<Vec<Warning>, WriteError> {
    write_to_with(writer, soup, format, WriteOptions::default())
}

/// As [`write_to`], with options.
///
/// # Errors
/// As [`write_file`].
pub fn write_to_with(
    writer: &mut dyn Write,
    soup: &PolygonSoup,
    format: Format,
    options: WriteOptions,
) -> Result<Vec<Warning>, WriteError> {
    error::check(soup, format)?;
    let mut losses = Losses::new(format);
    let mut sink = Sink::new(writer);
    match format {
        Format::Obj => obj::write(&mut sink, soup, &mut losses)?,
        Format::Ply => ply::write(&mut sink, soup, options.ascii, &mut losses)?,
        Format::Off => off::write(&mut sink, soup, &mut losses)?,
        Format::Stl => stl::write(&mut sink, soup, options.ascii, &mut losses)?,
        Format::Gltf => gltf::write_gltf(&mut sink, soup, &mut losses)?,
        Format::Glb => gltf::write_glb(&mut sink, soup, &mut losses)?,
    }
    sink.finish()?;
    Ok(losses.finish())
}
