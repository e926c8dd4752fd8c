//! What is minimised: a sum over triangles, and what may be added to it.

use glam::DVec2;
use robust::{Coord, orient2d};

use super::boundary::Obstacle;
use super::energy::{self, DistortionEnergy};
use super::system::NewtonSystem;
use crate::flatten::collapse_time::collapse_time;
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

    /// All that is in the way when `step` is made up to `limit` times.
    fn obstacles(&self, places: &[DVec2], step: &[DVec2], limit: f64) -> Vec<Obstacle>;

    /// Pairs of vertices that the Hessian couples although they share no triangle; those too that
    /// it would couple if everything reached `widened` times as far.
    fn couplings(&self, _places: &[DVec2], _widened: f64) -> Vec<[u32; 2]> {
        Vec::new()
    }
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

    /// By how much the energy of each triangle is above the least, times its weight.
    pub(super) fn strains(&self, places: &[DVec2]) -> impl Iterator<Item = f64> {
        let weighted = self.weights.iter().zip(&self.sources);
        let strain = |((&weight, source), images)| {
            weight * (energy::value(self.energy, source, images) - self.energy.least())
        };
        weighted.zip(self.images(places)).map(strain)
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

    fn obstacles(&self, places: &[DVec2], step: &[DVec2], limit: f64) -> Vec<Obstacle> {
        let moving = self.images(places).zip(self.images(step));
        let collapsing = moving
            .zip(&self.corners)
            .filter_map(|((images, steps), &corners)| {
                let time = collapse_time(images, steps);
                (time <= limit).then(|| Obstacle {
                    vertices: tip_first(corners, images),
                    time,
                })
            });
        collapsing.collect()
    }
}

/// The corners of a triangle, that opposite to its longest side first.
fn tip_first([a, b, c]: [u32; 3], [p, q, r]: [DVec2; 3]) -> [u32; 3] {
    let sides = [
        q.distance_squared(r),
        r.distance_squared(p),
        p.distance_squared(q),
    ];
    if sides[0] >= sides[1] && sides[0] >= sides[2] {
        [a, b, c]
    } else if sides[1] >= sides[2] {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Whether the corners turn counter-clockwise. Exact.
pub(in crate::flatten) fn is_upright(corners: [DVec2; 3]) -> bool {
    let [a, b, c] = corners.map(|p| Coord { x: p.x, y: p.y });
    orient2d(a, b, c) > 0.0
}
