//! Direction, line and cross fields: from curvature, smoothed, held to boundaries, features and
//! guides, with their singularities and the scale that takes their curl away.
//!
//! [`cross_field()`] does it all; each of its steps is a function of its own.
//!
//! ```
//! use graticule::field::{FieldOptions, cross_field};
//! use graticule::mesh::Surface;
//! use graticule::watch::Watch;
//!
//! let torus = graticule_fixtures::torus(2.0, 0.7, 40, 16);
//! let surface = Surface::from_triangles(torus.positions, &torus.triangles)?;
//! let found = cross_field(&surface, &FieldOptions::default(), &Watch::new())?;
//! assert_eq!(found.singularities.count(), 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod angle_fit;
mod cancel;
mod connection;
mod cross_field;
mod curl;
mod curvature;
mod diffusion;
mod disk;
mod domain;
mod error;
mod face_path;
mod features;
mod graded;
mod guidance;
mod guide;
pub(crate) mod hierarchy;
mod matching;
mod mirror_order;
mod newton;
mod options;
pub(crate) mod phase_graph;
mod prescribed;
mod report;
mod singularity;
mod smoothing;
mod stage;
mod streamline;
mod stroke;
mod symmetry;
mod tangent;

pub use cancel::{CancelOptions, Cancellation};
pub use cross_field::CrossField;
pub use curl::{CurlCorrection, CurlOptions, CurlReport};
pub use curvature::{CurvatureOptions, PrincipalCurvature, principal_curvatures};
pub(crate) use diffusion::phase;
pub use domain::FieldDomain;
pub use error::FieldError;
pub use features::feature_edges;
pub use guidance::{Guidance, Strength};
pub use guide::{Guide, GuidePlace};
pub use newton::{NewtonOptions, smooth_field_by_newton};
pub use options::{FeatureOptions, FieldOptions};
pub use prescribed::{Prescription, SingularityPlan};
pub use report::{FieldReport, IndexCount};
pub use singularity::{Singularities, Singularity, rotations};
pub use smoothing::{SmoothField, SmoothingOptions, SmoothingReport, smooth_field};
pub use stage::{FieldResult, cross_field};
pub use streamline::streamlines;
pub use stroke::Stroke;
pub use symmetry::Symmetry;

#[cfg(test)]
mod tests;
