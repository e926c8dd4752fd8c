//! `graticule demo`: the main job on a built-in surface.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec2;
use graticule::flatten::{NaturalOptions, Patch, natural_map};
use graticule::mesh::{CornerAttribute, PerVertex, PolygonSoup, Surface};
use graticule_io::{Format, write_to};
use serde::Serialize;
use serde_json::{Value, json};

use super::flatten::{Judged, map_to_report};
use crate::failure::Failure;
use crate::mask::mask;
use crate::outcome::{Outcome, Plan};
use crate::output::check_writable;
use crate::picture::PictureFormat;
use crate::report::Report;
use crate::session::Session;

/// Options of `graticule demo`.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    /// Folder for the files; made if it does not exist
    #[arg(long, value_name = "FOLDER", default_value = "graticule-demo")]
    output_folder: PathBuf,
    /// Rings of triangles in the surface: about 6 N² triangles
    #[arg(long, value_name = "N", default_value_t = 90, value_parser = clap::value_parser!(u32).range(30..=1000))]
    rings: u32,
}

/// The files made, in the folder.
const MESH: &str = "mask.obj";
const PICTURE: &str = "demo.png";
const REPORT: &str = "report.json";

/// Makes the surface, flattens, measures, draws, writes, and says what it wrote.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let folder = &options.output_folder;
    make_folder(folder)?;
    let mut plan = Plan::check(&session.common)?;
    plan.add_report(folder.join(REPORT))?;
    let surface = {
        let _stage = session.watch.stage("make surface");
        mask(options.rings)?
    };
    let mut outcome = Outcome::of(Report::new("demo", session.options_to_report(options)?));
    outcome.report.input = input_to_report(&surface);
    let stage = session.watch.stage("flatten");
    let patch = Patch::new(surface, &session.watch)?;
    let map = natural_map(&patch, &NaturalOptions::default(), &session.watch)?;
    drop(stage);
    let uv = map.unit_square_uv();
    outcome.report.result = map_to_report(&map);
    let judged = Judged::of(patch.surface(), &uv, session)?;
    judged.tell(&mut outcome)?;
    let picture = judged.draw(session)?;
    outcome.picture = plan.picture_format().map(|format| format.encode(&picture));
    outcome.files = vec![
        (folder.join(MESH), mesh_file(patch.surface(), uv)?),
        (folder.join(PICTURE), PictureFormat::Png.encode(&picture)),
    ];
    for name in [MESH, PICTURE, REPORT] {
        outcome
            .text
            .push_str(&format!("{}\n", folder.join(name).display()));
    }
    plan.finish(session, outcome)
}

/// Makes the folder, before any work.
fn make_folder(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| {
        Failure::usage(
            format!("the folder {} could not be made: {error}", folder.display()),
            "name another place with --output-folder",
        )
    })?;
    check_writable(&folder.join(MESH))
}

fn input_to_report(surface: &Surface) -> Value {
    json!({
        "path": null,
        "vertices": surface.mesh().vertex_count(),
        "polygons": surface.mesh().face_count(),
    })
}

/// The surface with its texture coordinates, as OBJ.
fn mesh_file(surface: &Surface, uv: PerVertex<DVec2>) -> Result<Vec<u8>, Failure> {
    let mesh = surface.mesh();
    let triangles: Vec<[u32; 3]> = mesh
        .faces()
        .map(|face| mesh.triangle(face).map(|vertex| vertex.0))
        .collect();
    let mut soup = PolygonSoup {
        positions: surface.positions().as_slice().to_vec(),
        polygons: triangles.iter().map(|triangle| &triangle[..]).collect(),
        ..PolygonSoup::default()
    };
    soup.attributes.uv_sets.push(CornerAttribute {
        name: String::new(),
        values: uv.into_vec(),
        corner_values: soup.polygons.corner_vertices().to_vec(),
    });
    let mut bytes = Vec::new();
    write_to(&mut bytes, &soup, Format::Obj)?;
    Ok(bytes)
}
