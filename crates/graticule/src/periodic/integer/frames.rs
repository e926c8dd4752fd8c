//! From a cross at each vertex to a cross in each triangle, singular at vertices only.

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;

use super::cut::DualForest;
use crate::field::{CrossField, Singularities};
use crate::geometry::{IntrinsicTriangulation, transport_angles};
use crate::mesh::{
    FaceId, HalfedgeId, PerCorner, PerEdge, PerFace, PerVertex, TriangleMesh, VertexId,
};
use crate::periodic::QuarterTurn;

/// The axes of the coordinates in each triangle, and how they turn from one to the next.
///
/// A vertex field turns round triangles. Here each singular triangle hands its turn to one of its
/// corners: its axes agree with the crosses of the other two. So no singularity is lost or made,
/// whatever the shapes of the triangles.
#[derive(Clone, Debug)]
pub(super) struct FaceFrames {
    /// The angle of the first axis, in the coordinates of the triangle's shape.
    pub(super) angles: PerFace<f64>,
    /// The turn of coordinates from the halfedge's triangle to its twin's.
    pub(super) turns: PerCorner<QuarterTurn>,
    /// The index of each vertex, in quarters.
    pub(super) steps: PerVertex<i32>,
}

impl FaceFrames {
    /// `wished` has the index in quarters that each vertex should get if a singularity is near, for
    /// vertices on lines to be followed; `None` elsewhere.
    pub(super) fn of(
        mesh: &TriangleMesh,
        triangulation: &IntrinsicTriangulation,
        field: &CrossField,
        wished: &PerVertex<Option<i32>>,
    ) -> Self {
        let quarters = edge_quarters(field, triangulation);
        let singular = Singularities::of(field, mesh, triangulation);
        let (corners, steps) = singular_corners(mesh, &singular, wished);
        let mut labels = PerCorner::filled(mesh.halfedge_count(), 0);
        for face in mesh.faces() {
            label_face(mesh, &quarters, corners[face], face, &mut labels);
        }
        let turns = PerCorner::from_fn(mesh.halfedge_count(), |halfedge| {
            mesh.twin(halfedge)
                .map_or(QuarterTurn::NONE, |twin: HalfedgeId| {
                    let there = labels[twin] - oriented(mesh, &quarters, halfedge);
                    QuarterTurn::of_quarters(there - labels[halfedge])
                })
        });
        let angles = PerFace::from_fn(mesh.face_count(), |face| {
            face_angle(triangulation, field, &labels, corners[face], face)
        });
        Self {
            angles,
            turns,
            steps,
        }
    }

    /// Turns the axes so that coordinates go over without a turn along the branches of `forest`.
    pub(super) fn straighten(&mut self, mesh: &TriangleMesh, forest: &DualForest) {
        let mut quarters = PerFace::filled(mesh.face_count(), 0);
        for &(face, entered) in &forest.order {
            if let Some(from) = entered {
                quarters[face] = quarters[from.face()] + i32::from(self.turns[from].quarters());
            }
        }
        for halfedge in mesh.halfedges() {
            if let Some(twin) = mesh.twin(halfedge) {
                let turned = quarters[halfedge.face()] - quarters[twin.face()];
                self.turns[halfedge] = self.turns[halfedge].then(QuarterTurn::of_quarters(turned));
            }
        }
        for face in mesh.faces() {
            self.angles[face] += f64::from(quarters[face].rem_euclid(4)) * FRAC_PI_2;
        }
    }

    /// The direction of a halfedge in the axes of its triangle, in quarters of a circle.
    pub(super) fn direction(
        &self,
        triangulation: &IntrinsicTriangulation,
        halfedge: HalfedgeId,
    ) -> f64 {
        let face = halfedge.face();
        (side_angle(triangulation, halfedge) - self.angles[face]) / FRAC_PI_2
    }
}

/// The angle of a halfedge in the coordinates of its triangle's shape.
pub(super) fn side_angle(triangulation: &IntrinsicTriangulation, halfedge: HalfedgeId) -> f64 {
    let corners = triangulation.shape(halfedge.face()).corners();
    let side = corners[halfedge.next().side()] - corners[halfedge.side()];
    libm::atan2(side.y, side.x)
}

