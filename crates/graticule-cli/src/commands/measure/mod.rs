//! `graticule measure`: the distortion of any mesh with texture coordinates, and the quality of any
//! quad mesh.

mod uv_set;

use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec2;
use graticule::measure::{
    MapMeasure, QuadMeasure, ReferenceMeasure, compare_to_reference, measure_partial_map,
    measure_quads,
};
use graticule::mesh::{CornerAttribute, PerCorner, PolygonSoup, Repaired};
use graticule::watch::Watch;
use graticule_draw::{Panel, Picture, side_by_side};
use serde::Serialize;
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::mesh_input::{Input, repair_to_report};
use crate::outcome::{Outcome, Plan};
use crate::picture::{PANEL, map_panels};
use crate::quads::{quad_panel, quad_table};
use crate::repair_options::RepairArguments;
use crate::report::{Report, to_value};
use crate::session::Session;
use crate::tables::measure_table;
use crate::uvs;

/// Options of `graticule measure`.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    /// The mesh: with texture coordinates, or mostly of quads, or both; - is standard input
    #[arg(value_name = "MESH")]
    mesh: PathBuf,
    /// Measure against this mesh. If it has the same polygons, texture coordinates are measured from
    /// its positions (where a flat MESH has none, its x and y are taken as such); a mesh of quads
    /// is compared to it as a surface, of whatever polygons
    #[arg(long, value_name = "MESH")]
    reference: Option<PathBuf>,
    /// Which set of texture coordinates, by name or by number from 0
    #[arg(long, value_name = "SET")]
    uv_set: Option<String>,
    /// Measure the polygons as a quad mesh also where few of them are quads
    #[arg(long)]
    quads: bool,
    #[command(flatten)]
    repair: RepairArguments,
}

/// Reads, measures, draws, reports.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let plan = Plan::check(&session.common)?;
    let input = Input::read(&options.mesh, session)?;
    let reference = options.reference.as_ref();
    let reference = reference
        .map(|path| Input::read(path, session))
        .transpose()?;
    let subject = Subject::choose(input, reference, options)?;
    let mut outcome = Outcome::of(Report::new("measure", session.options_to_report(options)?));
    outcome.report.input = subject.input.to_report();
    let wants_picture = plan.picture_format().is_some();
    let found = subject.measure(options, wants_picture, session)?;
    if let Some(repaired) = &found.repaired {
        outcome.report.repair = repair_to_report(&repaired.changes)?;
    }
    outcome.report.measure = found.to_report()?;
    let set = subject.uv_set.as_ref().map(|set| &set.name);
    outcome.report.result = json!({ "uv_set": set, "quads": subject.has_quads });
    if let Some(format) = plan.picture_format() {
        let _stage = session.watch.stage("draw");
        outcome.picture = Some(format.encode(&found.picture(&subject, &session.watch)?));
    }
    outcome.text = found.text();
    plan.finish(session, outcome)
}

/// What there is to measure.
struct Subject {
    input: Input,
    reference: Option<Input>,
    /// Whether the polygons are measured as a quad mesh.
    has_quads: bool,
    uv_set: Option<CornerAttribute<DVec2>>,
}

impl Subject {
    fn choose(input: Input, reference: Option<Input>, options: &Options) -> Result<Self, Failure> {
        let has_quads = options.quads || is_mostly_quads(&input.soup);
        let mut uv_set = uv_set::choose(&input, options)?;
        if let Some(reference) = &reference {
            let same = has_same_polygons(&input, reference);
            if !same && !has_quads {
                return Err(other_polygons(&input, reference));
            }
            if uv_set.is_none() && same && (!has_quads || is_flat(&input.soup)) {
                uv_set = Some(uv_set::positions_as_uvs(&input.soup));
            }
        }
        if uv_set.is_none() && (!has_quads || options.uv_set.is_some()) {
            let hint = "make some with 'graticule flatten', name the surface with --reference if \
                        MESH is flat, or have its polygons measured with --quads";
            let fault = Failure::new("the mesh has no texture coordinates", hint);
            return Err(fault.at(input.path.display()));
        }
        Ok(Self {
            input,
            reference,
            has_quads,
            uv_set,
        })
    }

