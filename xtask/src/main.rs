//! Chores of the workspace: `cargo xtask --help`.
#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, clippy::print_stderr)] // a program talks

mod layers;
mod papers;
mod source;

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Why a chore failed, in words for the terminal.
#[derive(Debug)]
pub(crate) struct Trouble(pub(crate) String);

impl Trouble {
    pub(crate) fn reading(path: &Path, error: &io::Error) -> Self {
        Self(format!("{}: {error}", path.display()))
    }
}

/// Chores of the Graticule workspace.
#[derive(Parser)]
#[command(bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Subcommand)]
enum Chore {
    /// Check that modules and crates use only what stands above them.
    Layers,
    /// Check the tables of equations in `papers/`.
    Papers,
}

fn main() -> ExitCode {
    match run(&Arguments::parse().chore) {
        Ok(sentence) => {
            println!("{sentence}");
            ExitCode::SUCCESS
        }
        Err(Trouble(text)) => {
            eprintln!("{text}");
            ExitCode::FAILURE
        }
    }
}

fn run(chore: &Chore) -> Result<String, Trouble> {
    let root = workspace_root();
    match chore {
        Chore::Layers => layers::check(&root),
        Chore::Papers => papers::check(&root),
    }
}

/// The folder of the workspace: the parent of this package's.
fn workspace_root() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().unwrap_or(package).to_path_buf()
}
