//! The place of a vertex among those around it, such that none of its triangles is flipped.

use glam::DVec2;

use super::energy::{self, DistortionEnergy};
use super::objective::is_upright;
use crate::flatten::collapse_time::collapse_time;
use crate::measure::SourceTriangle;
use crate::tolerance::{SHARE_TO_COLLAPSE, SUFFICIENT_DECREASE};

/// Steps towards the best place.
const STEPS: usize = 40;

/// Halvings of a distance, down to the last digits of coordinates of size 1.
const MOST_HALVINGS: usize = 60;

/// Halvings along a boundary edge. If so near to its end there is no place, only rounding could
/// make one look admissible further on.
const EDGE_HALVINGS: usize = 12;

/// A vertex to be placed: the sides opposite to it of its triangles, turning about it
/// counter-clockwise.
pub(super) struct Star<'a> {
    /// The sides' ends.
    pub(super) sides: Vec<[DVec2; 2]>,
    /// The shapes of the triangles, the vertex their first corner.
    pub(super) sources: Vec<SourceTriangle>,
    /// How much each triangle counts.
    pub(super) weights: &'a [f64],
    pub(super) energy: DistortionEnergy,
}

impl Star<'_> {
    /// Whether no triangle is flipped or collapsed with the vertex there. Exact.
    pub(super) fn admits(&self, place: DVec2) -> bool {
        place.is_finite() && self.sides.iter().all(|&[a, b]| is_upright([place, a, b]))
    }

    /// An admissible place: the middle of the neighbours if it is one, else one near `target`,
    /// which is one of them.
    pub(super) fn inner_place(&self, target: DVec2) -> Option<DVec2> {
        let middle = self.middle();
        if self.admits(middle) {
            return Some(middle);
        }
        let mut at_target = self.sides.iter().filter(|side| side.contains(&target));
        let sides = [*at_target.next()?, *at_target.next()?];
        self.place_near(target, sides, |_| true)
    }

    /// An admissible place on the boundary edge between `target` and `other`, or near `target`
    /// where the triangles there turn by more than half a circle; such that `is_clear` has nothing
    /// against it.
    pub(super) fn boundary_place(
        &self,
        [target, other]: [DVec2; 2],
        is_clear: impl Fn(DVec2) -> bool,
    ) -> Option<DVec2> {
        let along = |share: f64| target.lerp(other, 0.5 * share);
        let will_do = |place| self.admits(place) && is_clear(place);
        let on_edge = first_where(along, EDGE_HALVINGS, will_do);
        on_edge.or_else(|| {
            let side = *self.sides.iter().find(|side| side.contains(&target))?;
            // The boundary comes from where the sides end and goes to where they start.
            let edge = if side[0] == target {
                [other, target]
            } else {
                [target, other]
            };
            self.place_near(target, [side, edge], is_clear)
        })
    }

    /// Near the target only the two sides that meet there matter: the place must lie to the left of
    /// both, so it is looked for half way between them.
    fn place_near(
        &self,
        target: DVec2,
        sides: [[DVec2; 2]; 2],
        is_clear: impl Fn(DVec2) -> bool,
    ) -> Option<DVec2> {
        let [first, second] = sides.map(|[a, b]| (b - a).normalize_or_zero().perp());
        let direction = (first + second).normalize_or_zero();
        let reach = self.middle().distance(target);
        let near = |share: f64| target + direction * (reach * share);
        first_where(near, MOST_HALVINGS, |place| {
            self.admits(place) && is_clear(place)
        })
    }

    fn middle(&self) -> DVec2 {
        let ends = self.sides.iter().map(|side| side[0].midpoint(side[1]));
        ends.sum::<DVec2>() / self.sides.len() as f64
    }

    /// An admissible place beyond the boundary edge that the vertex's only triangle stands on, such
    /// that `is_clear` has nothing against it.
    pub(super) fn outer_place(&self, is_clear: impl Fn(DVec2) -> bool) -> Option<DVec2> {
        let &[a, b] = self.sides.first()?;
        let beyond = |share: f64| a.midpoint(b) + (b - a).perp() * share;
        first_where(beyond, MOST_HALVINGS, |place| {
            self.admits(place) && is_clear(place)
        })
    }

    /// A better place than an admissible one, by a few Newton steps.
    pub(super) fn improved(&self, mut place: DVec2) -> DVec2 {
        let mut energy = self.value(place);
        for _ in 0..STEPS {
            let (gradient, [xx, xy, yy]) = self.expand(place);
            let determinant = xx * yy - xy * xy;
            let direction = -DVec2::new(
                yy * gradient.x - xy * gradient.y,
                xx * gradient.y - xy * gradient.x,
            ) / determinant;
            if !direction.is_finite() {
                break;
            }
            let slope = gradient.dot(direction);
            let Some((next, value)) = self.step(place, direction, [energy, slope]) else {
                break;
            };
            let gain = energy - value;
            (place, energy) = (next, value);
            if gain < SUFFICIENT_DECREASE * energy {
                break;
            }
        }
        place
    }

    fn step(
        &self,
        place: DVec2,
        direction: DVec2,
        [energy, slope]: [f64; 2],
    ) -> Option<(DVec2, f64)> {
        let still = [direction, DVec2::ZERO, DVec2::ZERO];
        let times = self
            .sides
            .iter()
            .map(|&[a, b]| collapse_time([place, a, b], still));
        let mut step = (SHARE_TO_COLLAPSE * times.fold(f64::INFINITY, f64::min)).min(1.0);
        for _ in 0..STEPS {
            let next = place + direction * step;
            let value = self.value(next);
            if value <= energy + SUFFICIENT_DECREASE * step * slope
                && value < energy
                && self.admits(next)
            {
                return Some((next, value));
            }
            step *= 0.5;
        }
        None
    }

    fn value(&self, place: DVec2) -> f64 {
        let triangles = self.triangles(place);
        triangles
            .map(|(weight, source, images)| weight * energy::value(self.energy, source, images))
            .sum()
    }

    fn expand(&self, place: DVec2) -> (DVec2, [f64; 3]) {
        let mut sum = (DVec2::ZERO, [0.0; 3]);
        for (weight, source, images) in self.triangles(place) {
            let (gradient, hessian) = energy::expand(self.energy, source, images, 0.0).of_corner(0);
            sum.0 += weight * gradient;
            for (total, entry) in sum.1.iter_mut().zip(hessian) {
                *total += weight * entry;
            }
        }
        sum
    }

    fn triangles(&self, place: DVec2) -> impl Iterator<Item = (f64, &SourceTriangle, [DVec2; 3])> {
        let weighted = self.weights.iter().zip(&self.sources).zip(&self.sides);
        weighted.map(move |((&weight, source), &[a, b])| (weight, source, [place, a, b]))
    }
}

/// The first of the places at shares 1, 1/2, 1/4 … that will do.
pub(super) fn first_where(
    place: impl Fn(f64) -> DVec2,
    halvings: usize,
    will_do: impl Fn(DVec2) -> bool,
) -> Option<DVec2> {
    let mut share = 1.0;
    for _ in 0..halvings {
        let place = place(share);
        if will_do(place) {
            return Some(place);
        }
        share *= 0.5;
    }
    None
}
