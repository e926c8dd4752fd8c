//! The triangles on which a flattening is computed: the patch, perhaps with its holes closed.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use std::sync::Arc;

use faer::c64;
use glam::DVec3;

use crate::geometry::{
    EdgeWeights, GeometryError, IntrinsicTriangulation, TriangleShape, cotangent_weights,
    mesh_cotangent_weights,
};
use crate::mesh::{BoundaryLoopId, CornerTable, Element, PerFace, TriangleMesh, VertexId};
use crate::watch::Watch;

use super::conformal::Triangulation;
use super::energy::point;
use super::{FlattenError, FlipCount, MapEnergy, Patch};

/// Connectivity and shapes in unit lengths. The first vertices are the patch's.
#[derive(Debug)]
pub(super) struct Domain {
    /// Before any edge is flipped; its first triangles are the patch's.
    pub(super) mesh: Arc<TriangleMesh>,
    triangles: Triangles,
    /// A place in space for each vertex, for orderings only.
    pub(super) coordinates: Vec<DVec3>,
}

#[derive(Debug)]
enum Triangles {
    /// Those of the mesh, with these shapes.
    OfMesh(PerFace<TriangleShape>),
    /// Those that edge flips have made.
    Flipped(Box<IntrinsicTriangulation>),
}

impl Domain {
    /// The patch as it is.
    pub(super) fn of(patch: &Patch) -> Self {
        Self {
            mesh: patch.surface().shared_mesh(),
            triangles: Triangles::OfMesh(patch.shapes().clone()),
            coordinates: patch.unit_surface().positions().as_slice().to_vec(),
        }
    }

    /// The patch with a cone over each of these holes: one more vertex, joined to the hole's
    /// vertices by edges of one length, chosen so that the cone over a circle is flat.
    pub(super) fn with_cones(
        patch: &Patch,
        holes: &[BoundaryLoopId],
    ) -> Result<Self, FlattenError> {
        if holes.is_empty() {
            return Ok(Self::of(patch));
        }
        let mesh = patch.mesh();
        let faces = mesh.faces().map(|face| mesh.triangle(face).map(|v| v.0));
        let mut triangles: Vec<_> = faces.collect();
        let mut shapes = patch.shapes().as_slice().to_vec();
        let mut coordinates = patch.unit_surface().positions().as_slice().to_vec();
        for &hole in holes {
            let tip = coordinates.len() as u32;
            let base = mesh.boundary_loop(hole).iter();
            triangles
                .extend(base.map(|&side| [mesh.destination(side).0, mesh.origin(side).0, tip]));
            shapes.extend(cone_shapes(patch, hole));
            coordinates.push(middle(patch, hole));
        }
        let mesh = Arc::new(TriangleMesh::new(coordinates.len(), &triangles)?);
        Ok(Self {
            triangles: Triangles::OfMesh(PerFace::new(shapes)),
            mesh,
            coordinates,
        })
    }

    /// The patch as conformal maps with a free boundary see it: every triangle has an area.
    pub(super) fn conformal(
        patch: &Patch,
        triangulation: Triangulation,
        watch: &Watch,
    ) -> Result<Self, FlattenError> {
        let mut domain = Self::of(patch);
        match triangulation {
            Triangulation::Given => domain.mollify(watch),
            Triangulation::IntrinsicDelaunay => domain.make_delaunay(watch)?,
        }
        Ok(domain)
    }

    /// The cotangent weights of the domain's triangles.
    pub(super) fn cotangent_weights(&self) -> Result<EdgeWeights, GeometryError> {
        match &self.triangles {
            Triangles::OfMesh(shapes) => mesh_cotangent_weights(&self.mesh, shapes),
            Triangles::Flipped(triangulation) => cotangent_weights(triangulation),
        }
    }

    /// The domain's triangles as a triangulation of its own.
    pub(super) fn triangulation(&self) -> IntrinsicTriangulation {
        match &self.triangles {
            Triangles::OfMesh(shapes) => {
                IntrinsicTriangulation::from_shapes(&self.mesh, shapes.clone())
            }
            Triangles::Flipped(triangulation) => (**triangulation).clone(),
        }
    }

    /// Flips of the map among the domain's triangles, if they are not the patch's.
    pub(super) fn intrinsic_flips(&self, positions: &[c64]) -> Option<FlipCount> {
        let Triangles::Flipped(triangulation) = &self.triangles else {
            return None;
        };
        let place = |vertex: VertexId| point(positions[vertex.index()]);
        let corners = |face| triangulation.triangle(face).map(place);
        Some(FlipCount::of_triangles(triangulation.faces().map(corners)))
    }

