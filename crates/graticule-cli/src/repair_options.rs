//! Options of every command that repairs what it reads.

use clap::{Args, ValueEnum};
use graticule::mesh::{Fins, NonFinite, NonOrientable, RepairOptions, Weld};
use serde::Serialize;

use crate::field_arguments::parse_number;

/// How a mesh that is read becomes a surface.
#[derive(Args, Clone, Copy, Debug, Serialize)]
#[command(next_help_heading = "Repair")]
pub(crate) struct RepairArguments {
    /// Whether vertices at the same position become one
    #[arg(long, value_enum, default_value_t = WeldArgument::Auto)]
    weld: WeldArgument,
    /// Join vertices of open edges up to this far apart, in the mesh's unit of length: closes cracks
    #[arg(long, value_name = "DISTANCE", default_value_t = 0.0, allow_negative_numbers = true,
        value_parser = parse_distance)]
    weld_within: f64,
    /// What to do with polygons that have a position that is not finite
    #[arg(long, value_enum, default_value_t = NonFiniteArgument::Refuse)]
    non_finite: NonFiniteArgument,
    /// What to do with pieces that cannot be oriented
    #[arg(long, value_enum, default_value_t = NonOrientableArgument::Refuse)]
    non_orientable: NonOrientableArgument,
    /// Drop pieces of less than this share of the area that hang on a larger one by an edge with more
    /// than two faces, or by a vertex; 0 keeps all
    #[arg(long, value_name = "SHARE", value_parser = parse_share)]
    drop_fins: Option<f64>,
}

impl RepairArguments {
    /// The library's options; fins are dropped as told, or else as `fins` has it.
    pub(crate) fn with_fins(self, fins: Fins) -> RepairOptions {
        RepairOptions {
            weld: match self.weld {
                WeldArgument::Auto => Weld::Auto,
                WeldArgument::Always => Weld::Always,
                WeldArgument::Never => Weld::Never,
            },
            weld_within: self.weld_within,
            non_finite: match self.non_finite {
                NonFiniteArgument::Refuse => NonFinite::Refuse,
                NonFiniteArgument::Drop => NonFinite::DropPolygons,
            },
            non_orientable: match self.non_orientable {
                NonOrientableArgument::Refuse => NonOrientable::Refuse,
                NonOrientableArgument::Cut => NonOrientable::CutOpen,
            },
            fins: self.drop_fins.map_or(fins, Fins::DropBelowShare),
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum WeldArgument {
    /// Where that closes a seam; cuts stay open
    Auto,
    /// All of them
    Always,
    /// None
    Never,
}

#[derive(Clone, Copy, Debug, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum NonFiniteArgument {
    /// Refuse the mesh, naming the vertex
    Refuse,
    /// Drop these polygons
    Drop,
}

#[derive(Clone, Copy, Debug, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum NonOrientableArgument {
    /// Refuse the mesh, naming an edge
    Refuse,
    /// Cut them open
    Cut,
}

impl From<RepairArguments> for RepairOptions {
    fn from(arguments: RepairArguments) -> Self {
        arguments.with_fins(Fins::Keep)
    }
}

fn parse_share(text: &str) -> Result<f64, String> {
    parse_number(text, |x| (0.0..=1.0).contains(&x), "from 0 to 1")
}

fn parse_distance(text: &str) -> Result<f64, String> {
    let distance: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if distance >= 0.0 && distance.is_finite() {
        Ok(distance)
    } else {
        Err("must be finite and at least 0".into())
    }
}
