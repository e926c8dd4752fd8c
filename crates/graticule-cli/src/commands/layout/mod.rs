//! `graticule layout`: a surface cut into charts, each on a square of an atlas.

mod atlas;
mod atlas_options;
mod options;
mod output;
mod picture;
mod table;
mod textures;

use graticule::charts::{BaseComplex, LaidOut, base_complex, chart_layout};
use graticule_draw::side_by_side;
use graticule_io::{WriteOptions, write_to_with};
use serde_json::Value;

use super::field::lines_of_file;
use crate::failure::Failure;
use crate::mesh_input::{Input, repair_to_report};
use crate::outcome::Outcome;
use crate::report::{Report, to_value};
use crate::session::Session;

use atlas::{Atlas, AtlasInput};
pub(crate) use options::Options;

/// Side of a panel of the picture in pixels.
const PANEL: u32 = 1000;

/// Reads, repairs, lays out, draws, writes.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let (plan, complex_file) = options.check(&session.common)?;
    let input = Input::read(&options.paths.mesh, session)?;
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
    let laid_out = AtlasInput {
        soup: &input.soup,
        repaired: &repaired,
        layout: &found.layout,
    };
    let at_input = |failure: Failure| failure.at(input.path.display());
    let atlas = Atlas::of(&options.atlas, &laid_out, session).map_err(at_input)?;
    atlas
        .tell(&options.atlas, &laid_out, &mut outcome, session)
        .map_err(at_input)?;
    outcome.ascii = input.ascii;
    if let Some(format) = plan.picture_format() {
        let _stage = session.watch.stage("draw");
        let mut panels = picture::panels(&repaired.surface, &found, &complex)?;
        panels.extend(atlas.panels()?);
        let picture = side_by_side(panels).with_columns(3);
        let picture = picture.with_size(3 * PANEL, 2 * PANEL)?;
        outcome.picture = Some(format.encode(&picture));
    }
    if let Some(path) = &options.layout {
        let text = output::layout(&found.layout, &complex, atlas.maps(), &repaired)?;
        outcome.files.push((path.clone(), text.into_bytes()));
    }
    if let Some((path, format)) = complex_file {
        let soup = complex.mesh.into_soup();
        let mut bytes = Vec::new();
        write_to_with(&mut bytes, &soup, format, WriteOptions::default())?;
        outcome.files.push((path, bytes));
    }
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
