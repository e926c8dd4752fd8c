//! What a cross field and periodic coordinates along it cost by stage, beside the unit of time **L**
//! of the same surface.
//!
//! ```text
//! RAYON_NUM_THREADS=1 cargo run --release -p graticule --example field_times -- LEVELS...
//! ```
//!
//! prints a row for the bumpy sphere of 20 · 4^LEVELS triangles, for each of the levels, which should
//! ascend. Times are processor times where the system tells them (Linux), so that a busy machine
//! changes little; else they are those of the clock.
#![allow(clippy::print_stdout)]

mod unit;

use std::error::Error;
use std::fs;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use graticule::field::{FieldOptions, cross_field};
use graticule::mesh::Surface;
use graticule::periodic::{ParameterizeOptions, parameterize};
use graticule::watch::{Event, Watch};
use graticule_fixtures::{Fixture, bumpy_sphere};

const STAGES: [&str; 10] = [
    "triangulation",
    "curvature",
    "field smoothing",
    "cancelling pairs",
    "field",
    "energy",
    "minimisation",
    "refinement",
    "untangling",
    "parameterization",
];

fn main() -> Result<(), Box<dyn Error>> {
    let levels = std::env::args().skip(1).map(|level| level.parse());
    let levels: Vec<u32> = levels.collect::<Result<_, _>>()?;
    let spheres = levels.into_iter().map(|level| bumpy_sphere(1 << level));
    // All fields first: peak memory must not be that of an L.
    let rows: Result<Vec<(Fixture, Row)>, _> = spheres.map(measured).collect();
    println!(
        "| triangles | {} | L, s | peak memory, MiB |",
        STAGES.join(" | ")
    );
    println!("|{}", "---:|".repeat(STAGES.len() + 3));
    for (sphere, row) in rows? {
        let unit = unit::unit_of_time(&sphere, seconds)?;
        let stages = row.stages.map(|stage| format!("{:.2}", stage / unit));
        let memory = row.mebibytes.map_or_else(|| "–".into(), |m| m.to_string());
        let triangles = sphere.triangles.len();
        println!(
            "| {triangles} | {} | {unit:.2} | {memory} |",
            stages.join(" | ")
        );
    }
    Ok(())
}

/// Seconds of the stages and peak memory.
struct Row {
    stages: [f64; STAGES.len()],
    mebibytes: Option<u64>,
}

fn measured(sphere: Fixture) -> Result<(Fixture, Row), Box<dyn Error>> {
    let surface = Surface::from_triangles(sphere.positions.clone(), &sphere.triangles)?;
    let stages = Arc::new(Mutex::new([0.0; STAGES.len()]));
    let heard = Arc::clone(&stages);
    let watch = Watch::new().with_listener(move |event| {
        // Minus the time at which a stage begins, plus that at which it ends.
        let (name, sign) = match event {
            Event::StageBegan(name) => (*name, -1.0),
            Event::StageEnded(stage) => (stage.name, 1.0),
            _ => return,
        };
        if let Some(stage) = STAGES.iter().position(|&stage| stage == name) {
            heard.lock().unwrap_or_else(PoisonError::into_inner)[stage] += sign * seconds();
        }
    });
    let field = cross_field(&surface, &FieldOptions::default(), &watch)?.field;
    let options = ParameterizeOptions::default();
    parameterize(&surface, &field, None, &options, &watch)?;
    let stages = *stages.lock().unwrap_or_else(PoisonError::into_inner);
    let mebibytes = peak_memory();
    Ok((sphere, Row { stages, mebibytes }))
}

/// Processor seconds of all threads, or seconds since the first call.
fn seconds() -> f64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    let start = *START.get_or_init(Instant::now);
    processor_seconds().unwrap_or_else(|| start.elapsed().as_secs_f64())
}

fn processor_seconds() -> Option<f64> {
    let threads = fs::read_dir("/proc/self/task").ok()?;
    let nanoseconds = threads.map(|thread| {
        let text = fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse::<f64>().ok()
    });
    Some(nanoseconds.sum::<Option<f64>>()? / 1e9)
}

fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes >> 10)
}
