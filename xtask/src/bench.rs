//! Measures `graticule flatten` on patches of growing size, beside the unit of time **L**, and
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
use faer::sparse::{SparseColMat, Triplet};
use faer::{Par, Side};
use graticule_fixtures::Fixture;
use serde_json::Value;

use crate::Trouble;

/// Options of `cargo xtask bench`.
#[derive(Args, Debug)]
pub(crate) struct Options {
    /// Numbers of vertices, about
    #[arg(long, value_delimiter = ',', default_values_t = [10_000, 30_000, 100_000, 300_000, 500_000, 1_000_000])]
    sizes: Vec<u32>,
    /// Method of flattening
    #[arg(long, default_value = "natural")]
    method: String,
    /// Runs of each size; the fastest counts
    #[arg(long, default_value_t = 2)]
    repeats: u32,
    /// Threads of the command
    #[arg(long, default_value_t = 1)]
    threads: u32,
}

/// The measurements of one size.
struct Measurement {
    vertices: usize,
    unit: f64,
    total: f64,
    /// Seconds of the outermost stages, in order.
    stages: Vec<(String, f64)>,
    peak_mebibytes: Option<u64>,
}

/// Measures every size and returns the tables as Markdown.
pub(crate) fn run(root: &Path, options: &Options) -> Result<String, Trouble> {
    let program = crate::build_release(root)?;
    let folder = tempfile::tempdir().map_err(|error| Trouble(error.to_string()))?;
    let mut measurements = Vec::new();
    for &size in &options.sizes {
        let patch = patch(size);
        fs::write(folder.path().join("patch.obj"), obj(&patch))
            .map_err(|error| Trouble::reading(folder.path(), &error))?;
        let mut best: Option<Measurement> = None;
        for _ in 0..options.repeats.max(1) {
            let measurement = measure(&program, folder.path(), &patch, options)?;
            if best
                .as_ref()
                .is_none_or(|best| measurement.total < best.total)
            {
                best = Some(measurement);
            }
        }
        measurements.extend(best);
        eprintln!("{size} vertices measured");
    }
    Ok(markdown(&measurements))
}

/// A bumpy patch, irregular and without symmetry, of about `vertices` vertices.
fn patch(vertices: u32) -> Fixture {
    // A disk of r rings has 3r² + 3r + 1 vertices.
    let rings = (1..20_000)
        .find(|r| 3 * r * r + 3 * r >= vertices)
        .unwrap_or(1);
    graticule_fixtures::bumpy_patch(rings, 1)
}

fn obj(patch: &Fixture) -> String {
    let mut text = String::new();
    for p in &patch.positions {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for [a, b, c] in &patch.triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text
}

fn measure(
    program: &Path,
    folder: &Path,
    patch: &Fixture,
    options: &Options,
) -> Result<Measurement, Trouble> {
    let unit = unit_of_time(patch)?;
    let start = Instant::now();
    let output = Command::new(program)
        .args([
            "flatten",
            "patch.obj",
            "-o",
            "flat.obj",
            "--report",
            "report.json",
            "--quiet",
        ])
        .args(["--method", &options.method])
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
    let report: Value =
        serde_json::from_str(&report).map_err(|error| Trouble(error.to_string()))?;
    Ok(Measurement {
        vertices: patch.positions.len(),
        unit,
        total,
        stages: outermost_stages(&report),
        peak_mebibytes: report["peak_memory_bytes"]
            .as_u64()
            .map(|bytes| bytes >> 20),
    })
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

/// Seconds of one L for this mesh.
fn unit_of_time(patch: &Fixture) -> Result<f64, Trouble> {
    let laplacian = laplacian(patch)?;
    faer::set_global_parallelism(Par::Seq);
    let start = Instant::now();
    let factors = laplacian.sp_cholesky(Side::Lower);
    let seconds = start.elapsed().as_secs_f64();
    factors
        .map(|_| seconds)
        .map_err(|error| Trouble(format!("L could not be measured: {error:?}")))
}

/// The cotangent Laplacian plus 1e-6 on the diagonal, which makes it positive definite.
fn laplacian(patch: &Fixture) -> Result<SparseColMat<usize, f64>, Trouble> {
    let mut triplets = Vec::with_capacity(12 * patch.triangles.len());
    for triangle in &patch.triangles {
        let vertices = triangle.map(|vertex| vertex as usize);
        let [a, b, c] = vertices.map(|vertex| patch.positions[vertex]);
        let double_area = (b - a).cross(c - a).length();
        let sides = [(b - a, c - a), (c - b, a - b), (a - c, b - c)];
        for (corner, (one, other)) in sides.into_iter().enumerate() {
            let weight = one.dot(other) / double_area / 2.0;
            let [i, j] = [vertices[(corner + 1) % 3], vertices[(corner + 2) % 3]];
            triplets.extend([
                Triplet::new(i, i, weight),
                Triplet::new(j, j, weight),
                Triplet::new(i, j, -weight),
                Triplet::new(j, i, -weight),
            ]);
        }
    }
    let count = patch.positions.len();
    triplets.extend((0..count).map(|vertex| Triplet::new(vertex, vertex, 1e-6)));
    SparseColMat::try_new_from_triplets(count, count, &triplets)
        .map_err(|error| Trouble(format!("L could not be measured: {error:?}")))
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
