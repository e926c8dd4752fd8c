use glam::DVec2;

use super::Guidance;
use crate::geometry::{
    GeometryError, IntrinsicTriangulation, edge_cotangent_weights, transport_angles,
};
use crate::mesh::{PerVertex, VertexId};

/// How much a direction field turns, as a quadratic form of one complex number `u` per vertex, the
/// [`power`](super::Symmetry::power) of its angle: `Σ wᵢⱼ |uⱼ - rᵢⱼ uᵢ|²` over the edges, `rᵢⱼ` the
/// transport from `i` to `j` ([PGP06] Eq. 22, summed over triangles as in Appendix B: the weights
/// λ A become half-cotangents). Where the guidance has sizes, transport is that of the metric in which
/// they are the same everywhere.
///
/// No weight is negative: on an intrinsic Delaunay triangulation only those of boundary edges
/// opposite to obtuse angles would be, and these count as 0.
///
/// [PGP06]: crate::papers::PGP06
pub(super) struct ConnectionLaplacian {
    pub(super) edges: Vec<Connection>,
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
        guidance: &Guidance,
    ) -> Result<Self, GeometryError> {
        let symmetry = guidance.symmetry();
        let angles = transport_angles(triangulation);
        let graded = guidance.graded_turns(triangulation);
        let weights = edge_cotangent_weights(triangulation)?;
        let edges = weights.enumerate().map(|(edge, &weight)| {
            let halfedge = triangulation.edge_halfedge(edge);
            let more = graded.as_ref().map_or(0.0, |turns| turns[halfedge]);
            Connection {
                ends: triangulation.ends(halfedge),
                weight: weight.max(0.0),
                rotation: symmetry.power(angles[halfedge] + more),
            }
        });
        // An edge from a vertex to itself costs every unit vector there the same.
        let edges = edges.filter(|edge| edge.ends[0] != edge.ends[1]);
        Ok(Self {
            edges: edges.collect(),
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
}

impl Connection {
    /// Transport from the second end to the first.
    pub(super) fn conjugate(&self) -> DVec2 {
        DVec2::new(self.rotation.x, -self.rotation.y)
    }
}
