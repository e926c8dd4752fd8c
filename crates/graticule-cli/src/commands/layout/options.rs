//! The options of `graticule layout`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use graticule::charts::{LayoutMap, LayoutOptions};
use graticule::mesh::RepairOptions;
use graticule::periodic::{CoarseToFineOptions, Minimizer, ParameterizeOptions};
use graticule_io::Format;
use serde::Serialize;

use super::atlas_options::AtlasArguments;
use crate::arguments::CommonOptions;
use crate::chart_arguments::ChartArguments;
use crate::failure::Failure;
use crate::field_arguments::FieldArguments;
use crate::mesh_output::{MeshOutput, MeshPaths};
use crate::outcome::Plan;
use crate::repair_options::RepairArguments;

/// Options of `graticule layout`. The mesh written is cut along the borders of the charts, each a
/// group, with all charts side by side as texture coordinates.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    #[command(flatten)]
    #[serde(flatten)]
    pub(super) paths: MeshPaths,
    #[command(flatten)]
    #[serde(flatten)]
    size: ChartArguments,
    /// The map whose lines become borders of charts
    #[arg(long, value_enum, default_value_t = Map::IntegerGrid)]
    map: Map,
    /// Write the polygon mesh of the charts (.obj, .ply, .off)
    #[arg(long, value_name = "FILE")]
    base_complex: Option<PathBuf>,
    /// Write nodes, arcs and charts, and how coordinates go over from chart to chart
    #[arg(long, value_name = "FILE.json")]
    pub(super) layout: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Atlas")]
    #[serde(flatten)]
    pub(super) atlas: AtlasArguments,
    #[command(flatten, next_help_heading = "Field")]
    field: FieldArguments,
    #[command(flatten)]
    repair: RepairArguments,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Map {
    /// An integer grid map: nearly all charts are rectangles, about three for each singularity at least
    IntegerGrid,
    /// Periodic coordinates, as published: charts beside singularities have any number of sides
    Periodic,
}

/// A further mesh that is written: where to, and in which format.
pub(super) type FurtherMesh = Option<(PathBuf, Format)>;

impl Options {
    /// Checks everything that can be checked before any work.
    pub(super) fn check(&self, common: &CommonOptions) -> Result<(Plan, FurtherMesh), Failure> {
        let output = self.paths.output()?.with_uvs()?;
        let mut plan = Plan::with_mesh(common, Some(output))?;
        self.atlas.check()?;
        for path in self.atlas.image_files() {
            plan.add_file(path)?;
        }
        let mut complex = None;
        if let Some(path) = &self.base_complex {
            let format = MeshOutput::new(path, None)?.format();
            plan.add_file(path.clone())?;
            complex = Some((path.clone(), format));
        }
        if let Some(path) = &self.layout {
            plan.add_file(path.clone())?;
        }
        Ok((plan, complex))
    }

    pub(super) fn repair_options(&self) -> RepairOptions {
        self.repair.into()
    }

    /// The library's options, without lines of the file.
    pub(super) fn layout_options(&self, seed: u64) -> LayoutOptions {
        let start = CoarseToFineOptions {
            seed,
            ..CoarseToFineOptions::default()
        };
        LayoutOptions {
            field: self.field.field_options(seed),
            coordinates: ParameterizeOptions {
                chart_size: self.size.chart_size(),
                minimizer: Minimizer::CoarseToFine(start),
                follow_boundary: !self.field.boundary_is_free(),
                ..ParameterizeOptions::default()
            },
            map: match self.map {
                Map::Periodic => LayoutMap::Periodic,
                Map::IntegerGrid => LayoutMap::IntegerGrid,
            },
        }
    }
}
