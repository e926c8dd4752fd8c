//! Quad meshes on surfaces.
//!
//! [`shape()`] moves the vertices of a quad mesh along the surface that it lies on.

pub mod shape;

pub use shape::{Net, ShapeError, ShapeOptions, ShapeReport, Shaped, shape};
