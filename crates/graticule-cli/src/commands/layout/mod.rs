//! `graticule layout`: a surface cut into charts.

mod options;
mod output;
mod picture;
mod table;

use graticule::charts::{BaseComplex, LaidOut, base_complex, chart_layout};
use graticule_io::{WriteOptions, write_to_with};
use serde_json::Value;

use super::field::lines_of_file;
use crate::failure::Failure;
use crate::mesh_input::{Input, repair_to_report};
use crate::outcome::Outcome;
use crate::report::{Report, to_value};
use crate::session::Session;

pub(crate) use options::Options;

/// Reads, repairs, lays out, draws, writes.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let (plan, complex_file) = options.check(&session.common)?;
    let input = Input::read(&options.mesh, session)?;
    let mut outcome = Outcome::of(Report::new("layout", session.options_to_report(options)?));
    outcome.report.input = input.to_report();
    let repaired = input.repaired_on_the_way(options.repair_options(), session)?;
    outcome.report.repair = repair_to_report(&repaired.changes)?;
    let mut wanted = options.layout_options(session.common.seed);
    let (edges, beside) = lines_of_file(&input.soup, &repaired);
    wanted.field.features.edges = edges;
    wanted.field.strokes.extend(beside);
    let found = chart_layout(&repaired.surface, &wanted, &session.watch)
        .map_err(|error| Failure::from(error).at(input.path.display()))?;
    let complex = base_complex(&found.layout);
    outcome.report.result = result_to_report(&found, &complex)?;
    outcome.remarks = table::table(&found).to_string();
    if let Some(format) = plan.picture_format() {
        let _stage = session.watch.stage("draw");
        outcome.picture = Some(format.encode(&picture::picture(&found.layout)?));
    }
    if let Some(path) = &options.layout {
        let text = output::layout(&found.layout, &complex, &repaired)?;
        outcome.files.push((path.clone(), text.into_bytes()));
    }
    if let Some((path, format)) = complex_file {
        let soup = complex.mesh.into_soup();
        let mut bytes = Vec::new();
        write_to_with(&mut bytes, &soup, format, WriteOptions::default())?;
        outcome.files.push((path, bytes));
    }
    outcome.mesh = Some(output::refined_mesh(&found.layout));
    plan.finish(session, outcome)
}

fn result_to_report(found: &LaidOut, complex: &BaseComplex) -> Result<Value, Failure> {
    let mut report = to_value(&found.report)?;
    report["map"] = to_value(&found.map_kind)?;
    report["valences"] = output::counts_of_valences(&complex.valences());
    report["coordinates"] = to_value(&found.coordinates)?;
    report["field"] = to_value(&found.field.report)?;
    Ok(report)
}
