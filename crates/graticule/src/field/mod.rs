//! Cross fields.
mod connection;
mod cross_field;
mod curvature;
mod disk;
mod singularity;
mod symmetry;

pub use cross_field::CrossField;
pub use curvature::{CurvatureOptions, PrincipalCurvature, principal_curvatures};
pub use singularity::{Singularities, Singularity, rotations};
pub use symmetry::Symmetry;
