//! What nonlinear functionals of a map measure: [DMA02] §5.
//!
//! [DMA02]: crate::papers::DMA02

use glam::DVec2;
use serde::Serialize;

use crate::measure::{Jacobian2, SourceTriangle};
use crate::mesh::{Element, FaceId, TriangleMesh};

use super::Patch;

/// A measure of what a map does to a patch, to be made small. Each is a mean, so that it can be
/// compared between patches, and each is least for a map without distortion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Functional {
    /// Mean over the edges of `(ℓ'² / ℓ² − 1)²`, ℓ' the length in the map: 0 for an isometry
    /// ([DMA02] §5.1).
    ///
    /// [DMA02]: crate::papers::DMA02
    #[default]
    EdgeLength,
    /// Mean over the triangles of `(a' / a − 1)²`, a' the signed area in the map: 0 if areas are
    /// kept ([DMA02] §5.1).
    ///
    /// [DMA02]: crate::papers::DMA02
    Area,
    /// Mean over the surface of the squared L² stretch, times the area of the map over that of the
    /// patch: 1 for an isometry ([`SSGH01`](crate::papers::SSGH01)). Infinite where a triangle
    /// collapses.
    Stretch,
    /// Mean over the surface of σ₁² + σ₂² + σ₁⁻² + σ₂⁻²: 4 for an isometry
    /// ([`SS15`](crate::papers::SS15)). Infinite where a triangle collapses.
    SymmetricDirichlet,
}

impl Functional {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::EdgeLength,
        Self::Area,
        Self::Stretch,
        Self::SymmetricDirichlet,
    ];

    /// Whether it is infinite where a triangle collapses.
    pub(super) fn is_barrier(self) -> bool {
        matches!(self, Self::Stretch | Self::SymmetricDirichlet)
    }
}

/// A patch prepared for functionals of its maps, all in unit lengths.
pub(super) struct Measured<'a> {
    functional: Functional,
    mesh: &'a TriangleMesh,
    /// Ends of the edges that have a length, and its inverse square.
    edges: Vec<([usize; 2], f64)>,
    /// The triangles that have a shape and are not left out.
    triangles: Vec<(FaceId, SourceTriangle)>,
    /// Their area.
    area: f64,
    /// What positions are multiplied by before they are measured.
    scale: f64,
}

impl<'a> Measured<'a> {
    pub(super) fn new(patch: &'a Patch, functional: Functional) -> Self {
        let (mesh, surface) = (patch.mesh(), patch.unit_surface());
        let edges = mesh.edges().filter_map(|edge| {
            let side = mesh.edge_halfedge(edge);
            let inverse = surface.halfedge_vector(side).length_squared().recip();
            let ends = mesh.ends(side).map(Element::index);
            inverse.is_finite().then_some((ends, inverse))
        });
        let triangles = mesh.faces().filter_map(|face| {
            let corners = surface.corner_positions(face);
            Some((face, SourceTriangle::from_positions(corners)?))
        });
        let triangles: Vec<_> = triangles.collect();
        Self {
            functional,
            mesh,
            edges: edges.collect(),
            area: triangles.iter().map(|(_, source)| source.area()).sum(),
            triangles,
            scale: 1.0,
        }
    }

    /// Measures maps after scaling them by this factor.
    pub(super) fn scaled(self, scale: f64) -> Self {
        Self { scale, ..self }
    }

    /// Leaves out triangles that `positions` turn over or collapse; their number. Only functionals
    /// that are infinite on collapsed triangles do without them.
    pub(super) fn leave_out_flipped(&mut self, positions: &[DVec2]) -> usize {
        if !self.functional.is_barrier() {
            return 0;
        }
        let before = self.triangles.len();
        let mesh = self.mesh;
        self.triangles.retain(|(face, source)| {
            let images = images(mesh, *face, positions);
            source.jacobian(images).determinant() > 0.0
        });
        self.area = self.triangles.iter().map(|(_, s)| s.area()).sum();
        before - self.triangles.len()
    }

    /// The ends of each edge with the inverse square of its length.
    pub(super) fn edges(&self) -> &[([usize; 2], f64)] {
        &self.edges
    }

