//! Runs of every command on generated surfaces, for the chores that measure and compare them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use graticule_fixtures::{bumpy_patch, bumpy_sphere};
use serde_json::Value;

use crate::Trouble;
use crate::bench::rings;

/// What a run is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Input {
    /// A bumpy patch with one boundary.
    Patch,
    /// A closed bumpy surface.
    Closed,
    /// What the run of this name wrote.
    Written(&'static str),
}

/// A run of a command.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub(crate) name: &'static str,
    pub(crate) input: Input,
    /// The command and its options, without files.
    pub(crate) words: &'static [&'static str],
}

/// The file of the patch.
const PATCH: &str = "patch.obj";
/// The file of the closed surface.
const CLOSED: &str = "closed.obj";

/// The surfaces that runs are given, as OBJ files.
#[derive(Clone)]
pub(crate) struct Surfaces {
    pub(crate) patch: String,
    pub(crate) closed: String,
}

impl Surfaces {
    /// A bumpy patch and a bumpy sphere of about as many triangles.
    pub(crate) fn of(triangles: u32) -> Self {
        // A patch has half as many vertices as triangles, the sphere 20 times the square of its frequency.
        let frequency = (4 * (triangles / 20)).isqrt().div_ceil(2).max(1);
        Self {
            patch: bumpy_patch(rings(triangles / 2), 1).to_obj(),
            closed: bumpy_sphere(frequency).to_obj(),
        }
    }

    /// The number of triangles of the surface that a run is about.
    pub(crate) fn triangles(&self, input: Input) -> usize {
        let text = if input == Input::Patch {
            &self.patch
        } else {
            &self.closed
        };
        text.lines().filter(|line| line.starts_with("f ")).count()
    }

    /// Writes the files.
    pub(crate) fn write(&self, folder: &Path) -> Result<(), Trouble> {
        for (name, text) in [(PATCH, &self.patch), (CLOSED, &self.closed)] {
            let path = folder.join(name);
            fs::write(&path, text).map_err(|error| Trouble::reading(&path, &error))?;
        }
        Ok(())
    }
}

const fn run(name: &'static str, input: Input, words: &'static [&'static str]) -> Run {
    Run { name, input, words }
}

/// Every command, and every method of flattening. What a run is given is written before it.
pub(crate) const RUNS: [Run; 24] = [
    run("info", Input::Closed, &["info"]),
    run("repair", Input::Closed, &["repair"]),
    run("natural", Input::Patch, &["flatten"]),
    run(
        "spectral",
        Input::Patch,
        &["flatten", "--method", "spectral"],
    ),
    run("conformal", Input::Patch, &["flatten", "--method", "fixed"]),
    run(
        "authalic",
        Input::Patch,
        &["flatten", "--method", "fixed", "--weights", "authalic"],
    ),
    run(
        "mean-value",
        Input::Patch,
        &["flatten", "--method", "fixed", "--weights", "mean-value"],
    ),
    run(
        "intrinsic",
        Input::Patch,
        &["flatten", "--method", "fixed", "--intrinsic-delaunay"],
    ),
    run("optimal", Input::Patch, &["flatten", "--method", "optimal"]),
    run(
        "boundary-optimal",
        Input::Patch,
        &["flatten", "--method", "boundary-optimal", "--steps", "10"],
    ),
    run("target", Input::Patch, &["flatten", "--method", "target"]),
    run("injective", Input::Patch, &["flatten", "--injective"]),
    run(
        "mips",
        Input::Patch,
        &["flatten", "--injective", "--energy", "mips"],
    ),
    run("cut", Input::Closed, &["flatten", "--cut"]),
    run(
        "no-overlap",
        Input::Closed,
        &["flatten", "--cut", "--no-overlap"],
    ),
    run("field", Input::Closed, &["field"]),
    run(
        "lines",
        Input::Closed,
        &["field", "--symmetry", "2", "--seed", "7"],
    ),
    run("curl", Input::Closed, &["field", "--curl-correction"]),
    run("parameterize", Input::Closed, &["parameterize"]),
    run("layout", Input::Closed, &["layout"]),
    run("remesh", Input::Closed, &["remesh", "--quads", "5000"]),
    run("dominant", Input::Closed, &["remesh", "--dominant"]),
    run("measure", Input::Written("cut"), &["measure"]),
    run(
        "measure-quads",
        Input::Written("remesh"),
        &["measure", "--reference", "../closed.obj"],
    ),
];

/// The runs of these names, all if none is named, and those that write what they are given.
pub(crate) fn runs_named(names: &[String]) -> Vec<&'static Run> {
    let is_named = |run: &Run| names.is_empty() || names.iter().any(|name| name == run.name);
    let needed = |run: &Run| {
        let user = |other: &&Run| is_named(other) && other.input == Input::Written(run.name);
        RUNS.iter().any(|other| user(&other))
    };
    let chosen = RUNS.iter().filter(|run| is_named(run) || needed(run));
    chosen.collect()
}

