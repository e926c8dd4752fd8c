//! The corner from which a polygon is best cut into a fan.

use glam::DVec2;
use robust::{Coord, orient2d};

/// The corner of a plane polygon from which a fan of triangles turns over the fewest of them, the
/// first of several such; the fan turns the way the polygon does on the whole. Exact.
///
/// Most readers of mesh files cut each polygon into the fan from its first corner. A polygon that is
/// convex in space need not be so in a map.
///
/// Cost: linear for convex polygons, else up to quadratic.
///
/// ```
/// use glam::DVec2;
/// // A dart is cut through its dent.
/// let dart = [[0., 0.], [2., 1.], [0., 2.], [0.5, 1.]].map(DVec2::from);
/// assert_eq!(graticule::mesh::fan_apex(&dart), 1);
/// ```
#[must_use]
pub fn fan_apex(corners: &[DVec2]) -> usize {
    let double_area = |corners: &[DVec2]| -> f64 {
        let from = |k: usize| corners[k] - corners[0];
        (2..corners.len())
            .map(|k| from(k - 1).perp_dot(from(k)))
            .sum()
    };
    if corners.len() < 4 {
        return 0;
    }
    let sense = double_area(corners).signum();
    let mut best = (usize::MAX, 0);
    for apex in 0..corners.len() {
        let turned = turned_over(corners, apex, sense);
        best = best.min((turned, apex));
        if turned == 0 {
            break;
        }
    }
    best.1
}

/// How many triangles of the fan from a corner do not turn in the given sense.
fn turned_over(corners: &[DVec2], apex: usize, sense: f64) -> usize {
    let count = corners.len();
    let corner = |step: usize| {
        let DVec2 { x, y } = corners[(apex + step) % count];
        Coord { x, y }
    };
    let turn = |step: usize| orient2d(corner(0), corner(step), corner(step + 1));
    (1..count - 1)
        .filter(|&step| turn(step) * sense <= 0.0)
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points<const N: usize>(points: [[f64; 2]; N]) -> [DVec2; N] {
        points.map(DVec2::from)
    }

    #[test]
    fn a_convex_polygon_keeps_its_first_corner() {
        for mirrored in [1.0, -1.0] {
            let hexagon: Vec<DVec2> = (0..6)
                .map(|k| DVec2::from_angle(mirrored * f64::from(k)))
                .collect();
            assert_eq!(fan_apex(&hexagon), 0);
        }
    }

    #[test]
    fn a_dart_is_cut_through_its_dent_however_it_turns() {
        let dart = points([[0.0, 0.0], [1.0, 0.2], [2.0, 0.0], [1.0, 2.0]]);
        assert_eq!(fan_apex(&dart), 1);
        let mirrored = dart.map(|p| DVec2::new(-p.x, p.y));
        assert_eq!(fan_apex(&mirrored), 1);
    }

    #[test]
    fn where_no_fan_will_do_the_least_bad_is_taken() {
        // The letter U: no corner sees both arms.
        let u = points([
            [0.0, 3.0],
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [2.0, 3.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 3.0],
        ]);
        let apex = fan_apex(&u);
        let turned: Vec<_> = (0..u.len()).map(|k| turned_over(&u, k, 1.0)).collect();
        assert_eq!(turned[apex], *turned.iter().min().unwrap());
        assert!(turned[apex] > 0);
    }

    #[test]
    fn a_corner_without_angle_is_no_apex() {
        // Corner 0 lies on the side from 3 to 1.
        let quad = points([[1.0, 0.0], [2.0, 0.0], [1.0, 1.0], [0.0, 0.0]]);
        assert_eq!(fan_apex(&quad), 0);
        assert_eq!(fan_apex(&[quad[3], quad[0], quad[1], quad[2]]), 1);
    }
}
