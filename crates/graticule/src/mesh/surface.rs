use std::sync::Arc;

use glam::DVec3;

use super::{Element, FaceId, HalfedgeId, MeshError, PerVertex, TriangleMesh, VertexId};

/// A triangle mesh in space: connectivity with finite positions and an extent above zero.
///
/// The connectivity is shared, so that another embedding of the same mesh costs its positions
/// only.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    mesh: Arc<TriangleMesh>,
    positions: PerVertex<DVec3>,
}

impl Surface {
    /// Joins connectivity and positions.
    ///
    /// # Errors
    /// [`MeshError::PositionCount`], [`MeshError::NonFinitePosition`], [`MeshError::ZeroExtent`]
    /// or [`MeshError::ExtentOverflow`].
    pub fn new(
        mesh: impl Into<Arc<TriangleMesh>>,
        positions: PerVertex<DVec3>,
    ) -> Result<Self, MeshError> {
        let mesh = mesh.into();
        if positions.len() != mesh.vertex_count() {
            let (positions, vertices) = (positions.len(), mesh.vertex_count());
            return Err(MeshError::PositionCount {
                positions,
                vertices,
            });
        }
        if let Some((vertex, position)) = positions.enumerate().find(|(_, p)| !p.is_finite()) {
            let position = position.to_array();
            return Err(MeshError::NonFinitePosition { vertex, position });
        }
        check_extent(&positions)?;
        Ok(Self { mesh, positions })
    }

    /// Builds connectivity and surface from plain arrays.
    ///
    /// # Errors
    /// As [`TriangleMesh::new`] and [`Surface::new`].
    pub fn from_triangles(
        positions: Vec<DVec3>,
        triangles: &[[u32; 3]],
    ) -> Result<Self, MeshError> {
        Self::new(
            TriangleMesh::new(positions.len(), triangles)?,
            PerVertex::new(positions),
        )
    }

    /// The connectivity.
    #[must_use]
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// The connectivity, to be shared.
    #[must_use]
    pub fn shared_mesh(&self) -> Arc<TriangleMesh> {
        Arc::clone(&self.mesh)
    }

    /// The positions.
    #[must_use]
    pub fn positions(&self) -> &PerVertex<DVec3> {
        &self.positions
    }

    /// The position of a vertex.
    #[inline]
    #[must_use]
    pub fn position(&self, vertex: VertexId) -> DVec3 {
        self.positions[vertex]
    }

    /// The positions of the corners of a triangle, counter-clockwise.
    #[inline]
    #[must_use]
    pub fn corner_positions(&self, face: FaceId) -> [DVec3; 3] {
        self.mesh
            .triangle(face)
            .map(|vertex| self.positions[vertex])
    }

    /// The vector from the origin of a halfedge to its destination.
    #[inline]
    #[must_use]
    pub fn halfedge_vector(&self, halfedge: HalfedgeId) -> DVec3 {
        self.positions[self.mesh.destination(halfedge)] - self.positions[self.mesh.origin(halfedge)]
    }

    /// The corners of the smallest axis-aligned box around the surface: lowest, highest.
    #[must_use]
    pub fn bounding_box(&self) -> [DVec3; 2] {
        bounding_box(&self.positions)
    }
}

fn bounding_box(positions: &PerVertex<DVec3>) -> [DVec3; 2] {
    positions
        .iter()
        .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], &p| {
            [low.min(p), high.max(p)]
        })
}

fn check_extent(positions: &PerVertex<DVec3>) -> Result<(), MeshError> {
    let [low, high] = bounding_box(positions);
    let extent = (high - low).max_element();
    if extent == 0.0 {
        return Err(MeshError::ZeroExtent);
    }
    if !extent.is_finite() {
        let magnitude = |index: &usize| positions.as_slice()[*index].abs().max_element();
        let farthest = (0..positions.len())
            .max_by(|a, b| magnitude(a).total_cmp(&magnitude(b)))
            .unwrap_or_default();
        let vertex = VertexId::from_index(farthest);
        return Err(MeshError::ExtentOverflow {
            vertex,
            coordinate: magnitude(&farthest),
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(positions: [DVec3; 3]) -> Result<Surface, MeshError> {
        Surface::from_triangles(positions.to_vec(), &[[0, 1, 2]])
    }

    #[test]
    fn a_triangle_knows_its_box_and_sides() {
        let surface = triangle([DVec3::ZERO, DVec3::X, DVec3::new(0.0, 2.0, -1.0)]).unwrap();
        assert_eq!(
            surface.bounding_box(),
            [DVec3::new(0.0, 0.0, -1.0), DVec3::new(1.0, 2.0, 0.0)]
        );
        assert_eq!(surface.halfedge_vector(HalfedgeId(0)), DVec3::X);
    }

    #[test]
    fn positions_that_make_no_surface_are_refused() {
        let nan = triangle([DVec3::ZERO, DVec3::X, DVec3::splat(f64::NAN)]);
        assert!(matches!(
            nan,
            Err(MeshError::NonFinitePosition {
                vertex: VertexId(2),
                ..
            })
        ));
        assert_eq!(triangle([DVec3::ONE; 3]), Err(MeshError::ZeroExtent));
        let huge = triangle([DVec3::splat(-f64::MAX), DVec3::X, DVec3::splat(f64::MAX)]);
        assert!(matches!(huge, Err(MeshError::ExtentOverflow { .. })));
    }

    #[test]
    fn tiny_and_huge_extents_are_surfaces_too() {
        for scale in [1e-200, 1e150] {
            assert!(triangle([DVec3::ZERO, DVec3::X * scale, DVec3::Y * scale]).is_ok());
        }
    }
}
