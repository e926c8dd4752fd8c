//! Measures a command of `graticule`, flattening unless told, on patches of growing size, beside the unit of time **L**, and
//! prints the tables of `BENCHMARKS.md`.
//!
//! L is one analysis and factorisation of the mesh's cotangent Laplacian by `faer`, in `faer`'s own
//! ordering, on one thread in the same run. Ratios to L hold on any machine.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use clap::Args;
use serde_json::Value;

use crate::Trouble;

/// Options of `cargo xtask bench`.
#[derive(Args, Debug)]
pub(crate) struct Options {
    /// Numbers of vertices, about
    #[arg(long, value_delimiter = ',', default_values_t = [10_000, 30_000, 100_000, 300_000, 500_000, 1_000_000])]
    sizes: Vec<u32>,
    /// Command to measure: flatten or parameterize
    #[arg(long, default_value = "flatten", value_parser = ["flatten", "parameterize"])]
    command: String,
    /// Method of flattening
    #[arg(long, default_value = "natural")]
    method: String,
    /// Runs of each size; the fastest counts
    #[arg(long, default_value_t = 2)]
    repeats: u32,
    /// Threads of the command
    #[arg(long, default_value_t = 1)]
    threads: u32,
    /// Number vertices and triangles at random, not ring after ring, which suits minimum degree best
    #[arg(long)]
    shuffled: bool,
}

/// The measurements of one size.
struct Measurement {
    vertices: u32,
    unit: f64,
    total: f64,
    /// Seconds of the outermost stages, in order.
    stages: Vec<(String, f64)>,
    peak_mebibytes: Option<u64>,
}

impl Measurement {
    /// The least L of both, and the faster command.
    fn better_of(self, other: Self) -> Self {
        let unit = self.unit.min(other.unit);
        let faster = if other.total < self.total {
            other
        } else {
            self
        };
        Self { unit, ..faster }
    }
}

/// Measures every size and returns the tables as Markdown.
pub(crate) fn run(root: &Path, options: &Options) -> Result<String, Trouble> {
    let program = crate::build_release(root)?;
    crate::build(
        root,
        &["--package", "graticule", "--example", "unit_of_time"],
    )?;
    let folder = tempfile::tempdir().map_err(|error| Trouble(error.to_string()))?;
    let mut measurements = Vec::new();
    for &size in &options.sizes {
        let rings = rings(size);
        let mut patch = graticule_fixtures::bumpy_patch(rings, 1);
        if options.shuffled {
            patch = patch.renumbered(1).0;
        }
        fs::write(folder.path().join("patch.obj"), patch.to_obj())
            .map_err(|error| Trouble::reading(folder.path(), &error))?;
        let mut measurement = run_once(root, &program, folder.path(), rings, options)?;
        for _ in 1..options.repeats {
            let again = run_once(root, &program, folder.path(), rings, options)?;
            measurement = measurement.better_of(again);
        }
        measurements.push(measurement);
        eprintln!("{size} vertices measured");
    }
    Ok(markdown(&measurements))
}

fn run_once(
    root: &Path,
    program: &Path,
    folder: &Path,
    rings: u32,
    options: &Options,
) -> Result<Measurement, Trouble> {
    let unit = unit_of_time(root, rings, options.shuffled)?;
    let (total, report) = time_command(program, folder, options)?;
    let peak = report["peak_memory_bytes"].as_u64();
    Ok(Measurement {
        vertices: 3 * rings * (rings + 1) + 1,
        unit,
        total,
        stages: outermost_stages(&report),
        peak_mebibytes: peak.map(|bytes| bytes >> 20),
    })
}

/// The rings of the bumpy patch, irregular and without symmetry, of about `vertices` vertices.
pub(crate) fn rings(vertices: u32) -> u32 {
    // A disk of r rings has 3r² + 3r + 1 vertices.
    let found = (1..20_000).find(|r| 3 * r * r + 3 * r >= vertices);
    found.unwrap_or(20_000)
}

/// Seconds of one run of the command, and its report.
fn time_command(program: &Path, folder: &Path, options: &Options) -> Result<(f64, Value), Trouble> {
    let start = Instant::now();
    let is_flattening = options.command == "flatten";
    let method = is_flattening.then_some(["--method", options.method.as_str()]);
    let output = Command::new(program)
        .args([
            options.command.as_str(),
            "patch.obj",
            "-o",
            "flat.obj",
            "--report",
            "report.json",
            "--quiet",
        ])
        .args(method.into_iter().flatten())
        .args(["--threads", &options.threads.to_string()])
        .current_dir(folder)
        .output()
        .map_err(|error| Trouble::reading(program, &error))?;
    let total = start.elapsed().as_secs_f64();
    if !output.status.success() {
        let reason = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(Trouble(reason));
    }
    let report = crate::source::read(&folder.join("report.json"))?;
    let report = serde_json::from_str(&report).map_err(|error| Trouble(error.to_string()))?;
    Ok((total, report))
}

fn outermost_stages(report: &Value) -> Vec<(String, f64)> {
    let times = report["times"].as_array().map_or(&[][..], Vec::as_slice);
    let outermost = times.iter().filter(|time| time["depth"] == 0);
    outermost
        .map(|time| {
            let name = time["name"].as_str().unwrap_or_default().to_owned();
            (name, time["seconds"].as_f64().unwrap_or_default())
        })
        .collect()
}

/// Seconds of one L for the bumpy patch of so many rings.
fn unit_of_time(root: &Path, rings: u32, shuffled: bool) -> Result<f64, Trouble> {
    let program = crate::target_folder(root).join("release/examples/unit_of_time");
    let mut command = Command::new(&program);
    command.arg(rings.to_string());
    command.args(shuffled.then_some("shuffled"));
    let output = command.output();
    let output = output.map_err(|error| Trouble::reading(&program, &error))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let seconds = text.trim().parse();
    seconds.map_err(|_| Trouble("L could not be measured".into()))
}

fn markdown(measurements: &[Measurement]) -> String {
    let Some(first) = measurements.first() else {
        return String::new();
    };
    let names: Vec<&str> = first.stages.iter().map(|(name, _)| name.as_str()).collect();
    let mut text = format!(
        "| vertices | L, s | command, s | command / L | {} | peak memory, MiB |\n|{}\n",
        names.join(" | "),
        "---:|".repeat(names.len() + 5)
    );
    for measurement in measurements {
        let Measurement {
            vertices,
            unit,
            total,
            stages,
            peak_mebibytes,
        } = measurement;
        let shares: Vec<String> = stages
            .iter()
            .map(|(_, seconds)| format!("{:.0} %", 100.0 * seconds / total))
            .collect();
        let _ = writeln!(
            text,
            "| {vertices} | {unit:.2} | {total:.2} | {:.2} | {} | {} |",
            total / unit,
            shares.join(" | "),
            peak_mebibytes.map_or_else(|| "–".into(), |mebibytes| mebibytes.to_string()),
        );
    }
    text
}
