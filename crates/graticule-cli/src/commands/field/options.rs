//! The options of `graticule field`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use graticule::field::{
    CurlOptions, CurvatureOptions, FeatureOptions, FieldOptions, SmoothingOptions, Strength,
    Symmetry,
};
use graticule::mesh::RepairOptions;
use serde::Serialize;

use super::output::FieldOutput;
use crate::arguments::CommonOptions;
use crate::failure::Failure;
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
    /// Share of smoothness against following the curvature
    #[arg(long, value_name = "RHO", default_value_t = 0.8, value_parser = parse_share)]
    smoothing: f64,
    /// Directions and strokes to follow. JSON: [{"vertex": 7, "direction": [1, 0, 0], "weight": 5},
    /// {"stroke": [[0, 0, 0], [1, 0, 0]]}, ...]; "face" instead of "vertex" is a polygon; without
    /// weight the direction is kept exactly. OBJ: its lines are strokes, kept exactly
    #[arg(long, value_name = "FILE")]
    pub(super) guide: Option<PathBuf>,
    /// Angle in degrees between two triangles from which on their edge is kept; 180 for none.
    /// Lines of the mesh file are kept, too, beside its edges as strokes
    #[arg(long, value_name = "DEG", default_value_t = 60.0, value_parser = parse_degrees)]
    feature_angle: f64,
    /// How the boundary is followed
    #[arg(long, value_enum, default_value_t = Boundary::Soft)]
    boundary: Boundary,
    /// Distance, in mean edge lengths, up to which singularities of opposite sign cancel; 0 for
    /// none
    #[arg(long, value_name = "N", default_value_t = 6.0, value_parser = parse_length)]
    cancel: f64,
    /// The same in the unit of the mesh, for quads of a known size; the larger of the two counts
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, value_parser = parse_size)]
    cancel_length: f64,
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
    /// Radius, in mean edge lengths, that curvature is averaged over; 0 to follow none
    #[arg(long, value_name = "R", default_value_t = 3.0, value_parser = parse_length)]
    curvature_radius: f64,
    /// Compute the scale that takes the curl away
    #[arg(long)]
    curl_correction: bool,
    /// Largest factor, upward or downward, of that scale [default: 4]
    #[arg(long, value_name = "F", requires = "curl_correction", value_parser = parse_factor)]
    curl_range: Option<f64>,
    #[command(flatten)]
    repair: RepairArguments,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Boundary {
    /// Not at all
    Free,
    /// As far as the curvature agrees, with ten times its weight
    Soft,
    /// Exactly
    Hard,
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
        let default = FieldOptions::default();
        let radius = self.curvature_radius;
        FieldOptions {
            symmetry: Symmetry::of_order(self.symmetry).unwrap_or_default(),
            curvature: (radius > 0.0).then_some(CurvatureOptions { radius }),
            smoothing: SmoothingOptions {
                smoothing: self.smoothing,
                seed,
                ..default.smoothing
            },
            boundary: match self.boundary {
                Boundary::Free => None,
                Boundary::Soft => default.boundary,
                Boundary::Hard => Some(Strength::Hard),
            },
            features: FeatureOptions {
                dihedral: (self.feature_angle < 180.0).then(|| self.feature_angle.to_radians()),
                ..default.features
            },
            cancel_distance: self.cancel,
            cancel_length: self.cancel_length,
            curl_correction: self.curl_correction.then(|| CurlOptions {
                range: self.curl_range.or(CurlOptions::default().range),
            }),
            ..default
        }
    }
}

fn parse_order(text: &str) -> Result<u32, String> {
    let order = text.parse().ok().and_then(Symmetry::of_order);
    order
        .map(Symmetry::order)
        .ok_or_else(|| "must be 1, 2 or 4".into())
}

/// A number that `is_good`, or what it should have been.
pub(crate) fn parse_number(
    text: &str,
    is_good: impl Fn(f64) -> bool,
    wanted: &str,
) -> Result<f64, String> {
    let number = text.parse().ok();
    number
        .filter(|&number| is_good(number))
        .ok_or_else(|| format!("must be {wanted}"))
}

pub(crate) fn parse_share(text: &str) -> Result<f64, String> {
    parse_number(text, |x| (0.0..1.0).contains(&x), "from 0 to below 1")
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

pub(crate) fn parse_degrees(text: &str) -> Result<f64, String> {
    parse_number(text, |x| x > 0.0 && x <= 180.0, "above 0 and at most 180")
}

pub(crate) fn parse_length(text: &str) -> Result<f64, String> {
    parse_number(text, |x| (0.0..=1e6).contains(&x), "from 0 to 1e6")
}

fn parse_size(text: &str) -> Result<f64, String> {
    parse_number(
        text,
        |x| (0.0..=f64::MAX).contains(&x),
        "0 or above, finite",
    )
}

pub(crate) fn parse_factor(text: &str) -> Result<f64, String> {
    parse_number(text, |x| (1.0..=1e9).contains(&x), "from 1 to 1e9")
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
        for text in ["1", "-0.1", "nan", "inf", ""] {
            assert!(parse_share(text).is_err(), "{text}");
        }
        assert_eq!(parse_singularity("7:-0.25"), Ok((7, -0.25)));
        assert_eq!(parse_move("7:12"), Ok((7, 12)));
        for text in ["7", "7:", ":1", "7:x", "-1:1", "7:inf"] {
            assert!(
                parse_singularity(text).is_err() && parse_move(text).is_err(),
                "{text}"
            );
        }
        assert!(parse_degrees("0").is_err() && parse_degrees("180").is_ok());
        assert!(parse_length("-1").is_err() && parse_length("0").is_ok());
        assert!(parse_factor("0.9").is_err() && parse_factor("inf").is_err());
    }
}
