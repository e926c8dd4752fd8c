use std::f64::consts::PI;

use glam::DVec2;
use serde::Serialize;

use super::{CrossField, FieldDomain, FieldError};
use crate::geometry::{
    IntrinsicTriangulation, cotangent_weights, divergence, gradients, vertex_areas,
};
use crate::mesh::{Element, FaceId, PerComponent, PerFace, PerVertex, Topology, TriangleMesh};
use crate::solve::{DirichletSystem, Placement, SymmetricMatrix};
use crate::watch::Watch;

/// How curl is corrected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurlOptions {
    /// Largest factor by which the scale may leave 1, upward or downward; `None` for any.
    pub range: Option<f64>,
}

impl Default for CurlOptions {
    fn default() -> Self {
        Self { range: Some(4.0) }
    }
}

/// The factor by which the field's vectors are scaled, and what that achieves.
#[derive(Clone, Debug, PartialEq)]
pub struct CurlCorrection {
    /// The scale `v` of each vertex. In each component the mean of `v²` over the surface is 1
    /// before the range is applied, so that a density of lines stays what it was on average.
    pub scale: PerVertex<f64>,
    /// The figures.
    pub report: CurlReport,
}

/// Figures of a curl correction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CurlReport {
    /// Mean curl of the unit field, `sqrt(∫ |∇γ|² / area)` in one over the mean edge length, over
    /// regular triangles.
    pub curl_before: f64,
    /// The same of what is left with the scale found, before the range is applied.
    pub curl_after: f64,
    /// Smallest and largest scale found, before the range is applied.
    pub found_range: [f64; 2],
    /// Vertices at which the range cut the scale.
    pub clamped_vertices: usize,
    /// Their share of all vertices.
    pub clamped_share: f64,
    /// Triangles left out because the field is singular there: its turning has no bound.
    pub singular_faces: usize,
    /// Relative residual of the linear solve.
    pub residual: f64,
}

impl FieldDomain<'_> {
    /// Scales the field so that it has as little curl as possible: least squares of
    /// `∇ log v = R90 ∇γ`, γ the direction of the field in each triangle ([PGP06] Eqs. 17–20).
    ///
    /// γ is measured in one frame per triangle, after the three vertices are matched by steps of the
    /// field's symmetry, and its differences go through parallel transport; so it has no jump, and a
    /// jump of `atan2` never counts as curl. The system is a Poisson equation on the whole surface,
    /// one vertex of each component held.
    ///
    /// Cost: one scalar factorisation and solve.
    ///
    /// # Errors
    /// [`FieldError`].
    ///
    /// [PGP06]: crate::papers::PGP06
    pub fn curl_correction(
        &self,
        field: &CrossField,
        options: &CurlOptions,
        watch: &Watch,
    ) -> Result<CurlCorrection, FieldError> {
        check_range(options)?;
        let _stage = watch.stage("curl correction");
        let triangulation = self.delaunay();
        let (turning, singular_faces) = field_turning(triangulation, field);
        // R90 ∇γ, and nothing where the field is singular.
        let wanted = turning.map(|gradient| gradient.unwrap_or_default().perp());
        let topology = Topology::of(self.surface().mesh());
        let (logarithms, residual) = self.scale_logarithms(&topology, &wanted)?;
        let left = gradients(triangulation, &logarithms)?;
        let rest = |face: FaceId| (wanted[face] - left[face]).length_squared();
        let curl = |square: &dyn Fn(FaceId) -> f64| mean_root(triangulation, &turning, square);
        let mesh = self.surface().mesh();
        let mut scale = normalized_scale(mesh, triangulation, &topology, &logarithms);
        let found_range = extremes(&scale);
        let clamped_vertices = clamp(&mut scale, options.range);
        Ok(CurlCorrection {
            report: CurlReport {
                curl_before: curl(&|face| wanted[face].length_squared()),
                curl_after: curl(&rest),
                found_range,
                clamped_vertices,
                clamped_share: clamped_vertices as f64 / scale.len() as f64,
                singular_faces,
                residual,
            },
            scale,
        })
    }

    /// The logarithms of the scale, 0 at one vertex of each component.
    fn scale_logarithms(
        &self,
        topology: &Topology,
        wanted: &PerFace<DVec2>,
    ) -> Result<(PerVertex<f64>, f64), FieldError> {
        let weights = cotangent_weights(self.delaunay())?;
        let pairs = weights.ends.iter().map(|ends| ends.map(Element::index));
        let edges = pairs.zip(weights.weights.iter().copied());
        let count = self.delaunay().vertex_count();
        let matrix = SymmetricMatrix::laplacian(count, edges)?;
        let mut held = PerComponent::filled(topology.components.len(), usize::MAX);
        let mesh = self.surface().mesh();
        for face in mesh.faces() {
            let held = &mut held[topology.face_components[face]];
            *held = mesh
                .triangle(face)
                .iter()
                .map(|v| v.index())
                .fold(*held, usize::min);
        }
        let placement = Placement::at(self.surface().positions().as_slice());
        let system = DirichletSystem::new(&matrix, held.as_slice(), placement)?;
        // The Laplacian is minus the divergence of the gradient.
        let loads: Vec<f64> = divergence(self.delaunay(), wanted)
            .iter()
            .map(|flow| -flow)
            .collect();
        let solution = system.solve_with_loads(&vec![0.0; held.len()], &loads)?;
        Ok((PerVertex::new(solution.values), solution.residual))
    }
}

