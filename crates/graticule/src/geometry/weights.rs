use crate::mesh::{
    EdgeId, Element, HalfedgeId, PerEdge, PerFace, PerVertex, TriangleMesh, VertexId,
};

use super::flip::Diamond;
use super::rows::Rows;
use super::triangle::TriangleShape;
use super::{GeometryError, IntrinsicTriangulation};

/// One number for each pair of vertices that are joined by an edge: a symmetric Laplacian.
///
/// The pairs are sorted, the smaller vertex first; no pair occurs twice and none joins a vertex to
/// itself, so that each is one entry off the diagonal of a matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeWeights {
    /// The two vertices.
    pub ends: Vec<[VertexId; 2]>,
    /// Their weight, which is *minus* the entry off the diagonal of the positive semidefinite
    /// Laplacian.
    pub weights: Vec<f64>,
    vertex_count: usize,
}

impl EdgeWeights {
    /// The number of vertices of the mesh.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// The smallest weight; infinite if there is no edge.
    #[must_use]
    pub fn least(&self) -> f64 {
        self.weights.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The Laplacian `L` applied: `(L u)ᵢ = Σⱼ wᵢⱼ (uᵢ - uⱼ)`. For cotangent weights that is minus
    /// the integral of Δu over the dual cell of the vertex.
    #[must_use]
    pub fn apply(&self, values: &PerVertex<f64>) -> PerVertex<f64> {
        let mut result = PerVertex::filled(self.vertex_count, 0.0);
        for (&[i, j], weight) in self.ends.iter().zip(&self.weights) {
            let flow = weight * (values[i] - values[j]);
            result[i] += flow;
            result[j] -= flow;
        }
        result
    }

    /// The energy `½ Σ wᵢⱼ (uᵢ - uⱼ)²`. For cotangent weights that is the Dirichlet energy `½ ∫ |∇u|²`.
    #[must_use]
    pub fn energy(&self, values: &PerVertex<f64>) -> f64 {
        let pairs = self.ends.iter().zip(&self.weights);
        let terms = pairs.map(|(&[i, j], weight)| weight * (values[i] - values[j]).powi(2));
        0.5 * terms.sum::<f64>()
    }
}

/// The cotangent weights `wᵢⱼ = ½ (cot α + cot β)`, α and β the angles opposite to the edge, and
/// `½ cot α` on the boundary.
///
/// Half the coefficients of [`DMA02`] Eqs. 3 and 4: with the half, the energy is that of the
/// function and the weights are the stiffness matrix of linear finite elements. Edges with the
/// same ends are added up, edges from a vertex to itself left out: neither changes the energy.
///
/// A weight that is negative only by rounding, as [`intrinsic_delaunay`](super::intrinsic_delaunay)
/// judges, is 0. Other negative ones are kept: inside, a triangulation that is not Delaunay has
/// them; on the boundary any may.
///
/// Cost: linear.
///
/// # Errors
/// [`GeometryError::DegenerateFace`] where a triangle has no area.
///
/// [`DMA02`]: crate::papers::DMA02
pub fn cotangent_weights(
    triangulation: &IntrinsicTriangulation,
) -> Result<EdgeWeights, GeometryError> {
    let weights = edge_cotangent_weights(triangulation)?;
    let entries = weights.enumerate().map(|(edge, &weight)| {
        let halfedge = triangulation.edge_halfedge(edge);
        (triangulation.ends(halfedge), weight)
    });
    Ok(collect(triangulation.vertex_count(), entries.collect()))
}

/// The cotangent weight of each edge of the triangulation, several edges with the same ends kept
/// apart: for forms that carry vectors along the edges. See [`cotangent_weights`].
///
/// # Errors
/// [`GeometryError::DegenerateFace`] where a triangle has no area.
pub fn edge_cotangent_weights(
    triangulation: &IntrinsicTriangulation,
) -> Result<PerEdge<f64>, GeometryError> {
    let mut weights = Vec::with_capacity(triangulation.edge_count());
    for edge in triangulation.edges() {
        weights.push(rounded_weight(sides(triangulation, edge))?);
    }
    Ok(PerEdge::new(weights))
}

/// The [`cotangent_weights`] of triangles with the connectivity of a mesh, without the cost of a
/// triangulation whose edges can be flipped.
pub(crate) fn mesh_cotangent_weights(
    mesh: &TriangleMesh,
    shapes: &PerFace<TriangleShape>,
) -> Result<EdgeWeights, GeometryError> {
    let mut entries = Vec::with_capacity(mesh.edge_count());
    for edge in mesh.edges() {
        let halfedge = mesh.edge_halfedge(edge);
        let sides = [Some(halfedge), mesh.twin(halfedge)];
        let sides = sides.map(|side| side.map(|side| (side, &shapes[side.face()])));
        entries.push((mesh.ends(halfedge), rounded_weight(sides)?));
    }
    Ok(collect(mesh.vertex_count(), entries))
}

/// The halfedges of an edge with their triangles.
type Sides<'a> = [Option<(HalfedgeId, &'a TriangleShape)>; 2];

fn sides(triangulation: &IntrinsicTriangulation, edge: EdgeId) -> Sides<'_> {
    let halfedge = triangulation.edge_halfedge(edge);
    let sides = [Some(halfedge), triangulation.twin(halfedge)];
    sides.map(|side| side.map(|side| (side, triangulation.shape(side.face()))))
}

/// The weight of an edge, 0 if it is negative only by rounding.
fn rounded_weight(sides: Sides<'_>) -> Result<f64, GeometryError> {
    let weight = weight(sides)?;
    if let ([Some(left), Some(right)], true) = (sides, weight < 0.0) {
        let [left, right] = [left, right].map(|(side, shape)| shape.starting_at(side.side()));
        if !Diamond::between(left, right).is_negative() {
            return Ok(0.0);
        }
    }
    Ok(weight)
}

/// The weight 1 for each edge (W. T. Tutte, *How to draw a graph*, 1963).
#[must_use]
pub fn uniform_weights(mesh: &TriangleMesh) -> EdgeWeights {
    let edges = mesh
        .edges()
        .map(|edge| (mesh.ends(mesh.edge_halfedge(edge)), 1.0));
    collect(mesh.vertex_count(), edges.collect())
}

/// Half the sum of the cotangents opposite to an edge, as it comes.
pub(super) fn cotangent_weight(
    triangulation: &IntrinsicTriangulation,
    edge: EdgeId,
) -> Result<f64, GeometryError> {
    weight(sides(triangulation, edge))
}

fn weight(sides: Sides<'_>) -> Result<f64, GeometryError> {
    let opposite = |side: Option<(HalfedgeId, &TriangleShape)>| {
        let Some((halfedge, shape)) = side else {
            return Ok(0.0);
        };
        let cotangent = shape.cotangent(halfedge.previous().side());
        cotangent.ok_or_else(|| shape.degenerate(halfedge.face()))
    };
    let [left, right] = sides;
    Ok(f64::midpoint(opposite(left)?, opposite(right)?))
}

fn collect(vertex_count: usize, entries: Vec<([VertexId; 2], f64)>) -> EdgeWeights {
    let ordered = entries
        .into_iter()
        .map(|([i, j], weight)| (i.min(j), i.max(j), weight));
    let rows = Rows::collect(vertex_count, ordered.collect());
    let ends = (0..vertex_count)
        .map(VertexId::from_index)
        .flat_map(|vertex| {
            rows.columns(vertex)
                .iter()
                .map(move |&other| [vertex, other])
        });
    EdgeWeights {
        ends: ends.collect(),
        weights: rows.into_values(),
        vertex_count,
    }
}
