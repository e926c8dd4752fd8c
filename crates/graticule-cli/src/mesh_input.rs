//! The mesh that a command reads, and its way to a sound surface.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use graticule::mesh::{PolygonSoup, RepairChanges, RepairError, RepairOptions, Repaired, repair};
use graticule_io::{Format, MeshFile, ReadError, read_bytes, read_file};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::report::to_value;
use crate::session::Session;

/// Standard input's name on the command line, and in messages.
const STDIN: &str = "-";
const STDIN_NAME: &str = "<stdin>";

/// A mesh file that was read.
pub(crate) struct Input {
    pub(crate) path: PathBuf,
    pub(crate) format: Format,
    /// Whether a PLY or STL file is in its text form.
    pub(crate) ascii: bool,
    /// Size of the file; `None` for a pipe.
    pub(crate) bytes: Option<u64>,
    pub(crate) soup: PolygonSoup,
}

impl Input {
    /// Reads the file and passes its warnings on.
    pub(crate) fn read(path: &Path, session: &Session) -> Result<Self, Failure> {
        let _stage = session.watch.stage("read");
        let is_stdin = path.as_os_str() == STDIN;
        let path = if is_stdin {
            Path::new(STDIN_NAME)
        } else {
            path
        };
        let file = if is_stdin {
            read_stdin()
        } else {
            read_file(path)
        };
        let file = file.map_err(|error| Failure::from(error).at(path.display()))?;
        session.check()?;
        for warning in file.warnings {
            session.watch.warn(warning.code, warning.message);
        }
        let metadata = fs::metadata(path).ok().filter(fs::Metadata::is_file);
        Ok(Self {
            path: path.to_path_buf(),
            format: file.format,
            ascii: file.ascii,
            bytes: metadata.map(|metadata| metadata.len()),
            soup: file.soup,
        })
    }

    /// The surface that the file describes, repaired.
    pub(crate) fn repaired(
        &self,
        options: RepairOptions,
        session: &Session,
    ) -> Result<Repaired, Failure> {
        repair(&self.soup, &options, &session.watch)
            .map_err(|error| repair_failure(error).at(self.path.display()))
    }

    /// As [`repaired`](Self::repaired), for commands that were not asked to repair: what it does to
    /// the surface is a warning.
    pub(crate) fn repaired_on_the_way(
        &self,
        options: RepairOptions,
        session: &Session,
    ) -> Result<Repaired, Failure> {
        let repaired = self.repaired(options, session)?;
        for sentence in repaired.changes.of_surface().sentences() {
            session
                .watch
                .warn("repaired", format!("repaired: {sentence}"));
        }
        Ok(repaired)
    }

    /// What the report tells of the file.
    pub(crate) fn to_report(&self) -> Value {
        let soup = &self.soup;
        json!({
            "path": self.path.to_string_lossy(),
            "format": self.format.extension(),
            "bytes": self.bytes,
            "vertices": soup.positions.len(),
            "polygons": soup.polygons.len(),
            "corners": soup.polygons.corner_count(),
            "polylines": soup.polylines.len(),
            "attributes": attributes_to_report(soup),
        })
    }
}

/// Standard input, of which only the content can tell the format.
fn read_stdin() -> Result<MeshFile, ReadError> {
    let mut bytes = Vec::new();
    io::stdin().lock().read_to_end(&mut bytes)?;
    read_bytes(&bytes, None)
}

/// The failure, with the option that may avoid it as the hint.
fn repair_failure(error: RepairError) -> Failure {
    let option = match error {
        RepairError::NonOrientable { .. } => "cut it open with --non-orientable cut",
        RepairError::NonFinitePosition { .. } => {
            "export the mesh again without NaN, or drop the polygons there with --non-finite drop"
        }
        other => return other.into(),
    };
    Failure::new(error.to_string(), option)
}

fn attributes_to_report(soup: &PolygonSoup) -> Value {
    let attributes = &soup.attributes;
    let names = |labels: &Option<graticule::mesh::PolygonLabels>| {
        labels.as_ref().map_or(0, |labels| labels.names.len())
    };
    json!({
        "uv_sets": attributes.uv_sets.iter().map(|set| set.name.as_str()).collect::<Vec<_>>(),
        "normals": attributes.normals.is_some(),
        "vertex_colors": attributes.vertex_colors.is_some(),
        "objects": names(&attributes.objects),
        "groups": names(&attributes.groups),
        "materials": names(&attributes.materials),
        "smoothing_groups": names(&attributes.smoothing_groups),
        "material_libraries": attributes.material_libraries,
    })
}

/// What the report tells of a repair.
pub(crate) fn repair_to_report(changes: &RepairChanges) -> Result<Value, Failure> {
    let mut report = to_value(changes)?;
    if let Value::Object(fields) = &mut report {
        fields.shift_insert(0, "changed".into(), (!changes.is_empty()).into());
    }
    Ok(report)
}