    /// Energies of the map on the domain's triangles.
    pub(super) fn energy(&self, positions: &[c64]) -> MapEnergy {
        let place = |vertex: VertexId| positions[vertex.index()];
        let triangles = self.triangles();
        MapEnergy::of_triangles(triangles.map(|(shape, corners)| (shape, corners.map(place))))
    }

    /// The domain's triangles: shape and corners.
    pub(super) fn triangles(&self) -> impl Iterator<Item = (&TriangleShape, [VertexId; 3])> {
        let table: &CornerTable = match &self.triangles {
            Triangles::OfMesh(_) => &self.mesh,
            Triangles::Flipped(triangulation) => triangulation,
        };
        let shapes = self.shapes().enumerate();
        shapes.map(|(face, shape)| (shape, table.triangle(face)))
    }

    fn shapes(&self) -> &PerFace<TriangleShape> {
        match &self.triangles {
            Triangles::OfMesh(shapes) => shapes,
            Triangles::Flipped(triangulation) => triangulation.shapes(),
        }
    }

    /// Lengthens all edges a little if a triangle is degenerate, so that every triangle has an
    /// area; a warning says so.
    pub(super) fn mollify(&mut self, watch: &Watch) {
        if !self.shapes().iter().any(TriangleShape::is_degenerate) {
            return;
        }
        let mut triangulation = self.triangulation();
        let change = triangulation.mollify();
        self.triangles = Triangles::OfMesh(triangulation.shapes().clone());
        let message = format!(
            "{} triangles are degenerate: all edges are taken to be longer, by {:e} of the mean \
             edge length",
            change.faces,
            change.largest_shift / triangulation.mean_edge_length()
        );
        watch.warn("mollified", message);
    }

    /// Flips edges until no inner one has a negative cotangent weight; the vertices stay.
    pub(super) fn make_delaunay(&mut self, watch: &Watch) -> Result<(), GeometryError> {
        let mut triangulation = self.triangulation();
        triangulation.make_delaunay(watch)?;
        self.triangles = Triangles::Flipped(Box::new(triangulation));
        Ok(())
    }
}

/// The triangles between each edge of a hole and the tip of its cone: destination, origin, tip.
fn cone_shapes(patch: &Patch, hole: BoundaryLoopId) -> impl Iterator<Item = TriangleShape> {
    let steps: Vec<f64> = patch.unit_steps(hole).collect();
    let longest = steps.iter().copied().fold(0.0, f64::max);
    // No angle at the tip is above a right one, so that the triangles exist.
    let spoke = (steps.iter().sum::<f64>() / TAU).max(longest * FRAC_1_SQRT_2);
    let spoke = if spoke > 0.0 { spoke } else { 1.0 };
    let shape = move |step| TriangleShape::from_lengths([step, spoke, spoke]);
    steps.into_iter().filter_map(shape)
}

fn middle(patch: &Patch, hole: BoundaryLoopId) -> DVec3 {
    let positions = patch.unit_surface().positions();
    let sum: DVec3 = patch
        .loop_vertices(hole)
        .map(|vertex| positions[vertex])
        .sum();
    sum / patch.mesh().boundary_loop(hole).len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{HalfedgeId, Surface};
    use graticule_fixtures::annulus;

    fn closed_ring() -> (Patch, Domain) {
        let ring = annulus(0.5, 1.0, 24, 2);
        let surface = Surface::from_triangles(ring.positions, &ring.triangles).unwrap();
        let patch = Patch::new(surface, &Watch::new()).unwrap();
        let holes: Vec<_> = patch.holes().collect();
        let domain = Domain::with_cones(&patch, &holes).unwrap();
        (patch, domain)
    }

    #[test]
    fn a_closed_circular_hole_is_flat() {
        let (patch, domain) = closed_ring();
        assert_eq!(domain.mesh.boundary_loop_count(), 1);
        assert_eq!(domain.mesh.vertex_count(), patch.mesh().vertex_count() + 1);
        let shapes = domain.shapes().as_slice();
        let cone = &shapes[patch.mesh().face_count()..];
        let tip_angles: f64 = cone.iter().map(|shape| shape.angle(2)).sum();
        assert!((tip_angles - TAU).abs() < 0.03);
        assert!(domain.coordinates.last().unwrap().length() < 1e-12);
    }

    #[test]
    fn every_cone_triangle_has_the_length_of_the_edge_it_stands_on() {
        let (_, domain) = closed_ring();
        for edge in domain.mesh.edges() {
            let side = domain.mesh.edge_halfedge(edge);
            let length = |h: HalfedgeId| domain.shapes()[h.face()].length(h.side());
            if let Some(twin) = domain.mesh.twin(side) {
                assert!((length(side) - length(twin)).abs() < 1e-15);
            }
        }
    }
}
