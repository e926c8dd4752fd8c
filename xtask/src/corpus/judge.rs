//! What to run on a file, and whether it ended as promised.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use super::run::{End, Program, Run};
use super::table::{Cell, Figures, Row, Table, Verdict};
use crate::Trouble;
use crate::source::read;

/// A run of the command on one file.
struct Job {
    name: &'static str,
    /// Arguments, without the file, the output and the report.
    arguments: &'static [&'static str],
    writes_mesh: bool,
    promises_no_flip: bool,
}

const INFO: Job = Job {
    name: "info",
    arguments: &["info"],
    writes_mesh: false,
    promises_no_flip: false,
};

const REPAIR: Job = Job {
    name: "repair",
    arguments: &["repair"],
    writes_mesh: true,
    promises_no_flip: false,
};

const NATURAL: Job = flattening("natural", &["flatten", "--method", "natural"], false);

/// Crosses on whatever the surface is; the mesh written has them as lines.
const FIELD: Job = Job {
    name: "field",
    arguments: &["field"],
    writes_mesh: true,
    promises_no_flip: false,
};

/// Vectors and lines, on models of which something is expected. Each run checks that the indices sum
/// to the Euler characteristic.
const ON_MODELS: [Job; 2] = [
    Job {
        name: "field-1",
        arguments: &["field", "--symmetry", "1"],
        ..FIELD
    },
    Job {
        name: "field-2",
        arguments: &["field", "--symmetry", "2"],
        ..FIELD
    },
];

/// What is run on patches beside the natural map. Positive weights on the patch's own edges and a
/// convex boundary exclude flips (Tutte 1963, Floater 2003).
const ON_PATCHES: [Job; 4] = [
    flattening("spectral", &["flatten", "--method", "spectral"], false),
    flattening(
        "fixed-delaunay",
        &["flatten", "--method", "fixed", "--intrinsic-delaunay"],
        // Theory speaks of the intrinsic triangles, not of the patch's own.
        false,
    ),
    flattening(
        "fixed-mean-value",
        &["flatten", "--method", "fixed", "--weights", "mean-value"],
        true,
    ),
    flattening(
        "fixed-uniform",
        &["flatten", "--method", "fixed", "--weights", "uniform"],
        true,
    ),
];

const fn flattening(
    name: &'static str,
    arguments: &'static [&'static str],
    promises_no_flip: bool,
) -> Job {
    Job {
        name,
        arguments,
        writes_mesh: true,
        promises_no_flip,
    }
}

/// Runs everything that a file is for.
pub(super) fn run_file(program: &Program, folder: &Path, file: &str) -> Row {
    let is_patch = file.contains("disks/");
    let on_patches = if is_patch { &ON_PATCHES[..] } else { &[] };
    let is_model = file.starts_with("dev/") && !is_patch;
    let on_models = if is_model { &ON_MODELS[..] } else { &[] };
    let jobs = [INFO, REPAIR, NATURAL, FIELD];
    let cells = jobs.iter().chain(on_models).chain(on_patches);
    Row {
        file: file.to_owned(),
        cells: cells
            .map(|job| run_job(program, &folder.join(file), job))
            .collect(),
    }
}

fn run_job(program: &Program, mesh: &Path, job: &Job) -> Cell {
    let mut cell = Cell {
        run: job.name,
        verdict: Verdict::Bad,
        reason: String::new(),
        seconds: 0.0,
        figures: Figures::default(),
        promises_no_flip: job.promises_no_flip,
    };
    let judged = tempfile::tempdir()
        .map_err(|error| error.to_string())
        .and_then(|folder| {
            let run = program.run(&arguments(job, mesh), folder.path());
            cell.seconds = run.seconds;
            judge(program, job, &run, folder.path(), &mut cell.figures)
        });
    match judged {
        Ok((verdict, reason)) => (cell.verdict, cell.reason) = (verdict, reason),
        Err(reason) => cell.reason = reason,
    }
    cell
}

const MESH_OUT: &str = "out.obj";
const REPORT_OUT: &str = "report.json";

