//! Checks that every command writes the same bytes again: with one thread, with two, and a second time; and that
//! the order of components in a file decides nothing about what is done to each alone.
//!
//! Compared are all files that a command writes: meshes, pictures, and reports but for times, memory and the number of threads.

mod orders;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::Value;

use crate::Trouble;
use crate::runs::{Input, Run, Runner, Surfaces, runs_named};

/// Options of `cargo xtask same`.
#[derive(Args, Debug)]
pub(crate) struct Options {
    /// Numbers of triangles of the generated patch and closed surface, about
    #[arg(long, default_value_t = 10_000)]
    triangles: u32,
    /// Runs to make, by name; all unless told
    #[arg(long, value_delimiter = ',')]
    runs: Vec<String>,
    /// Meshes to take for the closed surface, too
    meshes: Vec<PathBuf>,
    /// Run this program rather than one built from these sources
    #[arg(long)]
    program: Option<PathBuf>,
}

/// The folders of the runs that are compared, with their numbers of threads.
const FOLDERS: [(&str, usize); 3] = [("one", 1), ("two", 2), ("again", 1)];

/// Keys of a report that may differ between two runs of one command.
const FREE_KEYS: [&str; 3] = ["times", "processor_seconds", "peak_memory_bytes"];

/// Runs and compares; a sentence, or all differences.
pub(crate) fn run(root: &Path, options: &Options) -> Result<String, Trouble> {
    let program = crate::program(root, options.program.as_deref())?;
    let runs = runs_named(&options.runs);
    let surfaces = Surfaces::of(options.triangles);
    let mut faults = compare_threads(&program, &runs, &surfaces)?;
    let closed_only: Vec<&Run> = runs
        .iter()
        .copied()
        .filter(|run| run.input != Input::Patch)
        .collect();
    for mesh in &options.meshes {
        let surfaces = Surfaces {
            closed: crate::source::read(mesh)?,
            ..surfaces.clone()
        };
        let found = compare_threads(&program, &closed_only, &surfaces)?;
        faults.extend(
            found
                .iter()
                .map(|fault| format!("{}: {fault}", mesh.display())),
        );
    }
    faults.extend(orders::compare(&program, &options.runs)?);
    if faults.is_empty() {
        Ok(format!(
            "the same bytes from {} runs with 1 and 2 threads and again; components in any order",
            runs.len()
        ))
    } else {
        Err(Trouble(faults.join("\n")))
    }
}

/// What differs between the runs of [`FOLDERS`].
fn compare_threads(
    program: &Path,
    runs: &[&Run],
    surfaces: &Surfaces,
) -> Result<Vec<String>, Trouble> {
    let folder = tempfile::tempdir().map_err(|error| Trouble(error.to_string()))?;
    surfaces.write(folder.path())?;
    let mut faults = Vec::new();
    for run in runs {
        for (name, threads) in FOLDERS {
            let runner = Runner::new(program, folder.path(), name, threads)?;
            let picture = format!("{}.png", run.name);
            runner.report(run, &["--picture", &picture])?;
        }
        let found = differing_files(folder.path(), run)?;
        eprintln!(
            "{}: {}",
            run.name,
            if found.is_empty() { "same" } else { "DIFFERS" }
        );
        faults.extend(found);
    }
    Ok(faults)
}

/// What a run wrote that is not the same in all of [`FOLDERS`].
fn differing_files(folder: &Path, run: &Run) -> Result<Vec<String>, Trouble> {
    let [first, others @ ..] = FOLDERS.map(|(name, _)| folder.join(name));
    let expected = comparable_files(&first, run)?;
    let mut faults = Vec::new();
    for (other, (name, _)) in others.iter().zip(&FOLDERS[1..]) {
        let found = comparable_files(other, run)?;
        let differing = expected
            .iter()
            .filter(|(file, bytes)| found.get(*file) != Some(bytes));
        faults.extend(differing.map(|(file, _)| format!("{file} differs in '{name}'")));
    }
    Ok(faults)
}

/// The contents of the files that a run wrote, of reports without what may differ.
fn comparable_files(folder: &Path, run: &Run) -> Result<BTreeMap<String, Vec<u8>>, Trouble> {
    let entries = fs::read_dir(folder).map_err(|error| Trouble::reading(folder, &error))?;
    let mut files = BTreeMap::new();
    for entry in entries {
        let entry = entry.map_err(|error| Trouble::reading(folder, &error))?;
        let path = entry.path();
        if path.file_stem().is_none_or(|stem| stem != run.name) {
            continue;
        }
        let mut bytes = fs::read(&path).map_err(|error| Trouble::reading(&path, &error))?;
        if path.extension().is_some_and(|ending| ending == "json") {
            bytes = comparable_report(&bytes)?.to_string().into_bytes();
        }
        files.insert(entry.file_name().to_string_lossy().into_owned(), bytes);
    }
    Ok(files)
}

fn comparable_report(bytes: &[u8]) -> Result<Value, Trouble> {
    let report = serde_json::from_slice(bytes);
    let mut report: Value = report.map_err(|error| Trouble(error.to_string()))?;
    if let Some(entries) = report.as_object_mut() {
        entries.retain(|key, _| !FREE_KEYS.contains(&key.as_str()));
    }
    report["options"]["threads"] = Value::Null;
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_memory_and_threads_may_differ_and_nothing_else() {
        let report = |text: &str| comparable_report(text.as_bytes()).unwrap();
        let one = report(r#"{"times": [1], "options": {"threads": 1}, "result": 3}"#);
        let two = report(r#"{"times": [2], "options": {"threads": 2}, "result": 3}"#);
        let other = report(r#"{"times": [1], "options": {"threads": 1}, "result": 4}"#);
        assert_eq!(one, two);
        assert_ne!(one, other);
    }
}