/// For each edge the quarters by which the chosen direction at the destination of its halfedge is
/// ahead of that at the origin.
fn edge_quarters(field: &CrossField, triangulation: &IntrinsicTriangulation) -> PerEdge<i32> {
    let transport = transport_angles(triangulation);
    PerEdge::from_fn(triangulation.edge_count(), |edge| {
        let halfedge = triangulation.edge_halfedge(edge);
        let [i, j] = triangulation.ends(halfedge);
        let difference = field.angle(j) - field.angle(i) - transport[halfedge];
        field.symmetry().reduce(difference).1
    })
}

fn oriented(mesh: &TriangleMesh, quarters: &PerEdge<i32>, halfedge: HalfedgeId) -> i32 {
    let edge = mesh.edge(halfedge);
    if mesh.edge_halfedge(edge) == halfedge {
        quarters[edge]
    } else {
        -quarters[edge]
    }
}

/// For each singular triangle the corner that becomes singular in its stead, and the index of
/// each vertex in quarters.
///
/// Preferred is a corner that comes nearer to the index wished for, which is 0 off the lines, then
/// one inside the surface and off the lines, then one not singular yet, then the one with most
/// triangles round it.
fn singular_corners(
    mesh: &TriangleMesh,
    singular: &Singularities,
    wished: &PerVertex<Option<i32>>,
) -> (PerFace<Option<u8>>, PerVertex<i32>) {
    let mut corners = PerFace::filled(mesh.face_count(), None);
    let mut steps = PerVertex::filled(mesh.vertex_count(), 0);
    for singularity in &singular.faces {
        let triangle = mesh.triangle(singularity.face);
        let merit = |&side: &usize| {
            let vertex: VertexId = triangle[side];
            let missing = wished[vertex].unwrap_or_default() - steps[vertex];
            let comes_nearer = missing * singularity.steps > 0;
            let is_free = wished[vertex].is_none() && !mesh.is_boundary_vertex(vertex);
            let room = mesh.outgoing(vertex).count();
            (comes_nearer, is_free, missing == 0, room, 3 - side)
        };
        let side = (0..3).max_by_key(merit).unwrap_or_default();
        steps[triangle[side]] += singularity.steps;
        corners[singularity.face] = Some(side as u8);
    }
    (corners, steps)
}

/// For each halfedge of a triangle the quarters by which the chosen direction at its origin is
/// ahead of the axes, as seen along this halfedge.
///
/// At a singular corner the two halfedges that meet there see different numbers.
fn label_face(
    mesh: &TriangleMesh,
    quarters: &PerEdge<i32>,
    singular: Option<u8>,
    face: FaceId,
    labels: &mut PerCorner<i32>,
) {
    let sides = face.halfedges();
    let start = singular.map_or(0, |side| (usize::from(side) + 1) % 3);
    let [first, second, third] = [sides[start], sides[(start + 1) % 3], sides[(start + 2) % 3]];
    labels[first] = 0;
    labels[second] = oriented(mesh, quarters, first);
    labels[third] = match singular {
        Some(_) => -oriented(mesh, quarters, third),
        None => labels[second] + oriented(mesh, quarters, second),
    };
}

/// The mean direction of the first axis as seen from the corners that agree on it.
fn face_angle(
    triangulation: &IntrinsicTriangulation,
    field: &CrossField,
    labels: &PerCorner<i32>,
    singular: Option<u8>,
    face: FaceId,
) -> f64 {
    let agreeing = face
        .halfedges()
        .into_iter()
        .filter(|halfedge| singular != Some(halfedge.side() as u8));
    let sum: DVec2 = agreeing
        .map(|halfedge| {
            let vertex = triangulation.origin(halfedge);
            let half = triangulation.shape(face).angle(halfedge.side()) / 2.0;
            // Both count from the bisector of the corner, so that neither side is preferred.
            let bisector =
                triangulation.direction(halfedge) + triangulation.angle_scale(vertex) * half;
            let beside = side_angle(triangulation, halfedge) + half;
            let quarters = f64::from(labels[halfedge].rem_euclid(4));
            let angle = beside + field.angle(vertex) - bisector - quarters * FRAC_PI_2;
            let (sin, cos) = libm::sincos(angle);
            DVec2::new(cos, sin)
        })
        .sum();
    libm::atan2(sum.y, sum.x)
}
