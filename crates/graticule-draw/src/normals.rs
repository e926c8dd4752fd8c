use glam::DVec3;
use graticule::mesh::{Element, HalfedgeId, Surface};
use rayon::prelude::*;

use crate::Shading;

/// Cosine of the dihedral angle (40°) beyond which an edge is shaded as sharp.
const CREASE_COSINE: f64 = 0.766;

/// Normals at the corners of each triangle, averaged by area over those neighbours around the
/// vertex that are not across a crease.
///
/// Cost: linear in the sum of the squared valences.
pub(crate) fn smooth_shading(surface: &Surface) -> Shading {
    let mesh = surface.mesh();
    let normals = face_normals(surface);
    let corner_normal = |corner: HalfedgeId| {
        let own = normals[corner.face().index()];
        let sum: DVec3 = mesh
            .outgoing(mesh.origin(corner))
            .map(|halfedge| normals[halfedge.face().index()])
            .filter(|other| other.dot(own) >= CREASE_COSINE * other.length() * own.length())
            .sum();
        sum.normalize_or(DVec3::ZERO).as_vec3().to_array()
    };
    let corners = (0..mesh.face_count())
        .into_par_iter()
        .map(|face| {
            let first = 3 * face as u32;
            [first, first + 1, first + 2].map(|corner| corner_normal(HalfedgeId(corner)))
        })
        .collect();
    Shading::Smooth(corners)
}

/// Normal of each face, twice its area long, in units of the extent of the surface.
fn face_normals(surface: &Surface) -> Vec<DVec3> {
    let [low, high] = surface.bounding_box();
    let extent = (high - low).max_element();
    (0..surface.mesh().face_count())
        .into_par_iter()
        .map(|face| {
            let face = Element::from_index(face);
            let [a, b, c] = surface.corner_positions(face).map(|p| (p - low) / extent);
            (b - a).cross(c - a)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normals(fixture: &graticule_fixtures::Fixture) -> (Surface, Vec<[[f32; 3]; 3]>) {
        let surface =
            Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap();
        let Shading::Smooth(normals) = smooth_shading(&surface) else {
            unreachable!("smooth shading was asked for")
        };
        (surface, normals)
    }

    #[test]
    fn a_sphere_is_smooth_and_a_cube_sharp() {
        let (sphere, corners) = normals(&graticule_fixtures::icosphere(3));
        for face in sphere.mesh().faces() {
            for (position, normal) in sphere
                .corner_positions(face)
                .iter()
                .zip(corners[face.index()])
            {
                assert!(position.as_vec3().dot(normal.into()) > 0.999);
            }
        }
        let (_, corners) = normals(&graticule_fixtures::cube());
        for corner in corners.iter().flatten() {
            let largest = corner.iter().fold(0.0_f32, |a, b| a.max(b.abs()));
            assert!(largest > 0.9999, "a cube's normals lie along the axes");
        }
    }
}
