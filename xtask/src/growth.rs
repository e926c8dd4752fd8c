//! Measures how every command grows, from ten thousand triangles to three million: the table of `BENCHMARKS.md`.
//!
//! Times are the processor's, so that other work on the machine counts little.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::Trouble;
use crate::runs::{Run, Runner, Surfaces, runs_named};

/// Options of `cargo xtask growth`.
#[derive(Args, Debug)]
pub(crate) struct Options {
    /// Numbers of triangles, about
    #[arg(long, value_delimiter = ',', default_values_t = [10_000, 100_000, 1_000_000, 3_000_000])]
    sizes: Vec<u32>,
    /// Runs to measure, by the names in the table; all unless told
    #[arg(long, value_delimiter = ',')]
    runs: Vec<String>,
    /// Seconds by the clock after which a run is given up, and larger ones are not tried
    #[arg(long, default_value_t = 1200, value_name = "S")]
    seconds: u32,
    /// Measure this program rather than one built from these sources
    #[arg(long)]
    program: Option<PathBuf>,
}

/// One run.
struct Measurement {
    triangles: u32,
    seconds: f64,
    mebibytes: u64,
}

/// What is known of a run at all sizes.
struct Row {
    run: &'static Run,
    measurements: Vec<Measurement>,
    /// Why larger sizes are missing.
    given_up: Option<String>,
}

/// Measures every run at every size, on one thread, and returns the table as Markdown.
pub(crate) fn run(root: &Path, options: &Options) -> Result<String, Trouble> {
    let program = crate::program(root, options.program.as_deref())?;
    let mut rows: Vec<Row> = runs_named(&options.runs)
        .into_iter()
        .map(|run| Row {
            run,
            measurements: Vec::new(),
            given_up: None,
        })
        .collect();
    for &size in &options.sizes {
        let folder = tempfile::tempdir().map_err(|error| Trouble(error.to_string()))?;
        let surfaces = Surfaces::of(size);
        surfaces.write(folder.path())?;
        let runner = Runner::new(&program, folder.path(), "run", 1)?;
        for row in &mut rows {
            let triangles = surfaces.triangles(row.run.input) as u32;
            row.measure(&runner, options.seconds, triangles);
        }
        eprintln!("{}", markdown(&rows));
    }
    Ok(markdown(&rows))
}

impl Row {
    /// Measures the run at one more size, unless a smaller one has failed.
    fn measure(&mut self, runner: &Runner<'_>, seconds: u32, triangles: u32) {
        if self.given_up.is_some() {
            return;
        }
        match runner.report(self.run, &["--max-seconds", &seconds.to_string()]) {
            Ok(report) => self.measurements.push(Measurement {
                triangles,
                seconds: report["processor_seconds"].as_f64().unwrap_or(f64::NAN),
                mebibytes: report["peak_memory_bytes"].as_u64().unwrap_or(0) >> 20,
            }),
            Err(Trouble(reason)) => {
                eprintln!("{reason}");
                let fact = reason.lines().find(|line| line.contains("error: "));
                self.given_up = Some(fact.unwrap_or(&reason).into());
            }
        }
    }
}

fn markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "| run | triangles | s | µs a triangle | peak memory, MiB | exponent |\n\
         |---|---:|---:|---:|---:|---:|\n",
    );
    for row in rows {
        let name = row.run.name;
        let before = std::iter::once(None).chain(row.measurements.iter().map(Some));
        for (before, measurement) in before.zip(&row.measurements) {
            let Measurement {
                triangles,
                seconds,
                mebibytes,
            } = measurement;
            let exponent = before.map_or_else(
                || "–".into(),
                |before| format!("{:.2}", exponent(before, measurement)),
            );
            let each = 1e6 * seconds / f64::from(*triangles);
            let _ = writeln!(
                text,
                "| {name} | {triangles} | {seconds:.2} | {each:.1} | {mebibytes} | {exponent} |"
            );
        }
        if let Some(reason) = &row.given_up {
            let _ = writeln!(text, "| {name} | {reason} | | | | |");
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
    use crate::runs::RUNS;

    #[test]
    fn the_table_tells_by_which_power_a_method_grows() {
        let run = |triangles, seconds| Measurement {
            triangles,
            seconds,
            mebibytes: 1,
        };
        let row = Row {
            run: &RUNS[2],
            measurements: vec![run(1000, 0.1), run(4000, 0.8)],
            given_up: None,
        };
        let table = markdown(&[row]);
        let last = table.lines().last().unwrap();
        assert_eq!(last, "| natural | 4000 | 0.80 | 200.0 | 1 | 1.50 |");
    }
}
