//! Whether a run ended as promised.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::jobs::{Job, MESH_OUT, MESH_OUT_AGAIN, PICTURE_OUT, Promise, REPORT_OUT};
use super::run::{End, Program, Run};
use super::table::{Cell, Figures, Verdict};

/// Runs a job on a mesh; a picture it draws is kept as `picture`.
pub(super) fn run_job(program: &Program, mesh: &Path, job: &Job, picture: &Path) -> Cell {
    let mut cell = Cell {
        run: job.name,
        verdict: Verdict::Bad,
        reason: String::new(),
        seconds: 0.0,
        figures: Figures::default(),
        promises_no_flip: job.promise == Promise::NoFlip,
    };
    // A picture of an earlier corpus run is not this one's.
    let _ = fs::remove_file(picture);
    let judged = tempfile::tempdir()
        .map_err(|error| error.to_string())
        .and_then(|folder| {
            let run = program.run(&job.arguments(mesh), folder.path());
            cell.seconds = run.seconds;
            let judged = judge(program, job, &run, folder.path(), &mut cell.figures)?;
            if judged.0 != Verdict::Refused {
                if job.runs_twice {
                    compare_second_run(program, job, mesh, folder.path())?;
                }
                keep_picture(job, folder.path(), picture)?;
            }
            Ok(judged)
        });
    match judged {
        Ok((verdict, reason)) => (cell.verdict, cell.reason) = (verdict, reason),
        Err(reason) => cell.reason = reason,
    }
    cell
}

/// The same bytes for two threads as for one.
fn compare_second_run(
    program: &Program,
    job: &Job,
    mesh: &Path,
    folder: &Path,
) -> Result<(), String> {
    let run = program.run(&job.arguments_again(mesh), folder);
    if !matches!(run.end, End::Code(0)) {
        let reason = last_line(&run.stderr);
        return Err(format!("with two threads it fails: {reason}"));
    }
    let read = |name: &str| fs::read(folder.join(name)).map_err(|error| error.to_string());
    if read(MESH_OUT)? != read(MESH_OUT_AGAIN)? {
        return Err("two threads give another mesh than one".into());
    }
    Ok(())
}

fn keep_picture(job: &Job, folder: &Path, picture: &Path) -> Result<(), String> {
    if !job.draws() {
        return Ok(());
    }
    fs::copy(folder.join(PICTURE_OUT), picture)
        .map(|_| ())
        .map_err(|error| format!("no picture: {error}"))
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
    if job.promise == Promise::SoundQuads {
        check_quads(&report)?;
    }
    if job.writes_mesh() {
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

/// Faults of a quad mesh that no shape of the surface excuses.
fn check_quads(report: &Value) -> Result<(), String> {
    let quads = "/measure/quads";
    // Vertices on the edges of others are no fault in themselves: sheets may touch each other.
    let none = ["duplicate_polygons", "unused_vertices"];
    let none = none.map(|key| (format!("{quads}/connections/{key}"), Value::from(0)));
    let others = [
        (format!("{quads}/connections/manifold"), Value::from(true)),
        (format!("{quads}/polygons/triangles"), Value::from(0)),
        (format!("{quads}/polygons/larger"), Value::from(0)),
        ("/measure/reference/topology_kept".into(), Value::from(true)),
    ];
    for (key, wanted) in none.into_iter().chain(others) {
        let found = report.pointer(&key).unwrap_or(&Value::Null);
        if *found != wanted {
            return Err(format!("{key} is {found}, not {wanted}"));
        }
    }
    Ok(())
}

/// Where the reports of the commands count elements that are turned over.
const FLIPPED: [&str; 3] = [
    "/measure/faces/flipped",
    "/measure/quads/quality/scaled_jacobian/non_positive",
    "/result/inverted_faces",
];

fn figures_of(report: &Value) -> Figures {
    let count = |key: &str| report.pointer(key).and_then(Value::as_u64);
    Figures {
        flipped: FLIPPED.iter().find_map(|key| count(key)),
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
