use glam::DVec3;

use crate::mesh::{EdgeId, Element, FaceId, PerEdge, PerFace, PerVertex, Surface, largest_of};

use super::triangle::{TriangleShape, face_shapes};

/// The unit normal of each triangle, towards the side from which it is seen counter-clockwise;
/// the zero vector for a triangle without area.
///
/// Cost: linear, in parallel. Any scale.
#[must_use]
pub fn face_normals(surface: &Surface) -> PerFace<DVec3> {
    use rayon::prelude::*;
    let faces = (0..surface.mesh().face_count()).into_par_iter();
    let normal = |face| unit_normal(surface.corner_positions(FaceId::from_index(face)));
    PerFace::new(faces.map(normal).collect())
}

pub(super) fn unit_normal(corners: [DVec3; 3]) -> DVec3 {
    let [a, b, c] = corners;
    let sides = [b - a, c - b, a - c];
    let magnitudes = sides.map(|side| side.abs().max_element());
    let largest = magnitudes.into_iter().fold(0.0, f64::max);
    if largest == 0.0 {
        return DVec3::ZERO;
    }
    // The two shorter sides lose least; scaled, their product neither overflows nor underflows.
    let longest = largest_of(magnitudes);
    let [u, v] = [1, 2].map(|step| {
        let side = (longest + step) % 3;
        sides[side] / magnitudes[side].max(f64::MIN_POSITIVE)
    });
    u.cross(v).normalize_or_zero()
}

/// The unit normal of each vertex: the mean of those of its triangles, weighted by their angles
/// there (G. Thürmer, C. Wüthrich, *Computing Vertex Normals from Polygonal Facets*, 1998). It does
/// not depend on how the surface is cut into triangles. The zero vector where they cancel.
///
/// Cost: linear. Scales from 1e-70 to 1e70.
#[must_use]
pub fn vertex_normals(surface: &Surface) -> PerVertex<DVec3> {
    let mesh = surface.mesh();
    let mut sums = PerVertex::filled(mesh.vertex_count(), DVec3::ZERO);
    let normals = face_normals(surface);
    for (face, shape) in face_shapes(surface).enumerate() {
        for (vertex, angle) in mesh.triangle(face).into_iter().zip(shape.angles()) {
            sums[vertex] += normals[face] * angle;
        }
    }
    sums.map(|sum| sum.normalize_or_zero())
}

/// The angle between the normals of the two triangles at each edge, in `-π..=π`: positive where the
/// edge stands out, negative where it is a groove, 0 on the boundary and beside a triangle without
/// area.
#[must_use]
pub fn dihedral_angles(surface: &Surface) -> PerEdge<f64> {
    let mesh = surface.mesh();
    let normals = face_normals(surface);
    PerEdge::from_fn(mesh.edge_count(), |edge: EdgeId| {
        let halfedge = mesh.edge_halfedge(edge);
        let Some(twin) = mesh.twin(halfedge) else {
            return 0.0;
        };
        let [left, right] = [normals[halfedge.face()], normals[twin.face()]];
        let axis = surface.halfedge_vector(halfedge);
        let axis = axis / axis.abs().max_element().max(f64::MIN_POSITIVE);
        let sine = axis.normalize_or_zero().dot(left.cross(right));
        libm::atan2(sine, left.dot(right))
    })
}

/// The area of the surface as a vector: the sum of its triangles' areas times their normals. It
/// vanishes for a closed surface.
#[must_use]
pub fn area_vector(surface: &Surface) -> DVec3 {
    let normals = face_normals(surface);
    let shapes = face_shapes(surface);
    let areas = shapes.iter().map(TriangleShape::area);
    areas
        .zip(&normals)
        .map(|(area, &normal)| normal * area)
        .sum()
}
