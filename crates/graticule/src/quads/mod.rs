//! Quad meshes on surfaces.
//!
//! [`shape()`] moves the vertices of a quad mesh along the surface that it lies on; [`Carry`] gives it
//! the attributes of the input.

mod attributes;
mod shape;

pub use attributes::{Carry, InputPoint};
pub use shape::{Net, ShapeError, ShapeOptions, ShapeQuality, ShapeReport, Shaped, shape};
