use std::f64::consts::FRAC_PI_2;

use crate::field::CrossField;
use crate::geometry::{IntrinsicTriangulation, reverse_direction};
use crate::mesh::{EdgeId, PerVertex};

use super::steps::EdgeSteps;
use super::energy::partner;

/// Largest angle between an edge and the field, in radians, up to which a line is laid along the
/// edge: 22.5°, where the two directions of a cross would be equally far.
const ALIGNED: f64 = std::f64::consts::PI / 8.0;

/// Which coordinates of the vertices must be whole, so that lines run along `edges`: of both ends of
/// an edge the one that crosses it.
///
/// Edges that the field does not follow, or follows differently at both ends, are not aligned to;
/// their number is the second result. Where aligned edges in different directions meet, both
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
        let at_i = crossing(triangulation.direction(halfedge) - field.angle(i));
        let at_j = crossing(reverse_direction(triangulation, halfedge) - field.angle(j));
        match (at_i, at_j) {
            (Some(at_i), Some(at_j)) if partner(steps.of_edge(edge).turn, at_i).0 == at_j => {
                whole[i][at_i] = true;
                whole[j][at_j] = true;
            }
            _ => left += 1,
        }
    }
    (whole, left)
}

/// The coordinate that stays the same along a direction, given by its angle against the field;
/// `None` if it is far from both.
fn crossing(angle: f64) -> Option<usize> {
    let quarters = (angle / FRAC_PI_2).round();
    let off = angle - quarters * FRAC_PI_2;
    (off.abs() <= ALIGNED).then(|| usize::from((quarters as i32).rem_euclid(2) == 0))
}
