//! What is minimised: a sum over triangles, and what may be added to it.

use glam::DVec2;
use robust::{Coord, orient2d};

use super::energy::{self, DistortionEnergy};
use super::system::NewtonSystem;
use crate::measure::SourceTriangle;

/// A function of the places of vertices, to be minimised over the maps it admits.
pub(super) trait Objective {
    /// The value; infinite outside the admissible maps. Exact in that no inadmissible map has a
    /// finite value.
    fn value(&self, places: &[DVec2]) -> f64;

    /// Adds gradient and Hessian at an admissible map; of negative curvatures only the share `kept`,
    /// so that with none the Hessian is positive.
    fn expand_into(&self, places: &[DVec2], kept: f64, system: &mut NewtonSystem);

    /// How many times `step` may be made before the map stops being admissible; infinite where it
    /// never does.
    fn first_obstacle(&self, places: &[DVec2], step: &[DVec2]) -> f64;
}

/// The mean distortion of triangles. Admissible are maps that flip and collapse none of them.
#[derive(Debug)]
pub(super) struct Triangles {
    energy: DistortionEnergy,
    corners: Vec<[u32; 3]>,
    sources: Vec<SourceTriangle>,
    /// How much each triangle counts; their sum is 1.
    weights: Vec<f64>,
}

impl Triangles {
    /// Triangles with their shapes and with weights of any sum.
    pub(super) fn new(
        energy: DistortionEnergy,
        corners: Vec<[u32; 3]>,
        sources: Vec<SourceTriangle>,
        mut weights: Vec<f64>,
    ) -> Self {
        let sum: f64 = weights.iter().sum();
        for weight in &mut weights {
            *weight /= sum;
        }
        Self {
            energy,
            corners,
            sources,
            weights,
        }
    }

    /// The vertices of each triangle.
    pub(super) fn corners(&self) -> &[[u32; 3]] {
        &self.corners
    }

    fn images(&self, places: &[DVec2]) -> impl Iterator<Item = [DVec2; 3]> {
        let corners = self.corners.iter();
        corners.map(|triangle| triangle.map(|vertex| places[vertex as usize]))
    }

    /// The scale of the whole map at which the energy is least.
    pub(super) fn best_scale(&self, places: &[DVec2]) -> f64 {
        if self.energy == DistortionEnergy::Mips {
            return 1.0;
        }
        let (mut stretched, mut shrunk) = (0.0, 0.0);
        for (index, images) in self.images(places).enumerate() {
            let jacobian = self.sources[index].jacobian(images);
            let norm = jacobian.norm_squared();
            stretched += self.weights[index] * norm;
            shrunk += self.weights[index] * norm / jacobian.determinant().powi(2);
        }
        (shrunk / stretched).sqrt().sqrt()
    }
}

impl Objective for Triangles {
    fn value(&self, places: &[DVec2]) -> f64 {
        let mut sum = 0.0;
        for (index, images) in self.images(places).enumerate() {
            if !is_upright(images) {
                return f64::INFINITY;
            }
            sum += self.weights[index] * energy::value(self.energy, &self.sources[index], images);
        }
        sum
    }

    fn expand_into(&self, places: &[DVec2], kept: f64, system: &mut NewtonSystem) {
        for (index, images) in self.images(places).enumerate() {
            let expansion = energy::expand(self.energy, &self.sources[index], images, kept);
            system.add_triangle(index, self.corners[index], self.weights[index], &expansion);
        }
    }

    fn first_obstacle(&self, places: &[DVec2], step: &[DVec2]) -> f64 {
        let steps = self.images(step);
        let times = self
            .images(places)
            .zip(steps)
            .map(|(p, s)| collapse_time(p, s));
        times.fold(f64::INFINITY, f64::min)
    }
}

/// Whether the corners turn counter-clockwise. Exact.
pub(super) fn is_upright(corners: [DVec2; 3]) -> bool {
    let [a, b, c] = corners.map(|p| Coord { x: p.x, y: p.y });
    orient2d(a, b, c) > 0.0
}

/// The first time above 0 at which a triangle with a positive area that moves by `steps` in a unit
/// of time has none; infinite if it always has one (Smith and Schaefer 2015, §4).
pub(super) fn collapse_time(corners: [DVec2; 3], steps: [DVec2; 3]) -> f64 {
    let [p, q] = [corners[1] - corners[0], corners[2] - corners[0]];
    let [r, s] = [steps[1] - steps[0], steps[2] - steps[0]];
    let constant = p.perp_dot(q);
    let linear = p.perp_dot(s) + r.perp_dot(q);
    first_root([r.perp_dot(s), linear, constant])
}

/// The least positive root of `a t² + b t + c`, or infinity. With c ≤ 0 it is 0.
pub(super) fn first_root([a, b, c]: [f64; 3]) -> f64 {
    // Not `<=`: what is not a number must not let a step pass.
    let positive = c > 0.0;
    if !positive {
        return 0.0;
    }
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return f64::INFINITY;
    }
    // 2c / (−b + √…) is the first root in every case: no cancellation where b < 0.
    let denominator = discriminant.sqrt() - b;
    if b < 0.0 {
        return 2.0 * c / denominator;
    }
    if a < 0.0 {
        return (discriminant.sqrt() + b) / (-2.0 * a);
    }
    f64::INFINITY
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_root_is_found_in_every_case() {
        assert!((first_root([1.0, -3.0, 2.0]) - 1.0).abs() < 1e-15);
        assert!((first_root([-1.0, 1.0, 2.0]) - 2.0).abs() < 1e-15);
        assert!((first_root([-1.0, -1.0, 2.0]) - 1.0).abs() < 1e-15);
        assert!((first_root([0.0, -1.0, 2.0]) - 2.0).abs() < 1e-15);
        assert!((first_root([1e-300, -1.0, 1e-9]) - 1e-9).abs() < 1e-24);
        assert!(first_root([1.0, 3.0, 2.0]).is_infinite());
        assert!(first_root([1.0, 0.0, 2.0]).is_infinite());
        assert!(first_root([0.0, 0.0, 2.0]).is_infinite());
        assert_eq!(first_root([1.0, 1.0, 0.0]), 0.0);
    }

    #[test]
    fn a_triangle_collapses_when_its_tip_meets_its_base() {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::new(0.3, 2.0)];
        let falling = [DVec2::ZERO, DVec2::ZERO, DVec2::NEG_Y];
        assert!((collapse_time(corners, falling) - 2.0).abs() < 1e-15);
        let drifting = [DVec2::X; 3];
        assert!(collapse_time(corners, drifting).is_infinite());
    }
}
