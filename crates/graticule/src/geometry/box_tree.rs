use std::ops::Range;

use rayon::prelude::*;

/// Boxes in a leaf, and children of a node.
const GROUP: usize = 8;

/// Most nodes that wait during a search: seven at each level of a tree of 2^32 items, and a group.
const WAITING: usize = 7 * 11 + GROUP;

/// An axis-aligned box in space of `D` dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds<const D: usize> {
    pub(crate) low: [f64; D],
    pub(crate) high: [f64; D],
}

impl<const D: usize> Bounds<D> {
    pub(crate) fn around(points: &[impl Into<[f64; D]> + Copy]) -> Self {
        points.iter().fold(Self::EMPTY, |bounds, &point| {
            let point = point.into();
            bounds.join(&Self {
                low: point,
                high: point,
            })
        })
    }

    const EMPTY: Self = Self {
        low: [f64::INFINITY; D],
        high: [f64::NEG_INFINITY; D],
    };

    fn join(mut self, other: &Self) -> Self {
        for axis in 0..D {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
        self
    }

    /// Whether the boxes share more than boundary points: what lies strictly inside both shapes
    /// that the boxes surround lies strictly inside both boxes.
    #[inline]
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        (0..D).all(|axis| self.low[axis] < other.high[axis] && other.low[axis] < self.high[axis])
    }

    /// The squared distance of a point from the box; 0 inside.
    #[inline]
    fn squared_distance(&self, point: &[f64; D]) -> f64 {
        let sides = self.low.iter().zip(&self.high).zip(point);
        let outside = sides.map(|((low, high), x)| (low - x).max(x - high).max(0.0));
        outside.map(|outside| outside * outside).sum()
    }
}

/// A static tree of boxes, packed bottom-up along a Morton curve through their centres.
///
/// Built in O(n log n). Searching costs O(log n) and the leaves met, as long as few boxes overlap
/// each other; boxes of long diagonal shapes side by side all overlap, whatever the shapes do.
#[derive(Clone, Debug)]
pub(crate) struct BoxTree<const D: usize> {
    /// The items in the order of the leaves.
    items: Vec<u32>,
    /// The boxes in the order of `items`.
    bounds: Vec<Bounds<D>>,
    /// Boxes around groups, leaves first, the root last.
    levels: Vec<Vec<Bounds<D>>>,
}

impl<const D: usize> BoxTree<D> {
    pub(crate) fn new(boxes: &[Bounds<D>]) -> Self {
        let all = boxes.iter().fold(Bounds::EMPTY, Bounds::join);
        let mut keys: Vec<(u64, u32)> = boxes
            .par_iter()
            .enumerate()
            .map(|(item, bounds)| (morton_key(bounds, &all), item as u32))
            .collect();
        keys.par_sort_unstable();
        let items: Vec<u32> = keys.into_iter().map(|(_, item)| item).collect();
        let bounds: Vec<_> = items.iter().map(|&item| boxes[item as usize]).collect();
        let mut levels = vec![groups(&bounds)];
        while let Some(last) = levels.last().filter(|last| last.len() > 1) {
            levels.push(groups(last));
        }
        Self {
            items,
            bounds,
            levels,
        }
    }

    pub(crate) fn leaf_count(&self) -> usize {
        self.levels[0].len()
    }

    /// The ranks of the items in a leaf.
    pub(crate) fn leaf(&self, leaf: usize) -> Range<usize> {
        GROUP * leaf..(GROUP * (leaf + 1)).min(self.items.len())
    }

    /// The item at a rank.
    #[inline]
    pub(crate) fn item(&self, rank: usize) -> usize {
        self.items[rank] as usize
    }

    /// The ranks of the items in `leaves` whose boxes overlap that of the item at `rank`, itself
    /// included if it has an area.
    pub(crate) fn overlapping<'a>(
        &'a self,
        rank: usize,
        leaves: &'a [usize],
    ) -> impl Iterator<Item = usize> + 'a {
        let target = &self.bounds[rank];
        leaves
            .iter()
            .filter(|&&leaf| self.levels[0][leaf].overlaps(target))
            .flat_map(|&leaf| self.leaf(leaf))
            .filter(|&other| self.bounds[other].overlaps(target))
    }

    /// Puts the leaves from number `first` on whose boxes overlap that of `leaf` into `found`.
    pub(crate) fn overlapping_leaves(&self, leaf: usize, first: usize, found: &mut Vec<usize>) {
        found.clear();
        let target = self.levels[0][leaf];
        let mut stack = vec![(self.levels.len() - 1, 0)];
        while let Some((level, node)) = stack.pop() {
            let last_leaf = (node + 1) * GROUP.pow(level as u32) - 1;
            if last_leaf < first || !self.levels[level][node].overlaps(&target) {
                continue;
            }
            if level == 0 {
                found.push(node);
                continue;
            }
            stack.extend(
                self.children(level, node)
                    .rev()
                    .map(|child| (level - 1, child)),
            );
        }
    }

    /// Whether the test holds for one of the pairs of items whose boxes overlap. Each pair is tried
    /// once, in the same order in every run, until one passes.
    pub(crate) fn any_overlapping_pair(&self, mut test: impl FnMut(usize, usize) -> bool) -> bool {
        let mut found = Vec::new();
        (0..self.leaf_count()).any(|leaf| {
            self.overlapping_leaves(leaf, leaf, &mut found);
            self.leaf(leaf).any(|rank| {
                let mut others = self.overlapping(rank, &found).filter(|&other| rank < other);
                others.any(|other| test(self.item(rank), self.item(other)))
            })
        })
    }

    fn children(&self, level: usize, node: usize) -> Range<usize> {
        GROUP * node..(GROUP * (node + 1)).min(self.levels[level - 1].len())
    }

    /// The item of least squared distance from `point`, if that is below `limit`, and the distance.
    ///
    /// `squared_distance` tells that of an item, which is at least that of its box; items of which
    /// it says infinity are not found. Of items equally far the first one met counts, which is the
    /// same in every run.
    pub(crate) fn nearest(
        &self,
        point: [f64; D],
        limit: f64,
        mut squared_distance: impl FnMut(usize) -> f64,
    ) -> Option<(usize, f64)> {
        let mut found = None;
        let mut least = limit;
        let mut waiting = Waiting::new(self.levels.len() - 1, self.leaf_count());
        while let Some((distance, level, node)) = waiting.pop() {
            if distance >= least {
                continue;
            }
            if level > 0 {
                let boxes = &self.levels[level - 1];
                let children = self.children(level, node);
                let far = |child: usize| boxes[child].squared_distance(&point);
                waiting.push_nearest_last(children.map(|child| (far(child), child)), level - 1);
                continue;
            }
            for rank in self.leaf(node) {
                if self.bounds[rank].squared_distance(&point) < least {
                    let distance = squared_distance(self.item(rank));
                    if distance < least {
                        least = distance;
                        found = Some((self.item(rank), distance));
                    }
                }
            }
        }
        found
    }
}

