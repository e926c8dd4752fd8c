//! `graticule repair`: a sound surface of any mesh, and what was changed.

use std::path::PathBuf;

use clap::Args;
use graticule::mesh::{PolygonSoup, RepairChanges, Topology};
use graticule_io::Format;
use serde::Serialize;
use serde_json::json;

use crate::failure::Failure;
use crate::mesh_input::{Input, repair_to_report};
use crate::mesh_output::{MeshOutput, parse_format};
use crate::outcome::{Outcome, Plan};
use crate::picture::surface_picture;
use crate::repair_options::RepairArguments;
use crate::report::Report;
use crate::session::Session;

/// Options of `graticule repair`.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    /// The mesh to repair; - is standard input
    #[arg(value_name = "MESH")]
    mesh: PathBuf,
    /// Where to write the repaired mesh; - is standard output
    #[arg(long, short, value_name = "OUT")]
    output: PathBuf,
    /// Format to write, if OUT's ending does not tell
    #[arg(long, value_name = "FORMAT", value_parser = parse_format)]
    #[serde(skip)]
    format: Option<Format>,
    #[command(flatten)]
    repair: RepairArguments,
}

/// Reads, repairs, writes, says what was done.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let output = MeshOutput::new(&options.output, options.format)?;
    let plan = Plan::with_mesh(&session.common, Some(output))?;
    let input = Input::read(&options.mesh, session)?;
    let mut outcome = Outcome::of(Report::new("repair", session.options_to_report(options)?));
    outcome.report.input = input.to_report();
    let repaired = input.repaired(options.repair.into(), session)?;
    outcome.report.repair = repair_to_report(&repaired.changes)?;
    let topology = Topology::of(repaired.surface.mesh());
    outcome.report.result = json!({
        "components": topology.components.len(),
        "total": topology.total,
        "output": options.output.to_string_lossy(),
    });
    if let Some(format) = plan.picture_format() {
        let _stage = session.watch.stage("draw");
        outcome.picture = Some(format.encode(&surface_picture(&repaired.surface)?));
    }
    let soup = repaired.to_soup(&input.soup);
    let told = RepairChanges {
        // Polygons that are written whole were cut for the inspection only.
        polygons_triangulated: polygons(&input.soup).saturating_sub(polygons(&soup)),
        ..repaired.changes.clone()
    };
    outcome.remarks = remarks(&told.sentences());
    outcome.mesh = Some(soup);
    outcome.ascii = input.ascii;
    plan.finish(session, outcome)
}

/// How many have more than three corners.
fn polygons(soup: &PolygonSoup) -> usize {
    let polygons = soup.polygons.iter();
    polygons.filter(|corners| corners.len() > 3).count()
}

fn remarks(sentences: &[String]) -> String {
    if sentences.is_empty() {
        return "nothing had to be changed".into();
    }
    sentences.join("\n")
}
