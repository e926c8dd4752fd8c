//! What a command has found out and where that goes.

use std::path::{Path, PathBuf};

use graticule::mesh::PolygonSoup;
use graticule_io::Format;

use crate::arguments::CommonOptions;
use crate::failure::Failure;
use crate::mesh_output::MeshOutput;
use crate::output::{check_distinct, check_writable, write_whole};
use crate::picture::PictureFormat;
use crate::report::Report;
use crate::session::Session;

/// The files that a command was asked for, checked before any work.
pub(crate) struct Plan {
    reports: Vec<PathBuf>,
    /// Further files, under names of the command's own.
    files: Vec<PathBuf>,
    picture: Option<(PathBuf, PictureFormat)>,
    meshes: Vec<MeshOutput>,
    json: bool,
}

impl Plan {
    /// Checks the common options of a command that draws but writes no mesh.
    pub(crate) fn check(common: &CommonOptions) -> Result<Self, Failure> {
        Self::with_mesh(common, None)
    }

    /// Checks the common options of a command that has nothing to draw.
    pub(crate) fn without_picture(common: &CommonOptions, command: &str) -> Result<Self, Failure> {
        if common.picture.is_some() {
            return Err(Failure::usage(
                format!("'graticule {command}' draws no picture"),
                "leave --picture out",
            ));
        }
        Self::with_mesh(common, None)
    }

    /// Checks the common options and the mesh file of a command.
    pub(crate) fn with_mesh(
        common: &CommonOptions,
        mesh: Option<MeshOutput>,
    ) -> Result<Self, Failure> {
        Self::with_meshes(common, mesh.into_iter().collect())
    }

    /// Checks the common options and the mesh files of a command.
    pub(crate) fn with_meshes(
        common: &CommonOptions,
        meshes: Vec<MeshOutput>,
    ) -> Result<Self, Failure> {
        let picture = match &common.picture {
            Some(path) => Some((path.clone(), PictureFormat::of(path)?)),
            None => None,
        };
        let plan = Self {
            reports: common.report.iter().cloned().collect(),
            files: Vec::new(),
            picture,
            meshes,
            json: common.json,
        };
        plan.check_files()?;
        Ok(plan)
    }

    fn check_files(&self) -> Result<(), Failure> {
        if self.json && self.meshes.iter().any(MeshOutput::is_stdout) {
            return Err(Failure::usage(
                "both the mesh and the report are to go to standard output",
                "name a file for one of them: --report FILE.json or -o FILE",
            ));
        }
        let meshes = self.meshes.iter().filter_map(MeshOutput::path);
        let picture = self.picture.as_ref().map(|(path, _)| path.as_path());
        let reports = self.reports.iter().map(PathBuf::as_path);
        let others = self.files.iter().map(PathBuf::as_path);
        let named = meshes.chain(picture).chain(reports);
        let files: Vec<&Path> = named.chain(others).collect();
        check_distinct(&files)?;
        files.into_iter().try_for_each(check_writable)
    }

    /// Writes the report to one more file, beside further files that the outcome will bring.
    pub(crate) fn add(&mut self, report: PathBuf, files: Vec<PathBuf>) -> Result<(), Failure> {
        self.reports.push(report);
        self.files = files;
        self.check_files()
    }

    /// Checks one more file, which the outcome will hold.
    pub(crate) fn add_file(&mut self, path: PathBuf) -> Result<(), Failure> {
        self.files.push(path);
        self.check_files()
    }

    /// The format of the picture that the user wants, if any.
    pub(crate) fn picture_format(&self) -> Option<PictureFormat> {
        self.picture.as_ref().map(|(_, format)| *format)
    }

    /// The format of the mesh that will be written, if any.
    pub(crate) fn mesh_format(&self) -> Option<Format> {
        self.meshes.first().map(MeshOutput::format)
    }

    /// Writes mesh, picture and report, then standard output.
    pub(crate) fn finish(self, session: &Session, outcome: Outcome) -> Result<(), Failure> {
        session.begin_writing()?;
        let watch = &session.watch;
        self.write_files(session, &outcome)?;
        let json = outcome.report.into_json(watch)?;
        for path in &self.reports {
            write_whole(path, |out| out.write_all(json.as_bytes()))?;
        }
        if !outcome.remarks.is_empty() {
            session.console.line(outcome.remarks.trim_end());
        }
        let text = if self.json { &json } else { &outcome.text };
        session.console.data(text.as_bytes())
    }

    /// Writes the mesh, the picture and what else there is beside the report.
    fn write_files(&self, session: &Session, outcome: &Outcome) -> Result<(), Failure> {
        if self.meshes.is_empty() && self.picture.is_none() && outcome.files.is_empty() {
            return Ok(());
        }
        let _stage = session.watch.stage("write");
        let soups = outcome.mesh.iter().chain(&outcome.further_meshes);
        for (output, soup) in self.meshes.iter().zip(soups) {
            output.write(soup, outcome.ascii, session)?;
        }
        for (path, bytes) in &outcome.files {
            write_whole(path, |out| out.write_all(bytes))?;
        }
        if let (Some((path, _)), Some(picture)) = (&self.picture, &outcome.picture) {
            write_whole(path, |out| out.write_all(picture))?;
        }
        Ok(())
    }
}

/// The results of a command.
pub(crate) struct Outcome {
    /// The report.
    pub(crate) report: Report,
    /// The mesh to write.
    pub(crate) mesh: Option<PolygonSoup>,
    /// Meshes to write beside it, in the order of their files.
    pub(crate) further_meshes: Vec<PolygonSoup>,
    /// Whether it is written as text, where the format has a binary form too.
    pub(crate) ascii: bool,
    /// The picture to write, encoded.
    pub(crate) picture: Option<Vec<u8>>,
    /// Further files with their content.
    pub(crate) files: Vec<(PathBuf, Vec<u8>)>,
    /// What goes to standard output where the report does not.
    pub(crate) text: String,
    /// What goes to standard error.
    pub(crate) remarks: String,
}

impl Outcome {
    /// Nothing but a report.
    pub(crate) fn of(report: Report) -> Self {
        Self {
            report,
            mesh: None,
            further_meshes: Vec::new(),
            ascii: false,
            picture: None,
            files: Vec::new(),
            text: String::new(),
            remarks: String::new(),
        }
    }
}