/// Nodes still to be searched, with their squared distances; on the stack of the thread, as a
/// search takes less time than an allocation.
struct Waiting {
    nodes: [(f64, u32, u32); WAITING],
    count: usize,
}

impl Waiting {
    /// The root alone, or nothing for an empty tree.
    fn new(root_level: usize, leaf_count: usize) -> Self {
        let nodes = [(0.0, root_level as u32, 0); WAITING];
        let count = usize::from(leaf_count > 0);
        Self { nodes, count }
    }

    fn pop(&mut self) -> Option<(f64, usize, usize)> {
        self.count = self.count.checked_sub(1)?;
        let (distance, level, node) = self.nodes[self.count];
        Some((distance, level as usize, node as usize))
    }

    /// Adds nodes so that the nearest comes out first.
    fn push_nearest_last(&mut self, nodes: impl Iterator<Item = (f64, usize)>, level: usize) {
        let first = self.count;
        for (distance, node) in nodes {
            let mut place = self.count;
            while place > first && self.nodes[place - 1].0 < distance {
                self.nodes[place] = self.nodes[place - 1];
                place -= 1;
            }
            self.nodes[place] = (distance, level as u32, node as u32);
            self.count += 1;
        }
    }
}

fn groups<const D: usize>(boxes: &[Bounds<D>]) -> Vec<Bounds<D>> {
    boxes
        .chunks(GROUP)
        .map(|group| group.iter().fold(Bounds::EMPTY, Bounds::join))
        .collect()
}

/// The interleaved bits of the centre's coordinates, as many of each as 64 bits hold.
fn morton_key<const D: usize>(bounds: &Bounds<D>, all: &Bounds<D>) -> u64 {
    let bits = 64 / D as u32;
    let cells = libm::ldexp(1.0, i32::try_from(bits).unwrap_or(0)) - 1.0;
    (0..D).fold(0, |key, axis| {
        let extent = (all.high[axis] - all.low[axis]).max(f64::MIN_POSITIVE);
        let centre = 0.5 * (bounds.low[axis] + bounds.high[axis]);
        key | spread::<D>((centre - all.low[axis]) / extent * cells, bits) << axis
    })
}

/// Moves bit `k` of a number to bit `D * k`.
#[allow(clippy::cast_sign_loss)] // `as` clamps, and a place on the curve need not be exact
fn spread<const D: usize>(place: f64, bits: u32) -> u64 {
    let place = place as u64;
    (0..bits).fold(0, |key, bit| key | (place >> bit & 1) << (D as u32 * bit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};
    use graticule_fixtures::Noise;

    #[test]
    fn the_tree_finds_every_overlapping_pair() {
        let mut noise = Noise::new(3);
        for count in [0, 1, 7, 8, 9, 64, 65, 700] {
            let boxes: Vec<_> = (0..count)
                .map(|_| {
                    let low = DVec2::new(noise.unit(), noise.unit());
                    let size = DVec2::new(noise.unit(), noise.unit()) * 0.1 * noise.unit();
                    Bounds::around(&[low, low + size])
                })
                .collect();
            let tree = BoxTree::new(&boxes);
            let mut pairs = Vec::new();
            tree.any_overlapping_pair(|a, b| {
                pairs.push((a.min(b), a.max(b)));
                false
            });
            pairs.sort_unstable();
            let expected: Vec<_> = (0..count)
                .flat_map(|a| (a + 1..count).map(move |b| (a, b)))
                .filter(|&(a, b)| boxes[a].overlaps(&boxes[b]))
                .collect();
            assert_eq!(pairs, expected);
        }
    }

    #[test]
    fn the_nearest_point_is_found_below_the_limit_and_not_above() {
        let mut noise = Noise::new(5);
        for count in [0, 1, 8, 9, 65, 700] {
            let mut point = || DVec3::new(noise.unit(), noise.unit(), noise.unit());
            let points: Vec<_> = (0..count).map(|_| point()).collect();
            let boxes: Vec<_> = points.iter().map(|&p| Bounds::around(&[p])).collect();
            let tree = BoxTree::new(&boxes);
            for _ in 0..50 {
                let from = point() * 2.0 - 0.5;
                let distance = |item: usize| points[item].distance_squared(from);
                let expected = (0..count).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
                let found = tree.nearest(from.into(), f64::INFINITY, distance);
                assert_eq!(found, expected.map(|item| (item, distance(item))));
                if let Some((_, least)) = found {
                    assert_eq!(tree.nearest(from.into(), least, distance), None);
                }
            }
        }
    }
}
