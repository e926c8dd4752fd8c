//! Lines of the net and exact places on them.
//!
//! Coordinates of a [`GridMap`] are multiples of 2^-32 below 2^20: as whole numbers of such steps
//! they have 53 bits, so that every comparison below is exact in 128.

use crate::mesh::HalfedgeId;
use crate::periodic::{GRID_STEPS, GridMap, Transition};

/// Steps of the coordinates in one line spacing.
pub(super) const STEPS: i64 = 1 << 32;

/// No line of a family passes.
pub(super) const NO_LINE: i32 = i32::MIN;

/// A point of the parameter plane, in steps.
pub(super) type Steps = [i64; 2];

/// The lines that pass through a point: the one along which the first coordinate is this whole
/// number, and the one along which the second is; [`NO_LINE`] for none.
pub(super) type Lines = [i32; 2];

/// The coordinates of a corner, in steps.
pub(super) fn corner_steps(map: &GridMap, corner: HalfedgeId) -> Steps {
    (map.coordinate(corner) * GRID_STEPS)
        .to_array()
        .map(|coordinate| coordinate as i64)
}

/// The lines through a point.
pub(super) fn lines_through(point: Steps) -> Lines {
    point.map(|steps| {
        if steps % STEPS == 0 {
            (steps / STEPS) as i32
        } else {
            NO_LINE
        }
    })
}

/// The same lines in the coordinates on the other side of a transition.
pub(super) fn lines_beyond(lines: Lines, transition: Transition) -> Lines {
    let moved = |line: i32, sign: i32, shift: i32| {
        if line == NO_LINE {
            NO_LINE
        } else {
            sign * line + shift
        }
    };
    let ([x, y], [a, b]) = (lines, transition.shift);
    match transition.turn.quarters() {
        0 => [moved(x, 1, a), moved(y, 1, b)],
        1 => [moved(y, -1, a), moved(x, 1, b)],
        2 => [moved(x, -1, a), moved(y, -1, b)],
        _ => [moved(y, 1, a), moved(x, -1, b)],
    }
}

/// A coordinate at a place where the other one reaches a line: `numerator / denominator` spacings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ratio {
    numerator: i128,
    denominator: i128,
}

impl Ratio {
    /// The coordinate number `1 - axis` where, between two points, the coordinate number `axis`
    /// reaches a line; it must differ at the two points.
    pub(super) fn across(axis: usize, line: i32, [from, to]: [Steps; 2]) -> Self {
        let wide = |steps: i64| i128::from(steps);
        let run = wide(to[axis] - from[axis]);
        let part = wide(i64::from(line) * STEPS - from[axis]);
        let other = 1 - axis;
        let numerator = wide(from[other]) * run + part * wide(to[other] - from[other]);
        Self {
            numerator: numerator * run.signum(),
            denominator: run.abs() * wide(STEPS),
        }
    }

    /// A coordinate of a point.
    pub(super) fn of_steps(steps: i64) -> Self {
        Self {
            numerator: i128::from(steps),
            denominator: i128::from(STEPS),
        }
    }

    fn floor(self) -> i32 {
        self.numerator.div_euclid(self.denominator) as i32
    }

    fn ceiling(self) -> i32 {
        -(-self.numerator).div_euclid(self.denominator) as i32
    }

    /// The whole numbers strictly between two coordinates.
    pub(super) fn wholes_between(self, other: Self) -> std::ops::Range<i32> {
        let ascending = self.floor() + 1..other.ceiling();
        if ascending.is_empty() {
            other.floor() + 1..self.ceiling()
        } else {
            ascending
        }
    }
}

/// The share of the way from `from` to `to` at which a coordinate reaches a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    numerator: i64,
    denominator: i64,
}

impl Share {
    /// `from` and `to` must differ.
    pub(super) fn at(line: i32, from: i64, to: i64) -> Self {
        let (numerator, denominator) = (i64::from(line) * STEPS - from, to - from);
        let sign = denominator.signum();
        Self {
            numerator: sign * numerator,
            denominator: sign * denominator,
        }
    }

    pub(super) fn compare(self, other: Self) -> std::cmp::Ordering {
        let product = |a: i64, b: i64| i128::from(a) * i128::from(b);
        product(self.numerator, other.denominator).cmp(&product(other.numerator, self.denominator))
    }

    pub(super) fn value(self) -> f64 {
        self.numerator as f64 / self.denominator as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::periodic::QuarterTurn;
    use glam::DVec2;

    #[test]
    fn lines_go_over_like_the_points_on_them() {
        let point = DVec2::new(3.0, -2.0);
        for quarters in 0..4 {
            let step = Transition {
                turn: QuarterTurn::of_quarters(quarters),
                shift: [5, -1],
            };
            let there = step.apply(point).to_array().map(|c| c as i32);
            assert_eq!(lines_beyond([3, -2], step), there);
            let one = lines_beyond([3, NO_LINE], step);
            assert_eq!(one.iter().filter(|&&line| line == NO_LINE).count(), 1);
            assert!(one.iter().zip(there).all(|(&l, t)| l == NO_LINE || l == t));
        }
    }

    #[test]
    fn wholes_between_two_coordinates_leave_the_ends_out() {
        let halves = |a: i64, b: i64| {
            let [a, b] = [a, b].map(|half| Ratio::of_steps(half * STEPS / 2));
            a.wholes_between(b)
        };
        assert_eq!(halves(0, 6), 1..3);
        assert_eq!(halves(7, 1), 1..4);
        assert_eq!(halves(-3, 3), -1..2);
        assert!(halves(2, 4).is_empty());
        assert!(halves(3, 3).is_empty());
    }

    #[test]
    fn the_other_coordinate_at_a_line_is_interpolated_exactly() {
        let ends = [[0, 0], [3 * STEPS, 6 * STEPS]];
        let at_one = Ratio::across(0, 1, ends);
        assert_eq!([at_one.floor(), at_one.ceiling()], [2, 2]);
        let back = Ratio::across(1, 3, [ends[1], ends[0]]);
        assert_eq!([back.floor(), back.ceiling()], [1, 2]);
    }

    #[test]
    fn shares_compare_exactly() {
        let third = Share::at(1, 0, 3 * STEPS);
        let nearly = Share::at(1, 1, 3 * STEPS + 1);
        assert_eq!(third.compare(third), std::cmp::Ordering::Equal);
        assert_eq!(third.compare(nearly), std::cmp::Ordering::Greater);
        assert_eq!(
            Share::at(2, 3 * STEPS, 0).compare(third),
            std::cmp::Ordering::Equal
        );
    }
}
