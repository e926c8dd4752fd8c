//! Surfaces: from the polygon soup that a file holds to an oriented, manifold triangle mesh.
//!
//! Connectivity ([`TriangleMesh`]), geometry (positions, lengths) and data ([`PerVertex`] and its
//! kin) are separate objects: an algorithm's signature shows what it reads. [`Surface`] is
//! connectivity with positions.

mod disjoint_sets;
mod element;
mod error;
mod faces;
mod gluing;
mod id;
mod point_tree;
mod polygon;
mod soup;
mod surface;
mod triangle_mesh;

pub use element::{Element, PerComponent, PerCorner, PerEdge, PerElement, PerFace, PerVertex};
pub use error::MeshError;
pub use id::{BoundaryLoopId, ComponentId, EdgeId, FaceId, HalfedgeId, VertexId};
pub use polygon::triangulate_polygon;
pub use soup::{Attributes, CornerAttribute, NO_VALUE, PolygonLabels, PolygonSoup, Polygons};
pub use surface::Surface;
pub use triangle_mesh::TriangleMesh;
