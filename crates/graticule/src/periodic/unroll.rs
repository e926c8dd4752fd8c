use std::collections::VecDeque;

use glam::DVec2;

use crate::geometry::IntrinsicTriangulation;
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerEdge, PerFace, PerVertex, TriangleMesh};

use super::energy::Phases;
use super::{EdgeStep, EdgeSteps, QuarterTurn, Transition};

/// Coordinates of each vertex in a frame of its own, and how the frames go over along the edges.
///
/// A frame is that of the field at the vertex. One unit is a whole period: `θ = 2π u`.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexFrames {
    /// The coordinates of each vertex.
    pub coordinates: PerVertex<DVec2>,
    /// For each edge how coordinates in the frame of the destination of its first halfedge become
    /// those in the frame of the origin: the integers r, s, t.
    pub jumps: PerEdge<Transition>,
}

/// The coordinates whose sines and cosines are given, in `-½..=½`.
#[must_use]
pub fn angles_of_phases(phases: &PerVertex<Phases>) -> PerVertex<DVec2> {
    let turns = |unit: DVec2| libm::atan2(unit.y, unit.x) / std::f64::consts::TAU;
    phases.map(|&[u, v]| DVec2::new(turns(u), turns(v)))
}

/// How coordinates of the destination of an edge become those of its origin ([PGP06] Algorithm 1):
/// the quarter turns of the step, then the whole numbers that bring them nearest to the origin's
/// plus the step.
///
/// The same step as in the energy (erratum 3).
///
/// [PGP06]: crate::papers::PGP06
#[must_use]
pub fn edge_jump(step: EdgeStep, origin: DVec2, destination: DVec2) -> Transition {
    let turn = step.turn.inverse();
    let shift = (origin + step.delta - turn.apply(destination)).round();
    Transition {
        turn,
        shift: [shift.x as i32, shift.y as i32],
    }
}

impl VertexFrames {
    /// Finds the jumps of all edges.
    #[must_use]
    pub fn new(
        triangulation: &IntrinsicTriangulation,
        steps: &EdgeSteps,
        coordinates: PerVertex<DVec2>,
    ) -> Self {
        let jump = |edge| {
            let [i, j] = triangulation.ends(triangulation.edge_halfedge(edge));
            edge_jump(steps.of_edge(edge), coordinates[i], coordinates[j])
        };
        Self {
            jumps: PerEdge::new(triangulation.edges().map(jump).collect()),
            coordinates,
        }
    }

    /// How coordinates of the destination of a halfedge become those of its origin.
    #[must_use]
    pub fn jump(&self, mesh: &TriangleMesh, halfedge: HalfedgeId) -> Transition {
        let edge = mesh.edge(halfedge);
        if mesh.edge_halfedge(edge) == halfedge {
            self.jumps[edge]
        } else {
            self.jumps[edge].inverse()
        }
    }

    /// What the jumps round a triangle compose to, from its first corner on; the identity if
    /// Algorithm 1 closes.
    #[must_use]
    pub fn holonomy(&self, mesh: &TriangleMesh, face: FaceId) -> Transition {
        let [ab, bc, ca] = face.halfedges().map(|side| self.jump(mesh, side));
        ca.then(bc).then(ab)
    }

    /// The coordinates of the corners of a triangle in the frame of its first vertex.
    #[must_use]
    pub fn corners(&self, mesh: &TriangleMesh, face: FaceId) -> [DVec2; 3] {
        let [ab, _, ca] = face.halfedges().map(|side| self.jump(mesh, side));
        let [a, b, c] = mesh.triangle(face).map(|vertex| self.coordinates[vertex]);
        [a, ab.apply(b), ca.inverse().apply(c)]
    }
}

