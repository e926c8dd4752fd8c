//! The options of `graticule flatten`, and which of them go together.

use clap::{Args, ValueEnum};
use graticule::flatten::{FlattenError, Mix};
use graticule::mesh::RepairOptions;
use graticule::tolerance::LARGEST_ASPECT;
use serde::Serialize;

use super::atlas_options::AtlasArguments;
use super::told::{Line, Pin, Place, Told, parse_line, parse_pin, parse_place, parse_told};
use crate::arguments::CommonOptions;
use crate::failure::Failure;
use crate::mesh_output::MeshPaths;
use crate::outcome::Plan;
use crate::repair_options::RepairArguments;

/// Options of `graticule flatten`.
#[derive(Args, Clone, Debug, Serialize)]
pub(crate) struct Options {
    #[command(flatten)]
    #[serde(flatten)]
    pub(super) paths: MeshPaths,
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
    /// Weights of fixed and boundary-optimal
    #[arg(long, value_enum)]
    pub(super) weights: Option<WeightsArgument>,
    /// Factor of the conformal energy in a mix of it with the authalic one, instead of --weights
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    pub(super) lambda: Option<f64>,
    /// Factor of the authalic energy in the mix
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    pub(super) mu: Option<f64>,
    /// What optimal and boundary-optimal make least; edge-length by default
    #[arg(long, value_enum)]
    pub(super) functional: Option<FunctionalArgument>,
    /// The most steps that boundary-optimal takes; 200 by default
    #[arg(long, value_name = "N")]
    pub(super) steps: Option<usize>,
    /// Lay a point at a place, under natural or fixed: a vertex by its number in the file, or a
    /// mean of the corners of a triangle, such as 4*0.2+9*0.5+7*0.3 (any number of times)
    #[arg(long, value_name = "POINT:U,V", value_parser = parse_place)]
    pub(super) constraint: Vec<Place>,
    /// Lay the line between two points straight between two places, under natural or fixed
    #[arg(long, value_name = "POINT:POINT:U,V:U,V", value_parser = parse_line)]
    pub(super) line: Vec<Line>,
    /// Keep constraints by springs of this weight rather than exactly
    #[arg(long, value_name = "WEIGHT")]
    pub(super) soft: Option<f64>,
    /// Multiply boundary lengths at a vertex by a factor, under target
    #[arg(long, value_name = "VERTEX:FACTOR", value_parser = parse_told)]
    pub(super) target_scale: Vec<Told>,
    /// Turn the boundary left by so many degrees at a vertex, under target; the others share the
    /// rest of a full turn
    #[arg(long, value_name = "VERTEX:DEGREES", value_parser = parse_told,
        allow_hyphen_values = true)]
    pub(super) target_angle: Vec<Told>,
    /// Keep a cone of so many degrees around a vertex inside, under target: the surface is cut
    /// open to it
    #[arg(long, value_name = "VERTEX:DEGREES", value_parser = parse_told)]
    pub(super) cone: Vec<Told>,
    /// How the interior follows the boundary under target
    #[arg(long, value_enum)]
    pub(super) extension: Option<ExtensionArgument>,
    /// Where fixed and optimal lay the outer boundary, and where boundary-optimal begins
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
    /// Scale of the texture coordinates; as-made with --pin, --constraint, --line and --boundary
    /// given, else unit-square
    #[arg(long, value_enum)]
    scale: Option<Scale>,
    #[command(flatten)]
    pub(super) atlas: AtlasArguments,
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
    /// The best combination of the conformal and the authalic map with the boundary on a curve
    Optimal,
    /// The boundary moved until a measure of distortion is least
    BoundaryOptimal,
    /// Conformal, with boundary lengths or turning angles as told, and cones
    Target,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum FunctionalArgument {
    /// Mean over the edges of (squared length ratio − 1)²
    EdgeLength,
    /// Mean over the triangles of (area ratio − 1)²
    Area,
    /// Squared L² stretch
    Stretch,
    /// Symmetric Dirichlet energy
    SymmetricDirichlet,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ExtensionArgument {
    /// Both coordinates harmonic: the boundary is exact
    Harmonic,
    /// One coordinate harmonic, the other conjugate to it: angles are kept better
    Conjugate,
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
    /// Keeping areas of neighbourhoods as best they can; may flip triangles
    Authalic,
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
    /// Where the natural map has it (boundary-optimal)
    Natural,
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

impl Options {
    /// Checks everything that can be checked before any work.
    pub(super) fn check(&self, common: &CommonOptions) -> Result<Plan, Failure> {
        let method = self.method.to_possible_value();
        let method = method.as_ref().map_or("", |value| value.get_name());
        let on_curve = [Method::Fixed, Method::Optimal, Method::BoundaryOptimal];
        let weighted = [Method::Fixed, Method::BoundaryOptimal];
        let measured = [Method::Optimal, Method::BoundaryOptimal];
        let constrained = [Method::Fixed, Method::Natural];
        let has_constraints = !(self.constraint.is_empty() && self.line.is_empty());
        for (given, option, methods) in [
            (!self.pin.is_empty(), "--pin", &[Method::Natural][..]),
            (self.weights.is_some(), "--weights", &weighted),
            (self.lambda.is_some(), "--lambda", &weighted),
            (self.mu.is_some(), "--mu", &weighted),
            (self.functional.is_some(), "--functional", &measured),
            (self.steps.is_some(), "--steps", &[Method::BoundaryOptimal]),
            (has_constraints, "--constraint or --line", &constrained),
            (
                !self.target_scale.is_empty(),
                "--target-scale",
                &[Method::Target],
            ),
            (
                !self.target_angle.is_empty(),
                "--target-angle",
                &[Method::Target],
            ),
            (!self.cone.is_empty(), "--cone", &[Method::Target]),
            (self.extension.is_some(), "--extension", &[Method::Target]),
            (self.boundary.is_some(), "--boundary", &on_curve),
            (self.holes.is_some(), "--holes", &on_curve),
            (!self.corner.is_empty(), "--corner", &on_curve),
            (self.aspect.is_some(), "--aspect", &on_curve),
        ] {
            if given && !methods.contains(&self.method) {
                return Err(Failure::usage(
                    format!("{option} does not go with --method {method}"),
                    "see 'graticule flatten --help' for the options of each method",
                ));
            }
        }
        self.check_numbers()?;
        self.atlas.check()?;
        if self.atlas.are_asked_for() && self.method != Method::Natural {
            return Err(Failure::usage(
                format!("--method {method} does not go with --injective, --no-overlap and --cut"),
                "leave one of them out: a map without flips has a method of its own",
            ));
        }
        self.check_counts()?;
        self.check_combinations()?;
        self.check_values()?;
        let output = self.paths.output()?.with_uvs()?;
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

    fn check_numbers(&self) -> Result<(), Failure> {
        if let Some(weight) = self.soft
            && !(weight > 0.0 && weight.is_finite())
        {
            return Err(Failure::usage(
                format!("--soft was given the weight {weight}"),
                "give a weight above 0; 1 is that of a vertex in the equations",
            ));
        }
        if self.lambda.is_some() || self.mu.is_some() {
            self.mix().map_err(|error| {
                Failure::usage(error.to_string(), "give finite numbers, one of them not 0")
            })?;
        }
        Ok(())
    }

    /// The mix of both intrinsic energies; a factor that is not given is 0.
    pub(super) fn mix(&self) -> Result<Mix, FlattenError> {
        Mix::new(self.lambda.unwrap_or(0.0), self.mu.unwrap_or(0.0))
    }

    fn check_combinations(&self) -> Result<(), Failure> {
        let cornered = matches!(self.boundary, Some(Boundary::Square | Boundary::Rectangle));
        let mixed = self.lambda.is_some() || self.mu.is_some();
        let has_constraints = !(self.constraint.is_empty() && self.line.is_empty());
        let clashes = [
            (
                mixed && self.weights.is_some(),
                "--weights does not go with --lambda and --mu",
            ),
            (
                self.soft.is_some() && !has_constraints,
                "--soft goes with --constraint and --line only",
            ),
            (
                !self.pin.is_empty() && has_constraints,
                "--pin does not go with --constraint and --line, which pin points themselves",
            ),
            (
                !self.target_scale.is_empty() && !self.target_angle.is_empty(),
                "--target-scale does not go with --target-angle",
            ),
            (
                self.boundary == Some(Boundary::Natural) && self.method != Method::BoundaryOptimal,
                "--boundary natural goes with --method boundary-optimal only",
            ),
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
                    && (mixed
                        || self.method == Method::Optimal
                        || self
                            .weights
                            .is_some_and(|w| w != WeightsArgument::Cotangent)),
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
        let has_places = !self.pin.is_empty()
            || !self.constraint.is_empty()
            || !self.line.is_empty()
            || self.boundary == Some(Boundary::Given);
        let default = if has_places {
            Scale::AsMade
        } else {
            Scale::UnitSquare
        };
        self.scale.unwrap_or(default)
    }
}
