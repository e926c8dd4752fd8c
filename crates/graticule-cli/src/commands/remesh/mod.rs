//! `graticule remesh`: a mesh of quads on a surface.

mod options;

use graticule::measure::{QuadMeasure, ReferenceMeasure, compare_to_reference, measure_quads};
use graticule::mesh::{PolygonSoup, RepairOptions, Repaired, repair};
use graticule::quads::{Carry, Remeshed, remesh};
use graticule_draw::{Picture, side_by_side};
use serde_json::{Value, json};

use super::field::lines_of_file;
use crate::failure::Failure;
use crate::mesh_input::{Input, repair_to_report};
use crate::outcome::Outcome;
use crate::picture::PANEL;
use crate::quads::{quad_panel, quad_table};
use crate::report::{Report, to_value};
use crate::session::Session;
pub(crate) use options::Options;

/// Reads, repairs, remeshes, carries attributes over, measures, draws, writes.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let plan = options.check(&session.common)?;
    let input = Input::read(&options.paths.mesh, session)?;
    let mut outcome = Outcome::of(Report::new("remesh", session.options_to_report(options)?));
    outcome.report.input = input.to_report();
    let repaired = input.repaired_on_the_way(options.repair_options(), session)?;
    outcome.report.repair = repair_to_report(&repaired.changes)?;
    let mut wanted = options.remesh_options(session.common.seed);
    let (edges, beside) = lines_of_file(&input.soup, &repaired);
    wanted.field.features.edges = edges;
    wanted.field.strokes.extend(beside);
    let made = remesh(&repaired.surface, &wanted, &session.watch)
        .map_err(|error| Failure::from(error).at(input.path.display()))?;
    let carry = Carry {
        original: &input.soup,
        repaired: &repaired,
        polygons: &made.mesh.polygons,
        origins: &made.mesh.origins,
    };
    let soup = {
        let _stage = session.watch.stage("carry attributes");
        carry.to_soup()
    };
    let judged = Judged::of(&soup, &repaired, session)?;
    judged.warn(session);
    outcome.report.result = result_to_report(&made)?;
    outcome.report.measure = judged.to_report()?;
    outcome.remarks = quad_table(&judged.measure, Some(&judged.reference)).to_string();
    if let Some(format) = plan.picture_format() {
        outcome.picture = Some(format.encode(&judged.draw(&soup, session)?));
    }
    outcome.mesh = Some(soup);
    plan.finish(session, outcome)
}

fn result_to_report(made: &Remeshed) -> Result<Value, Failure> {
    let mut report = to_value(&made.report)?;
    report["quads"] = json!(made.mesh.quad_count());
    report["vertices"] = json!(made.mesh.positions.len());
    Ok(report)
}

/// A quad mesh, measured.
struct Judged {
    measure: QuadMeasure,
    reference: ReferenceMeasure,
}

impl Judged {
    fn of(soup: &PolygonSoup, repaired: &Repaired, session: &Session) -> Result<Self, Failure> {
        let watch = &session.watch;
        Ok(Self {
            measure: measure_quads(soup, watch)?,
            reference: compare_to_reference(soup, &repaired.surface, watch)?,
        })
    }

    /// Tells of folds.
    fn warn(&self, session: &Session) {
        let count = self.measure.folds;
        if count > 0 {
            let what = "edges are folds: their polygons face more than 120° apart";
            session.watch.warn("folds", format!("{count} {what}"));
        }
    }

    fn to_report(&self) -> Result<Value, Failure> {
        Ok(json!({
            "quads": to_value(&self.measure)?,
            "reference": to_value(&self.reference)?,
        }))
    }

    fn draw(&self, soup: &PolygonSoup, session: &Session) -> Result<Picture, Failure> {
        let _stage = session.watch.stage("draw");
        let drawn = repair(soup, &RepairOptions::default(), &session.watch)?;
        let panel = quad_panel(soup, &drawn, &self.measure)?;
        Ok(side_by_side(vec![panel]).with_size(2 * PANEL, 2 * PANEL)?)
    }
}
