//! `graticule measure`: the distortion of any mesh with texture coordinates.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec2;
use graticule::measure::measure_partial_map;
use graticule::mesh::{CornerAttribute, PerCorner, PolygonSoup};
use serde::Serialize;
use serde_json::json;

use crate::failure::Failure;
use crate::mesh_input::{Input, repair_to_report};
use crate::outcome::{Outcome, Plan};
use crate::picture::map_picture;
use crate::repair_options::RepairArguments;
use crate::report::{Report, to_value};
use crate::session::Session;
use crate::tables::measure_table;
use crate::uvs;

/// Options of `graticule measure`.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    /// The mesh with texture coordinates; - is standard input
    #[arg(value_name = "MESH")]
    mesh: PathBuf,
    /// Measure from this mesh, of the same polygons, instead of MESH's own positions; where MESH
    /// has no texture coordinates, its x and y are taken as such
    #[arg(long, value_name = "MESH")]
    reference: Option<PathBuf>,
    /// Which set of texture coordinates, by name or by number from 0
    #[arg(long, value_name = "SET")]
    uv_set: Option<String>,
    #[command(flatten)]
    repair: RepairArguments,
}

/// Reads, measures, draws, reports.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let plan = Plan::check(&session.common)?;
    let mut input = Input::read(&options.mesh, session)?;
    let uv_set = choose_set(&input, options)?;
    if let Some(reference) = &options.reference {
        let reference = Input::read(reference, session)?;
        check_same_polygons(&input, &reference)?;
        input.soup.positions = reference.soup.positions;
    }
    let mut outcome = Outcome::of(Report::new("measure", session.options_to_report(options)?));
    outcome.report.input = input.to_report();
    let repaired = input.repaired_on_the_way(options.repair.into(), session)?;
    outcome.report.repair = repair_to_report(&repaired.changes)?;
    let map = uvs::of_surface(&repaired, &uv_set);
    let measure = measure_partial_map(&repaired.surface, &map, &session.watch)
        .map_err(|error| Failure::from(error).at(input.path.display()))?;
    outcome.report.measure = to_value(&measure)?;
    outcome.report.result = json!({ "uv_set": uv_set.name });
    if let Some(format) = plan.picture_format() {
        let _stage = session.watch.stage("draw");
        let map: PerCorner<DVec2> = map.map(|uv| uv.unwrap_or(DVec2::NAN));
        let picture = map_picture(&repaired.surface, &map, &measure, &session.watch)?;
        outcome.picture = Some(format.encode(&picture));
    }
    outcome.text = measure_table(&measure).to_string();
    plan.finish(session, outcome)
}

/// The set of texture coordinates that the options ask for.
fn choose_set(input: &Input, options: &Options) -> Result<CornerAttribute<DVec2>, Failure> {
    let sets = &input.soup.attributes.uv_sets;
    let fault = |fact: String, hint: &str| Failure::new(fact, hint).at(input.path.display());
    if sets.is_empty() {
        return match options.reference {
            Some(_) => Ok(positions_as_uvs(&input.soup)),
            None => Err(fault(
                "the mesh has no texture coordinates".into(),
                "make some with 'graticule flatten', or name the surface with --reference if MESH is flat",
            )),
        };
    }
    let Some(wanted) = &options.uv_set else {
        return Ok(sets[0].clone());
    };
    let by_name = sets.iter().find(|set| set.name == *wanted);
    let by_number = || {
        wanted
            .parse()
            .ok()
            .and_then(|number: usize| sets.get(number))
    };
    by_name.or_else(by_number).cloned().ok_or_else(|| {
        let name = |name: &str| {
            if name.is_empty() {
                "no name".into()
            } else {
                format!("'{name}'")
            }
        };
        let names: Vec<String> = sets.iter().map(|set| name(&set.name)).collect();
        fault(
            format!("there is no set of texture coordinates '{wanted}'"),
            &format!(
                "it has {}, from number 0 on: {}",
                sets.len(),
                names.join(", ")
            ),
        )
    })
}

/// The x and y of each vertex as its coordinates in the plane.
fn positions_as_uvs(soup: &PolygonSoup) -> CornerAttribute<DVec2> {
    CornerAttribute {
        name: "positions".into(),
        values: soup.positions.iter().map(|p| p.truncate()).collect(),
        corner_values: soup.polygons.corner_vertices().to_vec(),
    }
}

fn check_same_polygons(mesh: &Input, reference: &Input) -> Result<(), Failure> {
    let counts = |input: &Input| (input.soup.positions.len(), input.soup.polygons.len());
    let name = |path: &Path| path.display().to_string();
    if counts(mesh) == counts(reference) && mesh.soup.polygons == reference.soup.polygons {
        return Ok(());
    }
    let [(vertices, polygons), (others, other_polygons)] = [counts(mesh), counts(reference)];
    Err(Failure::new(
        format!(
            "{} ({vertices} vertices, {polygons} polygons) and {} ({others} vertices, \
             {other_polygons} polygons) do not have the same polygons",
            name(&mesh.path),
            name(&reference.path)
        ),
        "take as reference the mesh that the map was made of",
    ))
}
