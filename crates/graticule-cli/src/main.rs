//! The command `graticule`: files in, files, pictures and reports out. It adds no algorithm to
//! the library.
#![forbid(unsafe_code)]

mod arguments;
mod chart_arguments;
mod commands;
mod console;
mod failure;
mod field_arguments;
mod lines;
mod mask;
mod mesh_input;
mod mesh_output;
mod outcome;
mod output;
mod picture;
mod quads;
mod repair_options;
mod report;
mod session;
mod signals;
mod tables;
mod teapot;
mod uvs;

use std::process::ExitCode;
use std::sync::Arc;

use clap::Parser;

use arguments::{Arguments, Command};
use commands::{cite, demo, field, flatten, info, layout, measure, parameterize, remesh, repair};
use console::Console;
use failure::Failure;
use session::Session;

/// Stages allocate and free arrays as large as the mesh: handing each back to the system and
/// asking for it again costs a fifth of the time of a long run.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let console = Arc::new(Console::new(arguments.common.quiet));
    match run(arguments, &console) {
        Ok(()) => {
            console.finish();
            ExitCode::SUCCESS
        }
        Err(failure) => {
            console.failure(&failure);
            failure.exit_code()
        }
    }
}

fn run(arguments: Arguments, console: &Arc<Console>) -> Result<(), Failure> {
    let session = Session::start(arguments.common, Arc::clone(console))?;
    run_command(&arguments.command, &session).map_err(|failure| {
        let failure = match session.check() {
            // Whatever was being computed: that it was stopped is the reason.
            Err(stopped) if !session.is_writing() => stopped,
            _ => failure,
        };
        if failure.is_of_the_work() {
            session.report_failure(&arguments.command, &failure);
        }
        failure
    })
}

fn run_command(command: &Command, session: &Session) -> Result<(), Failure> {
    match command {
        Command::Demo(options) => demo::run(options, session),
        Command::Info(options) => info::run(options, session),
        Command::Repair(options) => repair::run(options, session),
        Command::Flatten(options) => flatten::run(options, session),
        Command::Field(options) => field::run(options, session),
        Command::Parameterize(options) => parameterize::run(options, session),
        Command::Layout(options) => layout::run(options, session),
        Command::Remesh(options) => remesh::run(options, session),
        Command::Measure(options) => measure::run(options, session),
        Command::Cite(options) => cite::run(options, session),
    }
}
