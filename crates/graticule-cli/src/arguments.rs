//! The words of the command line that all commands share.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use serde::Serialize;

use crate::commands::{
    cite, demo, field, flatten, info, layout, measure, parameterize, remesh, repair,
};

/// Flattens patches of surface meshes, measures the maps, computes cross fields, and makes meshes of
/// quads.
///
/// Data goes to the named file or to standard output, everything else to standard error. Exit
/// code 0: the promised result was written. 1: it could not be; one line says why, one what to
/// do. 2: the arguments are wrong; nothing was done.
#[derive(Parser)]
#[command(
    name = "graticule",
    version,
    arg_required_else_help = true,
    max_term_width = 100
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) common: CommonOptions,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// Options of every command.
#[derive(Args, Clone, Debug, Serialize)]
#[command(next_help_heading = "Options of every command")]
pub(crate) struct CommonOptions {
    /// Write a report with all figures to this file
    #[arg(long, global = true, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    /// Draw a picture of the result into this file (.png or .svg)
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) picture: Option<PathBuf>,
    /// Print the report to standard output
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Print nothing to standard error but errors
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Threads to use, all cores by default; the result does not depend on it
    #[arg(long, global = true, value_name = "N", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Seed of whatever is drawn at random
    #[arg(
        long,
        global = true,
        value_name = "N",
        default_value_t = 0,
        allow_negative_numbers = true
    )]
    pub(crate) seed: u64,
    /// Give up after this many seconds, with exit code 1
    #[arg(long, global = true, value_name = "S", allow_negative_numbers = true,
        value_parser = positive_seconds)]
    pub(crate) max_seconds: Option<f64>,
}

/// What to do. Serialized as its name with its options.
#[derive(Subcommand, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Command {
    /// Run the other commands on built-in surfaces, with pictures; needs no file
    Demo(demo::Options),
    /// Tell what a mesh file holds: topology, defects, sizes
    Info(info::Options),
    /// Weld, split, orient and clean a mesh, and say what was done
    Repair(repair::Options),
    /// Lay a patch flat and write its mesh with texture coordinates
    Flatten(Box<flatten::Options>),
    /// Compute a smooth field of crosses, lines or vectors and its singularities
    Field(field::Options),
    /// Cover a surface with periodic coordinates that follow a cross field
    Parameterize(parameterize::Options),
    /// Cut a surface of any topology into charts, most of them squares
    Layout(layout::Options),
    /// Make a mesh of quads that follows the shape
    Remesh(remesh::Options),
    /// Measure the distortion of any mesh with texture coordinates
    Measure(measure::Options),
    /// Print the papers behind the commands
    Cite(cite::Options),
}

fn positive_seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    // A century: longer limits overflow the clock of some systems.
    if seconds > 0.0 && seconds < 3.2e9 {
        Ok(seconds)
    } else {
        Err("must be above 0 and below 3.2e9".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Arguments::command().debug_assert();
    }

    #[test]
    fn seconds_are_positive_and_finite() {
        assert_eq!(positive_seconds("1.5"), Ok(1.5));
        for text in ["0", "-1", "nan", "inf", "x"] {
            assert!(positive_seconds(text).is_err(), "{text}");
        }
    }
}
