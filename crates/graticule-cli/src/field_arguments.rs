//! Options of commands that compute a cross field on the way.

use clap::{Args, ValueEnum};
use graticule::field::{
    CurlOptions, CurvatureOptions, FeatureOptions, FieldOptions, SmoothingOptions, Strength,
};
use serde::Serialize;

/// How a field comes about.
#[derive(Args, Clone, Copy, Debug, Serialize)]
pub(crate) struct FieldArguments {
    /// Share of smoothness against following the curvature
    #[arg(long, value_name = "RHO", default_value_t = 0.8, value_parser = parse_share)]
    smoothing: f64,
    /// Angle in degrees between two triangles from which on their edge is followed exactly; 180 for
    /// none. Lines of the mesh file are followed, too, beside its edges as strokes
    #[arg(long, value_name = "DEG", default_value_t = 60.0, value_parser = parse_degrees)]
    feature_angle: f64,
    /// How the field follows the boundary
    #[arg(long, value_enum, default_value_t = Boundary::Soft)]
    boundary: Boundary,
    /// Distance, in mean edge lengths, up to which singularities of opposite sign cancel; 0 for
    /// none
    #[arg(long, value_name = "N", default_value_t = 7.0, value_parser = parse_length)]
    cancel: f64,
    /// The same in the unit of the mesh, for quads of a known size; the larger of the two counts
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, value_parser = parse_size)]
    cancel_length: f64,
    /// Radius, in mean edge lengths, that curvature is averaged over; 0 to follow none
    #[arg(long, value_name = "R", default_value_t = 3.0, value_parser = parse_length)]
    curvature_radius: f64,
    /// Scale the field so that it has the least curl: fewer lines end, and cells differ in size
    #[arg(long)]
    curl_correction: bool,
    /// Largest factor, upward or downward, of that scale [default: 4]
    #[arg(long, value_name = "F", requires = "curl_correction", value_parser = parse_factor)]
    curl_range: Option<f64>,
}

impl FieldArguments {
    /// Whether lines and field may leave the boundary.
    pub(crate) fn boundary_is_free(&self) -> bool {
        self.boundary == Boundary::Free
    }

    /// Whether the curvature is computed.
    pub(crate) fn follows_curvature(&self) -> bool {
        self.curvature_radius > 0.0
    }

    /// The library's options, without guides, edges and given singularities.
    pub(crate) fn field_options(&self, seed: u64) -> FieldOptions {
        let default = FieldOptions::default();
        let radius = self.curvature_radius;
        FieldOptions {
            curvature: (radius > 0.0).then_some(CurvatureOptions {
                radius,
                ..CurvatureOptions::default()
            }),
            smoothing: SmoothingOptions {
                smoothing: self.smoothing,
                seed,
                ..default.smoothing
            },
            boundary: match self.boundary {
                Boundary::Free => None,
                Boundary::Soft => default.boundary,
                Boundary::Hard => Some(Strength::Hard),
            },
            features: FeatureOptions {
                dihedral: (self.feature_angle < 180.0).then(|| self.feature_angle.to_radians()),
                ..default.features
            },
            cancel_distance: self.cancel,
            cancel_length: self.cancel_length,
            curl_correction: self.curl_correction.then(|| CurlOptions {
                range: self.curl_range.or(CurlOptions::default().range),
            }),
            ..default
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Boundary {
    /// Not at all
    Free,
    /// As far as the curvature agrees, with ten times its weight
    Soft,
    /// Exactly
    Hard,
}

/// A number that `is_good`, or what it should have been.
pub(crate) fn parse_number(
    text: &str,
    is_good: impl Fn(f64) -> bool,
    wanted: &str,
) -> Result<f64, String> {
    let number = text.parse().ok();
    number
        .filter(|&number| is_good(number))
        .ok_or_else(|| format!("must be {wanted}"))
}

fn parse_share(text: &str) -> Result<f64, String> {
    parse_number(text, |x| (0.0..1.0).contains(&x), "from 0 to below 1")
}

fn parse_degrees(text: &str) -> Result<f64, String> {
    parse_number(text, |x| x > 0.0 && x <= 180.0, "above 0 and at most 180")
}

fn parse_length(text: &str) -> Result<f64, String> {
    parse_number(text, |x| (0.0..=1e6).contains(&x), "from 0 to 1e6")
}

fn parse_size(text: &str) -> Result<f64, String> {
    parse_number(
        text,
        |x| (0.0..=f64::MAX).contains(&x),
        "0 or above, finite",
    )
}

fn parse_factor(text: &str) -> Result<f64, String> {
    parse_number(text, |x| (1.0..=1e9).contains(&x), "from 1 to 1e9")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_range_are_refused() {
        for text in ["1", "-0.1", "nan", "inf", ""] {
            assert!(parse_share(text).is_err(), "{text}");
        }
        assert!(parse_degrees("0").is_err() && parse_degrees("180").is_ok());
        assert!(parse_length("-1").is_err() && parse_length("0").is_ok());
        assert!(parse_factor("0.9").is_err() && parse_factor("inf").is_err());
    }
}
