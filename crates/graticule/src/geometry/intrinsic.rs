use std::f64::consts::TAU;

use crate::mesh::{
    EdgeId, Element, FaceId, HalfedgeId, PerCorner, PerFace, PerVertex, Surface, TriangleMesh,
    VertexId,
};

use super::triangle::{TriangleShape, corner_angles, face_shapes};
use super::{EdgeLengths, GeometryError};

pub(super) const NONE: u32 = u32::MAX;

/// A triangulation of a surface by its own shortest lines: connectivity, the shape of each
/// triangle, and the direction of each halfedge at its vertex; nothing about space.
///
/// The vertices are those of the mesh it was made from, so that whatever is computed per vertex
/// holds for the mesh. Triangles and edges keep their number but not their place once edges are
/// flipped. Then an edge may join a vertex to itself, two edges may have the same ends, and two
/// sides of a triangle may be the same edge; the numbering `3f + k` of halfedges (see
/// [`HalfedgeId`]) and the meaning of each method are those of [`TriangleMesh`].
///
/// *Directions.* The tangent plane of a vertex is its neighbourhood with the total angle Θ scaled
/// to 2π inside the surface; at the boundary angles stay as they are. The direction of a halfedge
/// is its angle there, counter-clockwise from the halfedge that was
/// [`TriangleMesh::vertex_halfedge`] at the start. Flips leave the tangent planes alone, so that
/// vectors given in them mean the same before and after
/// (N. Sharp, Y. Soliman, K. Crane, *Navigating Intrinsic Triangulations*, 2019).
///
/// Memory: about 130 bytes for each triangle.
#[derive(Clone, Debug, PartialEq)]
pub struct IntrinsicTriangulation {
    pub(super) origins: Vec<VertexId>,
    pub(super) twins: Vec<u32>,
    pub(super) halfedge_edges: Vec<EdgeId>,
    pub(super) edge_halfedges: Vec<HalfedgeId>,
    pub(super) vertex_halfedges: Vec<HalfedgeId>,
    pub(super) shapes: PerFace<TriangleShape>,
    pub(super) directions: PerCorner<f64>,
    angle_sums: PerVertex<f64>,
}

impl IntrinsicTriangulation {
    /// The triangles of the surface as they are. Degenerate ones are allowed; what divides by
    /// their area will name them.
    ///
    /// Cost: linear; shapes and angles in parallel.
    ///
    /// # Errors
    /// [`GeometryError::Scale`] if the longest edge is outside 1e-70 to 1e70.
    pub fn of(surface: &Surface) -> Result<Self, GeometryError> {
        check_scale(&EdgeLengths::of(surface))?;
        Ok(Self::assemble(surface.mesh(), face_shapes(surface)))
    }

    /// Triangles with the connectivity of a mesh and lengths of their own.
    ///
    /// # Errors
    /// [`GeometryError::TriangleInequality`] (see [`mollify`](super::mollify())), or
    /// [`GeometryError::Scale`].
    pub fn from_lengths(mesh: &TriangleMesh, lengths: &EdgeLengths) -> Result<Self, GeometryError> {
        check_scale(lengths)?;
        let mut shapes = Vec::with_capacity(mesh.face_count());
        for face in mesh.faces() {
            let sides = face
                .halfedges()
                .map(|halfedge| lengths[mesh.edge(halfedge)]);
            let broken = GeometryError::TriangleInequality {
                face,
                lengths: sides,
            };
            shapes.push(TriangleShape::from_lengths(sides).ok_or(broken)?);
        }
        Ok(Self::assemble(mesh, PerFace::new(shapes)))
    }

    /// Triangles with the connectivity of a mesh and the given shapes, which the caller vouches for:
    /// one for each triangle, equal in the lengths of common edges, of about unit size.
    pub(crate) fn from_shapes(mesh: &TriangleMesh, shapes: PerFace<TriangleShape>) -> Self {
        Self::assemble(mesh, shapes)
    }

