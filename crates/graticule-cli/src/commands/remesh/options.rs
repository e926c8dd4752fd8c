//! The options of `graticule remesh`.

use clap::Args;
use graticule::field::{FeatureOptions, FieldOptions, SmoothingOptions};
use graticule::mesh::RepairOptions;
use graticule::periodic::GridDensity;
use graticule::quads::{QuadMode, RemeshOptions, ShapeOptions};
use serde::Serialize;

use crate::arguments::CommonOptions;
use crate::failure::Failure;
use crate::mesh_output::MeshPaths;
use crate::outcome::Plan;
use crate::repair_options::RepairArguments;

/// Options of `graticule remesh`.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    #[command(flatten)]
    #[serde(flatten)]
    pub(super) paths: MeshPaths,
    /// How many quads [default: 5000]
    #[arg(long, value_name = "N", conflicts_with = "edge_length", value_parser = clap::value_parser!(u32).range(1..=50_000_000))]
    quads: Option<u32>,
    /// How long their sides, in the unit of the file
    #[arg(long, value_name = "L", value_parser = positive_length)]
    edge_length: Option<f64>,
    /// Quads only, which is the default
    #[arg(long, conflicts_with = "dominant")]
    pure: bool,
    /// Quads, and triangles where they fit better
    #[arg(long)]
    dominant: bool,
    /// Angle in degrees between two triangles from which on their edge becomes one of the quads'; 180
    /// for none. Lines of the mesh file are kept, too
    #[arg(long, value_name = "DEG", default_value_t = 60.0, value_parser = degrees)]
    feature_angle: f64,
    /// Share of smoothness against following the curvature
    #[arg(long, value_name = "RHO", default_value_t = 0.8, value_parser = share)]
    smoothing: f64,
    /// Leave vertices where lines cross
    #[arg(long)]
    no_shaping: bool,
    #[command(flatten)]
    repair: RepairArguments,
}

impl Options {
    /// Checks everything that can be checked before any work.
    pub(super) fn check(&self, common: &CommonOptions) -> Result<Plan, Failure> {
        let output = self.paths.output()?;
        Plan::with_mesh(common, Some(output))
    }

    pub(super) fn repair_options(&self) -> RepairOptions {
        self.repair.into()
    }

    /// The library's options, without lines of the file.
    pub(super) fn remesh_options(&self, seed: u64) -> RemeshOptions {
        let field = FieldOptions::default();
        RemeshOptions {
            density: match (self.edge_length, self.quads) {
                (Some(length), _) => GridDensity::EdgeLength(length),
                (None, quads) => GridDensity::Quads(quads.unwrap_or(5000) as usize),
            },
            mode: if self.dominant {
                QuadMode::Dominant
            } else {
                QuadMode::Pure
            },
            field: FieldOptions {
                smoothing: SmoothingOptions {
                    smoothing: self.smoothing,
                    seed,
                    ..field.smoothing
                },
                features: FeatureOptions {
                    dihedral: (self.feature_angle < 180.0).then(|| self.feature_angle.to_radians()),
                    ..field.features
                },
                ..field
            },
            shape: (!self.no_shaping).then(ShapeOptions::default),
        }
    }
}

fn number(text: &str, is_good: impl Fn(f64) -> bool, wanted: &str) -> Result<f64, String> {
    let number = text.parse().ok();
    number
        .filter(|&number| is_good(number))
        .ok_or_else(|| format!("must be {wanted}"))
}

fn positive_length(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0 && x.is_finite(), "above 0")
}

fn degrees(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0 && x <= 180.0, "above 0 and at most 180")
}

fn share(text: &str) -> Result<f64, String> {
    number(text, |x| (0.0..1.0).contains(&x), "from 0 to below 1")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_range_are_refused() {
        for text in ["0", "-1", "nan", "inf", ""] {
            assert!(positive_length(text).is_err(), "{text}");
        }
        assert!(degrees("0").is_err() && degrees("180").is_ok());
        assert!(share("1").is_err() && share("0").is_ok());
    }
}