fn arguments<'a>(job: &Job, mesh: &'a Path) -> Vec<&'a str> {
    let mut arguments: Vec<&str> = job.arguments.to_vec();
    arguments.push(mesh.to_str().unwrap_or_default());
    arguments.extend(["--threads", "1", "--report", REPORT_OUT]);
    if job.writes_mesh {
        arguments.extend(["-o", MESH_OUT]);
    }
    arguments
}

/// The verdict with its reason; an error where the end breaks a promise.
fn judge(
    program: &Program,
    job: &Job,
    run: &Run,
    folder: &Path,
    figures: &mut Figures,
) -> Result<(Verdict, String), String> {
    if run.stderr.contains("panicked") {
        return Err(format!("panic: {}", last_line(&run.stderr)));
    }
    match &run.end {
        End::Code(0) => judge_result(program, job, folder, figures),
        End::Code(1) => judge_refusal(run, folder),
        End::Code(code) => Err(format!("exit code {code}: {}", last_line(&run.stderr))),
        End::Signal => Err("ended by a signal".into()),
        End::Timeout => Err(format!("not over after {:.0} s", run.seconds)),
        End::NotStarted(error) => Err(format!("not started: {error}")),
    }
}

fn last_line(text: &str) -> &str {
    text.lines().last().unwrap_or_default()
}

/// A refusal tells a fact, then a hint, and leaves nothing but a report that says the same.
fn judge_refusal(run: &Run, folder: &Path) -> Result<(Verdict, String), String> {
    let lines: Vec<&str> = run.stderr.lines().collect();
    let [.., error, hint] = lines[..] else {
        return Err("refused without a reason".into());
    };
    let (Some(fact), true) = (error.strip_prefix("error: "), hint.starts_with("hint: ")) else {
        return Err("refused without 'error:' and 'hint:' at the end".into());
    };
    if !run.stdout.is_empty() {
        return Err("refused, but wrote to standard output".into());
    }
    let report = read_report(folder)?;
    if report["error"]["fact"] != fact || !report["result"].is_null() {
        return Err("refused, but the report tells otherwise".into());
    }
    let left = fs::read_dir(folder).map_or(0, Iterator::count);
    if left > 1 {
        return Err(format!("refused, but left {left} files behind"));
    }
    // The reason without the path, which differs from machine to machine.
    let reason = fact.split_once(": ").map_or(fact, |(_, reason)| reason);
    Ok((Verdict::Refused, reason.to_owned()))
}

fn read_report(folder: &Path) -> Result<Value, String> {
    let text = fs::read_to_string(folder.join(REPORT_OUT)).map_err(|_| "no report".to_owned())?;
    serde_json::from_str(&text).map_err(|error| format!("report: {error}"))
}

/// A result has a report, and a mesh without NaN that can be read again.
fn judge_result(
    program: &Program,
    job: &Job,
    folder: &Path,
    figures: &mut Figures,
) -> Result<(Verdict, String), String> {
    let report = read_report(folder)?;
    *figures = figures_of(&report);
    if job.writes_mesh {
        let mesh = fs::read_to_string(folder.join(MESH_OUT)).map_err(|_| "no mesh".to_owned())?;
        if let Some(line) = first_line_with_nan(&mesh) {
            return Err(format!("the mesh written has '{line}'"));
        }
        let again = program.run(&["info", MESH_OUT, "--quiet"], folder);
        if !matches!(again.end, End::Code(0)) {
            let reason = last_line(&again.stderr);
            return Err(format!("the mesh written cannot be read again: {reason}"));
        }
    }
    let verdict = if has_remarks(&report) {
        Verdict::OkWithRemarks
    } else {
        Verdict::Ok
    };
    Ok((verdict, String::new()))
}

fn figures_of(report: &Value) -> Figures {
    let count = |key: &str| report.pointer(key).and_then(Value::as_u64);
    Figures {
        flipped: count("/measure/faces/flipped"),
        residual: ["/result/residual", "/result/smoothing/residual"]
            .iter()
            .find_map(|key| report.pointer(key).and_then(Value::as_f64)),
        peak_mebibytes: report["peak_memory_bytes"]
            .as_u64()
            .map(|bytes| bytes >> 20),
    }
}

