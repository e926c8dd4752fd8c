//! Quad meshes from maps whose whole coordinates form a net ([PGP06] §5).
//!
//! [`extract_polygons`] reads the polygons off a map; [`shape()`] moves their vertices along the
//! surface; [`Carry`] gives them the attributes of the input.
//!
//! [PGP06]: crate::papers::PGP06

mod alone;
mod attributes;
mod cells;
mod complex;
mod count;
mod debris;
mod doublets;
mod edge_nodes;
mod error;
mod extents;
mod extract;
mod features;
mod finer;
mod line;
mod mend;
mod net_cells;
mod overlay;
mod partition;
mod polygon_mesh;
mod purify;
mod rectangles;
mod regular;
mod remesh;
mod roomy;
mod shape;
mod sides;
mod sizing;
mod small_components;
mod snap;
mod split;
mod triangle_cut;

pub use attributes::{Carry, InputPoint};
pub use error::QuadsError;
pub use extract::{Extraction, extract_polygons};
pub use features::FeatureReport;
pub use mend::{MendReport, mend};
pub(crate) use net_cells::NetCells;
pub(crate) use overlay::ArcKind as NetArcKind;
pub use polygon_mesh::PolygonMesh;
pub use purify::{CutReport, pure_quads, quad_dominant};
pub(crate) use remesh::all_features;
pub use remesh::{
    QuadMode, RemeshError, RemeshOptions, RemeshReport, Remeshed, remesh, remesh_levels,
};
pub use shape::{Net, ShapeError, ShapeOptions, ShapeQuality, ShapeReport, Shaped, shape};
pub use sizing::QuadSizing;

#[cfg(test)]
pub(crate) mod tests;
