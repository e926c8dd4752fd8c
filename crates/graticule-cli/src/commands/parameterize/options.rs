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

use crate::arguments::CommonOptions;
use crate::chart_arguments::ChartArguments;
use crate::failure::Failure;
use crate::field_arguments::FieldArguments;
use crate::mesh_output::MeshOutput;
use crate::outcome::Plan;
use crate::repair_options::RepairArguments;

/// Options of `graticule parameterize`.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    /// The mesh
    #[arg(value_name = "MESH")]
    pub(super) mesh: PathBuf,
    /// Where to write the mesh with its coordinates as texture coordinates (.obj, .ply, .glb), one
    /// unit for each chart; - is standard output
    #[arg(long, short, value_name = "OUT")]
    output: PathBuf,
    /// Format of the mesh, if the name does not tell
    #[arg(long, value_name = "FORMAT")]
    format: Option<String>,
    #[command(flatten)]
    #[serde(flatten)]
    size: ChartArguments,
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
    /// Leave inverted triangles as they are
    #[arg(long)]
    no_untangle: bool,
    /// Write what is singular, and the whole numbers between triangles
    #[arg(long, value_name = "FILE.json")]
    pub(super) integers: Option<PathBuf>,
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
        let format = self.format.as_deref().map(crate::mesh_output::parse_format);
        let format = format
            .transpose()
            .map_err(|fact| Failure::usage(fact, "name one of obj, ply, glb"))?;
        let output = MeshOutput::new(&self.output, format)?.with_uvs()?;
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
            untangle: !self.no_untangle,
        }
    }
}
