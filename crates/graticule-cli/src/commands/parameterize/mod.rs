//! `graticule parameterize`: periodic coordinates that follow a cross field.

mod options;
mod output;
mod picture;
pub(crate) mod sizing;
mod table;

use graticule::field::{FieldResult, cross_field, feature_edges};
use graticule::measure::measure_map;
use graticule::mesh::{PolygonSoup, Repaired, Surface};
use graticule::periodic::{Parameterization, parameterize};

use super::field::lines_of_file;
use crate::failure::Failure;
use crate::mesh_input::{Input, repair_to_report};
use crate::outcome::Outcome;
use crate::report::{Report, to_value};
use crate::session::Session;
use crate::uvs;

pub(crate) use options::Options;
pub(crate) use picture::{FIELD_SINGULAR, dots, lines_panel};

/// Reads, repairs, computes field and coordinates, draws, writes.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let plan = options.check(&session.common)?;
    let input = Input::read(&options.paths.mesh, session)?;
    let mut outcome = Outcome::of(Report::new(
        "parameterize",
        session.options_to_report(options)?,
    ));
    outcome.report.input = input.to_report();
    let repaired = input.repaired_on_the_way(options.repair_options(), session)?;
    outcome.report.repair = repair_to_report(&repaired.changes)?;
    let found = Found::of(options, &input.soup, &repaired, session)
        .map_err(|failure| failure.at(input.path.display()))?;
    outcome.report.result = to_value(&found.map.report)?;
    outcome.report.result["field"] = to_value(&found.field.report)?;
    outcome.remarks = table::table(&found.map).to_string();
    if let Some(format) = plan.picture_format() {
        let _stage = session.watch.stage("draw");
        let picture = picture::picture(&repaired.surface, &found.map, options.draw_norms)?;
        outcome.picture = Some(format.encode(&picture));
    }
    if let Some(path) = &options.integers {
        let text = output::integers(&repaired, &found.map)?;
        outcome.files.push((path.clone(), text.into_bytes()));
    }
    let coordinates = output::polygon_coordinates(&repaired, &found.map);
    {
        let _stage = session.watch.stage("measure");
        let measure = measure_map(&repaired.surface, &coordinates, &session.watch)?;
        outcome.report.measure = to_value(&measure)?;
    }
    let (values, value_of_corner) =
        uvs::distinct_at_vertices(repaired.surface.mesh(), &coordinates);
    let soup = uvs::put_at_corners(input.soup, &repaired, values, &value_of_corner);
    outcome.mesh = Some(soup);
    plan.finish(session, outcome)
}

/// Coordinates with the field that they follow.
struct Found {
    field: FieldResult,
    map: Parameterization,
}

impl Found {
    fn of(
        options: &Options,
        soup: &PolygonSoup,
        repaired: &Repaired,
        session: &Session,
    ) -> Result<Self, Failure> {
        let surface: &Surface = &repaired.surface;
        let seed = session.common.seed;
        let mut wanted = options.field_options(seed);
        let (edges, beside) = lines_of_file(soup, repaired);
        wanted.features.edges = edges;
        wanted.strokes.extend(beside);
        let field = cross_field(surface, &wanted, &session.watch)?;
        let sizing = options.sizing();
        let density = sizing.density(&field, soup, repaired, &session.watch)?;
        let mut options = options.parameterize_options(seed);
        options.features = wanted.features.edges;
        if let Some(dihedral) = wanted.features.dihedral {
            let sharp = feature_edges(surface, dihedral, wanted.features.least_edges);
            options.features.extend(sharp);
        }
        options.features.sort_unstable();
        options.features.dedup();
        let density = density.as_ref();
        let map = parameterize(surface, &field.field, density, &options, &session.watch)?;
        Ok(Self { field, map })
    }
}
