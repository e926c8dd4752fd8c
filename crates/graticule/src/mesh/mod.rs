//! Surfaces: from the polygon soup that a file holds to an oriented, manifold triangle mesh.
//!
//! Connectivity ([`TriangleMesh`]), geometry (positions, lengths) and data ([`PerVertex`] and its
//! kin) are separate objects: an algorithm's signature shows what it reads. [`Surface`] is
//! connectivity with positions.

mod coincidence;
mod corner_table;
mod cutting;
mod defects;
pub(crate) mod disjoint_sets;
mod element;
mod error;
mod faces;
mod gluing;
mod id;
mod list;
mod measures;
mod point_tree;
mod polygon;
mod polygon_connectivity;
mod refine;
mod refined_surface;
mod repair;
mod seams;
mod sentence;
mod soup;
mod surface;
mod surface_point;
#[cfg(test)]
mod test_soups;
mod topology;
mod triangle_mesh;
mod usable;

pub use corner_table::CornerTable;
pub use cutting::{CutSurface, cut_along};
pub use defects::{Defects, Finding, Severity};
pub(crate) use disjoint_sets::{DisjointSets, number_names};
pub use element::{Element, PerComponent, PerCorner, PerEdge, PerElement, PerFace, PerVertex};
pub use error::MeshError;
pub(crate) use id::element_id;
pub use id::{BoundaryLoopId, ComponentId, EdgeId, FaceId, HalfedgeId, VertexId};
pub use list::ElementList;
pub(crate) use measures::{largest_of, length};
pub(crate) use point_tree::PointTree;
pub use polygon::{fan_apex, triangulate_polygon};
pub(crate) use polygon_connectivity::PolygonConnectivity;
pub use refine::{Refinement, refine, refined_count};
pub use refined_surface::RefinedSurface;
pub use repair::{
    Fins, NonFinite, NonOrientable, RepairChanges, RepairError, RepairOptions, Repaired, Weld,
    repair,
};
pub use soup::{Attributes, CornerAttribute, NO_VALUE, PolygonLabels, PolygonSoup, Polygons};
pub use surface::Surface;
pub use surface_point::SurfacePoint;
pub use topology::{
    ComponentTopology, Components, PerBoundaryLoop, Submesh, Topology, extract_component,
};
pub(crate) use topology::{find_components, submesh_of};
pub use triangle_mesh::TriangleMesh;
