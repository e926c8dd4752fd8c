use glam::DVec2;
use serde::Serialize;

use crate::periodic::QuarterTurn;
use crate::tolerance::CHART_AGREEMENT;

/// Charts have sides of whole multiples of one over this, unless the boundary cuts them.
const FINEST_PART: f64 = 64.0;

/// How coordinates of one chart become those of its neighbour: `p` becomes `turn · p + shift`. The
/// shift is a multiple of the distance of lines: a whole number where all lines bound charts and none was
/// drawn closer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChartTransition {
    /// The turn, which comes first.
    pub turn: QuarterTurn,
    /// The shift.
    pub shift: DVec2,
}

impl ChartTransition {
    /// Coordinates in the neighbour.
    #[must_use]
    pub fn apply(self, point: DVec2) -> DVec2 {
        self.turn.apply(point) + self.shift
    }

    /// The transition that takes one pair of points to another.
    pub(super) fn between([a, b]: [DVec2; 2], [to_a, to_b]: [DVec2; 2]) -> Self {
        let turn = nearest_turn(b - a, to_b - to_a);
        let shift = to_a - turn.apply(a);
        Self { turn, shift }
    }

    /// The same with a shift without rounding errors.
    pub(super) fn rounded(self) -> Self {
        Self {
            shift: self.shift.map(exact_part),
            ..self
        }
    }
}

/// The nearest multiple of the finest part of a chart, if that is near.
pub(super) fn exact_part(coordinate: f64) -> f64 {
    let part = (coordinate * FINEST_PART).round() / FINEST_PART;
    if (part - coordinate).abs() < CHART_AGREEMENT {
        part
    } else {
        coordinate
    }
}

/// The turn that takes the first vector nearest to the second.
pub(super) fn nearest_turn(from: DVec2, to: DVec2) -> QuarterTurn {
    let [along, across] = [from.dot(to), from.perp_dot(to)];
    QuarterTurn::of_quarters(if along.abs() >= across.abs() {
        if along >= 0.0 { 0 } else { 2 }
    } else if across > 0.0 {
        1
    } else {
        3
    })
}
