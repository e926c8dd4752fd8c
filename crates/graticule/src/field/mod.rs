//! Cross fields.

mod cancel;
mod connection;
mod cross_field;
mod curl;
mod curvature;
mod disk;
mod error;
mod guidance;
mod singularity;
mod smoothing;
mod symmetry;

pub use cancel::{CancelOptions, Cancellation, Triangulations, cancel_close_pairs};
pub use cross_field::CrossField;
pub use curl::{CurlCorrection, CurlOptions, CurlReport, curl_correction};
pub use curvature::{CurvatureOptions, PrincipalCurvature, principal_curvatures};
pub use error::FieldError;
pub use guidance::{Guidance, Strength};
pub use singularity::{Singularities, Singularity, rotations};
pub use smoothing::{SmoothField, SmoothingOptions, SmoothingReport, smooth_field};
pub use symmetry::Symmetry;
