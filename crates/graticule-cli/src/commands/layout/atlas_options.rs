//! The options of `graticule layout` that lay its charts onto squares.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use graticule::charts::{Arrangement, ChartMapOptions, Tiles};
use serde::Serialize;

use crate::failure::Failure;
use crate::field_arguments::parse_number;

/// An atlas, geometry images, textures.
#[derive(Args, Clone, Debug, Serialize)]
pub(crate) struct AtlasArguments {
    /// Texels along the side of the texture, or of each tile
    #[arg(long, value_name = "TEXELS", default_value_t = 2048,
        value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub(super) resolution: u32,
    /// Texels between charts
    #[arg(long, value_name = "TEXELS", default_value_t = 4)]
    pub(super) padding: u32,
    /// Spread the charts over at most this many UDIM tiles
    #[arg(long, value_name = "TILES", value_parser = clap::value_parser!(u32).range(1..=999))]
    udim: Option<u32>,
    /// As many UDIM tiles as so many texels in a unit of length need
    #[arg(long, value_name = "TEXELS", value_parser = parse_density, conflicts_with = "udim")]
    texel_density: Option<f64>,
    /// Whole coordinates at every corner of a chart: a pattern that a quarter turn leaves as it is,
    /// repeated once for each spacing of lines (a quarter of a chart with an integer grid map), shows no
    /// seam
    #[arg(long, conflicts_with_all = ["udim", "texel_density", "texture", "normal_map"])]
    grid_seams: bool,
    /// Most steps to less distortion in each chart with singularities; 0 for mean value coordinates
    #[arg(long, value_name = "STEPS", default_value_t = ChartMapOptions::default().improvement_steps)]
    improve: u32,
    /// Rounds of relaxation across the borders of charts with singularities
    #[arg(long, value_name = "ROUNDS", default_value_t = 0)]
    relax: u32,
    /// An image in the mesh's own texture coordinates, and where to write it for the atlas (PNG)
    #[arg(long, num_args = 2, value_names = ["IN", "OUT"])]
    pub(super) texture: Option<Vec<PathBuf>>,
    /// The same for a map of normals in the frame of the texture coordinates
    #[arg(long, num_args = 2, value_names = ["IN", "OUT"])]
    pub(super) normal_map: Option<Vec<PathBuf>>,
    /// A folder for an image of positions and one of normals for each square
    #[arg(long, value_name = "DIR")]
    pub(super) geometry_images: Option<PathBuf>,
    /// Points along the sides of geometry images
    #[arg(long, value_name = "N", default_value_t = 33,
        value_parser = clap::value_parser!(u32).range(2..=4097))]
    pub(super) geometry_side: u32,
    /// Format of geometry images
    #[arg(long, value_enum, default_value_t = GeometryFormat::Png)]
    pub(super) geometry_format: GeometryFormat,
}

/// How geometry images are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum GeometryFormat {
    /// 16 bits, positions within the bounding box
    Png,
    /// `OpenEXR`: the positions themselves, in single precision
    Exr,
}

impl AtlasArguments {
    /// Checks all that can be checked before any work.
    pub(super) fn check(&self) -> Result<(), Failure> {
        for [from, _] in self.images() {
            if !from.is_file() {
                return Err(Failure::usage(
                    format!("there is no image {}", from.display()),
                    "name a PNG file",
                ));
            }
        }
        match &self.geometry_images {
            Some(folder) if !folder.is_dir() => Err(Failure::usage(
                format!("the folder {} does not exist", folder.display()),
                "create it first, or name another place",
            )),
            _ => Ok(()),
        }
    }

    /// The textures that will be written; with several tiles their names get numbers.
    pub(super) fn image_files(&self) -> Vec<PathBuf> {
        self.images().iter().map(|[_, to]| (*to).clone()).collect()
    }

    /// Where images come from and go to.
    fn images(&self) -> Vec<[&PathBuf; 2]> {
        let named = [&self.texture, &self.normal_map].into_iter().flatten();
        named.map(|names| [&names[0], &names[1]]).collect()
    }

    pub(super) fn map_options(&self) -> ChartMapOptions {
        ChartMapOptions {
            keep_net: self.grid_seams,
            improvement_steps: self.improve,
            relaxation_rounds: self.relax,
        }
    }

    pub(super) fn keeps_net(&self) -> bool {
        self.grid_seams
    }

    pub(super) fn arrangement(&self) -> Arrangement {
        if self.grid_seams {
            return Arrangement::Net;
        }
        Arrangement::Packed {
            resolution: self.resolution,
            padding: self.padding,
            tiles: match (self.udim, self.texel_density) {
                (_, Some(density)) => Tiles::Density(density),
                (count, None) => Tiles::AtMost(count.unwrap_or(1)),
            },
        }
    }
}

fn parse_density(text: &str) -> Result<f64, String> {
    parse_number(text, |x| x > 0.0 && x.is_finite(), "above 0, finite")
}
