//! How much closer together lines are than asked for, where they would not fit otherwise.

use std::collections::BinaryHeap;

use glam::DVec2;

use super::energy::SideEnergy;
use crate::mesh::{FaceId, PerCorner, PerVertex, TriangleMesh, VertexId};

/// A factor on the number of lines at each vertex.
///
/// A part thinner than a cell has no room for the whole numbers of its corners and singularities,
/// so that triangles flip there. More lines make room.
pub(super) struct Sizing {
    /// The wishes where all factors are 1.
    asked: PerCorner<DVec2>,
    factors: PerVertex<f64>,
}

/// What the factor grows by in one round.
const GROWTH: f64 = 1.5;

/// The largest factor.
const LARGEST_FACTOR: f64 = 6.0;

/// What the factor loses over one spacing of lines, so that cells change size gradually.
const LOSS_PER_LINE: f64 = 0.15;

impl Sizing {
    /// No lines more than asked for.
    pub(super) fn as_asked(mesh: &TriangleMesh, energy: &SideEnergy) -> Self {
        Self {
            asked: energy.wishes.clone(),
            factors: PerVertex::filled(mesh.vertex_count(), 1.0),
        }
    }

    /// Raises the factors at the triangles and, less and less, round them. Tells whether any rose.
    pub(super) fn raise_at(&mut self, mesh: &TriangleMesh, faces: &[FaceId], density: f64) -> bool {
        let mut corners: Vec<VertexId> = faces.iter().flat_map(|&f| mesh.triangle(f)).collect();
        corners.sort_unstable();
        corners.dedup();
        let mut heap = BinaryHeap::new();
        for vertex in corners {
            let raised = (GROWTH * self.factors[vertex]).min(LARGEST_FACTOR);
            if raised > self.factors[vertex] {
                self.factors[vertex] = raised;
                heap.push((raised.to_bits(), vertex));
            }
        }
        let any = !heap.is_empty();
        while let Some((bits, vertex)) = heap.pop() {
            if bits == self.factors[vertex].to_bits() {
                self.spread(mesh, vertex, density, &mut heap);
            }
        }
        any
    }

    /// Raises the neighbours of a vertex to its factor less the loss on the way.
    fn spread(
        &mut self,
        mesh: &TriangleMesh,
        vertex: VertexId,
        density: f64,
        heap: &mut BinaryHeap<(u64, VertexId)>,
    ) {
        for corner in mesh.outgoing(vertex) {
            let before = corner.previous();
            for (side, other) in [
                (corner, mesh.destination(corner)),
                (before, mesh.origin(before)),
            ] {
                let lines = density * self.asked[side].length();
                let reached = self.factors[vertex] - LOSS_PER_LINE * lines;
                if reached > self.factors[other] {
                    self.factors[other] = reached;
                    // Factors are positive: their bits are in their order.
                    heap.push((reached.to_bits(), other));
                }
            }
        }
    }

    /// The wishes with these factors.
    pub(super) fn wishes(&self, mesh: &TriangleMesh) -> PerCorner<DVec2> {
        PerCorner::from_fn(mesh.halfedge_count(), |halfedge| {
            let corners = mesh.triangle(halfedge.face());
            let mean = corners.map(|v| self.factors[v]).iter().sum::<f64>() / 3.0;
            self.asked[halfedge] * mean
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Element, HalfedgeId, Surface};
    use graticule_fixtures::grid;

    #[test]
    fn factors_rise_at_the_triangles_and_fade_with_the_distance() {
        let plane = grid(10.0, 10.0, 20, 20);
        let surface = Surface::from_triangles(plane.positions, &plane.triangles).unwrap();
        let mesh = surface.mesh();
        let side = |h: HalfedgeId| surface.halfedge_vector(h).truncate();
        let energy = SideEnergy {
            weights: PerCorner::filled(mesh.halfedge_count(), 1.0),
            wishes: PerCorner::from_fn(mesh.halfedge_count(), side),
        };
        let mut sizing = Sizing::as_asked(mesh, &energy);
        assert_eq!(sizing.wishes(mesh), energy.wishes);
        let [near, far] = [FaceId(0), FaceId::from_index(mesh.face_count() - 1)];
        let mut rounds = 0;
        while sizing.raise_at(mesh, &[near], 1.0) {
            rounds += 1;
        }
        assert_eq!(rounds, 5);
        let ratio = |sizing: &Sizing, face: FaceId| {
            let [halfedge, ..] = face.halfedges();
            sizing.wishes(mesh)[halfedge].length() / energy.wishes[halfedge].length()
        };
        assert!((ratio(&sizing, near) - LARGEST_FACTOR).abs() < 1e-12);
        // The way along edges is at most the two sides of the square.
        assert!(ratio(&sizing, far) > LARGEST_FACTOR - 20.0 * LOSS_PER_LINE - 1e-9);
        assert!(ratio(&sizing, far) < LARGEST_FACTOR - 12.0 * LOSS_PER_LINE);
    }
}