    /// The triangles measured, with the corners' vertices.
    pub(super) fn triangles(&self) -> impl Iterator<Item = ([usize; 3], &SourceTriangle)> {
        let corners = |face: FaceId| self.mesh.triangle(face).map(Element::index);
        let triangles = self.triangles.iter();
        triangles.map(move |(face, source)| (corners(*face), source))
    }

    /// The functional of a map; infinite where it has no finite value.
    pub(super) fn value(&self, positions: &[DVec2]) -> f64 {
        let value = match self.functional {
            Functional::EdgeLength => self.edge_length(positions),
            _ => self.over_triangles(positions, |_, _| ()),
        };
        if value.is_nan() { f64::INFINITY } else { value }
    }

    /// The functional and its gradient by the position of each vertex of the patch.
    pub(super) fn gradient(&self, positions: &[DVec2]) -> (f64, Vec<DVec2>) {
        let mut gradient = vec![DVec2::ZERO; self.mesh.vertex_count()];
        if self.functional == Functional::EdgeLength {
            self.edge_length_gradient(positions, &mut gradient);
            return (self.value(positions), gradient);
        }
        let mut total_area = vec![DVec2::ZERO; gradient.len()];
        let mut sum = 0.0;
        let value = self.over_triangles(positions, |place, jacobian| {
            let (face, source) = &self.triangles[place];
            let corners = self.mesh.triangle(*face).map(Element::index);
            sum += source.area() * jacobian.determinant();
            let rows = self.derivative(jacobian, source.area());
            let of_area = cofactor(jacobian).map(|row| row * source.area() / self.area);
            for (corner, by_corner) in corners.into_iter().zip(source.corner_gradients()) {
                let along = |rows: [DVec2; 2]| DVec2::from(rows.map(|row| row.dot(by_corner)));
                gradient[corner] += along(rows) * self.scale;
                total_area[corner] += along(of_area) * self.scale;
            }
        });
        if self.functional == Functional::Stretch {
            let share = sum / self.area;
            for (gradient, by_area) in gradient.iter_mut().zip(&total_area) {
                *gradient = *gradient * share + *by_area * (value / share);
            }
        }
        (value, gradient)
    }

    fn edge_length(&self, positions: &[DVec2]) -> f64 {
        let terms = self.edges.iter().map(|&([i, j], inverse)| {
            let length = (positions[i] - positions[j]).length_squared();
            (self.scale * self.scale * length * inverse - 1.0).powi(2)
        });
        terms.sum::<f64>() / self.edges.len().max(1) as f64
    }

    fn edge_length_gradient(&self, positions: &[DVec2], gradient: &mut [DVec2]) {
        let square = self.scale * self.scale;
        let count = self.edges.len().max(1) as f64;
        for &([i, j], inverse) in &self.edges {
            let along = positions[i] - positions[j];
            let excess = square * along.length_squared() * inverse - 1.0;
            let push = along * (4.0 * excess * square * inverse / count);
            gradient[i] += push;
            gradient[j] -= push;
        }
    }

    /// The functional as a sum over the triangles; `visit` gets the place and the Jacobian of each.
    fn over_triangles(&self, positions: &[DVec2], mut visit: impl FnMut(usize, &Jacobian2)) -> f64 {
        let [mut sum, mut area] = [0.0; 2];
        for (place, (face, source)) in self.triangles.iter().enumerate() {
            let images = images(self.mesh, *face, positions).map(|p| p * self.scale);
            let jacobian = source.jacobian(images);
            let determinant = jacobian.determinant();
            if self.functional.is_barrier() && determinant <= 0.0 {
                return f64::INFINITY;
            }
            area += source.area() * determinant;
            sum += match self.functional {
                Functional::Stretch => source.area() * jacobian.squared_stretch(),
                Functional::SymmetricDirichlet => source.area() * jacobian.symmetric_dirichlet(),
                Functional::Area => (determinant - 1.0).powi(2),
                Functional::EdgeLength => 0.0,
            };
            visit(place, &jacobian);
        }
        match self.functional {
            Functional::Stretch => sum / self.area * (area / self.area),
            Functional::SymmetricDirichlet => sum / self.area,
            Functional::Area | Functional::EdgeLength => sum / self.triangles.len().max(1) as f64,
        }
    }

