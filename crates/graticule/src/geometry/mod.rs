//! Lengths, angles, areas, weights, transport, and an intrinsic Delaunay triangulation.
//!
//! Two kinds of geometry are kept apart. What depends on distances along the surface alone takes an
//! [`IntrinsicTriangulation`], which knows no positions: weights, areas of vertices, curvature,
//! transport, gradients. What needs space takes a [`Surface`](crate::mesh::Surface): normals,
//! dihedral angles, frames.
//!
//! ```
//! use glam::DVec3;
//! use graticule::geometry::{cotangent_weights, intrinsic_delaunay};
//! use graticule::mesh::Surface;
//! use graticule::watch::Watch;
//!
//! // Two flat triangles with a common side that is too long.
//! let positions = vec![-DVec3::X, DVec3::X, DVec3::Y * 0.5, DVec3::Y * -0.5];
//! let surface = Surface::from_triangles(positions, &[[0, 1, 2], [1, 0, 3]])?;
//! let (triangulation, report) = intrinsic_delaunay(&surface, &Watch::new())?;
//! assert_eq!(report.flips, 1);
//! assert!(cotangent_weights(&triangulation)?.least() > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! *Degenerate triangles.* Whatever divides by an area gives a typed error that names the triangle,
//! never an infinite number; [`intrinsic_delaunay`] removes degenerate triangles by flips or, where
//! flips cannot, by mollified lengths.
//!
//! *Scale.* Fourth powers of lengths occur, so edges should be between 1e-70 and 1e70 long:
//! [`normalized`] brings any surface there without rounding. Otherwise scaling by a power of two
//! changes no digit of what has no unit.

mod box_tree;
mod closest_point;
mod delaunay;
mod directed_weights;
mod error;
mod flip;
mod gradient;
mod intrinsic;
mod lengths;
mod mollify;
mod normals;
mod rows;
mod similarity;
mod transport;
mod triangle;
mod vertex;
mod weights;

pub(crate) use box_tree::{Bounds, BoxTree};
pub use closest_point::TriangleTree;
pub(crate) use closest_point::{closest_on_segment, slide_towards, slide_within};
pub use delaunay::{DelaunayReport, intrinsic_delaunay};
pub use directed_weights::{
    DirectedWeights, authalic_weights, intrinsic_weights, mean_value_weights,
    uniform_directed_weights,
};
pub use error::GeometryError;
pub use gradient::{divergence, divergence_in_space, face_axes, gradients, gradients_in_space};
pub use intrinsic::IntrinsicTriangulation;
pub use lengths::EdgeLengths;
pub use mollify::{Mollification, mollify};
pub use normals::{area_vector, dihedral_angles, face_normals, vertex_normals};
pub use similarity::{Similarity, normalized};
pub use transport::{
    TangentFrame, face_curvatures, reverse_direction, transport_angles, vertex_frames,
};
pub use triangle::{
    TriangleShape, corner_angles, corner_cotangents, face_areas, face_shapes, total_area,
};
pub use vertex::{angle_defects, mixed_voronoi_areas, vertex_areas};
pub(crate) use weights::mesh_cotangent_weights;
pub use weights::{EdgeWeights, cotangent_weights, edge_cotangent_weights, uniform_weights};
