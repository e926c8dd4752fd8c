//! The options of `graticule remesh`.

use clap::Args;
use graticule::field::{FeatureOptions, FieldOptions, SmoothingOptions};
use graticule::mesh::{Fins, RepairOptions};
use graticule::periodic::GridDensity;
use graticule::quads::{QuadMode, QuadSizing, RemeshOptions, ShapeOptions};
use serde::Serialize;

use crate::arguments::CommonOptions;
use crate::commands::parameterize::sizing::{self, SizeSource};
use crate::failure::Failure;
use crate::field_arguments::parse_number;
use crate::mesh_output::MeshPaths;
use crate::outcome::Plan;
use crate::repair_options::RepairArguments;

/// How many quads, unless told.
const DEFAULT_QUADS: u32 = 5000;

/// Options of `graticule remesh`.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    #[command(flatten)]
    #[serde(flatten)]
    pub(super) paths: MeshPaths,
    /// How many quads [default: 5000]. Several numbers, as 500,5000,50000, make as many meshes of one
    /// field, written to OUT-500 and so on, before OUT's ending
    #[arg(long, value_name = "N,…", value_delimiter = ',', conflicts_with = "edge_length", value_parser = clap::value_parser!(u32).range(1..=50_000_000))]
    pub(super) quads: Vec<u32>,
    /// How long their sides, in the unit of the file
    #[arg(long, value_name = "L", value_parser = positive_length)]
    edge_length: Option<f64>,
    /// Lengths of sides by vertex, over each other: a text file of one number for each vertex of the
    /// mesh file; or `colors`, the brightness of its vertices, black for a quarter, white for four
    /// times the length
    #[arg(long, value_name = "FILE|colors", value_parser = sizing::parse_source)]
    pub(super) sizing: Option<SizeSource>,
    /// Sides up to F times shorter where the surface bends more than on the mean
    #[arg(long, value_name = "F", default_value_t = 1.0, value_parser = factor)]
    adaptive: f64,
    /// Quads up to A times as long in the direction in which the surface bends least as across it
    #[arg(long, value_name = "A", default_value_t = 1.0, value_parser = factor)]
    anisotropy: f64,
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
        if self.quads.len() < 2 {
            return Plan::with_mesh(common, Some(self.paths.output()?));
        }
        let named = self
            .quads
            .iter()
            .map(|quads| self.paths.output_named(&quads.to_string()));
        Plan::with_meshes(common, named.collect::<Result<_, Failure>>()?)
    }

    /// The densities of the meshes, in the order of their files.
    pub(super) fn densities(&self) -> Vec<GridDensity> {
        match self.edge_length {
            Some(length) => vec![GridDensity::EdgeLength(length)],
            None if self.quads.is_empty() => vec![GridDensity::Quads(DEFAULT_QUADS as usize)],
            None => {
                let numbers = self.quads.iter();
                numbers
                    .map(|&quads| GridDensity::Quads(quads as usize))
                    .collect()
            }
        }
    }

    /// Fins of less than half a quad are dropped unless told otherwise.
    pub(super) fn repair_options(&self) -> RepairOptions {
        let fins = if let Some(length) = self.edge_length {
            Fins::DropBelowArea(0.5 * length * length)
        } else {
            let finest = self.quads.iter().copied().max().unwrap_or(DEFAULT_QUADS);
            Fins::DropBelowShare(0.5 / f64::from(finest))
        };
        self.repair.with_fins(fins)
    }

    /// The library's options, without lines of the file and sizes.
    pub(super) fn remesh_options(&self, seed: u64) -> RemeshOptions {
        let field = FieldOptions::default();
        RemeshOptions {
            density: self.densities()[0],
            sizing: QuadSizing {
                sizes: None,
                adaptivity: self.adaptive,
                anisotropy: self.anisotropy,
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

fn positive_length(text: &str) -> Result<f64, String> {
    parse_number(text, |x| x > 0.0 && x.is_finite(), "above 0")
}

fn factor(text: &str) -> Result<f64, String> {
    parse_number(text, |x| (1.0..=100.0).contains(&x), "from 1 to 100")
}

fn degrees(text: &str) -> Result<f64, String> {
    parse_number(text, |x| x > 0.0 && x <= 180.0, "above 0 and at most 180")
}

fn share(text: &str) -> Result<f64, String> {
    parse_number(text, |x| (0.0..1.0).contains(&x), "from 0 to below 1")
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
        assert!(factor("0.9").is_err() && factor("1").is_ok() && factor("nan").is_err());
        assert!(share("1").is_err() && share("0").is_ok());
    }
}
