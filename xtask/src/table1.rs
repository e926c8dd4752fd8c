//! Table I of `PGP06` made anew: `graticule parameterize` on the models of a folder, without and with
//! curl correction, beside the figures that the paper prints; and the same figures of the whole atlas
//! that `graticule layout` makes, from which nothing is left out.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;
use serde_json::Value;

use crate::Trouble;

/// Options of `cargo xtask table1`.
#[derive(Args, Debug)]
pub(crate) struct Options {
    /// Folder with the models, by the names in the table; those that are missing are left out
    folder: PathBuf,
    /// The command to measure, if not the one built with the release profile
    #[arg(long)]
    program: Option<PathBuf>,
    /// Threads of the command
    #[arg(long, default_value_t = 1)]
    threads: u32,
    /// File to write the table to
    #[arg(long)]
    output: Option<PathBuf>,
}

/// A model of the paper's table, with its printed figures.
struct Model {
    file: &'static str,
    /// What the paper calls it.
    name: &'static str,
    /// Without and with curl correction.
    printed: [Printed; 2],
}

/// Stretch, shear and time as printed.
struct Printed(f64, f64, &'static str);

const MODELS: [Model; 6] = [
    Model {
        file: "horse_20k.obj",
        name: "Horse, 20K",
        printed: [Printed(1.07, 0.20, "45 s"), Printed(1.176, 0.12, "53 s")],
    },
    Model {
        file: "bunny_28k.obj",
        name: "Bunny, 25K",
        printed: [
            Printed(1.029, 0.167, "58 s"),
            Printed(1.14, 0.14, "1 min 12 s"),
        ],
    },
    Model {
        file: "bull_34k.ply",
        name: "Bull, 34.5K",
        printed: [
            Printed(1.064, 0.1774, "1 min 26 s"),
            Printed(1.209, 0.0885, "1 min 35 s"),
        ],
    },
    Model {
        file: "camel_78k.ply",
        name: "Camel, 78K",
        printed: [
            Printed(1.048, 0.1596, "5 min 46 s"),
            Printed(1.654, 0.0711, "6 min 51 s"),
        ],
    },
    Model {
        file: "david_203k.ply",
        name: "David, 200K",
        printed: [
            Printed(1.121, 0.2398, "17 min 35 s"),
            Printed(1.270, 0.1310, "20 min 43 s"),
        ],
    },
    Model {
        file: "vaselion_370k.ply",
        name: "Lion, 400K",
        printed: [
            Printed(1.123, 0.1728, "33 min 42 s"),
            Printed(1.425, 0.0826, "45 min 18 s"),
        ],
    },
];

/// What stands above the table.
const PREFACE: &str = "# Table I of PGP06

`cargo xtask table1 FOLDER --output docs/table1.md`: `graticule parameterize` with its defaults, without and with
`--curl-correction`, one thread. The paper's figures stand in brackets; its models are the same or close, its machine had 1.7 GHz.

*Stretch* (L², isometry 1) and *shear* (mean |cos| between the gradients) are over regular triangles; *apart* is the stretch without
two rings of triangles round singular ones, *at scale* that with lengths measured in charts of the size wanted at each place, so that
what a curl correction asks for does not count. *Singular* is the share of singular triangles of all kinds (the paper speaks of 2 to
3 %), then those of the field, those where a line ends, and inverted ones. *Off* is the mean angle between lines and field. Seconds are
those of energy, minimisation, unrolling, refinement and untangling, and, after the plus sign, of the field.

| Model | Triangles | Curl correction | Stretch | apart | at scale | Shear | Singular | Off | s | paper |
|---|---:|---|---|---:|---:|---|---|---:|---:|---:|
";

/// What stands above the table of atlases.
const ATLAS_PREFACE: &str = "
## The whole atlas

`graticule layout` with its defaults, which follow an integer grid map, and with `--map periodic`, which is the paper's way: all
charts laid on squares, those round singularities anew by mean value coordinates, and the squares packed. *Stretch*, *shear* and the
symmetric Dirichlet energy (isometry 4) are over all triangles, nothing left out; *seams* is the length of all sides of squares over
the root of the area. *Not regular* is the share of charts, and of the area, that the map makes no rectangles of: the paper has 2 to
5 %. Periodic coordinates have a singularity in about as many charts as there are singularities, so that the share falls with the
size of charts; of an integer grid map they are at corners. Seconds are those of field and map, and, after the plus sign, of all
that makes an atlas of them.

| Model | Map | Charts | Not regular | Squares | Stretch | Shear | Symmetric Dirichlet | Flips | Seams | s |
|---|---|---:|---|---:|---:|---:|---:|---:|---:|---:|
";

/// Runs the command on all models and returns, or writes, the table as Markdown.
pub(crate) fn run(root: &Path, options: &Options) -> Result<String, Trouble> {
    let program = match &options.program {
        Some(program) => program.clone(),
        None => crate::build_release(root)?,
    };
    let mut text = PREFACE.to_owned();
    let mut atlases = ATLAS_PREFACE.to_owned();
    for model in &MODELS {
        let path = options.folder.join(model.file);
        if !path.exists() {
            eprintln!("{} is not there", path.display());
            continue;
        }
        for (printed, is_corrected) in model.printed.iter().zip([false, true]) {
            let more = is_corrected.then_some("--curl-correction");
            let run = ["parameterize"].into_iter().chain(more);
            let report = report_of(&program, run, &path, options.threads)?;
            text.push_str(&row(model, printed, is_corrected, &report));
        }
        for map in ["integer-grid", "periodic"] {
            let run = ["layout", "--map", map];
            let report = report_of(&program, run, &path, options.threads)?;
            atlases.push_str(&atlas_row(model, &report));
        }
        eprintln!("{} measured", model.file);
    }
    text.push_str(&atlases);
    match &options.output {
        Some(path) => {
            fs::write(path, &text).map_err(|error| Trouble::reading(path, &error))?;
            Ok(format!("{} written", path.display()))
        }
        None => Ok(text),
    }
}

/// The report of one run of the command.
fn report_of<'a>(
    program: &Path,
    run: impl IntoIterator<Item = &'a str>,
    model: &Path,
    threads: u32,
) -> Result<Value, Trouble> {
    let folder = tempfile::tempdir().map_err(|error| Trouble(error.to_string()))?;
    let report = folder.path().join("report.json");
    let output = Command::new(program)
        .args(run)
        .arg(model)
        .arg("--output")
        .arg(folder.path().join("out.obj"))
        .arg("--report")
        .arg(&report)
        .args(["--quiet", "--threads", &threads.to_string()])
        .output()
        .map_err(|error| Trouble::reading(program, &error))?;
    if !output.status.success() {
        let reason = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(Trouble(format!("{}: {reason}", model.display())));
    }
    let text = crate::source::read(&report)?;
    serde_json::from_str(&text).map_err(|error| Trouble(error.to_string()))
}

