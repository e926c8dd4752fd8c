//! Which runs of the command a file is for.

use std::path::Path;

/// A run of the command on one file.
#[derive(Clone, Copy)]
pub(super) struct Job {
    pub(super) name: &'static str,
    /// Arguments, without the file, the output and the report.
    pub(super) arguments: &'static [&'static str],
    pub(super) output: Output,
    pub(super) promise: Promise,
    /// Takes long on a large file, so that a selection leaves it out there.
    pub(super) is_slow: bool,
    /// Whether it is run once more with another number of threads, for the same bytes.
    pub(super) runs_twice: bool,
}

/// What a run writes beside its report.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Output {
    Nothing,
    Mesh,
    MeshAndPicture,
}

/// What holds for every result of a run.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Promise {
    Nothing,
    /// No triangle is turned over.
    NoFlip,
    /// Nothing but quads, manifold, with the topology of the surface.
    SoundQuads,
}

/// The mesh a run writes, in its folder.
pub(super) const MESH_OUT: &str = "out.obj";
/// The mesh of the second run.
pub(super) const MESH_OUT_AGAIN: &str = "again.obj";
/// The report a run writes, in its folder.
pub(super) const REPORT_OUT: &str = "report.json";
/// The picture a run writes, in its folder.
pub(super) const PICTURE_OUT: &str = "picture.png";

/// Above this many bytes a file is large.
const LARGE_FILE: u64 = 800 << 10;

const PLAIN: Job = Job {
    name: "",
    arguments: &[],
    output: Output::Mesh,
    promise: Promise::Nothing,
    is_slow: false,
    runs_twice: false,
};

pub(super) const REPAIR: Job = Job {
    name: "repair",
    arguments: &["repair"],
    ..PLAIN
};

/// What is run on every file.
const ON_ALL: [Job; 7] = [
    Job {
        name: "info",
        arguments: &["info"],
        output: Output::Nothing,
        ..PLAIN
    },
    REPAIR,
    Job {
        name: "natural",
        arguments: &["flatten", "--method", "natural"],
        ..PLAIN
    },
    Job {
        name: "field",
        arguments: &["field"],
        output: Output::MeshAndPicture,
        ..PLAIN
    },
    Job {
        name: "parameterize",
        arguments: &["parameterize"],
        output: Output::MeshAndPicture,
        is_slow: true,
        ..PLAIN
    },
    Job {
        name: "layout",
        arguments: &["layout"],
        output: Output::MeshAndPicture,
        promise: Promise::NoFlip,
        is_slow: true,
        ..PLAIN
    },
    Job {
        name: "remesh",
        arguments: &["remesh", "--quads", "5000"],
        output: Output::MeshAndPicture,
        promise: Promise::SoundQuads,
        is_slow: true,
        runs_twice: true,
    },
];

/// Vectors and lines, on models of which something is expected, and a cut into one patch. Each
/// field checks that the indices sum to the Euler characteristic.
const ON_MODELS: [Job; 3] = [
    Job {
        name: "field-1",
        arguments: &["field", "--symmetry", "1"],
        ..PLAIN
    },
    Job {
        name: "field-2",
        arguments: &["field", "--symmetry", "2"],
        ..PLAIN
    },
    Job {
        name: "cut-injective",
        arguments: &["flatten", "--cut", "--injective"],
        output: Output::MeshAndPicture,
        promise: Promise::NoFlip,
        is_slow: true,
        ..PLAIN
    },
];

