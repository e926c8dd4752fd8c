use glam::DVec3;

use super::polygons::area;

/// Steps of the sequence that spreads points evenly over the unit square: the inverse powers of
/// the root of x³ = x + 1 (M. Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*,
/// 2018).
const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) triangle: usize,
    pub(super) position: DVec3,
}

/// `count` points spread evenly over the area of the triangles, always the same; none where there
/// is no area.
pub(super) fn spread_over_triangles(triangles: &[[DVec3; 3]], count: usize) -> Vec<Sample> {
    let shares = Shares::new(triangles.iter().map(|&triangle| area(triangle)), count);
    shares
        .enumerate()
        .map(|(number, (triangle, _))| {
            let [across, along] = STEPS.map(|step| ((number as f64 + 0.5) * step).fract());
            let [a, b, c] = triangles[triangle];
            let root = across.sqrt();
            let position = a * (1.0 - root) + b * (root * (1.0 - along)) + c * (root * along);
            Sample { triangle, position }
        })
        .collect()
}

/// Evenly spaced points along segments, each with its segment.
pub(super) fn spread_along(segments: &[[DVec3; 2]], count: usize) -> Vec<(usize, DVec3)> {
    let lengths = segments.iter().map(|[from, to]| from.distance(*to));
    Shares::new(lengths, count)
        .map(|(segment, share)| {
            (
                segment,
                segments[segment][0].lerp(segments[segment][1], share),
            )
        })
        .collect()
}

/// Evenly spaced values of a sum that grows item by item: in which item each lies, and how far.
struct Shares {
    reached: Vec<f64>,
    item: usize,
    number: usize,
    count: usize,
}

impl Shares {
    fn new(sizes: impl Iterator<Item = f64>, count: usize) -> Self {
        let mut sum = 0.0;
        let reached: Vec<f64> = sizes
            .map(|size| {
                sum += size;
                sum
            })
            .collect();
        Self {
            count: if sum > 0.0 { count } else { 0 },
            reached,
            item: 0,
            number: 0,
        }
    }
}

impl Iterator for Shares {
    type Item = (usize, f64);

    fn next(&mut self) -> Option<(usize, f64)> {
        if self.number == self.count {
            return None;
        }
        let whole = self.reached.last()?;
        let wanted = (self.number as f64 + 0.5) / self.count as f64 * whole;
        self.number += 1;
        while self.item + 1 < self.reached.len() && self.reached[self.item] <= wanted {
            self.item += 1;
        }
        let before = self
            .item
            .checked_sub(1)
            .map_or(0.0, |item| self.reached[item]);
        let size = self.reached[self.item] - before;
        Some((self.item, ((wanted - before) / size).clamp(0.0, 1.0)))
    }
}
