//! Runs every mesh of a folder through the command, each run in a process of its own with a limit
//! on time and memory, judges what comes out, and compares it with the accepted table.

mod expectations;
mod jobs;
mod judge;
mod run;
mod sheet;
mod table;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use clap::Args;

use crate::Trouble;
use crate::source::read;
use jobs::Job;
use run::{Limits, Program};
use table::{AcceptedTable, Row, Table};

/// Endings of the names of files that are run.
const MESH_EXTENSIONS: [&str; 7] = ["glb", "gltf", "meshb", "obj", "off", "ply", "stl"];

/// Options of `cargo xtask corpus`.
#[derive(Args, Debug)]
pub(crate) struct Options {
    /// Folder of meshes; by default `$GRATICULE_CORPUS`, or else `../shared/meshes`
    folder: Option<PathBuf>,
    /// Take the outcome as the accepted one of the files and runs that were run
    #[arg(long)]
    accept: bool,
    /// Only files whose path contains this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Leave slow runs out on large files
    #[arg(long)]
    selection: bool,
    /// Runs at the same time
    #[arg(long, default_value_t = 2, value_name = "N")]
    jobs: usize,
    /// Time limit of one run
    #[arg(long, default_value_t = 120.0, value_name = "S")]
    seconds: f64,
    /// Limit of the address space of one run
    #[arg(long, default_value_t = 4096, value_name = "N")]
    mebibytes: u64,
    /// The program to run, instead of building it with the release profile
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
}

/// Runs the corpus and returns a sentence, or what went wrong.
pub(crate) fn run(root: &Path, options: &Options) -> Result<String, Trouble> {
    let Some(folder) = corpus_folder(root, options) else {
        return Ok(
            "corpus: skipped, for there is no folder of meshes (set GRATICULE_CORPUS)".into(),
        );
    };
    let program = match &options.program {
        Some(program) => program.clone(),
        None => crate::build_release(root)?,
    };
    let program = Program {
        path: program,
        limits: Limits {
            time: Duration::from_secs_f64(options.seconds),
            mebibytes: options.mebibytes,
        },
    };
    let files = mesh_files(&folder, options.only.as_deref())?;
    let expectations = expectations::expectations(&folder)?;
    let out = crate::target_folder(root).join("corpus");
    let pictures = out.join("pictures");
    fs::create_dir_all(&pictures).map_err(|error| Trouble::reading(&pictures, &error))?;
    let corpus = Corpus {
        program,
        folder,
        pictures,
        selection: options.selection,
    };
    let table = Table::new(corpus.run_all(&files, options.jobs));
    sheet::write(&out, &table)?;
    finish(root, options, &table, &expectations)
}

/// The folder asked for, if it exists.
fn corpus_folder(root: &Path, options: &Options) -> Option<PathBuf> {
    let folder = options.folder.clone();
    let folder = folder.or_else(|| std::env::var_os("GRATICULE_CORPUS").map(PathBuf::from));
    let folder = folder.unwrap_or_else(|| root.join("../shared/meshes"));
    folder.is_dir().then_some(folder)
}

/// Paths of the meshes, relative to the folder, sorted.
fn mesh_files(folder: &Path, only: Option<&str>) -> Result<Vec<String>, Trouble> {
    let mut files = Vec::new();
    for extension in MESH_EXTENSIONS {
        for file in crate::source::files_below(folder, extension)? {
            let name = file.strip_prefix(folder).unwrap_or(&file);
            files.push(name.to_string_lossy().into_owned());
        }
    }
    files.retain(|file| only.is_none_or(|text| file.contains(text)));
    files.sort();
    Ok(files)
}

/// What all runs share.
struct Corpus {
    program: Program,
    folder: PathBuf,
    /// Where pictures are kept.
    pictures: PathBuf,
    selection: bool,
}

impl Corpus {
    /// Runs the files in order, as many at a time as there are jobs.
    fn run_all(&self, files: &[String], jobs: usize) -> Vec<Row> {
        let next = AtomicUsize::new(0);
        let rows = Mutex::new(BTreeMap::new());
        thread::scope(|scope| {
            for _ in 0..jobs.max(1) {
                scope.spawn(|| {
                    while let Some(file) = files.get(next.fetch_add(1, Ordering::Relaxed)) {
                        let row = self.run_file(file);
                        eprintln!("{row}");
                        let mut rows = rows.lock().unwrap_or_else(PoisonError::into_inner);
                        rows.insert(file.clone(), row);
                    }
                });
            }
        });
        let rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
        rows.into_values().collect()
    }

    fn run_file(&self, file: &str) -> Row {
        let path = self.folder.join(file);
        let bytes = fs::metadata(&path).map_or(0, |data| data.len());
        let jobs = jobs::jobs_for(file, bytes, self.selection);
        let run = |job: &Job| {
            let picture = self.pictures.join(sheet::picture_name(file, job.name));
            judge::run_job(&self.program, &path, job, &picture)
        };
        Row {
            file: file.to_owned(),
            cells: jobs.iter().map(run).collect(),
        }
    }
}

/// Writes the tables and compares them with what was promised and accepted before.
fn finish(
    root: &Path,
    options: &Options,
    table: &Table,
    expectations: &BTreeMap<String, String>,
) -> Result<String, Trouble> {
    let out = crate::target_folder(root).join("corpus");
    table.write(&out)?;
    println!("{}\n{}", table.to_markdown(), table.slowest());
    let mut faults = table.broken_promises();
    faults.extend(expectations::unmet_expectations(table, expectations));
    let accepted = root.join("xtask/corpus.json");
    if options.accept {
        let whole = options.only.is_none() && !options.selection;
        let kept = if whole || !accepted.is_file() {
            AcceptedTable::new()
        } else {
            Table::accepted(&read(&accepted)?)?
        };
        table.accept(kept, &accepted)?;
    } else if accepted.is_file() {
        let accepted = Table::accepted(&read(&accepted)?)?;
        faults.extend(table.differences(&accepted, options.only.is_none()));
    } else {
        let message = "xtask/corpus.json is missing: look at the table, then take it with --accept";
        faults.push(message.into());
    }
    if faults.is_empty() {
        let runs = table.run_count();
        Ok(format!(
            "corpus: {runs} runs ended as they should\n{runs} passed, 0 failed"
        ))
    } else {
        Err(Trouble(format!(
            "corpus: {} faults\n{}",
            faults.len(),
            faults.join("\n")
        )))
    }
}
