use crate::mesh::{Element, HalfedgeId, PerVertex, TriangleMesh, VertexId};

use super::rows::Rows;
use super::triangle::TriangleShape;
use super::{GeometryError, IntrinsicTriangulation};

/// For each vertex a weight of each of its neighbours: a Laplacian that need not be symmetric.
///
/// Rows of boundary vertices are there too, made from the triangles that exist; a map with fixed
/// boundary does not use them.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectedWeights(Rows);

impl DirectedWeights {
    /// The number of vertices of the mesh.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.0.row_count()
    }

    /// The number of weights.
    #[must_use]
    pub fn weight_count(&self) -> usize {
        let vertices = (0..self.vertex_count()).map(VertexId::from_index);
        vertices.map(|vertex| self.neighbors(vertex).len()).sum()
    }

    /// The vertices that have a weight in the row of `vertex`, ascending, never `vertex` itself.
    #[must_use]
    pub fn neighbors(&self, vertex: VertexId) -> &[VertexId] {
        self.0.columns(vertex)
    }

    /// The weights in the row of `vertex`, in the order of [`neighbors`](Self::neighbors).
    #[must_use]
    pub fn weights(&self, vertex: VertexId) -> &[f64] {
        self.0.values(vertex)
    }

    /// The Laplacian applied: `(L u)ᵢ = Σⱼ wᵢⱼ (uᵢ - uⱼ)`.
    #[must_use]
    pub fn apply(&self, values: &PerVertex<f64>) -> PerVertex<f64> {
        PerVertex::from_fn(self.vertex_count(), |vertex: VertexId| {
            let row = self.neighbors(vertex).iter().zip(self.weights(vertex));
            row.map(|(&other, weight)| weight * (values[vertex] - values[other]))
                .sum()
        })
    }
}

/// The mean value weights `wᵢⱼ = (tan γ/2 + tan δ/2) / |ij|`, γ and δ the angles at `i` on either
/// side of the edge (M. Floater, *Mean value coordinates*, 2003). None is negative,
/// and only a flat triangle with an angle of 0 gives a 0.
///
/// Cost: linear.
///
/// # Errors
/// [`GeometryError::DegenerateFace`] where an edge has no length or an angle is π.
pub fn mean_value_weights(
    triangulation: &IntrinsicTriangulation,
) -> Result<DirectedWeights, GeometryError> {
    collect(triangulation, |shape, corner, side| {
        let tangent = shape.half_angle_tangent(corner.here)?;
        Some(tangent / shape.length(side))
    })
}

/// The authalic weights `wᵢⱼ = (cot γ + cot δ) / |ij|²`, γ and δ the angles at `j` on either side
/// of the edge: [`DMA02`] Eq. 6, the matrix M^χ of §4.1. Some are negative where triangles are
/// obtuse.
///
/// Cost: linear.
///
/// # Errors
/// [`GeometryError::DegenerateFace`] where a triangle has no area.
///
/// [`DMA02`]: crate::papers::DMA02
pub fn authalic_weights(
    triangulation: &IntrinsicTriangulation,
) -> Result<DirectedWeights, GeometryError> {
    collect(triangulation, |shape, corner, side| {
        let length = shape.length(side);
        Some(shape.cotangent(corner.there)? / length / length)
    })
}

/// The weights of a mix of both intrinsic energies, `λ E_A + μ E_χ` of [`DMA02`] §3.4:
/// `wᵢⱼ = λ (cot α + cot β) + μ ℓ² (cot γ + cot δ) / |ij|²`, α and β opposite to the edge, γ and δ
/// at `j`.
///
/// ℓ² is the mean square of the edge lengths: both terms are numbers then, and one λ : μ means the
/// same for every unit of length and for coarse and fine triangles.
///
/// Cost: linear.
///
/// # Errors
/// [`GeometryError::DegenerateFace`] where a triangle has no area.
///
/// [`DMA02`]: crate::papers::DMA02
pub fn intrinsic_weights(
    triangulation: &IntrinsicTriangulation,
    lambda: f64,
    mu: f64,
) -> Result<DirectedWeights, GeometryError> {
    let lengths = triangulation.edges().map(|e| triangulation.edge_length(e));
    let squares: f64 = lengths.map(|length| length * length).sum();
    let mean_square = squares / triangulation.edge_count().max(1) as f64;
    collect(triangulation, |shape, corner, side| {
        let length = shape.length(side);
        let opposite = 3 - corner.here - corner.there;
        let conformal = lambda * shape.cotangent(opposite)?;
        let authalic = mu * (shape.cotangent(corner.there)? / length / length) * mean_square;
        Some(conformal + authalic)
    })
}

/// The weight 1 for each neighbour, as a directed weight.
#[must_use]
pub fn uniform_directed_weights(mesh: &TriangleMesh) -> DirectedWeights {
    let entries = mesh.edges().flat_map(|edge| {
        let [i, j] = mesh.ends(mesh.edge_halfedge(edge));
        [(i, j, 1.0), (j, i, 1.0)]
    });
    DirectedWeights(Rows::collect(mesh.vertex_count(), entries.collect()))
}

/// The corners at the two ends of a side of a triangle.
#[derive(Clone, Copy)]
struct SideCorners {
    /// At the vertex whose row it is.
    here: usize,
    /// At its neighbour.
    there: usize,
}

/// Adds up what the triangle on either side of each edge gives to each of the two directions.
fn collect(
    triangulation: &IntrinsicTriangulation,
    term: impl Fn(&TriangleShape, SideCorners, usize) -> Option<f64>,
) -> Result<DirectedWeights, GeometryError> {
    let mut entries = Vec::with_capacity(2 * triangulation.edge_count());
    for edge in triangulation.edges() {
        let halfedge = triangulation.edge_halfedge(edge);
        let mut weights = directions(triangulation, halfedge, &term)?;
        if let Some(twin) = triangulation.twin(halfedge) {
            let [back, forth] = directions(triangulation, twin, &term)?;
            weights = [weights[0] + forth, weights[1] + back];
        }
        let [i, j] = triangulation.ends(halfedge);
        entries.extend([(i, j, weights[0]), (j, i, weights[1])]);
    }
    let rows = Rows::collect(triangulation.vertex_count(), entries);
    Ok(DirectedWeights(rows))
}

/// The terms of one triangle: from the origin of its side to the destination, and back.
fn directions(
    triangulation: &IntrinsicTriangulation,
    halfedge: HalfedgeId,
    term: &impl Fn(&TriangleShape, SideCorners, usize) -> Option<f64>,
) -> Result<[f64; 2], GeometryError> {
    let shape = triangulation.shape(halfedge.face());
    let side = halfedge.side();
    let end = halfedge.next().side();
    let finite = |here, there| {
        let value = term(shape, SideCorners { here, there }, side);
        let value = value.filter(|value| value.is_finite());
        value.ok_or_else(|| shape.degenerate(halfedge.face()))
    };
    Ok([finite(side, end)?, finite(end, side)?])
}
