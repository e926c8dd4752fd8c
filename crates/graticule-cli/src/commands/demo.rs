//! `graticule demo`: the other commands, one after another, on built-in surfaces.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, Parser};
use graticule::mesh::{PolygonSoup, Surface, VertexId};
use graticule_io::{Format, write_to};
use serde::Serialize;
use serde_json::json;

use crate::arguments::Arguments;
use crate::failure::Failure;
use crate::mask::mask;
use crate::outcome::{Outcome, Plan};
use crate::output::{check_writable, write_whole};
use crate::report::Report;
use crate::run_command;
use crate::session::Session;
use crate::teapot::teapot;

/// Options of `graticule demo`.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    /// Folder for the files; made if it does not exist
    #[arg(long, value_name = "FOLDER", default_value = "graticule-demo")]
    output_folder: PathBuf,
    /// Cells of the grid that the teapot is made from, along its length: about 4 N² triangles
    #[arg(long, value_name = "N", default_value_t = 72, value_parser = clap::value_parser!(u32).range(48..=200))]
    cells: u32,
    /// Quads that the teapot is remeshed with
    #[arg(long, value_name = "N", default_value_t = 3000, value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    quads: u32,
    /// Rings of triangles in the mask: about 6 N² triangles
    #[arg(long, value_name = "N", default_value_t = 90, value_parser = clap::value_parser!(u32).range(30..=1000))]
    rings: u32,
}

const TEAPOT: &str = "teapot.obj";
const MASK: &str = "mask.obj";
const REPORT: &str = "report.json";

/// What a command of the demo reads, its other words, and the name of all that it writes.
struct Step {
    command: &'static str,
    input: &'static str,
    name: &'static str,
    words: Vec<String>,
}

/// Makes a teapot and a mask, lays charts and quads on the one and flattens the other.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let folder = &options.output_folder;
    let mut plan = Plan::without_picture(&session.common, "demo")?;
    make_folder(folder)?;
    plan.add(folder.join(REPORT), Vec::new())?;
    let mask = {
        let _stage = session.watch.stage("make surfaces");
        write_mesh(&teapot(options.cells)?, &folder.join(TEAPOT))?;
        let mask = mask(options.rings)?;
        write_mesh(&mask, &folder.join(MASK))?;
        mask
    };
    let mut commands = Vec::new();
    let mut files: Vec<PathBuf> = [TEAPOT, MASK].map(|name| folder.join(name)).into();
    for step in steps(options, &mask) {
        let [mesh, picture, report] =
            ["obj", "png", "json"].map(|ending| folder.join(format!("{}.{ending}", step.name)));
        let words = step.command_line(folder, &mesh, &picture, &report);
        commands.push(run_step(words, session)?);
        files.extend([mesh, picture, report]);
    }
    files.push(folder.join(REPORT));
    let mut outcome = Outcome::of(Report::new("demo", session.options_to_report(options)?));
    outcome.report.result = json!({ "commands": commands });
    let lines = files.iter().map(|file| format!("{}\n", file.display()));
    outcome.text = lines.collect();
    plan.finish(session, outcome)
}

fn steps(options: &Options, mask: &Surface) -> [Step; 3] {
    let pins = upright_pins(mask);
    [
        Step {
            command: "layout",
            input: TEAPOT,
            name: "charts",
            words: vec!["--grid-seams".into()],
        },
        Step {
            command: "remesh",
            input: TEAPOT,
            name: "quads",
            words: vec!["--quads".into(), options.quads.to_string()],
        },
        Step {
            command: "flatten",
            input: MASK,
            name: "flat",
            words: pins
                .into_iter()
                .flat_map(|pin| ["--pin".into(), pin])
                .collect(),
        },
    ]
}

impl Step {
    /// All words of the command, as they would be typed.
    fn command_line(
        &self,
        folder: &Path,
        mesh: &Path,
        picture: &Path,
        report: &Path,
    ) -> Vec<OsString> {
        let mut words: Vec<OsString> = vec!["graticule".into(), self.command.into()];
        words.push(folder.join(self.input).into());
        words.extend(self.words.iter().map(OsString::from));
        for (option, file) in [("-o", mesh), ("--picture", picture), ("--report", report)] {
            words.extend([option.into(), file.into()]);
        }
        words
    }
}

/// Runs one command as a part of the session; returns what would be typed for it.
fn run_step(words: Vec<OsString>, session: &Session) -> Result<String, Failure> {
    let typed: Vec<_> = words.iter().map(|word| word.to_string_lossy()).collect();
    let typed = typed.join(" ");
    session.console.line(&format!("\n$ {typed}"));
    let arguments = Arguments::try_parse_from(words)
        .map_err(|error| Failure::usage(error.to_string(), "name another folder"))?;
    let mut common = arguments.common;
    common.quiet = session.common.quiet;
    common.threads = session.common.threads;
    common.seed = session.common.seed;
    run_command(&arguments.command, &session.part(common))?;
    Ok(typed)
}

/// Makes the folder, before any work.
fn make_folder(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| {
        Failure::usage(
            format!("the folder {} could not be made: {error}", folder.display()),
            "name another place with --output-folder",
        )
    })?;
    check_writable(&folder.join(TEAPOT))
}

fn write_mesh(surface: &Surface, path: &Path) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    write_to(&mut bytes, &PolygonSoup::from(surface), Format::Obj)?;
    write_whole(path, |out| out.write_all(&bytes))
}

/// The lowest and the highest boundary vertex, one above the other in the map too.
fn upright_pins(surface: &Surface) -> Vec<String> {
    let mesh = surface.mesh();
    let by_height = |a: &VertexId, b: &VertexId| {
        let [a, b] = [a, b].map(|&vertex| surface.position(vertex).y);
        a.total_cmp(&b)
    };
    let boundary = || mesh.vertices().filter(|&v| mesh.is_boundary_vertex(v));
    let lowest = boundary().min_by(by_height);
    let highest = boundary().max_by(by_height);
    let ends = [(lowest, "0,0"), (highest, "0,1")];
    let pin = |(vertex, place): (Option<VertexId>, &str)| Some(format!("{}:{place}", vertex?.0));
    ends.into_iter().filter_map(pin).collect()
}
