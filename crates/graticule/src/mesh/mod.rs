//! Surfaces: from the polygon soup that a file holds to an oriented, manifold triangle mesh.
//!
//! Connectivity ([`TriangleMesh`]), geometry (positions, lengths) and data ([`PerVertex`] and its
//! kin) are separate objects: an algorithm's signature shows what it reads. [`Surface`] is
//! connectivity with positions.

mod coincidence;
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
mod repair;
mod seams;
mod soup;
mod surface;
mod surface_point;
mod topology;
mod triangle_mesh;
mod usable;

pub use defects::{Defects, Finding, Severity};
pub use element::{Element, PerComponent, PerCorner, PerEdge, PerElement, PerFace, PerVertex};
pub use error::MeshError;
pub use id::{BoundaryLoopId, ComponentId, EdgeId, FaceId, HalfedgeId, VertexId};
pub use list::ElementList;
pub use polygon::triangulate_polygon;
pub(crate) use polygon_connectivity::PolygonConnectivity;
pub use repair::{
    NonFinite, NonOrientable, RepairChanges, RepairError, RepairOptions, Repaired, Weld, repair,
};
pub use soup::{Attributes, CornerAttribute, NO_VALUE, PolygonLabels, PolygonSoup, Polygons};
pub use surface::Surface;
pub use surface_point::SurfacePoint;
pub use topology::{ComponentTopology, PerBoundaryLoop, Submesh, Topology, extract_component};
pub use triangle_mesh::TriangleMesh;
