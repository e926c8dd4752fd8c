//! Measures of maps: what a reader of a result wants to know before relying on it.
//!
//! [`measure_map`] takes any surface with texture coordinates at its corners, whoever made them.
//! Three kinds of figures are kept apart:
//!
//! - decided exactly, on the numbers given: orientation of every triangle, islands and their
//!   boundaries, folded vertices, crossing boundary edges, whether anything overlaps, and with all
//!   that whether the map is one to one ([`MapMeasure::bijective`]);
//! - computed to rounding: the distortion of each triangle ([`FaceDistortion`]) and its summary
//!   ([`Distortion`]), from singular values;
//! - estimated, with a stated resolution: the area of overlaps ([`Overlap::area_share`]).
//!
//! What a figure leaves out is always told beside it ([`FaceCounts::left_out`]).
//!
//! [`SourceTriangle`] and [`Jacobian2`] are the same formulas for single triangles, with
//! derivatives, for methods that optimise what is measured here.

mod coverage;
mod distortion;
mod error;
mod face;
mod islands;
mod jacobian;
mod map_measure;
mod overlap;
mod quads;
mod simple_border;
mod statistics;
mod uv_map;

#[cfg(test)]
mod tests;

pub use distortion::{AreaScale, Distortion, QuasiConformalError};
pub use error::MeasureError;
pub use face::{FaceDistortion, FaceState};
pub use islands::{Island, IslandLoop};
pub use jacobian::{Jacobian2, SourceTriangle};
pub use map_measure::{
    FaceCounts, IslandCounts, MapElements, MapMeasure, Overlap, Packing, measure_map,
    measure_partial_map, overlapping_faces,
};
pub(crate) use uv_map::{box_around, orientation};

pub(crate) use quads::vector_area;
pub use quads::{
    AngleDeviation, Aspect, Connections, Deviation, EdgeLengthSpread, IrregularVertex,
    LineCarrying, NormalDeviation, Planarity, PolygonCounts, QuadElements, QuadMeasure,
    QuadQuality, ReferenceMeasure, ScaledJacobian, Strips, Valences, compare_to_reference,
    measure_quads, scaled_jacobian,
};

use glam::DVec2;

use crate::mesh::{PerCorner, PerVertex, TriangleMesh};

/// The coordinates of each corner, where each vertex has one pair.
#[must_use]
pub fn corner_uvs(mesh: &TriangleMesh, uvs: &PerVertex<DVec2>) -> PerCorner<DVec2> {
    PerCorner::from_fn(mesh.halfedge_count(), |corner| uvs[mesh.origin(corner)])
}
