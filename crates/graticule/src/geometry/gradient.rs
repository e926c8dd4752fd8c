use glam::{DVec2, DVec3};

use crate::mesh::{FaceId, PerFace, PerVertex, Surface};

use super::{GeometryError, IntrinsicTriangulation};

/// The gradient, in each triangle, of the function that is linear there and has these values at the
/// vertices.
///
/// Coordinates are those of [`TriangleShape::corners`](super::TriangleShape::corners): the x axis
/// runs along the first halfedge of the triangle.
///
/// # Errors
/// [`GeometryError::DegenerateFace`] where a triangle has no area.
pub fn gradients(
    triangulation: &IntrinsicTriangulation,
    values: &PerVertex<f64>,
) -> Result<PerFace<DVec2>, GeometryError> {
    let mut gradients = Vec::with_capacity(triangulation.face_count());
    for (face, shape) in triangulation.shapes().enumerate() {
        let [a, b, c] = shape.corners();
        let [rise_b, rise_c] = rises(triangulation.triangle(face).map(|v| values[v]));
        let turned = (a - c).perp() * rise_b + (b - a).perp() * rise_c;
        let gradient = turned / shape.double_area();
        let gradient = Some(gradient).filter(|gradient| gradient.is_finite());
        gradients.push(gradient.ok_or_else(|| shape.degenerate(face))?);
    }
    Ok(PerFace::new(gradients))
}

/// The same as [`gradients`], as vectors in space that lie in the planes of the triangles.
///
/// # Errors
/// [`GeometryError::DegenerateFace`] where a triangle has no area.
pub fn gradients_in_space(
    surface: &Surface,
    values: &PerVertex<f64>,
) -> Result<PerFace<DVec3>, GeometryError> {
    let shapes = super::face_shapes(surface);
    let normals = super::face_normals(surface);
    let mut gradients = Vec::with_capacity(shapes.len());
    for (face, shape) in shapes.enumerate() {
        let [a, b, c] = surface.corner_positions(face);
        let [rise_b, rise_c] = rises(surface.mesh().triangle(face).map(|v| values[v]));
        let turned = normals[face].cross((a - c) * rise_b + (b - a) * rise_c);
        let gradient = turned / shape.double_area();
        let gradient = Some(gradient).filter(|gradient| gradient.is_finite());
        gradients.push(gradient.ok_or_else(|| shape.degenerate(face))?);
    }
    Ok(PerFace::new(gradients))
}

fn rises([a, b, c]: [f64; 3]) -> [f64; 2] {
    [b - a, c - a]
}

/// The divergence of a vector field that is constant in each triangle, integrated over the dual
/// cell of each vertex: minus the integral of its product with the gradient of the vertex's hat
/// function. On the boundary it includes the flow across it.
///
/// Coordinates as in [`gradients`]. The divergence of a gradient is minus
/// [`EdgeWeights::apply`](super::EdgeWeights::apply) of the cotangent weights.
#[must_use]
pub fn divergence(
    triangulation: &IntrinsicTriangulation,
    field: &PerFace<DVec2>,
) -> PerVertex<f64> {
    let mut flow = PerVertex::filled(triangulation.vertex_count(), 0.0);
    for (face, shape) in triangulation.shapes().enumerate() {
        let [a, b, c] = shape.corners();
        // The gradient of a hat function times the area is the opposite side turned left, halved.
        let opposite = [c - b, a - c, b - a];
        for (vertex, side) in triangulation.triangle(face).into_iter().zip(opposite) {
            flow[vertex] -= 0.5 * side.perp().dot(field[face]);
        }
    }
    flow
}

/// The same as [`divergence`], of vectors in space.
#[must_use]
pub fn divergence_in_space(surface: &Surface, field: &PerFace<DVec3>) -> PerVertex<f64> {
    let mesh = surface.mesh();
    let normals = super::face_normals(surface);
    let mut flow = PerVertex::filled(mesh.vertex_count(), 0.0);
    for face in mesh.faces() {
        let [a, b, c] = surface.corner_positions(face);
        let across = field[face].cross(normals[face]);
        let opposite = [c - b, a - c, b - a];
        for (vertex, side) in mesh.triangle(face).into_iter().zip(opposite) {
            flow[vertex] -= 0.5 * across.dot(side);
        }
    }
    flow
}

/// The unit vectors, in space, of the coordinates in which [`gradients`] are given in a triangle;
/// zero vectors for a triangle without area.
#[must_use]
pub fn face_axes(surface: &Surface, face: FaceId) -> [DVec3; 2] {
    let [a, b, c] = surface.corner_positions(face);
    let x = (b - a).normalize_or_zero();
    let normal = (b - a).cross(c - a).normalize_or_zero();
    [x, normal.cross(x)]
}
