//! The options of `graticule flatten`, and which of them go together.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::DVec2;
use graticule::mesh::RepairOptions;
use graticule::tolerance::LARGEST_ASPECT;
use graticule_io::Format;
use serde::Serialize;

use crate::arguments::CommonOptions;
use crate::failure::Failure;
use crate::mesh_output::{MeshOutput, parse_format};
use crate::outcome::Plan;
use crate::repair_options::RepairArguments;

/// Options of `graticule flatten`.
#[derive(Args, Clone, Debug, Serialize)]
pub(crate) struct Options {
    /// The mesh with the patch; - is standard input
    #[arg(value_name = "MESH")]
    pub(super) mesh: PathBuf,
    /// Where to write the mesh with texture coordinates; - is standard output
    #[arg(long, short, value_name = "OUT")]
    output: PathBuf,
    /// Format to write, if OUT's ending does not tell
    #[arg(long, value_name = "FORMAT", value_parser = parse_format)]
    #[serde(skip)]
    format: Option<Format>,
    /// How to flatten
    #[arg(long, value_enum, default_value_t = Method::Natural)]
    pub(super) method: Method,
    /// Pin a vertex of natural: its number in the file from 0, and its place in the surface's
    /// unit of length (twice)
    #[arg(long, value_name = "VERTEX:U,V", value_parser = parse_pin)]
    pub(super) pin: Vec<Pin>,
    /// Take cotangents from the intrinsic Delaunay triangulation, where none is negative inside
    #[arg(long)]
    pub(super) intrinsic_delaunay: bool,
    /// Weights of fixed
    #[arg(long, value_enum)]
    pub(super) weights: Option<WeightsArgument>,
    /// Where fixed lays the outer boundary
    #[arg(long, value_enum)]
    pub(super) boundary: Option<Boundary>,
    /// Boundary vertex that comes to a corner of the square or rectangle, by its number in the
    /// file (four times)
    #[arg(long, value_name = "VERTEX", allow_negative_numbers = true)]
    pub(super) corner: Vec<u32>,
    /// Width over height of the rectangle
    #[arg(long, value_name = "RATIO", allow_negative_numbers = true)]
    pub(super) aspect: Option<f64>,
    /// What becomes of holes under fixed; filled by default
    #[arg(long, value_enum)]
    pub(super) holes: Option<HolesArgument>,
    /// Flatten only this component, numbered as 'graticule info' does
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(super) component: Option<u32>,
    /// Scale of the texture coordinates; as-made with --pin and --boundary given, else unit-square
    #[arg(long, value_enum)]
    scale: Option<Scale>,
    #[command(flatten)]
    repair: RepairArguments,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Method {
    /// Conformal, the boundary free, two vertices pinned
    Natural,
    /// Conformal, the boundary free, nothing pinned
    Spectral,
    /// The boundary on a curve, each inner vertex a weighted mean of its neighbours
    Fixed,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum WeightsArgument {
    /// Conformal; may be negative, and then flip triangles
    Cotangent,
    /// Positive, near conformal
    MeanValue,
    /// All the same
    Uniform,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Boundary {
    /// By arc length on a circle
    Circle,
    /// By arc length on a square
    Square,
    /// By arc length on a rectangle
    Rectangle,
    /// Where the mesh's own texture coordinates put it
    Given,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum HolesArgument {
    /// Closed with a cone while the map is made: triangles there cannot flip with positive weights
    Filled,
    /// Free: nothing pulls at their rims
    Natural,
    /// Where the mesh's own texture coordinates put them (with --boundary given)
    Fixed,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Scale {
    /// Moved and scaled to fill the unit square from its lower left corner, angles kept
    UnitSquare,
    /// In the surface's unit of length, where the method puts them
    AsMade,
}

/// A vertex of the file with its place in the plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Pin {
    pub(super) vertex: u32,
    pub(super) place: DVec2,
}

impl Options {
    /// Checks everything that can be checked before any work.
    pub(super) fn check(&self, common: &CommonOptions) -> Result<Plan, Failure> {
        let method = self.method.to_possible_value();
        let method = method.as_ref().map_or("", |value| value.get_name());
        for (given, option, wanted) in [
            (!self.pin.is_empty(), "--pin", Method::Natural),
            (self.weights.is_some(), "--weights", Method::Fixed),
            (self.boundary.is_some(), "--boundary", Method::Fixed),
            (self.holes.is_some(), "--holes", Method::Fixed),
            (!self.corner.is_empty(), "--corner", Method::Fixed),
            (self.aspect.is_some(), "--aspect", Method::Fixed),
        ] {
            if given && self.method != wanted {
                return Err(Failure::usage(
                    format!("{option} does not go with --method {method}"),
                    "see 'graticule flatten --help' for the options of each method",
                ));
            }
        }
        self.check_counts()?;
        self.check_combinations()?;
        self.check_values()?;
        let output = MeshOutput::new(&self.output, self.format)?.with_uvs()?;
        Plan::with_mesh(common, Some(output))
    }

    fn check_counts(&self) -> Result<(), Failure> {
        if !matches!(self.pin.len(), 0 | 2) {
            return Err(Failure::usage(
                format!("--pin was given {} times", self.pin.len()),
                "pin two vertices, or none",
            ));
        }
        if !matches!(self.corner.len(), 0 | 4) {
            return Err(Failure::usage(
                format!("--corner was given {} times", self.corner.len()),
                "name four corners, or none",
            ));
        }
        Ok(())
    }

    fn check_combinations(&self) -> Result<(), Failure> {
        let cornered = matches!(self.boundary, Some(Boundary::Square | Boundary::Rectangle));
        let clashes = [
            (
                !self.corner.is_empty() && !cornered,
                "--corner goes with --boundary square or rectangle only",
            ),
            (
                self.aspect.is_some() && self.boundary != Some(Boundary::Rectangle),
                "--aspect goes with --boundary rectangle only",
            ),
            (
                self.intrinsic_delaunay
                    && matches!(
                        self.weights,
                        Some(WeightsArgument::MeanValue | WeightsArgument::Uniform)
                    ),
                "--intrinsic-delaunay goes with cotangent weights only",
            ),
            (
                self.holes == Some(HolesArgument::Fixed) && self.boundary != Some(Boundary::Given),
                "--holes fixed goes with --boundary given only",
            ),
        ];
        match clashes.iter().find(|(clash, _)| *clash) {
            Some((_, fact)) => Err(Failure::usage(*fact, "leave one of them out")),
            None => Ok(()),
        }
    }

    fn check_values(&self) -> Result<(), Failure> {
        if let [first, second] = self.pin[..] {
            let vertex = first.vertex;
            if vertex == second.vertex {
                let fact = format!("vertex {vertex} is pinned twice");
                return Err(Failure::usage(fact, "pin two different vertices"));
            }
            if first.place == second.place {
                let fact = format!("both pins are at {},{}", first.place.x, first.place.y);
                return Err(Failure::usage(
                    fact,
                    "give them places apart from each other",
                ));
            }
        }
        let repeated = |(index, corner): (usize, &u32)| self.corner[..index].contains(corner);
        if let Some(index) = self.corner.iter().enumerate().position(repeated) {
            let fact = format!("vertex {} is named for two corners", self.corner[index]);
            return Err(Failure::usage(fact, "name four different vertices"));
        }
        match self.aspect {
            Some(aspect) if !(LARGEST_ASPECT.recip()..=LARGEST_ASPECT).contains(&aspect) => {
                Err(Failure::usage(
                    format!("a rectangle cannot be {aspect} times as wide as high"),
                    "give a width over height between 1e-6 and 1e6",
                ))
            }
            _ => Ok(()),
        }
    }

    /// The same with the defaults that depend on the method filled in.
    pub(super) fn in_force(&self) -> Self {
        let mut all = self.clone();
        all.scale = Some(self.scale());
        if self.method == Method::Fixed {
            all.weights.get_or_insert(WeightsArgument::Cotangent);
            all.boundary.get_or_insert(Boundary::Circle);
            all.holes.get_or_insert(HolesArgument::Filled);
        }
        all
    }

    pub(super) fn repair_options(&self) -> RepairOptions {
        self.repair.into()
    }

    /// Where the user gives places, they are kept unless told otherwise.
    pub(super) fn scale(&self) -> Scale {
        let has_places = !self.pin.is_empty() || self.boundary == Some(Boundary::Given);
        let default = if has_places {
            Scale::AsMade
        } else {
            Scale::UnitSquare
        };
        self.scale.unwrap_or(default)
    }
}

fn parse_pin(text: &str) -> Result<Pin, String> {
    let parse = || {
        let (vertex, place) = text.split_once(':')?;
        let (u, v) = place.split_once(',')?;
        let place = DVec2::new(u.trim().parse().ok()?, v.trim().parse().ok()?);
        let vertex = vertex.trim().parse().ok()?;
        place.is_finite().then_some(Pin { vertex, place })
    };
    parse().ok_or_else(|| "not of the form VERTEX:U,V, such as 12:0.5,1".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pins_are_a_vertex_and_two_finite_numbers() {
        let pin = parse_pin("12:-0.5,1e3").unwrap();
        assert_eq!((pin.vertex, pin.place), (12, DVec2::new(-0.5, 1000.0)));
        for text in ["12", "12:1", "x:1,2", "1:nan,0", "-1:0,0", "1:0,0,0"] {
            assert!(parse_pin(text).is_err(), "{text}");
        }
    }
}
