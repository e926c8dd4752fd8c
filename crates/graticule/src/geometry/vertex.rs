use std::f64::consts::{PI, TAU};

use crate::mesh::PerVertex;

use super::IntrinsicTriangulation;
use super::triangle::TriangleShape;

/// A third of the area of the triangles at each vertex: the lumped mass of linear finite elements.
///
/// The areas sum to that of the surface.
#[must_use]
pub fn vertex_areas(triangulation: &IntrinsicTriangulation) -> PerVertex<f64> {
    sum_at_corners(triangulation, |shape| [shape.area() / 3.0; 3])
}

/// The area nearer to each vertex than to the others of its triangles, or, in an obtuse triangle,
/// half of it for the obtuse corner and a quarter for each of the others
/// (M. Meyer, M. Desbrun, P. Schröder, A. Barr, *Discrete Differential-Geometry Operators for
/// Triangulated 2-Manifolds*, 2003, §3.3).
///
/// The areas are not negative and sum to that of the surface. Best taken on the intrinsic Delaunay
/// triangulation, where few triangles are obtuse.
#[must_use]
pub fn mixed_voronoi_areas(triangulation: &IntrinsicTriangulation) -> PerVertex<f64> {
    sum_at_corners(triangulation, mixed_voronoi_parts)
}

fn mixed_voronoi_parts(shape: &TriangleShape) -> [f64; 3] {
    let area = shape.area();
    if let Some(obtuse) = (0..3).find(|&corner| shape.dot(corner) <= 0.0) {
        let mut parts = [area / 4.0; 3];
        parts[obtuse] = area / 2.0;
        return parts;
    }
    // All products are positive here, hence all cotangents finite.
    let part = |side: usize| {
        let opposite = shape.dot((side + 2) % 3) / shape.double_area();
        shape.length(side).powi(2) * opposite / 8.0
    };
    [0, 1, 2].map(|corner| part(corner) + part((corner + 2) % 3))
}

fn sum_at_corners(
    triangulation: &IntrinsicTriangulation,
    parts: impl Fn(&TriangleShape) -> [f64; 3],
) -> PerVertex<f64> {
    let mut sums = PerVertex::filled(triangulation.vertex_count(), 0.0);
    for (face, shape) in triangulation.shapes().enumerate() {
        for (vertex, part) in triangulation.triangle(face).into_iter().zip(parts(shape)) {
            sums[vertex] += part;
        }
    }
    sums
}

/// What the angles at each vertex lack: 2π less their sum inside (the curvature), π less their sum
/// on the boundary (how much the boundary turns there). They sum to 2π times the Euler
/// characteristic (Gauss–Bonnet).
#[must_use]
pub fn angle_defects(triangulation: &IntrinsicTriangulation) -> PerVertex<f64> {
    let sums = triangulation.angle_sums();
    PerVertex::new(
        sums.enumerate()
            .map(|(vertex, sum)| {
                let whole = if triangulation.is_boundary_vertex(vertex) {
                    PI
                } else {
                    TAU
                };
                whole - sum
            })
            .collect(),
    )
}
