//! The rectangle of least area around points: one of its sides holds a side of their convex hull
//! (Freeman and Shapira 1975).

use glam::DVec2;
use robust::{Coord, orient2d};

/// The rotation, by cosine and sine, after which the box of the points has the least area, and that
/// box: lowest, highest corner. Its longer side is horizontal.
pub(super) fn least_rectangle(points: &[DVec2]) -> (DVec2, [DVec2; 2]) {
    let hull = convex_hull(points);
    let sides = (0..hull.len()).map(|i| hull[(i + 1) % hull.len()] - hull[i]);
    let mut best = (DVec2::X, bounds(&hull, DVec2::X));
    for direction in sides.filter_map(DVec2::try_normalize) {
        let rotation = DVec2::new(direction.x, -direction.y);
        let candidate = bounds(&hull, rotation);
        if area(candidate) < area(best.1) {
            best = (rotation, candidate);
        }
    }
    let size = best.1[1] - best.1[0];
    if size.y > size.x {
        let rotation = best.0.perp();
        best = (rotation, bounds(&hull, rotation));
    }
    best
}

/// Directions tried for a square in a quarter turn, beside those of the hull's sides.
const DIRECTIONS: u32 = 90;

/// The rotation, by cosine and sine, after which the box of the points fits into the smallest
/// square that it finds, and that box.
pub(super) fn least_square(points: &[DVec2]) -> (DVec2, [DVec2; 2]) {
    let hull = convex_hull(points);
    let even = (0..DIRECTIONS).map(|step| {
        let angle = std::f64::consts::FRAC_PI_2 * f64::from(step) / f64::from(DIRECTIONS);
        DVec2::new(libm::cos(angle), libm::sin(angle))
    });
    let sides = (0..hull.len()).map(|i| hull[(i + 1) % hull.len()] - hull[i]);
    let sides = sides
        .filter_map(DVec2::try_normalize)
        .map(|side| DVec2::new(side.x, -side.y));
    let boxes = even
        .chain(sides)
        .map(|rotation| (rotation, bounds(&hull, rotation)));
    let side = |[low, high]: [DVec2; 2]| (high - low).max_element();
    let smaller = |a: (DVec2, [DVec2; 2]), b: (DVec2, [DVec2; 2])| {
        if side(b.1) < side(a.1) { b } else { a }
    };
    boxes
        .reduce(smaller)
        .unwrap_or((DVec2::X, [DVec2::ZERO; 2]))
}

fn area([low, high]: [DVec2; 2]) -> f64 {
    (high.x - low.x) * (high.y - low.y)
}

fn bounds(points: &[DVec2], rotation: DVec2) -> [DVec2; 2] {
    let Some(&first) = points.first() else {
        return [DVec2::ZERO; 2];
    };
    let first = rotation.rotate(first);
    points.iter().fold([first, first], |[low, high], &point| {
        let point = rotation.rotate(point);
        [low.min(point), high.max(point)]
    })
}

/// The convex hull, counter-clockwise, by Andrew's monotone chain with exact predicates.
fn convex_hull(points: &[DVec2]) -> Vec<DVec2> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut hull = chain(sorted.iter().copied());
    hull.pop();
    hull.extend(chain(sorted.into_iter().rev()));
    hull.pop();
    hull
}

fn chain(points: impl Iterator<Item = DVec2>) -> Vec<DVec2> {
    let mut chain: Vec<DVec2> = Vec::new();
    for point in points {
        while let [.., a, b] = chain[..] {
            let [a, b, c] = [a, b, point].map(|p| Coord { x: p.x, y: p.y });
            if orient2d(a, b, c) > 0.0 {
                break;
            }
            chain.pop();
        }
        chain.push(point);
    }
    chain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_grid_is_its_four_corners() {
        let points: Vec<_> = (0..25)
            .map(|k| DVec2::new(f64::from(k % 5), f64::from(k / 5)))
            .collect();
        assert_eq!(convex_hull(&points).len(), 4);
        assert_eq!(convex_hull(&[DVec2::ONE; 7]).len(), 1);
        assert_eq!(convex_hull(&[]).len(), 0);
    }

    #[test]
    fn a_needle_fits_into_the_smallest_square_along_its_diagonal() {
        let (_, [low, high]) = least_square(&[DVec2::ZERO, DVec2::X]);
        let side = (high - low).max_element();
        assert!((side - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-12);
    }

    #[test]
    fn a_turned_rectangle_is_found() {
        let turn = DVec2::from_angle(1.1);
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 5.0), (0.0, 5.0), (0.5, 2.0)];
        let points = corners.map(|(x, y)| turn.rotate(DVec2::new(x, y)));
        let (_, [low, high]) = least_rectangle(&points);
        assert!((high - low).distance(DVec2::new(5.0, 1.0)) < 1e-12);
    }
}
