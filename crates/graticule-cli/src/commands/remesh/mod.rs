//! `graticule remesh`: a mesh of quads on a surface.

mod options;

use graticule::measure::{QuadMeasure, ReferenceMeasure, compare_to_reference, measure_quads};
use graticule::mesh::{PolygonSoup, RepairOptions, Repaired, repair};
use graticule::quads::{Carry, Remeshed, remesh_levels};
use graticule_draw::{Panel, Picture, side_by_side};
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
    if let Some(source) = &options.sizing {
        wanted.sizing.sizes = Some(source.on_surface(&input.soup, &repaired)?);
    }
    let densities = options.densities();
    let levels = remesh_levels(&repaired.surface, &wanted, &densities, &session.watch)
        .map_err(|error| Failure::from(error).at(input.path.display()))?;
    let levels = levels
        .iter()
        .map(|made| Level::of(made, &input.soup, &repaired, session))
        .collect::<Result<Vec<Level>, Failure>>()?;
    if let [level] = levels.as_slice() {
        outcome.report.result.clone_from(&level.result);
        outcome.report.measure = level.judged.to_report()?;
    } else {
        outcome.report.result = levels_to_report(&options.quads, &levels)?;
    }
    for level in &levels {
        let (measure, reference) = (&level.judged.measure, &level.judged.reference);
        outcome.remarks += &quad_table(measure, Some(reference)).to_string();
    }
    if let Some(format) = plan.picture_format() {
        outcome.picture = Some(format.encode(&draw(&levels, session)?));
    }
    let mut soups = levels.into_iter().map(|level| level.soup);
    outcome.mesh = soups.next();
    outcome.further_meshes = soups.collect();
    plan.finish(session, outcome)
}

/// The mesh of one density, with all that is told of it.
struct Level {
    soup: PolygonSoup,
    judged: Judged,
    result: Value,
}

impl Level {
    fn of(
        made: &Remeshed,
        original: &PolygonSoup,
        repaired: &Repaired,
        session: &Session,
    ) -> Result<Self, Failure> {
        let carry = Carry {
            original,
            repaired,
            polygons: &made.mesh.polygons,
            origins: &made.mesh.origins,
        };
        let soup = {
            let _stage = session.watch.stage("carry attributes");
            carry.to_soup()
        };
        let judged = Judged::of(&soup, repaired, session)?;
        judged.warn(session);
        let result = result_to_report(made)?;
        Ok(Self {
            soup,
            judged,
            result,
        })
    }
}

fn levels_to_report(asked: &[u32], levels: &[Level]) -> Result<Value, Failure> {
    let told = asked.iter().zip(levels).map(|(asked, level)| {
        let measure = level.judged.to_report()?;
        Ok(json!({ "asked": asked, "result": level.result, "measure": measure }))
    });
    let told = told.collect::<Result<Vec<Value>, Failure>>()?;
    Ok(json!({ "levels": told }))
}

/// The widest picture, in panels of full size.
const MOST_PANELS: u32 = 4;

/// The meshes side by side.
fn draw(levels: &[Level], session: &Session) -> Result<Picture, Failure> {
    let _stage = session.watch.stage("draw");
    let panel = |Level { soup, judged, .. }: &Level| -> Result<Panel, Failure> {
        let drawn = repair(soup, &RepairOptions::default(), &session.watch)?;
        Ok(quad_panel(soup, &drawn, &judged.measure)?)
    };
    let panels = levels.iter().map(panel).collect::<Result<Vec<_>, _>>()?;
    let width = 2 * PANEL * (panels.len() as u32).min(MOST_PANELS);
    Ok(side_by_side(panels).with_size(width, 2 * PANEL)?)
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
}