impl Run {
    /// Whether the run ends in a mesh.
    fn writes_mesh(&self) -> bool {
        !matches!(self.words[0], "info" | "measure")
    }

    /// The mesh that the run writes.
    pub(crate) fn mesh_out(&self) -> String {
        format!("{}.obj", self.name)
    }

    /// The report that the run writes.
    fn report_out(&self) -> String {
        format!("{}.json", self.name)
    }

    /// All words of the command; generated surfaces are in the folder above that of the run.
    fn arguments(&self, threads: usize) -> Vec<String> {
        let mesh = match self.input {
            Input::Patch => format!("../{PATCH}"),
            Input::Closed => format!("../{CLOSED}"),
            Input::Written(name) => format!("{name}.obj"),
        };
        let mut words: Vec<String> = self.words.iter().map(|&word| word.into()).collect();
        let report = self.report_out();
        words.extend([mesh, "--quiet".into(), "--report".into(), report]);
        words.extend(["--threads".into(), threads.to_string()]);
        if self.writes_mesh() {
            words.extend(["-o".into(), self.mesh_out()]);
        }
        words
    }
}

/// A program and a folder in which it runs.
pub(crate) struct Runner<'a> {
    program: &'a Path,
    pub(crate) folder: PathBuf,
    threads: usize,
}

impl<'a> Runner<'a> {
    /// Runs `program` in a folder of this name below `surfaces`, where the generated ones are.
    pub(crate) fn new(
        program: &'a Path,
        surfaces: &Path,
        name: &str,
        threads: usize,
    ) -> Result<Self, Trouble> {
        let folder = surfaces.join(name);
        fs::create_dir_all(&folder).map_err(|error| Trouble::reading(&folder, &error))?;
        Ok(Self {
            program,
            folder,
            threads,
        })
    }

    /// Runs a command and returns its report.
    ///
    /// # Errors
    /// What the command says if it fails.
    pub(crate) fn report(&self, run: &Run, more: &[&str]) -> Result<Value, Trouble> {
        let output = Command::new(self.program)
            .args(run.arguments(self.threads))
            .args(more)
            .current_dir(&self.folder)
            .output()
            .map_err(|error| Trouble::reading(self.program, &error))?;
        if !output.status.success() {
            let reason = String::from_utf8_lossy(&output.stderr);
            return Err(Trouble(format!("{}: {}", run.name, reason.trim_end())));
        }
        let report = crate::source::read(&self.folder.join(run.report_out()))?;
        serde_json::from_str(&report).map_err(|error| Trouble(error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_comes_with_the_one_that_writes_its_mesh() {
        let names = |chosen: &[&str]| -> Vec<&str> {
            let chosen: Vec<String> = chosen.iter().map(|&name| name.into()).collect();
            runs_named(&chosen).iter().map(|run| run.name).collect()
        };
        assert_eq!(names(&["measure"]), ["cut", "measure"]);
        assert_eq!(names(&["info"]), ["info"]);
        assert_eq!(names(&[]).len(), RUNS.len());
    }
}
