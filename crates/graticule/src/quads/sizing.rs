//! Quads whose sides differ over the surface: as told, by how much it bends, or along its curvature.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::FRAC_PI_2;

use super::remesh::side_length;
use super::{RemeshError, RemeshOptions};
use crate::field::{CurvatureOptions, FieldResult, PrincipalCurvature, principal_curvatures};
use crate::geometry::{IntrinsicTriangulation, face_shapes, normalized, total_area, vertex_areas};
use crate::mesh::{PerVertex, RefinedSurface, Surface, VertexId};
use crate::periodic::{
    CurvatureSizing, GridDensity, IntegerGridError, Stretch, check_sizes, curvature_density,
};
use crate::tolerance::{
    FADING_IN_QUADS, GROWTH_OF_SIDES, SHARPEST_BEND_IN_QUADS, SHORTEST_SIDE_REFINED, SURE_DIRECTION,
};
use crate::watch::Watch;

/// How the sides of quads vary over the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadSizing {
    /// Lengths of sides at each vertex, over each other, as far as a net allows: lines do not end but
    /// at singularities, which are placed for that as far as curvature, boundary and features leave
    /// them free. `None` for the same everywhere.
    pub sizes: Option<PerVertex<f64>>,
    /// By what factor sides get shorter at most where the surface bends more than on the mean, 1 and
    /// above.
    pub adaptivity: f64,
    /// The largest ratio of the sides of a quad, 1 and above: quads are longer in the direction in
    /// which the surface bends least.
    pub anisotropy: f64,
}

impl Default for QuadSizing {
    fn default() -> Self {
        Self {
            sizes: None,
            adaptivity: 1.0,
            anisotropy: 1.0,
        }
    }
}

impl QuadSizing {
    pub(super) fn check(&self, surface: &Surface) -> Result<(), IntegerGridError> {
        if let Some(sizes) = &self.sizes {
            check_sizes(sizes, surface.mesh().vertex_count())?;
        }
        for (name, value) in [
            ("adaptivity", self.adaptivity),
            ("anisotropy", self.anisotropy),
        ] {
            if !(1.0..=f64::MAX).contains(&value) {
                let range = "1 and above";
                return Err(IntegerGridError::Option { name, value, range });
            }
        }
        Ok(())
    }

    /// The shortest side over the mean one, as far as triangles are made smaller for its sake.
    pub(super) fn shortest_side(&self) -> f64 {
        let shortest = self.sizes.as_ref().map_or(1.0, |sizes| {
            let mean = sizes.iter().sum::<f64>() / sizes.len() as f64;
            sizes.iter().copied().fold(f64::INFINITY, f64::min) / mean
        });
        let bent = self.adaptivity.sqrt() * self.anisotropy.sqrt();
        (shortest / bent).max(SHORTEST_SIDE_REFINED)
    }

    /// The same on smaller triangles.
    pub(super) fn on_finer(&self, original: &Surface, finer: &RefinedSurface) -> Self {
        let mesh = original.mesh();
        let sizes = self.sizes.as_ref().map(|sizes| {
            finer
                .vertex_origin
                .map(|origin| origin.interpolate(mesh.triangle(origin.face).map(|v| sizes[v])))
        });
        Self {
            sizes,
            ..self.clone()
        }
    }

    /// The same on a part, which tells the vertex of the whole for each of its vertices.
    pub(super) fn on_part(&self, sources: &PerVertex<VertexId>) -> Self {
        let sizes = self.sizes.as_ref();
        Self {
            sizes: sizes.map(|sizes| sources.map(|&source| sizes[source])),
            ..self.clone()
        }
    }