    fn assemble(mesh: &TriangleMesh, shapes: PerFace<TriangleShape>) -> Self {
        let twin = |halfedge| mesh.twin(halfedge).map_or(NONE, |twin| twin.0);
        let mut triangulation = Self {
            origins: mesh.halfedges().map(|h| mesh.origin(h)).collect(),
            twins: mesh.halfedges().map(twin).collect(),
            halfedge_edges: mesh.halfedges().map(|h| mesh.edge(h)).collect(),
            edge_halfedges: mesh.edges().map(|e| mesh.edge_halfedge(e)).collect(),
            vertex_halfedges: mesh.vertices().map(|v| mesh.vertex_halfedge(v)).collect(),
            shapes,
            directions: PerCorner::filled(mesh.halfedge_count(), 0.0),
            angle_sums: PerVertex::filled(mesh.vertex_count(), 0.0),
        };
        triangulation.lay_out_directions();
        triangulation
    }

    /// Takes new shapes for the same triangles; each vertex keeps the direction of its
    /// [`vertex_halfedge`](Self::vertex_halfedge).
    pub(super) fn replace_shapes(&mut self, shapes: PerFace<TriangleShape>) {
        self.shapes = shapes;
        self.lay_out_directions();
    }

    fn lay_out_directions(&mut self) {
        let angles = corner_angles(&self.shapes);
        let mut sums = PerVertex::filled(self.vertex_count(), 0.0);
        for (&origin, &angle) in self.origins.iter().zip(&angles) {
            sums[origin] += angle;
        }
        self.angle_sums = sums;
        for vertex in self.vertices() {
            let scale = self.angle_scale(vertex);
            let first = self.vertex_halfedge(vertex);
            let mut direction = self.directions[first];
            let mut halfedge = first;
            loop {
                self.directions[halfedge] = wrapped(direction);
                direction += scale * angles[halfedge];
                match self.turn_left(halfedge) {
                    Some(left) if left != first => halfedge = left,
                    _ => break,
                }
            }
        }
    }