    /// The derivative of one triangle's term by the rows of its Jacobian; for the stretch without
    /// the factor of the map's area.
    fn derivative(&self, jacobian: &Jacobian2, area: f64) -> [DVec2; 2] {
        let share = area / self.area;
        match self.functional {
            Functional::Stretch => jacobian.squared_stretch_derivative().map(|row| row * share),
            Functional::SymmetricDirichlet => {
                let rows = jacobian.symmetric_dirichlet_derivative();
                rows.map(|row| row * share)
            }
            Functional::Area | Functional::EdgeLength => {
                let count = self.triangles.len().max(1) as f64;
                let by_determinant = 2.0 * (jacobian.determinant() - 1.0) / count;
                cofactor(jacobian).map(|row| row * by_determinant)
            }
        }
    }
}

/// The derivative of the determinant by the rows of the matrix.
pub(super) fn cofactor(jacobian: &Jacobian2) -> [DVec2; 2] {
    let [u, v] = jacobian.gradients();
    [DVec2::new(v.y, -v.x), DVec2::new(-u.y, u.x)]
}

fn images(mesh: &TriangleMesh, face: FaceId, positions: &[DVec2]) -> [DVec2; 3] {
    mesh.triangle(face).map(|vertex| positions[vertex.index()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Surface;
    use crate::watch::Watch;
    use graticule_fixtures::{Noise, bumpy_patch, irregular_disk};

    fn patch(fixture: graticule_fixtures::Fixture) -> Patch {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        Patch::new(surface, &Watch::new()).unwrap()
    }

    fn plane(patch: &Patch) -> Vec<DVec2> {
        let positions = patch.unit_surface().positions().iter();
        positions.map(|p| p.truncate()).collect()
    }

    #[test]
    fn an_isometry_has_the_least_value_and_no_gradient() {
        let patch = patch(irregular_disk(5, 2));
        let least = [0.0, 0.0, 1.0, 4.0];
        for (functional, least) in Functional::ALL.into_iter().zip(least) {
            let measured = Measured::new(&patch, functional);
            let (value, gradient) = measured.gradient(&plane(&patch));
            assert!((value - least).abs() < 1e-12, "{functional:?}: {value}");
            let steepest = gradient.iter().map(|g| g.length()).fold(0.0, f64::max);
            assert!(steepest < 1e-11, "{functional:?}: {steepest:e}");
        }
    }

    #[test]
    fn gradients_are_the_slopes_of_their_functionals() {
        let patch = patch(bumpy_patch(5, 3));
        let mut noise = Noise::new(4);
        let mut moved = plane(&patch);
        for p in &mut moved {
            *p += DVec2::new(noise.signed(), noise.signed()) * 0.01;
        }
        for functional in Functional::ALL {
            let measured = Measured::new(&patch, functional).scaled(1.3);
            let (value, gradient) = measured.gradient(&moved);
            assert!(value.is_finite());
            let size = gradient.iter().map(|g| g.length()).fold(0.0, f64::max);
            for vertex in (0..moved.len()).step_by(7) {
                for axis in [DVec2::X, DVec2::Y] {
                    let step = 1e-6;
                    let at = |distance: f64| {
                        let mut other = moved.clone();
                        other[vertex] += axis * distance;
                        measured.value(&other)
                    };
                    let slope = (at(step) - at(-step)) / (2.0 * step);
                    let error = (slope - gradient[vertex].dot(axis)).abs();
                    assert!(error < 1e-6 * size, "{functional:?}: {error:e} of {size:e}");
                }
            }
        }
    }

    #[test]
    fn a_flipped_triangle_is_infinitely_bad_or_left_out() {
        let patch = patch(irregular_disk(4, 1));
        let mut folded = plane(&patch);
        folded[0] += DVec2::new(3.0, 0.0);
        let mut measured = Measured::new(&patch, Functional::SymmetricDirichlet);
        assert!(measured.value(&folded).is_infinite());
        assert!(measured.leave_out_flipped(&folded) > 0);
        assert!(measured.value(&folded).is_finite());
        let mut polynomial = Measured::new(&patch, Functional::Area);
        assert_eq!(polynomial.leave_out_flipped(&folded), 0);
        assert!(polynomial.value(&folded).is_finite());
    }
}
