//! Measures how the methods of flattening grow, from ten thousand vertices to a million: the table
//! of `BENCHMARKS.md`.
//!
//! Times are the processor's, so that other work on the machine counts little.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;
use serde_json::Value;

use crate::Trouble;
use crate::bench::rings;

/// Options of `cargo xtask growth`.
#[derive(Args, Debug)]
pub(crate) struct Options {
    /// Numbers of vertices, about
    #[arg(long, value_delimiter = ',', default_values_t = [10_000, 100_000, 1_000_000])]
    sizes: Vec<u32>,
    /// Methods to measure, by the names in the table; all unless told
    #[arg(long, value_delimiter = ',')]
    methods: Vec<String>,
    /// Measure this program rather than one built from these sources
    #[arg(long)]
    program: Option<PathBuf>,
}

/// The methods, with their options.
const METHODS: [(&str, &[&str]); 5] = [
    ("natural", &["--method", "natural"]),
    ("spectral", &["--method", "spectral"]),
    ("conformal", &["--method", "fixed"]),
    ("authalic", &["--method", "fixed", "--weights", "authalic"]),
    ("injective", &["--injective"]),
];

/// One run.
struct Measurement {
    triangles: u32,
    seconds: f64,
    mebibytes: u64,
}

/// Measures every method at every size, on one thread, and returns the table as Markdown.
pub(crate) fn run(root: &Path, options: &Options) -> Result<String, Trouble> {
    let program = match &options.program {
        Some(program) => program.clone(),
        None => crate::build_release(root)?,
    };
    let folder = tempfile::tempdir().map_err(|error| Trouble(error.to_string()))?;
    let chosen =
        |name: &str| options.methods.is_empty() || options.methods.iter().any(|m| m == name);
    let methods: Vec<_> = METHODS.iter().filter(|(name, _)| chosen(name)).collect();
    let mut rows: Vec<Vec<Measurement>> = methods.iter().map(|_| Vec::new()).collect();
    for &size in &options.sizes {
        let rings = rings(size);
        let patch = graticule_fixtures::bumpy_patch(rings, 1);
        fs::write(folder.path().join("patch.obj"), patch.to_obj())
            .map_err(|error| Trouble::reading(folder.path(), &error))?;
        for ((name, arguments), row) in methods.iter().zip(&mut rows) {
            let report = flatten(&program, folder.path(), arguments)?;
            let measurement = Measurement {
                triangles: patch.triangles.len() as u32,
                seconds: report["processor_seconds"].as_f64().unwrap_or(f64::NAN),
                mebibytes: report["peak_memory_bytes"].as_u64().unwrap_or(0) >> 20,
            };
            eprintln!("{name}, {size} vertices: {:.2} s", measurement.seconds);
            row.push(measurement);
        }
    }
    let names = methods.iter().map(|(name, _)| *name);
    Ok(markdown(&names.zip(&rows).collect::<Vec<_>>()))
}

/// One run of the command; its report.
fn flatten(program: &Path, folder: &Path, arguments: &[&str]) -> Result<Value, Trouble> {
    let output = Command::new(program)
        .args(["flatten", "patch.obj", "-o", "flat.obj", "--quiet"])
        .args(["--report", "report.json", "--threads", "1"])
        .args(arguments)
        .current_dir(folder)
        .output()
        .map_err(|error| Trouble::reading(program, &error))?;
    if !output.status.success() {
        let reason = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(Trouble(reason));
    }
    let report = crate::source::read(&folder.join("report.json"))?;
    serde_json::from_str(&report).map_err(|error| Trouble(error.to_string()))
}

fn markdown(rows: &[(&str, &Vec<Measurement>)]) -> String {
    let mut text = String::from(
        "| method | triangles | s | µs a triangle | peak memory, MiB | exponent |\n\
         |---|---:|---:|---:|---:|---:|\n",
    );
    for (name, row) in rows {
        let mut before: Option<&Measurement> = None;
        for measurement in *row {
            let Measurement {
                triangles,
                seconds,
                mebibytes,
            } = measurement;
            let exponent = before.map_or_else(
                || "–".into(),
                |b| format!("{:.2}", exponent(b, measurement)),
            );
            let each = 1e6 * seconds / f64::from(*triangles);
            let _ = writeln!(
                text,
                "| {name} | {triangles} | {seconds:.2} | {each:.1} | {mebibytes} | {exponent} |"
            );
            before = Some(measurement);
        }
    }
    text
}

/// The power of the number of triangles that the seconds grow with.
fn exponent(small: &Measurement, large: &Measurement) -> f64 {
    (large.seconds / small.seconds).ln()
        / (f64::from(large.triangles) / f64::from(small.triangles)).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_tells_by_which_power_a_method_grows() {
        let run = |triangles, seconds| Measurement {
            triangles,
            seconds,
            mebibytes: 1,
        };
        let row = vec![run(1000, 0.1), run(4000, 0.8)];
        let table = markdown(&[("natural", &row)]);
        let last = table.lines().last().unwrap();
        assert_eq!(last, "| natural | 4000 | 0.80 | 200.0 | 1 | 1.50 |");
    }
}
