//! Parallel transport between the tangent planes of vertices, along edges
//! (F. Knöppel, K. Crane, U. Pinkall, P. Schröder, *Globally Optimal Direction Fields*, 2013, §6.1).

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::mesh::{HalfedgeId, PerCorner, PerFace, PerVertex, Surface, VertexId};
use crate::tolerance::TANGENT_SLANT;

use super::IntrinsicTriangulation;
use super::intrinsic::wrapped;
use super::normals::vertex_normals;

/// For each halfedge from `i` to `j` the angle that takes the direction of a vector in the tangent
/// plane of `i` to its direction in that of `j`, in `-π..π`. The twin has minus that angle.
///
/// Directions are those of [`IntrinsicTriangulation::direction`].
#[must_use]
pub fn transport_angles(triangulation: &IntrinsicTriangulation) -> PerCorner<f64> {
    let mut angles = PerCorner::filled(triangulation.halfedge_count(), 0.0);
    for edge in triangulation.edges() {
        let halfedge = triangulation.edge_halfedge(edge);
        let leaving = triangulation.direction(halfedge);
        let arriving = reverse_direction(triangulation, halfedge) + PI;
        let angle = centred(arriving - leaving);
        angles[halfedge] = angle;
        if let Some(twin) = triangulation.twin(halfedge) {
            angles[twin] = -angle;
        }
    }
    angles
}

/// The direction, at the destination of a halfedge, of the edge back to its origin, in `0.0..2π`;
/// also on the boundary, where no halfedge runs back.
#[must_use]
pub fn reverse_direction(triangulation: &IntrinsicTriangulation, halfedge: HalfedgeId) -> f64 {
    if let Some(twin) = triangulation.twin(halfedge) {
        return triangulation.direction(twin);
    }
    let next = halfedge.next();
    let angle = triangulation.shape(next.face()).angle(next.side());
    let scale = triangulation.angle_scale(triangulation.origin(next));
    wrapped(triangulation.direction(next) + scale * angle)
}

/// The curvature of each triangle: the angle by which a vector turns when it is carried round the
/// triangle, counter-clockwise. Scaling the angles at the vertices inside to 2π moves their
/// curvature into the triangles.
///
/// With the angles that the boundary turns by, the sum is 2π times the Euler characteristic. The
/// three [`transport_angles`] of a triangle sum to this up to whole turns.
#[must_use]
pub fn face_curvatures(triangulation: &IntrinsicTriangulation) -> PerFace<f64> {
    PerFace::new(
        triangulation
            .shapes()
            .enumerate()
            .map(|(face, shape)| {
                let corners = triangulation.triangle(face).into_iter().zip(shape.angles());
                let scaled = corners.map(|(v, angle)| triangulation.angle_scale(v) * angle);
                scaled.sum::<f64>() - PI
            })
            .collect(),
    )
}

/// The angle plus or minus whole turns, in `-π..π`.
fn centred(angle: f64) -> f64 {
    let wrapped = wrapped(angle);
    if wrapped < PI { wrapped } else { wrapped - TAU }
}

/// The tangent plane of a vertex in space: three unit vectors at right angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentFrame {
    /// The direction 0 of the tangent plane.
    pub x: DVec3,
    /// The direction π/2 of the tangent plane.
    pub y: DVec3,
    /// The normal, `x × y`.
    pub normal: DVec3,
}

impl TangentFrame {
    /// The vector in space that has these coordinates in the tangent plane.
    #[must_use]
    pub fn lift(&self, vector: DVec2) -> DVec3 {
        self.x * vector.x + self.y * vector.y
    }

    /// The coordinates of the projection of a vector to the tangent plane.
    #[must_use]
    pub fn project(&self, vector: DVec3) -> DVec2 {
        DVec2::new(self.x.dot(vector), self.y.dot(vector))
    }

    fn new(normal: DVec3, towards: DVec3) -> Self {
        let normal = normal.try_normalize().unwrap_or(DVec3::Z);
        let scaled = towards / towards.abs().max_element().max(f64::MIN_POSITIVE);
        let along = scaled - normal * normal.dot(scaled);
        // An edge along the normal gives no direction: any will do.
        let is_clear = along.length() > TANGENT_SLANT * scaled.length();
        let x = if is_clear {
            along.normalize()
        } else {
            normal.any_orthonormal_vector()
        };
        let y = normal.cross(x);
        Self { x, y, normal }
    }
}

/// A frame at each vertex: the angle-weighted normal, and the x axis along the projection of
/// [`vertex_halfedge`](crate::mesh::CornerTable::vertex_halfedge), which is where the directions of
/// an [`IntrinsicTriangulation`] of the surface are counted from.
///
/// Where a vertex has no normal, or the edge runs along it, any frame that fits is taken.
#[must_use]
pub fn vertex_frames(surface: &Surface) -> PerVertex<TangentFrame> {
    let mesh = surface.mesh();
    let normals = vertex_normals(surface);
    PerVertex::from_fn(mesh.vertex_count(), |vertex: VertexId| {
        let towards = surface.halfedge_vector(mesh.vertex_halfedge(vertex));
        TangentFrame::new(normals[vertex], towards)
    })
}
