//! The options of `graticule flatten` that lay a whole surface flat without flips.

use clap::{Args, ValueEnum};
use graticule::flatten::{
    DistortionEnergy, InjectiveOptions, Overlap, PackingOptions, SeamOptions,
};
use serde::Serialize;

use crate::failure::Failure;

/// Cutting, injective maps, packing.
#[derive(Args, Clone, Debug, Serialize)]
pub(crate) struct AtlasArguments {
    /// Flatten without any flipped triangle, the boundary free; several components side by side
    #[arg(long)]
    injective: bool,
    /// As --injective, and nothing may lie over anything else
    #[arg(long)]
    no_overlap: bool,
    /// As --injective, and cut the surface open first, so that any surface can be laid flat
    #[arg(long)]
    cut: bool,
    /// What --injective makes small
    #[arg(long, value_enum)]
    energy: Option<EnergyArgument>,
    /// Edges to cut along before anything else (may be given several times)
    #[arg(long, value_enum, value_name = "EDGES")]
    pub(super) seam: Vec<SeamArgument>,
    /// Cut along edges whose triangles turn by more than this many degrees
    #[arg(long, value_name = "DEGREES")]
    pub(super) seam_angle: Option<f64>,
    /// Most places that --cut leads the seam to for less distortion; 16 by default
    #[arg(long, value_name = "N")]
    seam_tips: Option<usize>,
    /// How much lengths may differ in scale before --cut leads the seam there; 3 by default
    #[arg(long, value_name = "FACTOR")]
    seam_factor: Option<f64>,
    /// Least distance of islands, as a share of the whole; 0.002 by default
    #[arg(long, value_name = "SHARE")]
    margin: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum EnergyArgument {
    /// Lengths change little: the symmetric Dirichlet energy
    SymmetricDirichlet,
    /// Angles change little: MIPS
    Mips,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum SeamArgument {
    /// The lines of the file (`l` in OBJ)
    Lines,
    /// The seams of the file's own texture coordinates
    Uv,
}

impl AtlasArguments {
    /// Whether the surface is to be laid flat this way.
    pub(super) fn are_asked_for(&self) -> bool {
        self.injective || self.no_overlap || self.cut
    }

    /// Checks all that can be checked before any work.
    pub(super) fn check(&self) -> Result<(), Failure> {
        let without = !self.are_asked_for();
        let clashes = [
            (
                without && self.energy.is_some(),
                "--energy goes with --injective only",
            ),
            (
                without && !self.seam.is_empty(),
                "--seam goes with --injective or --cut only",
            ),
            (
                without && self.seam_angle.is_some(),
                "--seam-angle goes with --injective or --cut only",
            ),
            (
                without && self.margin.is_some(),
                "--margin goes with --injective or --cut only",
            ),
            (
                !self.cut && self.seam_tips.is_some(),
                "--seam-tips goes with --cut only",
            ),
            (
                !self.cut && self.seam_factor.is_some(),
                "--seam-factor goes with --cut only",
            ),
        ];
        if let Some((_, fact)) = clashes.iter().find(|(clash, _)| *clash) {
            return Err(Failure::usage(
                *fact,
                "add that option, or leave this one out",
            ));
        }
        in_range("--seam-angle", self.seam_angle, 0.0..=180.0)?;
        in_range("--seam-factor", self.seam_factor, 1.0..=1e6)?;
        in_range("--margin", self.margin, 0.0..=0.1)
    }

    /// How patches are laid down.
    pub(super) fn injective(&self) -> InjectiveOptions {
        InjectiveOptions {
            energy: match self.energy {
                Some(EnergyArgument::Mips) => DistortionEnergy::Mips,
                Some(EnergyArgument::SymmetricDirichlet) | None => DistortionEnergy::default(),
            },
            overlap: if self.no_overlap {
                Overlap::Forbidden
            } else {
                Overlap::Allowed
            },
            ..InjectiveOptions::default()
        }
    }

    /// How the surface is cut, if it is.
    pub(super) fn cut(&self) -> Option<SeamOptions> {
        let default = SeamOptions::default();
        self.cut.then(|| SeamOptions {
            tips: self.seam_tips.unwrap_or(default.tips),
            length_factor: self.seam_factor.unwrap_or(default.length_factor),
        })
    }

    /// How islands are packed.
    pub(super) fn packing(&self) -> PackingOptions {
        let default = PackingOptions::default();
        PackingOptions {
            margin: self.margin.unwrap_or(default.margin),
            ..default
        }
    }
}

fn in_range(
    option: &str,
    value: Option<f64>,
    range: std::ops::RangeInclusive<f64>,
) -> Result<(), Failure> {
    match value {
        Some(value) if !range.contains(&value) => Err(Failure::usage(
            format!(
                "{option} {value} is not between {} and {}",
                range.start(),
                range.end()
            ),
            "give a number in that range",
        )),
        _ => Ok(()),
    }
}