/// Where a triangle stands among the elements that [PGP06] §3.2 tells apart.
///
/// [PGP06]: crate::papers::PGP06
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaceKind {
    /// Its coordinates close and turn counter-clockwise.
    Regular,
    /// The quarter turns round it do not close: a singularity of the field.
    FieldSingular,
    /// The quarter turns close, the whole shifts do not: a line ends here.
    PhaseSingular,
    /// Its coordinates close and do not turn counter-clockwise.
    Inverted,
}

impl FaceKind {
    /// Whether the coordinates of the corners fit together.
    #[must_use]
    pub fn closes(self) -> bool {
        matches!(self, Self::Regular | Self::Inverted)
    }
}

/// The kind of each triangle.
#[must_use]
pub fn face_kinds(mesh: &TriangleMesh, frames: &VertexFrames) -> PerFace<FaceKind> {
    PerFace::from_fn(mesh.face_count(), |face| {
        let holonomy = frames.holonomy(mesh, face);
        if holonomy.turn != QuarterTurn::NONE {
            FaceKind::FieldSingular
        } else if !holonomy.is_identity() {
            FaceKind::PhaseSingular
        } else if double_area(frames.corners(mesh, face)) > 0.0 {
            FaceKind::Regular
        } else {
            FaceKind::Inverted
        }
    })
}

/// Twice the signed area.
pub(super) fn double_area([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Coordinates of the corners of all triangles, with as few seams as a walk over the surface leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Per corner; in a triangle that does not close, walked from its first corner.
    pub coordinates: PerCorner<DVec2>,
    /// From the triangle of each halfedge to that of its twin ([PGP06] Eq. 16); `None` on the
    /// boundary and beside triangles that do not close.
    ///
    /// [PGP06]: crate::papers::PGP06
    pub transitions: PerCorner<Option<Transition>>,
}

/// Lays the triangles out, each beside one before it where both close.
#[must_use]
pub fn layout(mesh: &TriangleMesh, frames: &VertexFrames, kinds: &PerFace<FaceKind>) -> Layout {
    let sheets = sheets(mesh, frames, kinds);
    let closes = |halfedge: HalfedgeId| kinds[halfedge.face()].closes();
    Layout {
        coordinates: PerCorner::from_fn(mesh.halfedge_count(), |corner| {
            sheets[corner].apply(frames.coordinates[mesh.origin(corner)])
        }),
        transitions: PerCorner::from_fn(mesh.halfedge_count(), |halfedge| {
            let twin = mesh.twin(halfedge)?;
            let fits = closes(halfedge) && closes(twin);
            fits.then(|| sheets[halfedge].inverse().then(sheets[twin.next()]))
        }),
    }
}

/// For each corner how the frame of its vertex becomes the plane in which its triangle is laid out.
fn sheets(
    mesh: &TriangleMesh,
    frames: &VertexFrames,
    kinds: &PerFace<FaceKind>,
) -> PerCorner<Transition> {
    let mut sheets = PerCorner::filled(mesh.halfedge_count(), Transition::identity());
    let mut is_laid = PerFace::filled(mesh.face_count(), false);
    let mut waiting = VecDeque::new();
    for first in mesh.faces() {
        if is_laid[first] {
            continue;
        }
        is_laid[first] = true;
        waiting.push_back(first.halfedges()[0]);
        while let Some(corner) = waiting.pop_front() {
            // The sheet of this corner is known, the others follow from it.
            let next = corner.next();
            sheets[next] = frames.jump(mesh, corner).then(sheets[corner]);
            let back = frames.jump(mesh, corner.previous()).inverse();
            sheets[corner.previous()] = back.then(sheets[corner]);
            if !kinds[corner.face()].closes() {
                continue;
            }
            for side in [corner, next, corner.previous()] {
                let Some(twin) = mesh.twin(side) else {
                    continue;
                };
                if !is_laid[twin.face()] && kinds[twin.face()].closes() {
                    is_laid[twin.face()] = true;
                    sheets[twin] = sheets[side.next()];
                    waiting.push_back(twin);
                }
            }
        }
    }
    sheets
}
