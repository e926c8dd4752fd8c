use glam::DVec2;
use serde::Serialize;

/// A turn by 0, 1, 2 or 3 quarters of a circle, counter-clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
pub struct QuarterTurn(u8);

impl QuarterTurn {
    /// No turn.
    pub const NONE: Self = Self(0);
    /// The turn that takes the x axis to the y axis.
    pub const LEFT: Self = Self(1);
    /// The turn to the opposite direction.
    pub const BACK: Self = Self(2);
    /// The turn that takes the y axis to the x axis.
    pub const RIGHT: Self = Self(3);

    /// The turn by this many quarters, modulo 4.
    #[inline]
    #[must_use]
    pub fn of_quarters(quarters: i32) -> Self {
        Self(quarters.rem_euclid(4) as u8)
    }

    /// The number of quarters: 0, 1, 2 or 3.
    #[inline]
    #[must_use]
    pub fn quarters(self) -> u8 {
        self.0
    }

    /// The turn back.
    #[inline]
    #[must_use]
    pub fn inverse(self) -> Self {
        Self((4 - self.0) % 4)
    }

    /// This turn, then the other.
    #[inline]
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        Self((self.0 + next.0) % 4)
    }

    /// Turns a vector. Exact: coordinates change places and signs.
    #[inline]
    #[must_use]
    pub fn apply(self, vector: DVec2) -> DVec2 {
        match self.0 {
            0 => vector,
            1 => DVec2::new(-vector.y, vector.x),
            2 => -vector,
            _ => DVec2::new(vector.y, -vector.x),
        }
    }

    /// Turns a vector of whole numbers.
    #[inline]
    #[must_use]
    pub fn apply_whole(self, [x, y]: [i32; 2]) -> [i32; 2] {
        match self.0 {
            0 => [x, y],
            1 => [y.wrapping_neg(), x],
            2 => [x.wrapping_neg(), y.wrapping_neg()],
            _ => [y, x.wrapping_neg()],
        }
    }
}

/// How coordinates go over from one triangle to the next: `p` becomes `turn · p + shift`
/// ([PGP06] Eq. 16, with one line spacing as unit).
///
/// Turning and shifting whole numbers takes the set of lines with whole coordinates to itself.
/// Shifts that leave the range of `i32` wrap round.
///
/// [PGP06]: crate::papers::PGP06
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
pub struct Transition {
    /// The turn, which comes first.
    pub turn: QuarterTurn,
    /// The shift, in line spacings.
    pub shift: [i32; 2],
}

impl Transition {
    /// The transition that changes nothing.
    #[must_use]
    pub fn identity() -> Self {
        Self::default()
    }

    /// Whether nothing changes.
    #[must_use]
    pub fn is_identity(self) -> bool {
        self == Self::default()
    }

    /// The way back.
    #[inline]
    #[must_use]
    pub fn inverse(self) -> Self {
        let turn = self.turn.inverse();
        let shift = turn.then(QuarterTurn::BACK).apply_whole(self.shift);
        Self { turn, shift }
    }

    /// This transition, then the other.
    #[inline]
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        let [x, y] = next.turn.apply_whole(self.shift);
        Self {
            turn: self.turn.then(next.turn),
            shift: [x.wrapping_add(next.shift[0]), y.wrapping_add(next.shift[1])],
        }
    }

    /// Coordinates on the other side. Exact for coordinates of a [`GridMap`](super::GridMap).
    #[inline]
    #[must_use]
    pub fn apply(self, point: DVec2) -> DVec2 {
        let [x, y] = self.shift.map(f64::from);
        self.turn.apply(point) + DVec2::new(x, y)
    }

    /// The point that the transition leaves in place, a multiple of one half; `None` where it does
    /// not turn.
    #[must_use]
    pub fn fixed_point(self) -> Option<DVec2> {
        let [x, y] = self.shift.map(f64::from);
        let twice = match self.turn.0 {
            0 => return None,
            1 => DVec2::new(x - y, x + y),
            2 => DVec2::new(x, y),
            _ => DVec2::new(x + y, y - x),
        };
        Some(twice / 2.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some_transitions() -> impl Iterator<Item = Transition> {
        (0..4).flat_map(|quarters| {
            [[0, 0], [3, -1], [-7, 2], [5, 5]].map(|shift| Transition {
                turn: QuarterTurn::of_quarters(quarters),
                shift,
            })
        })
    }

    #[test]
    fn four_quarters_are_no_turn_and_two_turn_back() {
        let point = DVec2::new(0.25, -3.5);
        assert_eq!(QuarterTurn::LEFT.apply(DVec2::X), DVec2::Y);
        let twice = QuarterTurn::LEFT.then(QuarterTurn::LEFT);
        assert_eq!(twice.apply(point), -point);
        assert_eq!(twice.then(twice), QuarterTurn::NONE);
        assert_eq!(QuarterTurn::of_quarters(-1), QuarterTurn::RIGHT);
    }

    #[test]
    fn a_transition_and_its_inverse_cancel() {
        let point = DVec2::new(1.5, 0.375);
        for transition in some_transitions() {
            assert!(transition.then(transition.inverse()).is_identity());
            assert_eq!(transition.inverse().apply(transition.apply(point)), point);
        }
    }

    #[test]
    fn applying_two_transitions_is_applying_their_composition() {
        let point = DVec2::new(-2.25, 10.5);
        for first in some_transitions() {
            for second in some_transitions() {
                assert_eq!(
                    first.then(second).apply(point),
                    second.apply(first.apply(point))
                );
            }
        }
    }

    #[test]
    fn a_fixed_point_stays_in_place_and_only_turns_have_one() {
        for transition in some_transitions() {
            match transition.fixed_point() {
                Some(point) => assert_eq!(transition.apply(point), point),
                None => assert_eq!(transition.turn, QuarterTurn::NONE),
            }
        }
    }
}
