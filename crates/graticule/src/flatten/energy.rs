//! The energies of a map from a surface to the plane.

use faer::c64;
use glam::DVec2;
use serde::Serialize;

use crate::geometry::TriangleShape;
use crate::mesh::{PerFace, PerVertex, TriangleMesh};

/// What a piecewise linear map does to lengths and areas, summed over the surface.
///
/// With σ₁ ≥ |σ₂| the singular values of the map's derivative on a triangle (σ₂ < 0 where it turns
/// the triangle over) and a sum over the triangles weighted by their area on the surface.
/// `dirichlet = area + conformal` holds exactly, which is why `dirichlet ≥ area` with equality for
/// conformal maps only: [DMA02] Eq. 1 for the functional of §3.2.
///
/// [DMA02]: crate::papers::DMA02
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MapEnergy {
    /// Dirichlet energy, Σ (σ₁² + σ₂²) / 2. Unit: area of the map.
    pub dirichlet: f64,
    /// Signed area of the map, Σ σ₁ σ₂.
    pub area: f64,
    /// Conformal energy, Σ (σ₁ − σ₂)² / 2; zero only if angles are kept.
    pub conformal: f64,
}

impl MapEnergy {
    /// The energies of the map that takes each vertex to `uv`.
    ///
    /// Triangles without area on the surface are left out. Linear time.
    #[must_use]
    pub fn of(mesh: &TriangleMesh, shapes: &PerFace<TriangleShape>, uv: &PerVertex<DVec2>) -> Self {
        let corners = |face| mesh.triangle(face).map(|vertex| complex(uv[vertex]));
        Self::of_triangles(
            shapes
                .enumerate()
                .map(|(face, shape)| (shape, corners(face))),
        )
    }

    /// The energies of a map of triangles that goes to these complex positions of their corners.
    pub(super) fn of_triangles<'a>(
        triangles: impl Iterator<Item = (&'a TriangleShape, [c64; 3])>,
    ) -> Self {
        let mut sum = Self::default();
        for (shape, corners) in triangles {
            let Some([holomorphic, antiholomorphic]) = derivatives(shape, corners) else {
                continue;
            };
            let kept = shape.area() * holomorphic.norm_sqr();
            let lost = shape.area() * antiholomorphic.norm_sqr();
            sum.dirichlet += kept + lost;
            sum.area += kept - lost;
            sum.conformal += 2.0 * lost;
        }
        sum
    }

    pub(super) fn over(self, area: f64) -> Self {
        Self {
            dirichlet: self.dirichlet / area,
            area: self.area / area,
            conformal: self.conformal / area,
        }
    }

    /// Conformal over Dirichlet energy, in `0.0..=2.0`: 0 for a conformal map, 1 for a map of no
    /// area, 2 for a mirrored conformal map.
    #[must_use]
    pub fn conformal_share(&self) -> f64 {
        if self.dirichlet > 0.0 {
            self.conformal / self.dirichlet
        } else {
            0.0
        }
    }
}

/// ∂f and ∂̄f of the linear map on a triangle, the plane taken as complex numbers:
/// `f(w) = ∂f·w + ∂̄f·w̄` with `w` in the triangle's own plane. `None` for a triangle without area.
fn derivatives(shape: &TriangleShape, [a, b, c]: [c64; 3]) -> Option<[c64; 2]> {
    let [_, base, apex] = shape.corners();
    let along = (b - a) / base.x;
    let apex = complex(apex);
    let antiholomorphic = (along * apex - (c - a)) / c64::new(0.0, 2.0 * apex.im);
    let result = [along - antiholomorphic, antiholomorphic];
    let finite = result.iter().all(|d| d.re.is_finite() && d.im.is_finite());
    finite.then_some(result)
}

/// A point of the plane as a complex number.
pub(super) fn complex(point: DVec2) -> c64 {
    c64::new(point.x, point.y)
}

/// A complex number as a point of the plane.
pub(super) fn point(number: c64) -> DVec2 {
    DVec2::new(number.re, number.im)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{corner_cotangents, face_shapes};
    use crate::mesh::Surface;
    use graticule_fixtures::{Noise, bumpy_patch};

    fn surface() -> Surface {
        let fixture = bumpy_patch(6, 3);
        Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
    }

    #[test]
    fn a_linear_map_of_a_plane_has_the_energies_of_its_singular_values() {
        let fixture = graticule_fixtures::irregular_disk(5, 1);
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let shapes = face_shapes(&surface);
        let total = crate::geometry::total_area(&shapes);
        let uv = surface
            .positions()
            .map(|p| DVec2::new(3.0 * p.x, -0.5 * p.y));
        let energy = MapEnergy::of(surface.mesh(), &shapes, &uv);
        let close = |a: f64, b: f64| assert!((a - b * total).abs() < 1e-12 * total, "{a} {b}");
        close(energy.dirichlet, f64::midpoint(9.0, 0.25));
        close(energy.area, -1.5);
        close(energy.conformal, 3.5 * 3.5 / 2.0);
    }

    #[test]
    fn the_sum_over_triangles_is_the_cotangent_sum_over_edges() {
        let surface = surface();
        let mesh = surface.mesh();
        let shapes = face_shapes(&surface);
        let mut noise = Noise::new(9);
        let uv = surface
            .positions()
            .map(|_| DVec2::new(noise.signed(), noise.signed()));
        let cotangents = corner_cotangents(&shapes).unwrap();
        // [DMA02] Eq. 3 sums cot |u_i − u_j|² over the oriented edges: four times the energy that
        // equals the area on the identity.
        let over_edges: f64 = mesh
            .halfedges()
            .map(|side| {
                let [a, b] = mesh.ends(side);
                cotangents[side.previous()] * uv[a].distance_squared(uv[b])
            })
            .sum();
        let energy = MapEnergy::of(mesh, &shapes, &uv);
        assert!((energy.dirichlet - over_edges / 4.0).abs() < 1e-11 * energy.dirichlet);
        assert!(
            (energy.dirichlet - energy.area - energy.conformal).abs() < 1e-12 * energy.dirichlet
        );
    }
}
