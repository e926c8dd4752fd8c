use glam::DVec3;
use rayon::prelude::*;

use super::Symmetry;
use super::tangent::TangentPlanes;
use crate::geometry::IntrinsicTriangulation;
use crate::mesh::{Element, PerVertex, Surface, VertexId};

/// A direction, line or cross at each vertex.
///
/// Each is held as one of its angles in the tangent plane of the vertex; see
/// [`IntrinsicTriangulation`] for where angles count from.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossField {
    symmetry: Symmetry,
    angles: PerVertex<f64>,
}

impl CrossField {
    /// A field from one of the angles at each vertex.
    #[must_use]
    pub fn from_angles(symmetry: Symmetry, angles: PerVertex<f64>) -> Self {
        Self { symmetry, angles }
    }

    /// The number of directions at each point.
    #[must_use]
    pub fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    /// One of the angles at each vertex.
    #[must_use]
    pub fn angles(&self) -> &PerVertex<f64> {
        &self.angles
    }

    /// One of the angles at a vertex.
    #[inline]
    #[must_use]
    pub fn angle(&self, vertex: VertexId) -> f64 {
        self.angles[vertex]
    }

    /// One of the directions at each vertex, as a unit vector in space at a right angle to the
    /// normal; along an edge it is the edge's. `triangulation` must have the triangles of `surface`.
    #[must_use]
    pub fn directions_in_space(
        &self,
        surface: &Surface,
        triangulation: &IntrinsicTriangulation,
    ) -> PerVertex<DVec3> {
        self.directions_through(&TangentPlanes::of(surface, triangulation))
    }

    /// The same through the tangent planes of such a triangulation.
    pub(super) fn directions_through(&self, planes: &TangentPlanes<'_>) -> PerVertex<DVec3> {
        let in_space = |number| {
            let vertex = VertexId::from_index(number);
            planes.in_space(self.symmetry, vertex, self.angles[vertex])
        };
        let vertices = (0..self.angles.len()).into_par_iter();
        PerVertex::new(vertices.map(in_space).collect())
    }
}
