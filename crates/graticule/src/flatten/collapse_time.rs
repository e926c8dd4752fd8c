//! When a triangle that moves in the plane collapses.

use glam::DVec2;

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
}