    /// The number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.vertex_halfedges.len()
    }

    /// The number of edges.
    #[must_use]
    pub fn edge_count(&self) -> usize {
        self.edge_halfedges.len()
    }

    /// The number of triangles.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.shapes.len()
    }

    /// The number of halfedges, which is that of corners: three for each triangle.
    #[must_use]
    pub fn halfedge_count(&self) -> usize {
        self.origins.len()
    }

    /// All vertices in order.
    #[must_use]
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = VertexId> + Clone + use<> {
        (0..self.vertex_count()).map(VertexId::from_index)
    }

    /// All edges in order.
    #[must_use]
    pub fn edges(&self) -> impl ExactSizeIterator<Item = EdgeId> + Clone + use<> {
        (0..self.edge_count()).map(EdgeId::from_index)
    }

    /// All triangles in order.
    #[must_use]
    pub fn faces(&self) -> impl ExactSizeIterator<Item = FaceId> + Clone + use<> {
        (0..self.face_count()).map(FaceId::from_index)
    }

    /// All halfedges (corners) in order.
    #[must_use]
    pub fn halfedges(&self) -> impl ExactSizeIterator<Item = HalfedgeId> + Clone + use<> {
        (0..self.halfedge_count()).map(HalfedgeId::from_index)
    }

    /// The vertex that the halfedge leaves from.
    #[inline]
    #[must_use]
    pub fn origin(&self, halfedge: HalfedgeId) -> VertexId {
        self.origins[halfedge.index()]
    }

    /// The vertex that the halfedge runs to; it may be the origin.
    #[inline]
    #[must_use]
    pub fn destination(&self, halfedge: HalfedgeId) -> VertexId {
        self.origin(halfedge.next())
    }

    /// The ends of the halfedge: origin, destination.
    #[inline]
    #[must_use]
    pub fn ends(&self, halfedge: HalfedgeId) -> [VertexId; 2] {
        [self.origin(halfedge), self.destination(halfedge)]
    }

    /// The halfedge on the other side of the same edge, or `None` on the boundary.
    #[inline]
    #[must_use]
    pub fn twin(&self, halfedge: HalfedgeId) -> Option<HalfedgeId> {
        let twin = self.twins[halfedge.index()];
        (twin != NONE).then_some(HalfedgeId(twin))
    }

    /// The edge that the halfedge runs along.
    #[inline]
    #[must_use]
    pub fn edge(&self, halfedge: HalfedgeId) -> EdgeId {
        self.halfedge_edges[halfedge.index()]
    }

    /// One of the halfedges of the edge; the only one on the boundary.
    #[inline]
    #[must_use]
    pub fn edge_halfedge(&self, edge: EdgeId) -> HalfedgeId {
        self.edge_halfedges[edge.index()]
    }

    /// Whether the edge lies on the boundary.
    #[inline]
    #[must_use]
    pub fn is_boundary_edge(&self, edge: EdgeId) -> bool {
        self.twin(self.edge_halfedge(edge)).is_none()
    }

    /// Whether the vertex lies on the boundary.
    #[inline]
    #[must_use]
    pub fn is_boundary_vertex(&self, vertex: VertexId) -> bool {
        self.twin(self.vertex_halfedge(vertex)).is_none()
    }

    /// The vertices of the triangle, counter-clockwise; not always three different ones.
    #[inline]
    #[must_use]
    pub fn triangle(&self, face: FaceId) -> [VertexId; 3] {
        face.halfedges().map(|halfedge| self.origin(halfedge))
    }

    /// A halfedge that leaves from the vertex; on the boundary the one that lies on the boundary.
    #[inline]
    #[must_use]
    pub fn vertex_halfedge(&self, vertex: VertexId) -> HalfedgeId {
        self.vertex_halfedges[vertex.index()]
    }

    /// The halfedge that leaves the same vertex, one triangle on counter-clockwise; `None` where
    /// the boundary is met.
    #[inline]
    #[must_use]
    pub fn turn_left(&self, halfedge: HalfedgeId) -> Option<HalfedgeId> {
        self.twin(halfedge.previous())
    }

    /// The halfedges that leave from the vertex, counter-clockwise, one for each corner there, from
    /// [`vertex_halfedge`](Self::vertex_halfedge) on.
    pub fn outgoing(&self, vertex: VertexId) -> impl Iterator<Item = HalfedgeId> + '_ {
        let first = self.vertex_halfedge(vertex);
        std::iter::successors(Some(first), move |&halfedge| {
            self.turn_left(halfedge).filter(|&left| left != first)
        })
    }

    /// The shape of each triangle.
    #[must_use]
    pub fn shapes(&self) -> &PerFace<TriangleShape> {
        &self.shapes
    }

    /// The shape of a triangle; its corner and side `k` are those of halfedge `3f + k`.
    #[inline]
    #[must_use]
    pub fn shape(&self, face: FaceId) -> &TriangleShape {
        &self.shapes[face]
    }

    /// The length of an edge.
    #[inline]
    #[must_use]
    pub fn edge_length(&self, edge: EdgeId) -> f64 {
        let halfedge = self.edge_halfedge(edge);
        self.shape(halfedge.face()).length(halfedge.side())
    }

    /// The mean length, each edge counted once.
    #[must_use]
    pub fn mean_edge_length(&self) -> f64 {
        let total: f64 = self.edges().map(|edge| self.edge_length(edge)).sum();
        total / self.edge_count() as f64
    }

    /// The direction of a halfedge at its origin, in `0.0..2π`; see
    /// [the type](IntrinsicTriangulation).
    #[inline]
    #[must_use]
    pub fn direction(&self, halfedge: HalfedgeId) -> f64 {
        self.directions[halfedge]
    }

    /// The sum of the angles at each vertex, not scaled.
    #[must_use]
    pub fn angle_sums(&self) -> &PerVertex<f64> {
        &self.angle_sums
    }

    /// The factor between angles on the surface and angles in the tangent plane of a vertex: 2π/Θ
    /// inside, 1 on the boundary and where all angles are 0.
    #[inline]
    #[must_use]
    pub fn angle_scale(&self, vertex: VertexId) -> f64 {
        let sum = self.angle_sums[vertex];
        if self.is_boundary_vertex(vertex) || sum == 0.0 {
            1.0
        } else {
            TAU / sum
        }
    }
}

/// The angle plus or minus whole turns, in `0.0..2π`.
pub(super) fn wrapped(angle: f64) -> f64 {
    let wrapped = angle - TAU * (angle / TAU).floor();
    // Rounding lifts a tiny negative angle to 2π itself.
    if wrapped < TAU { wrapped.max(0.0) } else { 0.0 }
}

/// Fourth powers of lengths are formed; smaller triangles of the mesh need room below.
fn check_scale(lengths: &EdgeLengths) -> Result<(), GeometryError> {
    let (edge, length) = lengths.longest();
    if (1e-70..=1e70).contains(&length) {
        Ok(())
    } else {
        Err(GeometryError::Scale { edge, length })
    }
}
