//! The report: one envelope for all commands. `docs/report.md` describes its keys.

use graticule::watch::{StageTime, Warning, Watch};
use serde::Serialize;
use serde_json::{Value, json};

use crate::failure::Failure;

/// Everything a run has found out, in the order written.
#[derive(Serialize)]
pub(crate) struct Report {
    graticule: &'static str,
    command: String,
    /// Why there is no result; `null` where there is one.
    error: Value,
    pub(crate) input: Value,
    pub(crate) options: Value,
    pub(crate) repair: Value,
    pub(crate) result: Value,
    pub(crate) measure: Value,
    warnings: Vec<Warning>,
    times: Vec<StageTime>,
    processor_seconds: Option<f64>,
    peak_memory_bytes: Option<u64>,
}

impl Report {
    /// A report without figures yet.
    pub(crate) fn new(command: impl Into<String>, options: Value) -> Self {
        Self {
            graticule: env!("CARGO_PKG_VERSION"),
            command: command.into(),
            error: Value::Null,
            input: Value::Null,
            options,
            repair: Value::Null,
            result: Value::Null,
            measure: Value::Null,
            warnings: Vec::new(),
            times: Vec::new(),
            processor_seconds: None,
            peak_memory_bytes: None,
        }
    }

    /// The report of a run without result.
    pub(crate) fn failed(command: String, options: Value, failure: &Failure) -> Self {
        let error = json!({ "fact": failure.fact, "hint": failure.hint });
        Self {
            error,
            ..Self::new(command, options)
        }
    }

    /// The report as JSON, with the warnings and times that `watch` has kept until now.
    pub(crate) fn into_json(mut self, watch: &Watch) -> Result<String, Failure> {
        self.warnings = watch.warnings();
        self.times = watch.stage_times();
        self.processor_seconds = processor_seconds();
        self.peak_memory_bytes = peak_memory_bytes();
        let mut text = serde_json::to_string_pretty(&self).map_err(|error| not_json(&error))?;
        text.push('\n');
        Ok(text)
    }
}

/// Any figures as a JSON value.
pub(crate) fn to_value(figures: &impl Serialize) -> Result<Value, Failure> {
    serde_json::to_value(figures).map_err(|error| not_json(&error))
}

fn not_json(error: &serde_json::Error) -> Failure {
    Failure::new(
        format!("the report could not be put into JSON: {error}"),
        "this is a fault of graticule: please report it with the command and the file",
    )
}

/// The processor time of all threads so far, where the system tells (Linux).
fn processor_seconds() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The program's name, in brackets, may hold anything; the state follows it.
    let (_, fields) = status.rsplit_once(')')?;
    let mut fields = fields.split_whitespace().skip(11);
    let [user, system]: [f64; 2] = [fields.next()?.parse().ok()?, fields.next()?.parse().ok()?];
    Some((user + system) / TICKS_PER_SECOND)
}

/// The unit of times that Linux tells to programs, whatever it uses itself.
const TICKS_PER_SECOND: f64 = 100.0;

/// The most memory that this process has held at once, where the system tells (Linux).
fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}
