//! The options of `graticule field`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use graticule::field::{FieldOptions, Symmetry};
use graticule::mesh::RepairOptions;
use serde::Serialize;

use super::output::FieldOutput;
use crate::arguments::CommonOptions;
use crate::failure::Failure;
use crate::field_arguments::FieldArguments;
use crate::outcome::Plan;
use crate::repair_options::RepairArguments;

/// Options of `graticule field`.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    /// The mesh
    #[arg(value_name = "MESH")]
    pub(super) mesh: PathBuf,
    /// Where to write the field: .json for its directions, .ply for the mesh with its directions as
    /// properties, .obj for the mesh with the field as lines; - is JSON on standard output
    #[arg(long, short, value_name = "OUT")]
    output: PathBuf,
    /// Directions at each point: 1 for vectors, 2 for lines, 4 for crosses
    #[arg(long, value_name = "1|2|4", default_value_t = 4, value_parser = parse_order)]
    symmetry: u32,
    /// Directions and strokes to follow. JSON: [{"vertex": 7, "direction": [1, 0, 0], "weight": 5},
    /// {"stroke": [[0, 0, 0], [1, 0, 0]]}, ...]; "face" instead of "vertex" is a polygon; without
    /// weight the direction is kept exactly. OBJ: its lines are strokes, kept exactly
    #[arg(long, value_name = "FILE")]
    pub(super) guide: Option<PathBuf>,
    /// Be singular here and nowhere else: a polygon of the file and its index, as 7:0.25; give it for
    /// each. The indices of a component must sum to its Euler characteristic
    #[arg(long, value_name = "POLYGON:INDEX", value_parser = parse_singularity,
        conflicts_with_all = ["singularities", "move_singularity"])]
    pub(super) singularity: Vec<(u32, f64)>,
    /// JSON file of the same: [{"polygon": 7, "index": 0.25}, ...]
    #[arg(long, value_name = "FILE.json", conflicts_with = "move_singularity")]
    pub(super) singularities: Option<PathBuf>,
    /// Bring the singularity of one polygon into another; onto one of opposite sign, both vanish
    #[arg(long, value_name = "FROM:TO", value_parser = parse_move)]
    pub(super) move_singularity: Vec<(u32, u32)>,
    /// How the picture shows the field
    #[arg(long, value_enum, default_value_t = Drawing::Streamlines)]
    pub(super) draw: Drawing,
    #[command(flatten)]
    #[serde(flatten)]
    pub(super) field: FieldArguments,
    #[command(flatten)]
    repair: RepairArguments,
}

/// How a picture shows a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Drawing {
    /// By evenly spaced lines along it
    Streamlines,
    /// By a cross, a line or a ray at some vertices
    Crosses,
}

impl Options {
    /// Checks everything that can be checked before any work.
    pub(super) fn check(&self, common: &CommonOptions) -> Result<(Plan, FieldOutput), Failure> {
        FieldOutput::plan(&self.output, common)
    }

    pub(super) fn repair_options(&self) -> RepairOptions {
        self.repair.into()
    }

    /// The library's options, without guides, edges and given singularities.
    pub(super) fn field_options(&self, seed: u64) -> FieldOptions {
        FieldOptions {
            symmetry: Symmetry::of_order(self.symmetry).unwrap_or_default(),
            ..self.field.field_options(seed)
        }
    }
}

fn parse_order(text: &str) -> Result<u32, String> {
    let order = text.parse().ok().and_then(Symmetry::of_order);
    order
        .map(Symmetry::order)
        .ok_or_else(|| "must be 1, 2 or 4".into())
}

/// Two numbers with a colon between.
fn parse_pair<A: std::str::FromStr, B: std::str::FromStr>(text: &str) -> Option<(A, B)> {
    let (first, second) = text.split_once(':')?;
    Some((first.parse().ok()?, second.parse().ok()?))
}

fn parse_singularity(text: &str) -> Result<(u32, f64), String> {
    let pair = parse_pair(text).filter(|(_, index): &(u32, f64)| index.is_finite());
    pair.ok_or_else(|| "must be the number of a polygon, a colon, and an index, as 7:0.25".into())
}

fn parse_move(text: &str) -> Result<(u32, u32), String> {
    parse_pair(text).ok_or_else(|| "must be the numbers of two polygons, as 7:12".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_range_are_refused() {
        for text in ["3", "0", "-1", "x"] {
            assert!(parse_order(text).is_err(), "{text}");
        }
        assert_eq!(parse_order("2"), Ok(2));
        assert_eq!(parse_singularity("7:-0.25"), Ok((7, -0.25)));
        assert_eq!(parse_move("7:12"), Ok((7, 12)));
        for text in ["7", "7:", ":1", "7:x", "-1:1", "7:inf"] {
            assert!(
                parse_singularity(text).is_err() && parse_move(text).is_err(),
                "{text}"
            );
        }
    }
}