    /// How far apart lines are to lie at each vertex, over each other, as told and by how much the
    /// surface bends; nowhere farther than rows of quads that grow by [`GROWTH_OF_SIDES`] reach.
    /// `None` for the same everywhere.
    pub(super) fn distances(
        &self,
        surface: &Surface,
        options: &RemeshOptions,
        watch: &Watch,
    ) -> Result<Option<PerVertex<f64>>, RemeshError> {
        let side = side_length(surface, options.density);
        let mut distances = self.sizes.clone();
        if self.adaptivity > 1.0 {
            let own = IntrinsicTriangulation::of(surface).map_err(IntegerGridError::from)?;
            let disks = options.field.curvature.unwrap_or_default();
            let curvatures = principal_curvatures(surface, &own, &disks, watch)?;
            if let Some(denser) = self.adapted(surface, &curvatures, side, watch)? {
                let told = distances.take();
                distances = Some(PerVertex::from_fn(denser.len(), |vertex| {
                    told.as_ref().map_or(1.0, |told| told[vertex]) / denser[vertex]
                }));
            }
        }
        Ok(distances.map(|distances| graded(surface, distances, side)))
    }

    /// How far quads are to be from squares at each vertex; `None` for squares.
    pub(super) fn stretches(
        &self,
        surface: &Surface,
        field: &FieldResult,
        watch: &Watch,
    ) -> Result<Option<PerVertex<Stretch>>, RemeshError> {
        if self.anisotropy <= 1.0 {
            return Ok(None);
        }
        let curvatures = if let Some(curvatures) = &field.curvatures {
            curvatures.clone()
        } else {
            let own = IntrinsicTriangulation::of(surface).map_err(IntegerGridError::from)?;
            principal_curvatures(surface, &own, &CurvatureOptions::default(), watch)?
        };
        Ok(Some(curvatures.map(|c| self.stretch(c))))
    }

    /// Lines per length over those where the surface bends no more than on the mean; `None` where
    /// it does not bend.
    fn adapted(
        &self,
        surface: &Surface,
        curvatures: &PerVertex<PrincipalCurvature>,
        side: f64,
        watch: &Watch,
    ) -> Result<Option<PerVertex<f64>>, RemeshError> {
        let (unit, _) = normalized(surface);
        let areas =
            vertex_areas(&IntrinsicTriangulation::of(&unit).map_err(IntegerGridError::from)?);
        let bends = areas.enumerate().map(|(vertex, area)| {
            let curvature: PrincipalCurvature = curvatures[vertex];
            // What is not a number is no bend.
            let bend = (side * curvature.largest()).max(0.0);
            area * bend.min(SHARPEST_BEND_IN_QUADS)
        });
        let mean = bends.sum::<f64>() / areas.iter().sum::<f64>();
        if !(mean > f64::EPSILON && mean.is_finite()) {
            return Ok(None);
        }
        let sizing = CurvatureSizing {
            chart_size: FADING_IN_QUADS * side,
            angle: FADING_IN_QUADS * mean,
            range: self.adaptivity,
        };
        Ok(Some(curvature_density(
            surface, curvatures, &sizing, watch,
        )?))
    }

    /// The ratio with which a quad departs from the surface as little as it can for its area, as far
    /// as the direction is known.
    fn stretch(&self, curvature: &PrincipalCurvature) -> Stretch {
        let (more, less) = (
            curvature.largest(),
            curvature.max.abs().min(curvature.min.abs()),
        );
        let ratio = (more / less.max(f64::MIN_POSITIVE)).sqrt();
        let bounded = if ratio >= 1.0 {
            ratio.min(self.anisotropy)
        } else {
            1.0
        };
        let turned = if curvature.max.abs() >= curvature.min.abs() {
            FRAC_PI_2
        } else {
            0.0
        };
        Stretch {
            direction: curvature.direction + turned,
            ratio: libm::pow(
                bounded,
                (SURE_DIRECTION * curvature.confidence).clamp(0.0, 1.0),
            )
            .max(1.0),
        }
    }
}

/// The distances, made shorter where they would grow too fast along the edges.
fn graded(surface: &Surface, mut distances: PerVertex<f64>, side: f64) -> PerVertex<f64> {
    let mesh = surface.mesh();
    let scale = side / mean_side(surface, &distances);
    let mut heap: BinaryHeap<_> = (distances.enumerate())
        // Sizes are positive: their bits are in their order.
        .map(|(vertex, size)| Reverse((size.to_bits(), vertex)))
        .collect();
    while let Some(Reverse((bits, vertex))) = heap.pop() {
        if bits != distances[vertex].to_bits() {
            continue;
        }
        for corner in mesh.outgoing(vertex) {
            for side in [corner, corner.previous()] {
                let [from, to] = mesh.ends(side);
                let other = if from == vertex { to } else { from };
                let way = surface.halfedge_vector(side).length();
                let most = distances[vertex] + GROWTH_OF_SIDES * way / scale;
                if most < distances[other] {
                    distances[other] = most;
                    heap.push(Reverse((most.to_bits(), other)));
                }
            }
        }
    }
    distances
}

