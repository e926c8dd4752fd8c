use std::f64::consts::TAU;
use std::ops::Deref;

use crate::mesh::{
    CornerTable, EdgeId, FaceId, HalfedgeId, PerCorner, PerFace, PerVertex, Surface, TriangleMesh,
    VertexId,
};

use super::triangle::{TriangleShape, corner_angles, face_shapes};
use super::{EdgeLengths, GeometryError};

/// A triangulation of a surface by its own shortest lines: connectivity, the shape of each
/// triangle, and the direction of each halfedge at its vertex; nothing about space.
///
/// The vertices are those of the mesh it was made from, so that whatever is computed per vertex
/// holds for the mesh. Triangles and edges keep their number but not their place once edges are
/// flipped. Then an edge may join a vertex to itself, two edges may have the same ends, and two
/// sides of a triangle may be the same edge; the numbering `3f + k` of halfedges (see
/// [`HalfedgeId`]) and the meaning of each method are those of a [`CornerTable`].
///
/// *Directions.* The tangent plane of a vertex is its neighbourhood with the total angle Θ scaled
/// to 2π inside the surface; at the boundary angles stay as they are. The direction of a halfedge
/// is its angle there, counter-clockwise from the halfedge that was
/// [`CornerTable::vertex_halfedge`] at the start. Flips leave the tangent planes alone, so that
/// vectors given in them mean the same before and after
/// (N. Sharp, Y. Soliman, K. Crane, *Navigating Intrinsic Triangulations*, 2019).
///
/// Memory: about 130 bytes for each triangle.
#[derive(Clone, Debug, PartialEq)]
pub struct IntrinsicTriangulation {
    pub(super) table: CornerTable,
    pub(super) shapes: PerFace<TriangleShape>,
    pub(super) directions: PerCorner<f64>,
    angle_sums: PerVertex<f64>,
}

impl Deref for IntrinsicTriangulation {
    type Target = CornerTable;

    #[inline]
    fn deref(&self) -> &CornerTable {
        &self.table
    }
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
        let mut triangulation = Self {
            table: CornerTable::clone(mesh),
            shapes,
            directions: PerCorner::filled(mesh.halfedge_count(), 0.0),
            angle_sums: PerVertex::filled(mesh.vertex_count(), 0.0),
        };
        triangulation.lay_out_directions();
        triangulation
    }

    /// Takes new shapes for the same triangles; each vertex keeps the direction of its
    /// [`vertex_halfedge`](CornerTable::vertex_halfedge).
    pub(super) fn replace_shapes(&mut self, shapes: PerFace<TriangleShape>) {
        self.shapes = shapes;
        self.lay_out_directions();
    }

    fn lay_out_directions(&mut self) {
        let angles = corner_angles(&self.shapes);
        let mut sums = PerVertex::filled(self.vertex_count(), 0.0);
        for (halfedge, &angle) in self.halfedges().zip(&angles) {
            sums[self.origin(halfedge)] += angle;
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
