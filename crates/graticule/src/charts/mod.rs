//! Layouts of charts: surfaces cut along the lines of a map into disks, most of them squares of the
//! parameter plane ([PGP06] §3.3).
//!
//! A [`ChartLayout`] holds the surface refined so that every arc is a chain of its edges, with nodes,
//! arcs and charts.
//!
//! [PGP06]: crate::papers::PGP06

mod arcs;
mod id;
mod layout;
mod layout_borders;
mod layout_corners;
mod layout_error;
#[cfg(test)]
pub(crate) mod layout_examples;
#[cfg(test)]
mod layout_tests;
mod layout_unroll;
mod nodes;

pub use id::{ArcId, ChartId};
pub use layout::{Arc, ArcKind, Chart, ChartKind, ChartLayout, Direction, EmbeddedNet};
pub use layout_error::LayoutError;