    fn measure(
        &self,
        options: &Options,
        wants_picture: bool,
        session: &Session,
    ) -> Result<Found, Failure> {
        let fault = |error| Failure::from(error).at(self.input.path.display());
        let mut found = Found::default();
        if self.has_quads {
            let quads = measure_quads(&self.input.soup, &session.watch).map_err(fault)?;
            found.quads = Some(quads);
        }
        if let (true, Some(reference)) = (self.has_quads, &self.reference) {
            let reference = reference.repaired_on_the_way(options.repair.into(), session)?;
            let surface = &reference.surface;
            let compared = compare_to_reference(&self.input.soup, surface, &session.watch);
            found.reference = Some(compared.map_err(fault)?);
        }
        if self.uv_set.is_some() || wants_picture {
            let shape = self.shape();
            found.repaired = Some(shape.repaired_on_the_way(options.repair.into(), session)?);
        }
        if let (Some(set), Some(repaired)) = (&self.uv_set, &found.repaired) {
            let map = uvs::of_surface(repaired, set);
            let measure = measure_partial_map(&repaired.surface, &map, &session.watch);
            found.map = Some((
                map.map(|uv| uv.unwrap_or(DVec2::NAN)),
                measure.map_err(fault)?,
            ));
        }
        Ok(found)
    }

    /// The mesh in the shape that texture coordinates are measured from.
    fn shape(&self) -> Input {
        let mut soup = self.input.soup.clone();
        let reference = self.reference.as_ref();
        if let Some(reference) = reference.filter(|other| has_same_polygons(&self.input, other)) {
            soup.positions.clone_from(&reference.soup.positions);
        }
        Input {
            path: self.input.path.clone(),
            soup,
            ..self.input
        }
    }
}

/// What was measured.
#[derive(Default)]
struct Found {
    repaired: Option<Repaired>,
    map: Option<(PerCorner<DVec2>, MapMeasure)>,
    quads: Option<QuadMeasure>,
    reference: Option<ReferenceMeasure>,
}

impl Found {
    /// The keys of the map, if there is one, and those of the quads beside them.
    fn to_report(&self) -> Result<Value, Failure> {
        let mut report = match &self.map {
            Some((_, measure)) => to_value(measure)?,
            None => json!({}),
        };
        if let Some(quads) = &self.quads {
            report["quads"] = to_value(quads)?;
            report["reference"] = to_value(&self.reference)?;
        }
        Ok(report)
    }

    fn text(&self) -> String {
        let quads = self.quads.as_ref();
        let quads = quads.map(|quads| quad_table(quads, self.reference.as_ref()).to_string());
        let map = self.map.as_ref();
        let map = map.map(|(_, measure)| measure_table(measure).to_string());
        quads.into_iter().chain(map).collect()
    }

    fn picture(&self, subject: &Subject, watch: &Watch) -> Result<Picture, Failure> {
        let mut panels: Vec<Panel> = Vec::new();
        let Some(repaired) = &self.repaired else {
            return Ok(side_by_side(panels));
        };
        if let Some(quads) = &self.quads {
            panels.push(quad_panel(&subject.input.soup, repaired, quads)?);
        }
        if let Some((map, measure)) = &self.map {
            panels.extend(map_panels(&repaired.surface, map, measure, watch)?);
        }
        // A panel alone has room to show single quads.
        let side = if panels.len() == 1 { 2 * PANEL } else { PANEL };
        let width = side * panels.len() as u32;
        Ok(side_by_side(panels).with_size(width, side)?)
    }
}

/// Whether more than half of the polygons have four corners.
fn is_mostly_quads(soup: &PolygonSoup) -> bool {
    let quads = soup.polygons.iter().filter(|polygon| polygon.len() == 4);
    2 * quads.count() > soup.polygons.len()
}

fn is_flat(soup: &PolygonSoup) -> bool {
    let heights = soup.positions.iter().map(|position| position.z);
    let [low, high] = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| {
        [low.min(z), high.max(z)]
    });
    high <= low
}

fn has_same_polygons(mesh: &Input, reference: &Input) -> bool {
    mesh.soup.positions.len() == reference.soup.positions.len()
        && mesh.soup.polygons == reference.soup.polygons
}

fn other_polygons(mesh: &Input, reference: &Input) -> Failure {
    let counts = |input: &Input| (input.soup.positions.len(), input.soup.polygons.len());
    let name = |path: &Path| path.display().to_string();
    let [(vertices, polygons), (others, other_polygons)] = [counts(mesh), counts(reference)];
    Failure::new(
        format!(
            "{} ({vertices} vertices, {polygons} polygons) and {} ({others} vertices, \
             {other_polygons} polygons) do not have the same polygons",
            name(&mesh.path),
            name(&reference.path)
        ),
        "take as reference the mesh that the map was made of; quads are compared with --quads",
    )
}
