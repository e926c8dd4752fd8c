//! The options of `graticule parameterize`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use graticule::field::FieldOptions;
use graticule::mesh::RepairOptions;
use graticule::periodic::{
    CoarseToFineOptions, DiffusionOptions, EnergyKind, EnergyTriangles, Minimizer, NewtonOptions,
    ParameterizeOptions,
};
use serde::Serialize;

use super::sizing::{self, SizeSource, Sizing};
use crate::arguments::CommonOptions;
use crate::chart_arguments::ChartArguments;
use crate::failure::Failure;
use crate::field_arguments::{FieldArguments, parse_number};
use crate::mesh_output::MeshPaths;
use crate::outcome::Plan;
use crate::repair_options::RepairArguments;

/// Options of `graticule parameterize`.
#[allow(clippy::struct_excessive_bools, reason = "switches of a command line")]
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    #[command(flatten)]
    #[serde(flatten)]
    pub(super) paths: MeshPaths,
    #[command(flatten)]
    #[serde(flatten)]
    size: ChartArguments,
    /// Smaller charts where the surface bends by more than this angle, in degrees, over the side of a
    /// chart; down to a quarter of the size
    #[arg(long, value_name = "DEG", value_parser = parse_angle)]
    chart_angle: Option<f64>,
    /// Sizes of charts by vertex: a text file of one number for each vertex of the mesh file, 1 where
    /// charts have the size asked for; or `colors`, the brightness of its vertices, black for a
    /// quarter, white for four times the size
    #[arg(long, value_name = "FILE|colors", value_parser = sizing::parse_source)]
    sizing: Option<SizeSource>,
    /// What is minimised
    #[arg(long, value_enum, default_value_t = Energy::Triangle)]
    energy: Energy,
    /// How it is minimised
    #[arg(long, value_enum, default_value_t = Method::CoarseToFine)]
    method: Method,
    /// Sum the energy over the triangles of the mesh itself instead of an intrinsic Delaunay
    /// triangulation
    #[arg(long)]
    own_triangles: bool,
    /// Leave the coordinates as their sines and cosines come out
    #[arg(long)]
    no_refine: bool,
    /// Times that the field gives way to the map after that: less shear, lines that follow the field
    /// less exactly
    #[arg(long, value_name = "N", default_value_t = 4, conflicts_with = "no_refine",
        value_parser = clap::value_parser!(u32).range(..=1000))]
    relaxations: u32,
    /// Leave inverted triangles as they are
    #[arg(long)]
    no_untangle: bool,
    /// Times that charts are halved about triangles that stay inverted
    #[arg(long, value_name = "N", default_value_t = 4, conflicts_with = "no_untangle",
        value_parser = clap::value_parser!(u32).range(..=20))]
    halvings: u32,
    /// Write what is singular, and the whole numbers between triangles
    #[arg(long, value_name = "FILE.json")]
    pub(super) integers: Option<PathBuf>,
    /// Draw the norms of the periodic variables and their energy beside the lines: small and high where
    /// something is singular
    #[arg(long, requires = "picture")]
    pub(super) draw_norms: bool,
    #[command(flatten, next_help_heading = "Field")]
    field: FieldArguments,
    #[command(flatten)]
    repair: RepairArguments,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Energy {
    /// Integrated over the triangles: the meshing has no influence
    Triangle,
    /// Summed over the edges, each with the same weight
    Edge,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Method {
    /// From coarse to fine
    CoarseToFine,
    /// The same, then diffusion and normalisation in turn
    Diffusion,
    /// The linear solution, then Newton's method, as published
    Newton,
}

impl Options {
    /// Checks everything that can be checked before any work.
    pub(super) fn check(&self, common: &CommonOptions) -> Result<Plan, Failure> {
        if self.chart_angle.is_some() && !self.field.follows_curvature() {
            return Err(Failure::usage(
                "--chart-angle needs the curvature, which --curvature-radius 0 leaves out",
                "give a radius above 0",
            ));
        }
        let output = self.paths.output()?.with_uvs()?;
        let mut plan = Plan::with_mesh(common, Some(output))?;
        if let Some(path) = &self.integers {
            plan.add_file(path.clone())?;
        }
        Ok(plan)
    }

    pub(super) fn repair_options(&self) -> RepairOptions {
        self.repair.into()
    }

    pub(super) fn field_options(&self, seed: u64) -> FieldOptions {
        self.field.field_options(seed)
    }

    pub(super) fn sizing(&self) -> Sizing<'_> {
        Sizing {
            chart_size: self.size.chart_size(),
            angle: self.chart_angle,
            source: self.sizing.as_ref(),
        }
    }

    /// The library's options, without features.
    pub(super) fn parameterize_options(&self, seed: u64) -> ParameterizeOptions {
        let start = CoarseToFineOptions {
            seed,
            ..CoarseToFineOptions::default()
        };
        let diffusion = DiffusionOptions::default();
        ParameterizeOptions {
            chart_size: self.size.chart_size(),
            energy: match self.energy {
                Energy::Triangle => EnergyKind::Triangle,
                Energy::Edge => EnergyKind::Edge,
            },
            triangles: if self.own_triangles {
                EnergyTriangles::Own
            } else {
                EnergyTriangles::Delaunay
            },
            minimizer: match self.method {
                Method::CoarseToFine => Minimizer::CoarseToFine(start),
                Method::Diffusion => Minimizer::DiffuseAndNormalise(DiffusionOptions {
                    start: CoarseToFineOptions {
                        seed,
                        ..diffusion.start
                    },
                    ..diffusion
                }),
                Method::Newton => Minimizer::Newton(NewtonOptions {
                    seed,
                    ..NewtonOptions::default()
                }),
            },
            features: Vec::new(),
            follow_boundary: !self.field.boundary_is_free(),
            refine: !self.no_refine,
            relaxations: self.relaxations as usize,
            untangle: !self.no_untangle,
            halvings: if self.no_untangle {
                0
            } else {
                self.halvings as usize
            },
        }
    }
}

fn parse_angle(text: &str) -> Result<f64, String> {
    parse_number(text, |x| x > 0.0 && x <= 360.0, "above 0 and at most 360")
}
