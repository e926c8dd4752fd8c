//! `graticule repair`: a sound surface of any mesh, and what was changed.

use clap::Args;
use graticule::mesh::{PolygonSoup, RepairChanges, Topology};
use serde::Serialize;
use serde_json::json;

use crate::failure::Failure;
use crate::mesh_input::{Input, repair_to_report};
use crate::mesh_output::MeshPaths;
use crate::outcome::{Outcome, Plan};
use crate::picture::surface_picture;
use crate::repair_options::RepairArguments;
use crate::report::Report;
use crate::session::Session;

/// Options of `graticule repair`.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    #[command(flatten)]
    #[serde(flatten)]
    paths: MeshPaths,
    #[command(flatten)]
    repair: RepairArguments,
}

/// Reads, repairs, writes, says what was done.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let output = options.paths.output()?;
    let plan = Plan::with_mesh(&session.common, Some(output))?;
    let input = Input::read(&options.paths.mesh, session)?;
    let mut outcome = Outcome::of(Report::new("repair", session.options_to_report(options)?));
    outcome.report.input = input.to_report();
    let repaired = input.repaired(options.repair.into(), session)?;
    outcome.report.repair = repair_to_report(&repaired.changes)?;
    let topology = Topology::of(repaired.surface.mesh());
    outcome.report.result = json!({
        "components": topology.components.len(),
        "total": topology.total,
        "output": options.paths.output.to_string_lossy(),
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
