//! When a triangle that moves in the plane collapses.

use glam::DVec2;

/// The first time above 0 at which a triangle with a positive area that moves by `steps` in a unit
/// of time has none; infinite if it always has one (Smith and Schaefer 2015, §4).
pub(super) fn collapse_time(corners: [DVec2; 3], steps: [DVec2; 3]) -> f64 {
    first_root(area_by_time(corners, steps))
}

/// The first time above 0 at which the first of three moving points lies on the segment between the
/// others, which it does not at time 0; infinite if it never does.
pub(super) fn meeting_time(points: [DVec2; 3], steps: [DVec2; 3]) -> f64 {
    let at = |time: f64| {
        let [p, a, b] = std::array::from_fn(|k| points[k] + steps[k] * time);
        // On the line of a and b, p is between them if it sees them in opposite directions.
        (a - p).dot(b - p) <= 0.0
    };
    let [a, b, c] = area_by_time(points, steps);
    let turned = if c < 0.0 { [-a, -b, -c] } else { [a, b, c] };
    let first = first_root(turned);
    if first > 0.0 && (first.is_infinite() || at(first)) {
        return first;
    }
    // The other root, by the product or the sum of both.
    let other = if c == 0.0 { -b / a } else { c / (a * first) };
    if other > 0.0 && other.is_finite() && at(other) {
        return other;
    }
    f64::INFINITY
}

/// Twice the signed area of a moving triangle: the coefficients of t², t and 1.
fn area_by_time(corners: [DVec2; 3], steps: [DVec2; 3]) -> [f64; 3] {
    let [p, q] = [corners[1] - corners[0], corners[2] - corners[0]];
    let [r, s] = [steps[1] - steps[0], steps[2] - steps[0]];
    [r.perp_dot(s), p.perp_dot(s) + r.perp_dot(q), p.perp_dot(q)]
}

/// The least positive root of `a t² + b t + c`, or infinity. With c ≤ 0 it is 0.
fn first_root([a, b, c]: [f64; 3]) -> f64 {
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
        assert!(first_root([1.0, 1.0, 0.0]).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn a_triangle_collapses_when_its_tip_meets_its_base() {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::new(0.3, 2.0)];
        let falling = [DVec2::ZERO, DVec2::ZERO, DVec2::NEG_Y];
        assert!((collapse_time(corners, falling) - 2.0).abs() < 1e-15);
        let drifting = [DVec2::X; 3];
        assert!(collapse_time(corners, drifting).is_infinite());
    }

    #[test]
    fn a_point_meets_a_segment_at_either_root_or_never() {
        let [a, b] = [DVec2::ZERO, DVec2::X];
        let down = [DVec2::NEG_Y, DVec2::ZERO, DVec2::ZERO];
        let meeting = |x: f64, steps| meeting_time([DVec2::new(x, 2.0), a, b], steps);
        assert!((meeting(0.3, down) - 2.0).abs() < 1e-15);
        assert!(meeting(1.3, down).is_infinite());
        assert!(meeting(0.3, [DVec2::Y, DVec2::ZERO, DVec2::ZERO]).is_infinite());
        // From the other side of the line.
        let up = [DVec2::Y, DVec2::ZERO, DVec2::ZERO];
        assert!((meeting_time([DVec2::new(0.3, -2.0), a, b], up) - 2.0).abs() < 1e-15);
        // The segment's line sweeps over the point beyond its end.
        let points = [DVec2::new(3.0, 1.0), a, b];
        let steps = [DVec2::ZERO, DVec2::ZERO, DVec2::new(1.0, 1.0)];
        assert!(meeting_time(points, steps).is_infinite());
        let points = [DVec2::new(2.0, 1.0), a, b];
        let steps = [DVec2::new(-1.0, -0.6), DVec2::ZERO, DVec2::new(1.0, 0.1)];
        let time = meeting_time(points, steps);
        let [p, q] = [points[0] + steps[0] * time, points[2] + steps[2] * time];
        assert!(
            p.perp_dot(q).abs() < 1e-12 && (a - p).dot(q - p) <= 0.0,
            "{time}"
        );
    }
}
