//! Quad meshes from maps whose whole coordinates form a net ([PGP06] §5).
//!
//! [PGP06]: crate::papers::PGP06

mod cells;
mod complex;
mod edge_nodes;
mod error;
mod extract;
mod line;
mod overlay;
mod polygon_mesh;
mod regular;
mod split;
mod triangle_cut;

pub use error::QuadsError;
pub use extract::{Extraction, extract_polygons};
pub use polygon_mesh::PolygonMesh;

#[cfg(test)]
mod tests;
