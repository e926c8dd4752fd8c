//! The two points of a set that lie farthest apart.

use glam::DVec3;

use crate::watch::{Stopped, Watch};

/// Points in one leaf of the hierarchy: small, as a leaf's box is what the bound is made of.
const LEAF: usize = 4;

/// Pairs of boxes after which the watch is asked again.
const STEPS_BETWEEN_LOOKS: usize = 4096;

/// The indices, ascending, of two points at the largest Euclidean distance; `None` for fewer than
/// two points.
///
/// Exact: branch and bound over boxes around runs of consecutive points, which are near each other
/// where the points follow curves. About `n^1.5` at worst for curves (a circle, where every point
/// is nearly as far from its opposite), nearly linear for others; quadratic for points that fill a
/// sphere.
///
/// # Errors
/// [`Stopped`] by the watch.
pub(super) fn farthest_pair(
    points: &[DVec3],
    watch: &Watch,
) -> Result<Option<[usize; 2]>, Stopped> {
    if points.len() < 2 {
        return Ok(None);
    }
    let boxes = Boxes::around(points);
    let mut best = double_sweep(points);
    let mut open = vec![[0..points.len(), 0..points.len()]];
    let mut steps = 0_usize;
    while let Some([a, b]) = open.pop() {
        if steps.is_multiple_of(STEPS_BETWEEN_LOOKS) {
            watch.check()?;
        }
        steps += 1;
        if boxes.distance_bound(&a, &b) <= best.distance_squared {
            continue;
        }
        if a.len() <= LEAF && b.len() <= LEAF {
            best.improve(points, a, &b);
        } else if a == b {
            let [left, right] = halves(&a);
            open.extend([
                [left.clone(), left.clone()],
                [right.clone(), right.clone()],
                [left, right],
            ]);
        } else if a.len() >= b.len() {
            open.extend(halves(&a).map(|half| [half, b.clone()]));
        } else {
            open.extend(halves(&b).map(|half| [a.clone(), half]));
        }
    }
    let [a, b] = best.pair;
    Ok(Some([a.min(b), a.max(b)]))
}

type Run = std::ops::Range<usize>;

struct Best {
    pair: [usize; 2],
    distance_squared: f64,
}

impl Best {
    fn improve(&mut self, points: &[DVec3], a: Run, b: &Run) {
        for i in a {
            for j in b.clone() {
                let distance_squared = points[i].distance_squared(points[j]);
                if distance_squared > self.distance_squared {
                    *self = Self {
                        pair: [i, j],
                        distance_squared,
                    };
                }
            }
        }
    }
}

/// A good pair to begin with: the point farthest from the first one, and the farthest from that.
fn double_sweep(points: &[DVec3]) -> Best {
    let mut best = Best {
        pair: [0, 1],
        distance_squared: points[0].distance_squared(points[1]),
    };
    for _ in 0..2 {
        let from = best.pair[1];
        best.improve(points, from..from + 1, &(0..points.len()));
    }
    best
}

/// Split where the hierarchy splits: the left half gets a power of two of leaves.
fn halves(run: &Run) -> [Run; 2] {
    let leaves = run.len().div_ceil(LEAF).next_power_of_two();
    let middle = run.start + LEAF * leaves / 2;
    [run.start..middle, middle..run.end]
}

/// Boxes around the runs that [`halves`] makes, as a binary heap.
struct Boxes {
    leaves: usize,
    heap: Vec<[DVec3; 2]>,
}

impl Boxes {
    fn around(points: &[DVec3]) -> Self {
        let leaves = points.len().div_ceil(LEAF).next_power_of_two();
        let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let mut heap = vec![empty; 2 * leaves];
        for (index, &point) in points.iter().enumerate() {
            let leaf = &mut heap[leaves + index / LEAF];
            *leaf = [leaf[0].min(point), leaf[1].max(point)];
        }
        for node in (1..leaves).rev() {
            let [left, right] = [heap[2 * node], heap[2 * node + 1]];
            heap[node] = [left[0].min(right[0]), left[1].max(right[1])];
        }
        Self { leaves, heap }
    }

    fn around_run(&self, run: &Run) -> [DVec3; 2] {
        let leaves = run.len().div_ceil(LEAF).next_power_of_two();
        self.heap[(self.leaves + run.start / LEAF) / leaves]
    }

    fn distance_bound(&self, a: &Run, b: &Run) -> f64 {
        let [low_a, high_a] = self.around_run(a);
        let [low_b, high_b] = self.around_run(b);
        (high_a - low_b).max(high_b - low_a).length_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    fn farthest(points: &[DVec3]) -> Option<[usize; 2]> {
        farthest_pair(points, &Watch::new()).unwrap()
    }

    #[test]
    fn points_that_fill_a_sphere_can_be_given_up() {
        let mut noise = Noise::new(2);
        let points = std::iter::repeat_with(|| {
            DVec3::new(noise.signed(), noise.signed(), noise.signed()).normalize_or(DVec3::X)
        });
        let points: Vec<_> = points.take(50_000).collect();
        let watch = Watch::new();
        watch.cancel_handle().cancel();
        assert!(farthest_pair(&points, &watch).is_err());
    }

    fn exhaustive(points: &[DVec3]) -> f64 {
        let distances = points
            .iter()
            .flat_map(|p| points.iter().map(|q| p.distance_squared(*q)));
        distances.fold(0.0, f64::max)
    }

    #[test]
    fn the_farthest_pair_is_that_of_an_exhaustive_search() {
        let mut noise = Noise::new(5);
        for count in (2..70).chain([500]) {
            let mut coordinate = || noise.signed();
            let points: Vec<_> = (0..count)
                .map(|_| DVec3::new(coordinate(), coordinate(), 0.3 * coordinate()))
                .collect();
            let [a, b] = farthest(&points).unwrap();
            assert!(a < b);
            let found = points[a].distance_squared(points[b]);
            assert!(found >= exhaustive(&points), "{count} points");
        }
    }

    #[test]
    fn a_circle_has_its_diameter_found_quickly() {
        let count = 20_000;
        let on_circle = |step: usize| {
            let angle = std::f64::consts::TAU * step as f64 / count as f64;
            DVec3::new(angle.cos(), angle.sin(), 0.0)
        };
        let points: Vec<_> = (0..count).map(on_circle).collect();
        let [a, b] = farthest(&points).unwrap();
        assert!((points[a].distance(points[b]) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn points_that_coincide_are_a_pair_too() {
        assert_eq!(farthest(&[DVec3::ONE; 3]), Some([0, 1]));
        assert_eq!(farthest(&[DVec3::ONE]), None);
    }
}
