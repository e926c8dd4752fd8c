//! What keeps triangles from being squeezed flat while a functional is lowered that would let them.
//!
//! The functionals of edge lengths and areas cost no more than 1 for a triangle that collapses. A
//! descent that may flip none then stops at the first one that it has squeezed flat, far from any
//! minimum. A barrier on the shapes of such triangles lets it see them coming.

use glam::DVec2;

use crate::measure::{Jacobian2, SourceTriangle};
use crate::tolerance::{GUARD_WEIGHT, GUARDED_SHAPE};

use super::functional::{Measured, cofactor};

/// `w/n Σ (s/q − 1)²` over the triangles with `q < s`; `q = 2 σ₁σ₂ / (σ₁² + σ₂²)` is 1 for a similarity
/// and 0 for a collapsed triangle, whatever its size.
pub(super) struct ShapeGuard {
    /// The triangles that are to keep their sense.
    triangles: Vec<([usize; 3], SourceTriangle)>,
}

impl ShapeGuard {
    /// Guards the triangles that `positions` lay down rightly.
    pub(super) fn new(measured: &Measured<'_>, positions: &[DVec2]) -> Self {
        let is_upright = |(corners, source): &([usize; 3], &SourceTriangle)| {
            let images = corners.map(|corner| positions[corner]);
            source.jacobian(images).determinant() > 0.0
        };
        let triangles = measured.triangles().filter(is_upright);
        Self {
            triangles: triangles
                .map(|(corners, source)| (corners, *source))
                .collect(),
        }
    }

    /// Infinite where a guarded triangle has collapsed.
    pub(super) fn value(&self, positions: &[DVec2]) -> f64 {
        let terms = self.jacobians(positions).map(|(_, _, jacobian)| {
            let shape = shape(&jacobian);
            if shape <= 0.0 {
                f64::INFINITY
            } else {
                (GUARDED_SHAPE / shape - 1.0).max(0.0).powi(2)
            }
        });
        self.weight() * terms.sum::<f64>()
    }

    /// Adds the gradient by the position of each vertex.
    pub(super) fn add_gradient(&self, positions: &[DVec2], gradient: &mut [DVec2]) {
        for (corners, source, jacobian) in self.jacobians(positions) {
            let shape = shape(&jacobian);
            if shape >= GUARDED_SHAPE {
                continue;
            }
            let by_shape = -2.0 * (GUARDED_SHAPE / shape - 1.0) * GUARDED_SHAPE / (shape * shape);
            let norm = jacobian.norm_squared();
            let [du, dv] = cofactor(&jacobian);
            let [u, v] = jacobian.gradients();
            let rows = [du - u * shape, dv - v * shape]
                .map(|row| row * (2.0 / norm) * by_shape * self.weight());
            for (corner, by_corner) in corners.into_iter().zip(source.corner_gradients()) {
                gradient[corner] += DVec2::from(rows.map(|row| row.dot(by_corner)));
            }
        }
    }

    fn weight(&self) -> f64 {
        GUARD_WEIGHT / self.triangles.len().max(1) as f64
    }

    fn jacobians(
        &self,
        positions: &[DVec2],
    ) -> impl Iterator<Item = ([usize; 3], &SourceTriangle, Jacobian2)> {
        self.triangles.iter().map(|(corners, source)| {
            let images = corners.map(|corner| positions[corner]);
            (*corners, source, source.jacobian(images))
        })
    }
}

fn shape(jacobian: &Jacobian2) -> f64 {
    2.0 * jacobian.determinant() / jacobian.norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{Functional, Patch};
    use crate::mesh::Surface;
    use crate::watch::Watch;
    use graticule_fixtures::{Noise, bumpy_patch};

    #[test]
    fn the_barrier_has_the_slope_of_differences_and_leaves_good_shapes_alone() {
        let fixture = bumpy_patch(4, 3);
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let patch = Patch::new(surface, &Watch::new()).unwrap();
        let flat = patch.unit_surface().positions().iter();
        let flat: Vec<DVec2> = flat.map(|p| p.truncate()).collect();
        let measured = Measured::new(&patch, Functional::EdgeLength);
        let guard = ShapeGuard::new(&measured, &flat);
        assert!(guard.value(&flat).abs() < f64::MIN_POSITIVE);
        let mut noise = Noise::new(4);
        let squeezed = flat
            .iter()
            .map(|p| DVec2::new(p.x, 0.03 * (p.y + 1e-3 * noise.signed())));
        let squeezed: Vec<DVec2> = squeezed.collect();
        let mut gradient = vec![DVec2::ZERO; flat.len()];
        guard.add_gradient(&squeezed, &mut gradient);
        assert!(guard.value(&squeezed) > 0.0);
        let size = gradient.iter().map(|g| g.length()).fold(0.0, f64::max);
        for vertex in 0..flat.len() {
            for axis in [DVec2::X, DVec2::Y] {
                let step = 1e-8;
                let at = |distance: f64| {
                    let mut moved = squeezed.clone();
                    moved[vertex] += axis * distance;
                    guard.value(&moved)
                };
                let slope = (at(step) - at(-step)) / (2.0 * step);
                let error = (slope - gradient[vertex].dot(axis)).abs();
                assert!(error < 1e-5 * size, "{error:e} of {size:e}");
            }
        }
        let mirrored: Vec<DVec2> = flat.iter().map(|p| DVec2::new(-p.x, p.y)).collect();
        assert!(guard.value(&mirrored).is_infinite());
    }
}