/// The side of one quad of as many as there are with these sides, were all of the same area.
fn mean_side(surface: &Surface, distances: &PerVertex<f64>) -> f64 {
    let shapes = face_shapes(surface);
    let quads = shapes.enumerate().map(|(face, shape)| {
        let corners = surface.mesh().triangle(face).map(|v| distances[v]);
        shape.area() / (corners.iter().sum::<f64>() / 3.0).powi(2)
    });
    (total_area(&shapes) / quads.sum::<f64>()).sqrt()
}

/// The places of several densities, that of the finest first.
pub(super) fn finest_first(densities: &[GridDensity], surface: &Surface) -> Vec<usize> {
    let mut order: Vec<usize> = (0..densities.len()).collect();
    let side = |&place: &usize| side_length(surface, densities[place]);
    order.sort_by(|a, b| side(a).total_cmp(&side(b)));
    order
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use graticule_fixtures::{Fixture, grid, icosphere};

    use super::*;
    use crate::quads::{PolygonMesh, RemeshOptions, remesh, remesh_levels};

    fn surface(fixture: Fixture) -> Surface {
        Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
    }

    fn options(quads: usize, sizing: QuadSizing) -> RemeshOptions {
        RemeshOptions {
            density: GridDensity::Quads(quads),
            sizing,
            ..RemeshOptions::default()
        }
    }

    /// The mean length of the sides whose middle fits.
    fn mean_side(mesh: &PolygonMesh, fits: impl Fn(DVec3) -> bool) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for polygon in 0..mesh.polygons.len() {
            let corners = mesh.polygons.vertices(polygon);
            for (place, &from) in corners.iter().enumerate() {
                let to = corners[(place + 1) % corners.len()];
                let [from, to] = [from, to].map(|v| mesh.positions[v as usize]);
                if fits(from.midpoint(to)) {
                    sum += from.distance(to);
                    count += 1.0;
                }
            }
        }
        sum / count
    }

    fn is_near(found: usize, wanted: usize) -> bool {
        (found as f64 / wanted as f64 - 1.0).abs() < 0.05
    }

    #[test]
    fn sides_have_the_sizes_told_and_the_number_of_quads_is_met() {
        let surface = surface(icosphere(4));
        let size = |z: f64| if z > 0.0 { 1.0 + z } else { 1.0 };
        let sizes = surface.positions().iter().map(|p| size(p.z)).collect();
        let sizing = QuadSizing {
            sizes: Some(PerVertex::new(sizes)),
            ..QuadSizing::default()
        };
        let options = options(1500, sizing);
        let made = remesh(&surface, &options, &Watch::new()).unwrap();
        assert!(is_near(made.mesh.polygons.len(), 1500));
        let [top, bottom] =
            [0.8, -1.0].map(|low| mean_side(&made.mesh, |p| (low..low + 0.25).contains(&p.z)));
        assert!((1.5..2.2).contains(&(top / bottom)), "{top} {bottom}");
        let again = remesh(&surface, &options, &Watch::new()).unwrap();
        assert_eq!(made.mesh, again.mesh);
    }

    #[test]
    fn a_plane_gets_the_singularities_that_a_ramp_of_sizes_needs() {
        let surface = surface(grid(1.0, 1.0, 40, 40));
        let sizes = surface.positions().iter().map(|p| libm::pow(3.0, p.x));
        let sizing = QuadSizing {
            sizes: Some(PerVertex::new(sizes.collect())),
            ..QuadSizing::default()
        };
        let made = remesh(&surface, &options(1500, sizing), &Watch::new()).unwrap();
        assert!(made.field.singularities.count() >= 2);
        let [left, right] =
            [0.0, 0.9].map(|low| mean_side(&made.mesh, |p| (low..low + 0.1).contains(&p.x)));
        // Of 2.7 that the sizes tell; along the lines of the square alone it is 1.6.
        assert!((2.3..3.1).contains(&(right / left)), "{left} {right}");
    }

    #[test]
    fn sides_are_shorter_where_the_surface_bends_more() {
        // A lens: its rim bends four times as much as its faces.
        let lens = surface(icosphere(4).map(|p| DVec3::new(p.x, p.y, 0.5 * p.z)));
        let rim_over_face = |adaptivity| {
            let sizing = QuadSizing {
                adaptivity,
                ..QuadSizing::default()
            };
            let made = remesh(&lens, &options(1500, sizing), &Watch::new()).unwrap();
            assert!(is_near(made.mesh.polygons.len(), 1500));
            let rim = mean_side(&made.mesh, |p| p.z.abs() < 0.1);
            rim / mean_side(&made.mesh, |p| p.z.abs() > 0.45)
        };
        let [even, adapted] = [1.0, 3.0].map(rim_over_face);
        assert!(adapted < 0.92 * even, "{adapted} {even}");
    }

    #[test]
    fn quads_on_a_tube_are_as_long_as_the_anisotropy_says() {
        let flat = grid(1.0, 1.0, 40, 60);
        let tube = surface(flat.map(|p| {
            let (sin, cos) = libm::sincos(3.0 * p.x);
            DVec3::new(cos, sin, 4.0 * p.y)
        }));
        let sizing = QuadSizing {
            anisotropy: 3.0,
            ..QuadSizing::default()
        };
        let made = remesh(&tube, &options(600, sizing), &Watch::new()).unwrap();
        let (mut along, mut around) = ([0.0; 2], [0.0; 2]);
        for polygon in 0..made.mesh.polygons.len() {
            let corners = made.mesh.polygons.vertices(polygon);
            for (place, &from) in corners.iter().enumerate() {
                let to = corners[(place + 1) % corners.len()];
                let [from, to] = [from, to].map(|v| made.mesh.positions[v as usize]);
                let side = to - from;
                let sum = if side.z.abs() > 0.7 * side.length() {
                    &mut along
                } else {
                    &mut around
                };
                sum[0] += side.length();
                sum[1] += 1.0;
            }
        }
        let ratio = along[0] / along[1] / (around[0] / around[1]);
        assert!((2.2..3.6).contains(&ratio), "{ratio}");
    }

    #[test]
    fn several_densities_come_from_one_field_in_the_order_given() {
        let surface = surface(icosphere(4));
        let wanted = [600, 2400, 300];
        let options = options(1, QuadSizing::default());
        let levels = remesh_levels(
            &surface,
            &options,
            &wanted.map(GridDensity::Quads),
            &Watch::new(),
        );
        let levels = levels.unwrap();
        assert_eq!(levels.len(), 3);
        for (made, wanted) in levels.iter().zip(wanted) {
            made.mesh.check(&surface).unwrap();
            let found = made.mesh.polygons.len();
            assert!(is_near(found, wanted), "{found} for {wanted}");
            assert_eq!(made.field, levels[0].field);
        }
        let none = remesh_levels(&surface, &options, &[], &Watch::new());
        assert_eq!(none, Ok(vec![]));
    }

    #[test]
    fn sizes_out_of_range_are_refused() {
        let surface = surface(icosphere(1));
        let count = surface.mesh().vertex_count();
        let sizes = |count, size| QuadSizing {
            sizes: Some(PerVertex::filled(count, size)),
            ..QuadSizing::default()
        };
        let adaptivity = QuadSizing {
            adaptivity: 0.5,
            ..QuadSizing::default()
        };
        let anisotropy = QuadSizing {
            anisotropy: f64::NAN,
            ..QuadSizing::default()
        };
        for sizing in [sizes(3, 1.0), sizes(count, 0.0), adaptivity, anisotropy] {
            let refused = remesh(&surface, &options(100, sizing), &Watch::new());
            assert!(matches!(refused, Err(RemeshError::Map(_))), "{refused:?}");
        }
    }
}
