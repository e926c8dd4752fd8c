use std::f64::consts::TAU;

use glam::DVec2;
use serde::Serialize;

/// How many directions a field has at each point, evenly spread over the turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Symmetry {
    /// One direction: angles count modulo 2π, singularities are whole poles.
    Vector,
    /// A line: angles count modulo π, singularities are half-poles.
    Line,
    /// Four directions at right angles: angles count modulo π/2, singularities are quarter-poles.
    #[default]
    Cross,
}

impl Symmetry {
    /// The number of directions: 1, 2 or 4.
    #[inline]
    #[must_use]
    pub fn order(self) -> u32 {
        match self {
            Self::Vector => 1,
            Self::Line => 2,
            Self::Cross => 4,
        }
    }

    /// The angle between one direction and the next: 2π, π or π/2.
    #[inline]
    #[must_use]
    pub fn step(self) -> f64 {
        TAU / f64::from(self.order())
    }

    /// The symmetry of this order, if it is 1, 2 or 4.
    #[must_use]
    pub fn of_order(order: u32) -> Option<Self> {
        [Self::Vector, Self::Line, Self::Cross]
            .into_iter()
            .find(|s| s.order() == order)
    }

    /// The unit vector whose angle is `order` times this one: the same for all directions of the
    /// field, which is what makes sums and differences of it meaningful ([PGP06] §4.2; the text has
    /// multiplication and division the wrong way round).
    ///
    /// [PGP06]: crate::papers::PGP06
    #[inline]
    #[must_use]
    pub fn power(self, angle: f64) -> DVec2 {
        let (sin, cos) = libm::sincos(f64::from(self.order()) * angle);
        DVec2::new(cos, sin)
    }

    /// One of the angles whose [`power`](Self::power) points along the vector, in
    /// `-step/2..=step/2`; 0 for the zero vector.
    #[inline]
    #[must_use]
    pub fn root(self, power: DVec2) -> f64 {
        libm::atan2(power.y, power.x) / f64::from(self.order())
    }

    /// The angle less the nearest multiple of the step, in `-step/2..=step/2`, and that multiple.
    #[inline]
    #[must_use]
    pub fn reduce(self, angle: f64) -> (f64, i32) {
        let turns = (angle / self.step()).round();
        (angle - turns * self.step(), turns as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_directions_of_a_field_have_the_same_power() {
        for symmetry in [Symmetry::Vector, Symmetry::Line, Symmetry::Cross] {
            for turn in 0..symmetry.order() {
                let other = 0.3 + f64::from(turn) * symmetry.step();
                assert!(symmetry.power(other).distance(symmetry.power(0.3)) < 1e-14);
            }
            assert!((symmetry.root(symmetry.power(0.3)) - 0.3).abs() < 1e-15);
            assert_eq!(Symmetry::of_order(symmetry.order()), Some(symmetry));
        }
        assert_eq!(Symmetry::of_order(3), None);
    }

    #[test]
    fn reducing_leaves_the_part_within_half_a_step() {
        let (rest, turns) = Symmetry::Cross.reduce(5.0);
        assert_eq!(turns, 3);
        assert!((rest + 3.0 * Symmetry::Cross.step() - 5.0).abs() < 1e-15);
    }
}
