use super::{
    FaceId, HalfedgeId, MeshError, PerFace, PerVertex, Surface, SurfacePoint, TriangleMesh,
};

/// A surface whose triangles are cut into smaller ones, and the way back.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinedSurface {
    /// The surface with small triangles.
    pub surface: Surface,
    /// The original triangle that each triangle is a part of.
    pub face_origin: PerFace<FaceId>,
    /// Where each vertex lies on the original.
    pub vertex_origin: PerVertex<SurfacePoint>,
}

impl RefinedSurface {
    /// A surface as a refinement of itself, with every triangle whole.
    #[must_use]
    pub fn whole(surface: Surface) -> Self {
        let mesh = surface.mesh();
        let corner = |vertex| SurfacePoint::at_corner(mesh.vertex_halfedge(vertex));
        Self {
            face_origin: PerFace::from_fn(mesh.face_count(), |face: FaceId| face),
            vertex_origin: PerVertex::from_fn(mesh.vertex_count(), corner),
            surface,
        }
    }

    /// The corners of a triangle as weights of the corners of its original; `None` where the vertices
    /// do not lie on that, because `original` is another surface.
    #[must_use]
    pub fn corner_weights(&self, original: &TriangleMesh, face: FaceId) -> Option<[[f64; 3]; 3]> {
        let weights = |corner: HalfedgeId| {
            let vertex = self.surface.mesh().origin(corner);
            self.vertex_origin[vertex].weights_in(original, self.face_origin[face])
        };
        let [a, b, c] = face.halfedges().map(weights);
        Some([a?, b?, c?])
    }

    /// The same point, on the original; `None` if that is another surface.
    #[must_use]
    pub fn to_original(
        &self,
        original: &TriangleMesh,
        point: SurfacePoint,
    ) -> Option<SurfacePoint> {
        let corners = self.corner_weights(original, point.face)?;
        let weight = |corner: usize| point.interpolate(corners.map(|weights| weights[corner]));
        Some(SurfacePoint {
            face: self.face_origin[point.face],
            barycentric: [0, 1, 2].map(weight),
        })
    }

    /// The same refinement of a surface with the same triangles in other places.
    ///
    /// # Errors
    /// [`MeshError`] for positions that make no surface.
    pub fn carried_to(self, original: &Surface) -> Result<Self, MeshError> {
        let positions = self.vertex_origin.map(|point| point.position(original));
        Ok(Self {
            surface: Surface::new(self.surface.shared_mesh(), positions)?,
            ..self
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_whole_surface_leads_back_to_itself_and_moves_with_its_original() {
        let torus = graticule_fixtures::torus(2.0, 0.7, 9, 5);
        let surface = Surface::from_triangles(torus.positions, &torus.triangles).unwrap();
        let refined = RefinedSurface::whole(surface.clone());
        for halfedge in surface.mesh().halfedges() {
            let point = SurfacePoint::on_halfedge(halfedge, 0.25);
            assert_eq!(refined.to_original(surface.mesh(), point), Some(point));
        }
        let moved = surface.positions().map(|&place| place + DVec3::X);
        let moved = Surface::new(surface.shared_mesh(), moved).unwrap();
        let carried = refined.carried_to(&moved).unwrap();
        assert_eq!(carried.surface, moved);
    }

    #[test]
    fn points_of_another_surface_are_told() {
        let torus = graticule_fixtures::torus(2.0, 0.7, 9, 5);
        let surface = Surface::from_triangles(torus.positions, &torus.triangles).unwrap();
        let mut refined = RefinedSurface::whole(surface.clone());
        refined.face_origin[FaceId(0)] = FaceId(40);
        let point = SurfacePoint::at_corner(HalfedgeId(0));
        assert_eq!(refined.to_original(surface.mesh(), point), None);
    }
}
