//! The mesh that a command writes: where to, and in which format.

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use graticule::mesh::PolygonSoup;
use graticule_io::{Format, UnknownFormat, WriteOptions, has_uv_per_vertex, write_to_with};
use serde::{Serialize, Serializer};

use crate::failure::Failure;
use crate::output::{extension, write_whole};
use crate::session::Session;

/// The mesh that a command reads, and the one that it writes.
#[derive(Args, Clone, Debug, Serialize)]
pub(crate) struct MeshPaths {
    /// The mesh (.obj, .ply, .off, .stl, .glb, .gltf); - is standard input
    #[arg(value_name = "MESH")]
    pub(crate) mesh: PathBuf,
    /// Where to write the result (.obj, .ply, .off, .stl, .glb); - is standard output
    #[arg(long, short, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Format to write, if OUT's ending does not tell
    #[arg(long, value_name = "FORMAT", value_parser = parse_format)]
    #[serde(
        serialize_with = "format_name",
        skip_serializing_if = "Option::is_none"
    )]
    format: Option<Format>,
}

impl MeshPaths {
    /// Settles place and format of the result; nothing is touched.
    pub(crate) fn output(&self) -> Result<MeshOutput, Failure> {
        MeshOutput::new(&self.output, self.format)
    }

    /// The same for one of several results: its name stands before the ending of the file's.
    pub(crate) fn output_named(&self, name: &str) -> Result<MeshOutput, Failure> {
        if self.output.as_os_str() == STDOUT {
            return Err(Failure::usage(
                "several meshes cannot go to standard output",
                "name a file: -o OUT.obj becomes OUT-500.obj and so on",
            ));
        }
        let mut file = self.output.file_stem().unwrap_or_default().to_os_string();
        file.push(format!("-{name}"));
        if let Some(ending) = self.output.extension() {
            file.push(".");
            file.push(ending);
        }
        MeshOutput::new(&self.output.with_file_name(file), self.format)
    }
}

#[allow(
    clippy::ref_option,
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature is serde's"
)]
fn format_name<S: Serializer>(format: &Option<Format>, serializer: S) -> Result<S::Ok, S::Error> {
    format.map(Format::extension).serialize(serializer)
}

/// Standard output's name on the command line.
const STDOUT: &str = "-";

/// A mesh file that will be written.
#[derive(Debug)]
pub(crate) struct MeshOutput {
    /// `None` is standard output.
    path: Option<PathBuf>,
    format: Format,
    /// Whether the mesh is of no use without its texture coordinates.
    needs_uvs: bool,
}

impl MeshOutput {
    /// Settles place and format; nothing is touched.
    pub(crate) fn new(path: &Path, format: Option<Format>) -> Result<Self, Failure> {
        let to_stdout = path.as_os_str() == STDOUT;
        let format = match format.or_else(|| Format::of_path(path)) {
            Some(format) => format,
            None if to_stdout => {
                return Err(Failure::usage(
                    "standard output has no ending that tells the format",
                    "name the format: --format obj",
                ));
            }
            None => {
                return Err(Failure::usage(
                    format!(
                        "a mesh cannot be written as '{}' ({})",
                        extension(path),
                        path.display()
                    ),
                    "end its name in .obj, .ply, .off, .stl or .glb, or name the format: --format obj",
                ));
            }
        };
        if format == Format::Gltf {
            return Err(Failure::usage(
                "a mesh cannot be written as glTF in JSON",
                "write it as .glb, which holds the same",
            ));
        }
        Ok(Self {
            path: (!to_stdout).then(|| path.to_path_buf()),
            format,
            needs_uvs: false,
        })
    }

    /// The same output, if its format can hold texture coordinates.
    pub(crate) fn with_uvs(self) -> Result<Self, Failure> {
        if self.format == Format::Stl {
            return Err(Failure::usage(
                "STL cannot hold texture coordinates",
                "write .obj, .ply or .glb",
            ));
        }
        Ok(Self {
            needs_uvs: true,
            ..self
        })
    }

    pub(crate) fn format(&self) -> Format {
        self.format
    }

    pub(crate) fn is_stdout(&self) -> bool {
        self.path.is_none()
    }

    pub(crate) fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// Writes the mesh, and warns of what the format cannot hold.
    ///
    /// PLY and STL are written as text if `ascii` says so.
    pub(crate) fn write(
        &self,
        soup: &PolygonSoup,
        ascii: bool,
        session: &Session,
    ) -> Result<(), Failure> {
        if self.needs_uvs && self.format == Format::Off && !has_uv_per_vertex(soup) {
            return Err(Failure::new(
                "OFF holds one texture coordinate for each vertex, and this mesh has vertices with \
                 several or none",
                "write .obj, .ply or .glb",
            ));
        }
        let mut losses = Vec::new();
        let options = WriteOptions { ascii };
        if let Some(path) = &self.path {
            write_whole(path, |mut out| {
                losses = write_to_with(&mut out, soup, self.format, options)
                    .map_err(io::Error::other)?;
                Ok(())
            })?;
        } else {
            let mut bytes = Vec::new();
            losses = write_to_with(&mut bytes, soup, self.format, options)?;
            session.console.data(&bytes)?;
        }
        for loss in losses {
            session.watch.warn(loss.code, loss.message);
        }
        Ok(())
    }
}

/// A format by the ending of file names.
fn parse_format(name: &str) -> Result<Format, String> {
    name.parse()
        .map_err(|error: UnknownFormat| error.to_string())
}
