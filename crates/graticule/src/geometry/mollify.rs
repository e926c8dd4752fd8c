//! Lengths that fit together to triangles with area, by the same small number added to all of
//! them (N. Sharp, K. Crane, *A Laplacian for Nonmanifold Triangle Meshes*, 2020, §4.5).
//!
//! Departures: the margin is a share of each triangle's own longest side, and each component gets
//! a number of its own, so that parts of very different size in one file do not harm each other.

use serde::Serialize;

use crate::mesh::{
    ComponentId, CornerTable, EdgeId, FaceId, PerComponent, PerEdge, PerFace, TriangleMesh,
    find_components,
};
use crate::tolerance::{MOLLIFICATION_MARGIN, SMALLEST_TRIANGLE};

use super::triangle::{TriangleShape, descending};
use super::{EdgeLengths, IntrinsicTriangulation};

/// What mollification has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Mollification {
    /// Triangles that were degenerate or broke the triangle inequality.
    pub faces: usize,
    /// Components whose lengths were changed.
    pub components: usize,
    /// The largest length added, a length; 0 if nothing was changed.
    pub largest_shift: f64,
}

/// Adds to the lengths of each component the least number with which, in all its triangles, two
/// sides are longer than the third by [`MOLLIFICATION_MARGIN`] of the longest.
///
/// Lengths that have the margin stay as they are. Only edges of no length in a mesh without any
/// length stay degenerate.
///
/// Cost: linear.
#[must_use]
pub fn mollify(mesh: &TriangleMesh, lengths: &EdgeLengths) -> (EdgeLengths, Mollification) {
    let sides: PerFace<[f64; 3]> = PerFace::from_fn(mesh.face_count(), |face: FaceId| {
        face.halfedges()
            .map(|halfedge| lengths[mesh.edge(halfedge)])
    });
    let floor = lengths.mean() * SMALLEST_TRIANGLE;
    let broken = sides.map(|&sides| missing_length(sides, floor) > 0.0);
    let plan = Plan::new(mesh, &broken, &sides, floor);
    let moved = PerEdge::from_fn(mesh.edge_count(), |edge: EdgeId| {
        lengths[edge] + plan.shift(mesh.edge_halfedge(edge).face())
    });
    let moved = EdgeLengths::new(mesh, moved)
        .unwrap_or_else(|_| unreachable!("finite lengths plus less than the longest of them"));
    (moved, plan.report)
}

impl IntrinsicTriangulation {
    /// Mollifies the components that have a degenerate triangle, as [`mollify`] does, and leaves
    /// the others alone.
    ///
    /// The directions at the vertices are laid out anew from the changed angles.
    pub fn mollify(&mut self) -> Mollification {
        let broken = self.shapes().map(TriangleShape::is_degenerate);
        if !broken.iter().any(|&broken| broken) {
            return Mollification::default();
        }
        let sides = self.shapes().map(TriangleShape::lengths);
        let floor = self.mean_edge_length() * SMALLEST_TRIANGLE;
        let plan = Plan::new(self, &broken, &sides, floor);
        let moved = self.shapes().enumerate().map(|(face, shape)| {
            let shift = plan.shift(face);
            let longer = shape.lengths().map(|length| length + shift);
            let moved = (shift > 0.0).then(|| TriangleShape::from_lengths(longer));
            moved.flatten().unwrap_or(*shape)
        });
        let moved = PerFace::new(moved.collect());
        self.replace_shapes(moved);
        plan.report
    }
}

/// The least number to be added to the sides of a triangle, or 0.
fn missing_length(sides: [f64; 3], floor: f64) -> f64 {
    let [a, b, c] = descending(sides);
    let margin = MOLLIFICATION_MARGIN * a.max(floor);
    let excess = c - (a - b);
    // The margin grows with the side it is a share of.
    ((margin - excess) / (1.0 - MOLLIFICATION_MARGIN)).max(0.0)
}

/// What each component gets.
struct Plan {
    components: PerFace<ComponentId>,
    shifts: PerComponent<f64>,
    report: Mollification,
}

impl Plan {
    fn new(
        table: &CornerTable,
        broken: &PerFace<bool>,
        sides: &PerFace<[f64; 3]>,
        floor: f64,
    ) -> Self {
        let (components, count) = find_components(table);
        let mut is_broken = PerComponent::filled(count, false);
        for (&component, &broken) in components.iter().zip(broken) {
            is_broken[component] |= broken;
        }
        let mut shifts = PerComponent::filled(count, 0.0_f64);
        for (&component, &sides) in components.iter().zip(sides) {
            if is_broken[component] {
                shifts[component] = shifts[component].max(missing_length(sides, floor));
            }
        }
        let report = Mollification {
            faces: broken.iter().filter(|&&broken| broken).count(),
            components: shifts.iter().filter(|&&shift| shift > 0.0).count(),
            largest_shift: shifts.iter().copied().fold(0.0, f64::max),
        };
        Self {
            components,
            shifts,
            report,
        }
    }

    fn shift(&self, face: FaceId) -> f64 {
        self.shifts[self.components[face]]
    }
}
