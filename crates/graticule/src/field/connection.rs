use glam::DVec2;

use super::Symmetry;
use crate::geometry::{
    GeometryError, IntrinsicTriangulation, edge_cotangent_weights, transport_angles,
};
use crate::mesh::{Element, PerVertex, VertexId};

/// How much a direction field turns, as a quadratic form of one complex number `u` per vertex, the
/// [`power`](Symmetry::power) of its angle: `Σ wᵢⱼ |uⱼ - rᵢⱼ uᵢ|²` over the edges, `rᵢⱼ` the
/// transport from `i` to `j` ([PGP06] Eq. 22, summed over triangles as in Appendix B: the weights
/// λ A become half-cotangents).
///
/// No weight is negative: on an intrinsic Delaunay triangulation only those of boundary edges
/// opposite to obtuse angles would be, and these count as 0.
pub(super) struct ConnectionLaplacian {
    pub(super) edges: Vec<Connection>,
    pub(super) vertex_count: usize,
}

/// One edge of a [`ConnectionLaplacian`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Connection {
    pub(super) ends: [VertexId; 2],
    pub(super) weight: f64,
    /// Transport from the first end to the second, as a complex number.
    pub(super) rotation: DVec2,
}

impl ConnectionLaplacian {
    pub(super) fn new(
        triangulation: &IntrinsicTriangulation,
        symmetry: Symmetry,
    ) -> Result<Self, GeometryError> {
        let angles = transport_angles(triangulation);
        let weights = edge_cotangent_weights(triangulation)?;
        let edges = weights.enumerate().map(|(edge, &weight)| {
            let halfedge = triangulation.edge_halfedge(edge);
            Connection {
                ends: triangulation.ends(halfedge),
                weight: weight.max(0.0),
                rotation: symmetry.power(angles[halfedge]),
            }
        });
        Ok(Self {
            edges: edges.collect(),
            vertex_count: triangulation.vertex_count(),
        })
    }

    /// The energy `Σ w |uⱼ - r uᵢ|²`.
    pub(super) fn energy(&self, powers: &PerVertex<DVec2>) -> f64 {
        let terms = self.edges.iter().map(|edge| {
            let [i, j] = edge.ends;
            edge.weight * powers[j].distance_squared(edge.rotation.rotate(powers[i]))
        });
        terms.sum()
    }

    /// The entries on and below the diagonal of the matrix of the form, unknowns `2i` and `2i + 1`
    /// being the two parts of `uᵢ`.
    pub(super) fn lower_triplets(&self) -> Vec<(usize, usize, f64)> {
        let mut triplets = Vec::with_capacity(8 * self.edges.len());
        for &Connection {
            ends,
            weight,
            rotation,
        } in &self.edges
        {
            let [i, j] = ends.map(|vertex| 2 * vertex.index());
            for unknown in [i, i + 1, j, j + 1] {
                triplets.push((unknown, unknown, weight));
            }
            // The block in the rows of j and the columns of i is -w R.
            let block = [[rotation.x, -rotation.y], [rotation.y, rotation.x]];
            for (row, values) in block.iter().enumerate() {
                for (column, value) in values.iter().enumerate() {
                    let (row, column) = (j + row, i + column);
                    triplets.push((row.max(column), row.min(column), -weight * value));
                }
            }
        }
        triplets
    }
}
