use std::f64::consts::TAU;

use serde::Serialize;

use super::{CrossField, FieldDomain, Symmetry};
use crate::geometry::{IntrinsicTriangulation, angle_defects, face_curvatures, transport_angles};
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerFace, TriangleMesh};

/// A triangle around which a field turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Singularity {
    /// The triangle.
    #[serde(serialize_with = "face_number")]
    pub face: FaceId,
    /// How often the field turns round it, in steps of the field's symmetry: quarter turns for a
    /// cross field. The index is this over the order of the symmetry.
    pub steps: i32,
}

#[allow(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature is serde's"
)]
fn face_number<S: serde::Serializer>(face: &FaceId, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u32(face.0)
}

/// Where a field is singular, and that it adds up.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Singularities {
    /// The symmetry of the field.
    pub symmetry: Symmetry,
    /// The singular triangles, in order.
    pub faces: Vec<Singularity>,
    /// How often the field turns against the boundary along each loop, as an index: 0 for a field
    /// that follows a smooth boundary.
    pub boundary_indices: Vec<f64>,
}

impl Singularities {
    /// Finds where `field` is singular in the triangles of `triangulation`, whose connectivity must
    /// be that of `mesh`.
    ///
    /// Between neighbours the field turns by the least angle ([PGP06] Eq. 13). The turns round a
    /// triangle, less what transport turns by, are a multiple of the symmetry's step. The sum of
    /// all indices is the Euler characteristic, whatever the field.
    ///
    /// [PGP06]: crate::papers::PGP06
    #[must_use]
    pub fn of(
        field: &CrossField,
        mesh: &TriangleMesh,
        triangulation: &IntrinsicTriangulation,
    ) -> Self {
        let transports = transport_angles(triangulation);
        let curvatures = face_curvatures(triangulation);
        Self::found(field, mesh, triangulation, (transports, &curvatures))
    }

    /// Those of a field on a domain.
    pub(super) fn on(domain: &FieldDomain<'_>, field: &CrossField) -> Self {
        let turns = (domain.transports().clone(), domain.face_curvatures());
        let mesh = domain.surface().mesh();
        Self::found(field, mesh, domain.triangulation(), turns)
    }

    /// From parallel transport along halfedges and the curvatures of triangles.
    fn found(
        field: &CrossField,
        mesh: &TriangleMesh,
        triangulation: &IntrinsicTriangulation,
        (transports, curvatures): (PerCorner<f64>, &PerFace<f64>),
    ) -> Self {
        let symmetry = field.symmetry();
        let rotations = rotations_against(field, triangulation, transports);
        let steps = PerFace::from_fn(triangulation.face_count(), |face: FaceId| {
            let turned: f64 = face.halfedges().iter().map(|&h| rotations[h]).sum();
            ((turned + curvatures[face]) / symmetry.step()).round() as i32
        });
        let singular = steps.enumerate().filter(|&(_, &steps)| steps != 0);
        let faces = singular
            .map(|(face, &steps)| Singularity { face, steps })
            .collect();
        let boundary_indices = boundary_indices(mesh, triangulation, &rotations);
        Self {
            symmetry,
            faces,
            boundary_indices,
        }
    }

    /// The number of singular triangles.
    #[must_use]
    pub fn count(&self) -> usize {
        self.faces.len()
    }

    /// The sum of all indices, those of the boundary loops included: the Euler characteristic, up
    /// to rounding of the boundary's turns.
    #[must_use]
    pub fn index_sum(&self) -> f64 {
        let steps: i32 = self.faces.iter().map(|singularity| singularity.steps).sum();
        let boundary: f64 = self.boundary_indices.iter().sum();
        f64::from(steps) / f64::from(self.symmetry.order()) + boundary
    }
}

/// For each halfedge the angle, within half a step, by which the field turns along it against
/// parallel transport. The twin has minus that angle.
#[must_use]
pub fn rotations(field: &CrossField, triangulation: &IntrinsicTriangulation) -> PerCorner<f64> {
    rotations_against(field, triangulation, transport_angles(triangulation))
}

/// The same from parallel transport along the halfedges.
fn rotations_against(
    field: &CrossField,
    triangulation: &IntrinsicTriangulation,
    transports: PerCorner<f64>,
) -> PerCorner<f64> {
    let mut rotations = transports;
    for edge in triangulation.edges() {
        let halfedge = triangulation.edge_halfedge(edge);
        let [i, j] = triangulation.ends(halfedge);
        let difference = field.angle(j) - field.angle(i) - rotations[halfedge];
        let (rotation, _) = field.symmetry().reduce(difference);
        rotations[halfedge] = rotation;
        if let Some(twin) = triangulation.twin(halfedge) {
            rotations[twin] = -rotation;
        }
    }
    rotations
}