/// Whether the report tells of warnings, or of any change that repair made.
fn has_remarks(report: &Value) -> bool {
    let warnings = report["warnings"].as_array().is_some_and(|w| !w.is_empty());
    warnings || report["repair"]["changed"].as_bool() == Some(true)
}

/// The first line of an OBJ file's numbers that holds one that is not finite.
fn first_line_with_nan(mesh: &str) -> Option<&str> {
    let mut numeric = mesh
        .lines()
        .filter(|line| ["v ", "vt ", "vn "].iter().any(|key| line.starts_with(key)));
    numeric.find(|line| {
        let mut words = line.split_whitespace().skip(1);
        words.any(|word| !word.parse::<f64>().is_ok_and(f64::is_finite))
    })
}

/// The verdicts that `broken/expected.csv` allows, by file relative to the corpus.
pub(super) fn expectations(folder: &Path) -> Result<BTreeMap<String, String>, Trouble> {
    let mut expectations = BTreeMap::new();
    for prefix in ["", "broken/"] {
        let table = folder.join(prefix).join("expected.csv");
        if !table.is_file() {
            continue;
        }
        for line in read(&table)?.lines().skip(1) {
            let mut cells = line.splitn(4, ',');
            if let (Some(file), Some(verdict)) = (cells.next(), cells.nth(1)) {
                expectations.insert(format!("{prefix}{file}"), verdict.to_owned());
            }
        }
    }
    Ok(expectations)
}

/// Files that `repair` did not treat as expected: `accept` and `repair` want a mesh, the latter
/// one that is told of, `refuse` a refusal.
pub(super) fn unmet_expectations(
    table: &Table,
    expectations: &BTreeMap<String, String>,
) -> Vec<String> {
    let mut faults = Vec::new();
    for row in &table.rows {
        let Some(expected) = expectations.get(&row.file) else {
            continue;
        };
        let repaired = row.cells.iter().find(|cell| cell.run == REPAIR.name);
        let Some(cell) = repaired.filter(|cell| cell.verdict != Verdict::Bad) else {
            continue;
        };
        let meets = |word: &str| match word {
            "accept" => cell.verdict != Verdict::Refused,
            "repair" => cell.verdict == Verdict::OkWithRemarks,
            "refuse" => cell.verdict == Verdict::Refused,
            _ => false,
        };
        if !expected.split('|').any(meets) {
            faults.push(format!(
                "{}: expected {expected}, but repair ended '{}' {}",
                row.file, cell.verdict, cell.reason
            ));
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_not_finite_are_found_and_names_are_not() {
        assert_eq!(
            first_line_with_nan("o nan\nv 0 0 1\nvt 0 nan\n"),
            Some("vt 0 nan")
        );
        assert_eq!(first_line_with_nan("v 0 0 inf\n"), Some("v 0 0 inf"));
        assert_eq!(first_line_with_nan("v 1e30 -0 1\nusemtl inf\n"), None);
    }

    #[test]
    fn a_refusal_needs_fact_hint_and_report_and_no_other_file() {
        let run = |stderr: &str| Run {
            end: End::Code(1),
            seconds: 0.0,
            stdout: Vec::new(),
            stderr: stderr.into(),
        };
        let folder = tempfile::tempdir().unwrap();
        let refused = run("[0.00 s] read\nerror: a.obj: no faces\nhint: export again\n");
        assert!(judge_refusal(&refused, folder.path()).is_err());
        let report = |text: &str| fs::write(folder.path().join(REPORT_OUT), text).unwrap();
        report(r#"{"error": {"fact": "another"}, "result": null}"#);
        assert!(judge_refusal(&refused, folder.path()).is_err());
        report(r#"{"error": {"fact": "a.obj: no faces"}, "result": null}"#);
        let (verdict, reason) = judge_refusal(&refused, folder.path()).unwrap();
        assert_eq!((verdict, reason.as_str()), (Verdict::Refused, "no faces"));
        assert!(judge_refusal(&run("no\n"), folder.path()).is_err());
        assert!(judge_refusal(&run("error: a\n"), folder.path()).is_err());
        fs::write(folder.path().join("half.obj"), "").unwrap();
        assert!(judge_refusal(&refused, folder.path()).is_err());
    }
}
