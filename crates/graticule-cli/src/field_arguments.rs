//! Options of commands that compute a cross field on the way.

use clap::Args;
use graticule::field::{
    CurlOptions, CurvatureOptions, FeatureOptions, FieldOptions, SmoothingOptions, Strength,
};
use serde::Serialize;

use crate::commands::field::options::{
    Boundary, parse_degrees, parse_factor, parse_length, parse_share,
};

/// How the cross field comes about that lines follow.
#[derive(Args, Clone, Copy, Debug, Serialize)]
#[command(next_help_heading = "Field")]
pub(crate) struct FieldArguments {
    /// Share of smoothness against following the curvature
    #[arg(long, value_name = "RHO", default_value_t = 0.8, value_parser = parse_share)]
    smoothing: f64,
    /// Angle in degrees between two triangles from which on field and lines follow their edge; 180
    /// for none
    #[arg(long, value_name = "DEG", default_value_t = 60.0, value_parser = parse_degrees)]
    feature_angle: f64,
    /// How the field follows the boundary
    #[arg(long, value_enum, default_value_t = Boundary::Soft)]
    boundary: Boundary,
    /// Distance, in mean edge lengths, up to which singularities of opposite sign cancel; 0 for
    /// none [default: that of 'graticule field']
    #[arg(long, value_name = "N", value_parser = parse_length)]
    cancel: Option<f64>,
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

    /// The library's options.
    pub(crate) fn field_options(&self, seed: u64) -> FieldOptions {
        let default = FieldOptions::default();
        let radius = self.curvature_radius;
        FieldOptions {
            curvature: (radius > 0.0).then_some(CurvatureOptions { radius }),
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
            cancel_distance: self.cancel.unwrap_or(default.cancel_distance),
            curl_correction: self.curl_correction.then(|| CurlOptions {
                range: self.curl_range.or(CurlOptions::default().range),
            }),
            ..default
        }
    }
}
