use std::f64::consts::FRAC_PI_2;

use crate::field::CrossField;
use crate::geometry::{IntrinsicTriangulation, reverse_direction};
use crate::mesh::{EdgeId, PerVertex};

use super::energy::partner;
use super::steps::EdgeSteps;

/// Largest angle between an edge and the field, in radians, up to which a line is laid along the
/// edge: 22.5°, where the two directions of a cross would be equally far.
const ALIGNED: f64 = std::f64::consts::PI / 8.0;

/// Which coordinates of the vertices must be whole, so that lines run along `edges`: of both ends of
/// an edge the one that crosses it.
///
/// Edges that the field follows at neither end are not aligned to; their number is the second
/// result. Where aligned edges in different directions meet, both
/// coordinates are whole: the vertex is a grid point.
///
/// `triangulation` must have the edges themselves.
#[must_use]
pub(super) fn whole_coordinates(
    triangulation: &IntrinsicTriangulation,
    field: &CrossField,
    steps: &EdgeSteps,
    edges: &[EdgeId],
) -> (PerVertex<[bool; 2]>, usize) {
    let mut whole = PerVertex::filled(triangulation.vertex_count(), [false; 2]);
    let mut left = 0;
    for &edge in edges {
        let halfedge = triangulation.edge_halfedge(edge);
        let [i, j] = triangulation.ends(halfedge);
        let turn = steps.of_edge(edge).turn;
        let (at_i, off_i) = crossing(triangulation.direction(halfedge) - field.angle(i));
        let back = reverse_direction(triangulation, halfedge);
        let (at_j, off_j) = crossing(back - field.angle(j));
        if off_i.min(off_j) > ALIGNED {
            left += 1;
            continue;
        }
        // The end that knows better tells the other: round a corner the field turns.
        let partners = [0, 1].map(|coordinate| partner(turn, coordinate).0);
        let (at_i, at_j) = if off_i <= off_j {
            (at_i, partners[at_i])
        } else {
            (usize::from(partners[0] != at_j), at_j)
        };
        whole[i][at_i] = true;
        whole[j][at_j] = true;
    }
    (whole, left)
}

/// The coordinate that stays the same along a direction, given by its angle against the field, and
/// how far the direction is from that.
fn crossing(angle: f64) -> (usize, f64) {
    let quarters = (angle / FRAC_PI_2).round();
    let off = angle - quarters * FRAC_PI_2;
    let coordinate = usize::from((quarters as i32).rem_euclid(2) == 0);
    (coordinate, off.abs())
}