fn row(model: &Model, printed: &Printed, is_corrected: bool, report: &Value) -> String {
    let result = &report["result"];
    let distortion = |key: &str| number(&result["distortion"][key]);
    let Printed(stretch, shear, time) = printed;
    let mut text = String::new();
    let _ = writeln!(
        text,
        "| {} ({}) | {} | {} | {:.3} ({stretch}) | {:.3} | {:.3} | {:.3} ({shear}) | {:.2} %: {}, {}, {} | {:.1}° | {:.2} + {:.2} | {time} |",
        model.file,
        model.name,
        report["input"]["polygons"]
            .as_u64()
            .map_or_else(|| "–".into(), |count| count.to_string()),
        if is_corrected { "yes" } else { "no" },
        distortion("stretch"),
        number(&result["distortion_apart"]["stretch"]),
        distortion("stretch_at_scale"),
        distortion("shear"),
        100.0 * number(&result["singular_share"]),
        result["field_singular_faces"],
        result["phase_singular_faces"],
        result["inverted_faces"],
        number(&result["field_deviation"]),
        seconds(report, "parameterization"),
        seconds(report, "field"),
    );
    text
}

fn atlas_row(model: &Model, report: &Value) -> String {
    let (result, distortion) = (&report["result"], &report["measure"]["distortion"]);
    let atlas = &result["atlas"];
    let map_stages: &[&str] = if result["map"] == "periodic" {
        &["field", "parameterization"]
    } else {
        &["field", "integer grid", "integer grid map"]
    };
    let map_time: f64 = (map_stages.iter()).map(|name| seconds(report, name)).sum();
    let whole: f64 = ["chart layout", "chart maps", "atlas"]
        .map(|name| seconds(report, name))
        .iter()
        .sum();
    format!(
        "| {} ({}) | {} | {} | {:.1} %, {:.1} % | {} | {:.3} | {:.3} | {:.2} | {} | {:.1} | {:.2} + {:.2} |\n",
        model.file,
        model.name,
        result["map"].as_str().unwrap_or("–"),
        result["charts"],
        100.0 * number(&result["singular_share"]),
        100.0 * number(&result["singular_area_share"]),
        atlas["squares"],
        number(&distortion["l2_stretch"]),
        number(&distortion["shear_mean"]),
        number(&distortion["symmetric_dirichlet"]),
        atlas["flipped"],
        number(&atlas["seam_length_over_root_of_area"]),
        map_time,
        whole - map_time,
    )
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// The seconds of a stage; NaN if there was none.
fn seconds(report: &Value, name: &str) -> f64 {
    let times = report["times"].as_array().map_or(&[][..], Vec::as_slice);
    let found = times.iter().find(|time| time["name"] == name);
    found.map_or(f64::NAN, |time| number(&time["seconds"]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_row_has_a_cell_for_each_column_and_the_printed_figures() {
        let report = json!({
            "input": {"polygons": 20000},
            "result": {
                "distortion": {"stretch": 1.0604, "stretch_at_scale": 1.05, "shear": 0.1366},
                "distortion_apart": {"stretch": 1.03},
                "singular_share": 0.0028, "field_singular_faces": 46,
                "phase_singular_faces": 11, "inverted_faces": 0, "field_deviation": 6.99,
            },
            "times": [{"name": "field", "seconds": 0.25}, {"name": "parameterization", "seconds": 0.4}],
        });
        let row = row(&MODELS[0], &MODELS[0].printed[0], false, &report);
        let header = PREFACE
            .lines()
            .find(|line| line.starts_with("| Model"))
            .unwrap();
        assert_eq!(row.matches('|').count(), header.matches('|').count());
        assert!(
            row.contains("1.060 (1.07)") && row.contains("0.28 %: 46, 11, 0"),
            "{row}"
        );
    }

    #[test]
    fn the_time_of_an_atlas_is_told_apart_from_that_of_its_map() {
        let report = json!({
            "result": {
                "map": "periodic", "charts": 115, "singular_share": 0.12, "singular_area_share": 0.21,
                "atlas": {"squares": 170, "flipped": 0, "seam_length_over_root_of_area": 23.54},
            },
            "measure": {"distortion": {
                "l2_stretch": 1.1, "shear_mean": 0.14, "symmetric_dirichlet": 4.52,
            }},
            "times": [
                {"name": "field", "seconds": 0.25}, {"name": "parameterization", "seconds": 0.5},
                {"name": "chart layout", "seconds": 1.0}, {"name": "chart maps", "seconds": 0.25},
                {"name": "atlas", "seconds": 0.125},
            ],
        });
        let row = atlas_row(&MODELS[0], &report);
        let mut headers = ATLAS_PREFACE
            .lines()
            .filter(|line| line.starts_with("| Model"));
        assert_eq!(
            row.matches('|').count(),
            headers.next().unwrap().matches('|').count()
        );
        assert!(
            row.contains("12.0 %, 21.0 %") && row.ends_with("| 0.75 + 0.62 |\n"),
            "{row}"
        );
    }
}