fn check_range(options: &CurlOptions) -> Result<(), FieldError> {
    match options.range {
        Some(value) if !(1.0..).contains(&value) => Err(FieldError::Option {
            name: "range",
            value,
            range: "1 and above",
        }),
        _ => Ok(()),
    }
}

/// The gradient of the field's direction in each triangle; `None`, and counted, where the matching
/// does not close.
fn field_turning(
    triangulation: &IntrinsicTriangulation,
    field: &CrossField,
) -> (PerFace<Option<DVec2>>, usize) {
    let mut singular = 0;
    let turning = PerFace::from_fn(triangulation.face_count(), |face: FaceId| {
        let Some([at_a, at_b, at_c]) = matched_headings(triangulation, field, face) else {
            singular += 1;
            return None;
        };
        let (to_b, to_c) = (at_b - at_a, at_c - at_a);
        let shape = triangulation.shape(face);
        let [a, b, c] = shape.corners();
        let turned = (a - c).perp() * to_b + (b - a).perp() * to_c;
        Some(turned / shape.double_area()).filter(|gradient| gradient.is_finite())
    });
    (turning, singular)
}

/// The direction of the field at the three corners in the plane of the triangle, in branches that
/// differ least; `None` where they do not close round the triangle, because it is singular.
pub(super) fn matched_headings(
    triangulation: &IntrinsicTriangulation,
    field: &CrossField,
    face: FaceId,
) -> Option<[f64; 3]> {
    let symmetry = field.symmetry();
    let turns = turns_to_triangle(triangulation, face);
    let corners = triangulation.triangle(face);
    let [a, b, c] = std::array::from_fn(|k| turns[k] + field.angle(corners[k]));
    let [to_b, to_c, between] = [b - a, c - a, c - b].map(|turn| symmetry.reduce(turn).0);
    let closes = (to_c - to_b - between).abs() <= 0.5 * symmetry.step();
    closes.then_some([a, a + to_b, a + to_c])
}

/// For each corner the angle that takes directions in the tangent plane of the vertex to those in
/// the plane of the triangle, whose x axis runs along its first side. The bisector of the corner
/// joins the two planes.
pub(super) fn turns_to_triangle(triangulation: &IntrinsicTriangulation, face: FaceId) -> [f64; 3] {
    let angles = triangulation.shape(face).angles();
    let sides = [0.0, PI - angles[1], 2.0 * PI - angles[1] - angles[2]];
    std::array::from_fn(|corner| {
        let halfedge = face.halfedges()[corner];
        let vertex = triangulation.origin(halfedge);
        let half = angles[corner] / 2.0;
        let bisector = triangulation.direction(halfedge) + triangulation.angle_scale(vertex) * half;
        sides[corner] + half - bisector
    })
}

/// Exponentials, scaled so that the mean of their squares over each component is 1.
fn normalized_scale(
    mesh: &TriangleMesh,
    triangulation: &IntrinsicTriangulation,
    topology: &Topology,
    logarithms: &PerVertex<f64>,
) -> PerVertex<f64> {
    let count = topology.components.len();
    let components = vertex_components(mesh, topology);
    // The largest first, so that no exponential overflows.
    let mut largest = PerComponent::filled(count, f64::NEG_INFINITY);
    for (vertex, &logarithm) in logarithms.enumerate() {
        let largest = &mut largest[components[vertex]];
        *largest = largest.max(logarithm);
    }
    let mut sums = PerComponent::filled(count, [0.0; 2]);
    for (vertex, &area) in vertex_areas(triangulation).enumerate() {
        let component = components[vertex];
        let scale = libm::exp(logarithms[vertex] - largest[component]);
        sums[component][0] += area * scale * scale;
        sums[component][1] += area;
    }
    PerVertex::from_fn(logarithms.len(), |vertex| {
        let component = components[vertex];
        let [squares, area] = sums[component];
        libm::exp(logarithms[vertex] - largest[component]) / (squares / area).sqrt()
    })
}

fn vertex_components(
    mesh: &TriangleMesh,
    topology: &Topology,
) -> PerVertex<crate::mesh::ComponentId> {
    PerVertex::from_fn(mesh.vertex_count(), |vertex| {
        topology.face_components[mesh.vertex_halfedge(vertex).face()]
    })
}

/// The root of the mean square over regular triangles, times the mean edge length.
fn mean_root(
    triangulation: &IntrinsicTriangulation,
    turning: &PerFace<Option<DVec2>>,
    square: &dyn Fn(FaceId) -> f64,
) -> f64 {
    let mut sums = [0.0; 2];
    for (face, shape) in triangulation.shapes().enumerate() {
        if turning[face].is_some() {
            sums[0] += shape.area() * square(face);
            sums[1] += shape.area();
        }
    }
    if sums[1] > 0.0 {
        (sums[0] / sums[1]).sqrt() * triangulation.mean_edge_length()
    } else {
        0.0
    }
}