fn boundary_indices(
    mesh: &TriangleMesh,
    triangulation: &IntrinsicTriangulation,
    rotations: &PerCorner<f64>,
) -> Vec<f64> {
    if mesh.boundary_loops().next().is_none() {
        return Vec::new();
    }
    let turns = angle_defects(triangulation);
    let against =
        |&halfedge: &HalfedgeId| turns[triangulation.origin(halfedge)] - rotations[halfedge];
    mesh.boundary_loops()
        .map(|boundary_loop| {
            mesh.boundary_loop(boundary_loop)
                .iter()
                .map(against)
                .sum::<f64>()
        })
        .map(|turned| turned / TAU)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Element, PerVertex, Surface};
    use graticule_fixtures::{
        Fixture, Noise, bumpy_patch, cube, cylinder_patch, disk, icosphere, torus,
    };
    use std::f64::consts::PI;

    const ALL: [Symmetry; 3] = [Symmetry::Vector, Symmetry::Line, Symmetry::Cross];

    fn triangulated(fixture: Fixture) -> (Surface, IntrinsicTriangulation) {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let triangulation = IntrinsicTriangulation::of(&surface).unwrap();
        (surface, triangulation)
    }

    #[test]
    fn indices_of_any_field_sum_to_the_euler_characteristic() {
        let cases = [
            (icosphere(2), 2.0),
            (cube(), 2.0),
            (torus(2.0, 0.7, 20, 10), 0.0),
            (disk(6), 1.0),
            (bumpy_patch(8, 3), 1.0),
            (cylinder_patch(1.0, 2.0, 12, 5), 0.0),
        ];
        for (seed, (fixture, euler_characteristic)) in cases.into_iter().enumerate() {
            let (surface, triangulation) = triangulated(fixture);
            let mut noise = Noise::new(seed as u64);
            for symmetry in ALL {
                let count = surface.mesh().vertex_count();
                let angles = PerVertex::from_fn(count, |_| PI * noise.signed());
                let field = CrossField::from_angles(symmetry, angles);
                let found = Singularities::of(&field, surface.mesh(), &triangulation);
                assert!(
                    (found.index_sum() - euler_characteristic).abs() < 1e-9,
                    "{found:?}"
                );
            }
        }
    }

    #[test]
    fn a_constant_field_in_the_plane_is_regular() {
        let (surface, triangulation) = triangulated(disk(5));
        let frames = crate::geometry::vertex_frames(&surface);
        let angles = PerVertex::from_fn(surface.mesh().vertex_count(), |vertex| {
            let along = frames[vertex].project(glam::DVec3::new(1.0, 0.3, 0.0));
            libm::atan2(along.y, along.x)
        });
        for symmetry in ALL {
            let field = CrossField::from_angles(symmetry, angles.clone());
            assert_eq!(
                Singularities::of(&field, surface.mesh(), &triangulation).count(),
                0
            );
            let rotations = rotations(&field, &triangulation);
            assert!(rotations.iter().all(|rotation| rotation.abs() < 1e-12));
        }
    }

    #[test]
    fn a_field_of_radii_has_one_pole_in_the_middle() {
        let (surface, triangulation) = triangulated(disk(6));
        let frames = crate::geometry::vertex_frames(&surface);
        let field = |symmetry: Symmetry| {
            let angles = PerVertex::from_fn(surface.mesh().vertex_count(), |vertex| {
                let p = surface.position(vertex);
                // Half, or a quarter, of the polar angle makes a half- or quarter-pole.
                let polar = libm::atan2(p.y - 1e-3, p.x - 2e-3) / f64::from(symmetry.order());
                let along = frames[vertex].project(glam::DVec3::new(polar.cos(), polar.sin(), 0.0));
                libm::atan2(along.y, along.x)
            });
            CrossField::from_angles(symmetry, angles)
        };
        for symmetry in ALL {
            let found = Singularities::of(&field(symmetry), surface.mesh(), &triangulation);
            assert_eq!(found.faces.iter().map(|s| s.steps).collect::<Vec<_>>(), [1]);
            // The triangles of the middle come first.
            assert!(found.faces[0].face.index() < 6);
        }
    }
}
