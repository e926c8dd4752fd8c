//! Chores of the workspace: `cargo xtask --help`.
#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, clippy::print_stderr)] // a program talks

mod bench;
mod corpus;
mod gallery;
mod growth;
mod layers;
mod papers;
mod picture;
mod runs;
mod same;
mod shrink;
mod source;
mod table1;

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

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
    /// Run every mesh of a folder through the command and compare with the accepted table.
    Corpus(corpus::Options),
    /// Measure a command on patches of growing size and print the tables of `BENCHMARKS.md`.
    Bench(bench::Options),
    /// Measure how the commands grow, from ten thousand triangles to three million, for `BENCHMARKS.md`.
    Growth(growth::Options),
    /// Check that every command writes the same bytes again, on one thread and on two.
    Same(same::Options),
    /// Make Table I of PGP06 anew, from the models of a folder.
    Table1(table1::Options),
    /// Make the gallery of the papers' figures anew.
    Gallery,
    /// Make the picture of the README anew.
    Picture,
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
        Chore::Corpus(options) => corpus::run(&root, options),
        Chore::Bench(options) => bench::run(&root, options),
        Chore::Growth(options) => growth::run(&root, options),
        Chore::Same(options) => same::run(&root, options),
        Chore::Table1(options) => table1::run(&root, options),
        Chore::Gallery => gallery::run(&root),
        Chore::Picture => picture::run(&root),
    }
}

/// The folder of the workspace: the parent of this package's.
fn workspace_root() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().unwrap_or(package).to_path_buf()
}

/// Builds the command with the release profile and returns its path.
fn build_release(root: &Path) -> Result<PathBuf, Trouble> {
    build(root, &["--package", "graticule-cli"])?;
    Ok(target_folder(root).join("release/graticule"))
}

/// The program told, or else the one built from these sources.
fn program(root: &Path, told: Option<&Path>) -> Result<PathBuf, Trouble> {
    let path = match told {
        Some(path) => path.to_path_buf(),
        None => build_release(root)?,
    };
    // It is run in other folders.
    std::fs::canonicalize(&path).map_err(|error| Trouble::reading(&path, &error))
}

/// Builds with the release profile.
fn build(root: &Path, what: &[&str]) -> Result<(), Trouble> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args(["build", "--release"])
        .args(what)
        .current_dir(root)
        .status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Trouble(format!(
            "{} could not be built: {status}",
            what.join(" ")
        ))),
        Err(error) => Err(Trouble(format!("cargo could not be started: {error}"))),
    }
}

/// Where cargo builds.
fn target_folder(root: &Path) -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| root.join("target"), |folder| root.join(folder))
}