fn extremes(scale: &PerVertex<f64>) -> [f64; 2] {
    scale.iter().fold([f64::INFINITY, 0.0], |[low, high], &v| {
        [low.min(v), high.max(v)]
    })
}

fn clamp(scale: &mut PerVertex<f64>, range: Option<f64>) -> usize {
    let Some(range) = range else { return 0 };
    let mut clamped = 0;
    for value in scale.as_mut_slice() {
        let allowed = 1.0 / range..=range;
        if !allowed.contains(value) {
            clamped += 1;
            *value = value.clamp(*allowed.start(), *allowed.end());
        }
    }
    clamped
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Symmetry;
    use crate::geometry::vertex_frames;
    use crate::mesh::Surface;
    use glam::DVec3;
    use graticule_fixtures::{Fixture, annulus, disk, torus};

    /// The field whose direction in space is `direction`, corrected without a range.
    fn corrected(
        fixture: Fixture,
        direction: impl Fn(DVec3) -> DVec3,
    ) -> (Surface, CurlCorrection) {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let watch = Watch::new();
        let frames = vertex_frames(&surface);
        let angles = PerVertex::from_fn(surface.mesh().vertex_count(), |vertex| {
            let along = frames[vertex].project(direction(surface.position(vertex)));
            libm::atan2(along.y, along.x)
        });
        let field = CrossField::from_angles(Symmetry::Cross, angles);
        let options = CurlOptions { range: None };
        let domain = FieldDomain::of(&surface, &watch).unwrap();
        let correction = domain.curl_correction(&field, &options, &watch).unwrap();
        (surface, correction)
    }

    /// Largest over smallest product of the scale and `radius`, which should be constant.
    fn spread(found: &(Surface, CurlCorrection), radius: impl Fn(DVec3) -> f64) -> f64 {
        let (surface, correction) = found;
        let products = surface
            .mesh()
            .vertices()
            .map(|vertex| correction.scale[vertex] * radius(surface.position(vertex)));
        let [low, high] = products.fold([f64::INFINITY, 0.0], |[low, high], p: f64| {
            [low.min(p), high.max(p)]
        });
        high / low
    }

    #[test]
    fn radii_of_a_ring_are_scaled_by_one_over_the_radius() {
        let found = corrected(annulus(0.25, 1.0, 96, 24), |p| p);
        assert!(
            spread(&found, DVec3::length) < 1.02,
            "{}",
            spread(&found, DVec3::length)
        );
        let report = &found.1.report;
        assert!(report.curl_after < 0.05 * report.curl_before, "{report:?}");
        assert_eq!(report.singular_faces, 0);
    }

    #[test]
    fn a_torus_is_scaled_by_one_over_its_distance_from_the_axis() {
        let found = corrected(torus(2.0, 0.7, 120, 50), |p| DVec3::new(-p.y, p.x, 0.0));
        let radius = |p: DVec3| p.truncate().length();
        assert!(spread(&found, radius) < 1.02, "{}", spread(&found, radius));
        let report = &found.1.report;
        assert!(report.curl_after < 0.1 * report.curl_before, "{report:?}");
    }

    #[test]
    fn a_straight_field_needs_no_scale() {
        let found = corrected(disk(10), |_| DVec3::new(1.0, 0.4, 0.0));
        assert!(found.1.scale.iter().all(|v| (v - 1.0).abs() < 1e-12));
        assert!(found.1.report.curl_before < 1e-12);
    }

    #[test]
    fn each_component_has_a_scale_of_its_own() {
        let ring = annulus(0.25, 1.0, 96, 24);
        let far = ring.clone().map(|p| p * 1000.0 + DVec3::X * 5000.0);
        let single = corrected(ring.clone(), |p| p);
        let double = corrected(ring.joined(&far), |p| {
            if p.x > 2000.0 {
                p - DVec3::X * 5000.0
            } else {
                p
            }
        });
        let count = single.1.scale.len();
        for (index, one) in single.1.scale.iter().enumerate() {
            let both = [
                double.1.scale.as_slice()[index],
                double.1.scale.as_slice()[count + index],
            ];
            assert!(
                both.iter().all(|v| (v / one - 1.0).abs() < 1e-9),
                "{one} {both:?}"
            );
        }
    }

    #[test]
    fn a_range_holds_the_scale_and_tells_how_often() {
        let mut scale = PerVertex::new(vec![0.1, 0.5, 1.0, 3.0]);
        assert_eq!(clamp(&mut scale, Some(2.0)), 2);
        assert_eq!(scale.as_slice(), [0.5, 0.5, 1.0, 2.0]);
        assert!(check_range(&CurlOptions { range: Some(0.5) }).is_err());
        assert!(
            check_range(&CurlOptions {
                range: Some(f64::NAN)
            })
            .is_err()
        );
    }
}
