use std::f64::consts::FRAC_PI_2;

use glam::DVec2;

use crate::field::CrossField;
use crate::geometry::{IntrinsicTriangulation, transport_angles};
use crate::mesh::{EdgeId, HalfedgeId, PerEdge, PerVertex};

use super::QuarterTurn;

/// What a field asks of the coordinates along an edge, from the origin to the destination of its
/// [`edge_halfedge`](crate::mesh::CornerTable::edge_halfedge).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeStep {
    /// The quarter turns r that bring the field at the destination closest to that at the origin:
    /// `K'ⱼ = R^r Kⱼ` ([PGP06] Eq. 13). Coordinates `p` of the destination are `R^-r p` in the
    /// frame of the origin.
    ///
    /// [PGP06]: crate::papers::PGP06
    pub turn: QuarterTurn,
    /// By how much both coordinates grow along the edge, `δ / 2π`, in the frame of the origin.
    pub delta: DVec2,
}

impl EdgeStep {
    /// The same step from the other end: the coordinates fall by as much, in the frame there.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self {
            turn: self.turn.inverse(),
            delta: -self.turn.apply(self.delta),
        }
    }
}

/// The steps of a field along all edges of a triangulation.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeSteps(PerEdge<EdgeStep>);

impl EdgeSteps {
    /// The step along an edge, from the origin of its first halfedge.
    #[must_use]
    pub fn of_edge(&self, edge: EdgeId) -> EdgeStep {
        self.0[edge]
    }

    /// The step along a halfedge of the triangulation that the steps were made from.
    #[must_use]
    pub fn along(&self, halfedge: HalfedgeId, triangulation: &IntrinsicTriangulation) -> EdgeStep {
        let edge = triangulation.edge(halfedge);
        let step = self.0[edge];
        if triangulation.edge_halfedge(edge) == halfedge {
            step
        } else {
            step.reversed()
        }
    }
}

/// The step of each edge: the quarter turns between its ends ([PGP06] Eq. 13) and
/// `δ = ω/2 (Kᵢ + K'ⱼ) · e`, here in turns.
///
/// Measured along the surface: the field's angles in the tangent planes of both ends are compared
/// with the edge's own. So the two ends agree on a step, and no length is lost to projection. The
/// energy and the unrolling both use this very step (erratum 3).
///
/// `density` is the wanted number of periods per unit length at each vertex: the scale of the
/// field over the chart size h, `ω = 2π / h` (erratum 1). Cost: linear.
///
/// [PGP06]: crate::papers::PGP06
#[must_use]
pub fn edge_steps(
    triangulation: &IntrinsicTriangulation,
    field: &CrossField,
    density: &PerVertex<f64>,
) -> EdgeSteps {
    let transport = transport_angles(triangulation);
    let symmetry = field.symmetry();
    let quarters = 4 / symmetry.order().cast_signed();
    let step = |edge: EdgeId| {
        let halfedge = triangulation.edge_halfedge(edge);
        let [i, j] = triangulation.ends(halfedge);
        let difference = field.angle(j) - field.angle(i) - transport[halfedge];
        let (rotation, steps) = symmetry.reduce(difference);
        let at_origin = triangulation.direction(halfedge) - field.angle(i);
        let half = 0.5 * triangulation.edge_length(edge);
        let delta =
            polar(half * density[i], at_origin) + polar(half * density[j], at_origin - rotation);
        EdgeStep {
            turn: QuarterTurn::of_quarters(-steps * quarters),
            delta,
        }
    };
    EdgeSteps(PerEdge::new(triangulation.edges().map(step).collect()))
}

fn polar(length: f64, angle: f64) -> DVec2 {
    // Whole quarters exactly, so that straight fields on grids give exact steps.
    let quarters = (angle / FRAC_PI_2).round();
    let (sin, cos) = libm::sincos(angle - quarters * FRAC_PI_2);
    QuarterTurn::of_quarters(quarters as i32).apply(DVec2::new(length * cos, length * sin))
}