/// What is run on patches beside the natural map. Positive weights on the patch's own edges and a
/// convex boundary exclude flips (Tutte 1963, Floater 2003).
const ON_PATCHES: [Job; 6] = [
    Job {
        name: "spectral",
        arguments: &["flatten", "--method", "spectral"],
        ..PLAIN
    },
    Job {
        name: "fixed-delaunay",
        // Theory speaks of the intrinsic triangles, not of the patch's own: nothing is promised.
        arguments: &["flatten", "--method", "fixed", "--intrinsic-delaunay"],
        ..PLAIN
    },
    Job {
        name: "fixed-mean-value",
        arguments: &["flatten", "--method", "fixed", "--weights", "mean-value"],
        promise: Promise::NoFlip,
        ..PLAIN
    },
    Job {
        name: "fixed-uniform",
        arguments: &["flatten", "--method", "fixed", "--weights", "uniform"],
        promise: Promise::NoFlip,
        ..PLAIN
    },
    Job {
        name: "optimal",
        arguments: &["flatten", "--method", "optimal"],
        ..PLAIN
    },
    Job {
        name: "injective",
        arguments: &["flatten", "--injective"],
        output: Output::MeshAndPicture,
        promise: Promise::NoFlip,
        is_slow: true,
        ..PLAIN
    },
];

/// Everything that a file is for; of slow runs only those on small files, if `selection`.
pub(super) fn jobs_for(file: &str, bytes: u64, selection: bool) -> Vec<Job> {
    let is_patch = file.contains("disks/");
    let on_patches = if is_patch { &ON_PATCHES[..] } else { &[] };
    let is_model = file.starts_with("dev/") && !is_patch;
    let on_models = if is_model { &ON_MODELS[..] } else { &[] };
    let leaves_out_slow = selection && bytes > LARGE_FILE;
    let all = ON_ALL.iter().chain(on_models).chain(on_patches);
    all.filter(|job| !(job.is_slow && leaves_out_slow))
        .copied()
        .collect()
}

impl Job {
    pub(super) fn writes_mesh(&self) -> bool {
        self.output != Output::Nothing
    }

    pub(super) fn draws(&self) -> bool {
        self.output == Output::MeshAndPicture
    }

    /// The arguments of the run on `mesh`.
    pub(super) fn arguments<'a>(&self, mesh: &'a Path) -> Vec<&'a str> {
        let mut arguments: Vec<&str> = self.arguments.to_vec();
        arguments.push(mesh.to_str().unwrap_or_default());
        arguments.extend(["--threads", "1", "--report", REPORT_OUT]);
        if self.writes_mesh() {
            arguments.extend(["-o", MESH_OUT]);
        }
        if self.draws() {
            arguments.extend(["--picture", PICTURE_OUT]);
        }
        arguments
    }

    /// The arguments of the second run on `mesh`, with two threads instead of one.
    pub(super) fn arguments_again<'a>(&self, mesh: &'a Path) -> Vec<&'a str> {
        let mut arguments: Vec<&str> = self.arguments.to_vec();
        arguments.push(mesh.to_str().unwrap_or_default());
        arguments.extend(["--threads", "2", "-o", MESH_OUT_AGAIN]);
        arguments
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(file: &str, bytes: u64, selection: bool) -> Vec<&'static str> {
        let jobs = jobs_for(file, bytes, selection);
        jobs.iter().map(|job| job.name).collect()
    }

    #[test]
    fn a_selection_leaves_slow_runs_out_on_large_files_only() {
        let large = LARGE_FILE + 1;
        assert!(names("dev/a.obj", large, false).contains(&"remesh"));
        assert!(names("dev/a.obj", LARGE_FILE, true).contains(&"remesh"));
        assert!(!names("dev/a.obj", large, true).contains(&"remesh"));
        assert!(names("dev/a.obj", large, true).contains(&"field"));
    }

    #[test]
    fn patches_models_and_broken_files_have_their_own_runs() {
        assert!(names("dev/disks/a.obj", 0, false).contains(&"injective"));
        assert!(!names("dev/disks/a.obj", 0, false).contains(&"cut-injective"));
        assert!(names("dev/a.obj", 0, false).contains(&"cut-injective"));
        assert_eq!(names("broken/a.obj", 0, false).len(), ON_ALL.len());
    }
}
