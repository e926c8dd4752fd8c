use std::ops::Range;

use glam::DVec2;
use rayon::prelude::*;

/// Boxes in a leaf, and children of a node.
const GROUP: usize = 8;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) low: DVec2,
    pub(super) high: DVec2,
}

impl Bounds {
    pub(super) fn around(points: &[DVec2]) -> Self {
        points.iter().fold(Self::EMPTY, |bounds, &p| Self {
            low: bounds.low.min(p),
            high: bounds.high.max(p),
        })
    }

    const EMPTY: Self = Self {
        low: DVec2::INFINITY,
        high: DVec2::NEG_INFINITY,
    };

    fn join(self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// Whether the boxes share more than boundary points: what lies strictly inside both shapes
    /// that the boxes surround lies strictly inside both boxes.
    #[inline]
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        self.low.x < other.high.x
            && other.low.x < self.high.x
            && self.low.y < other.high.y
            && other.low.y < self.high.y
    }
}

/// A static tree of boxes, packed bottom-up along a Morton curve through their centres.
///
/// Built in O(n log n). Searching costs O(log n) and the leaves met, as long as few boxes overlap
/// each other; boxes of long diagonal shapes side by side all overlap, whatever the shapes do.
pub(super) struct BoxTree {
    /// The items in the order of the leaves.
    items: Vec<u32>,
    /// The boxes in the order of `items`.
    bounds: Vec<Bounds>,
    /// Boxes around groups, leaves first, the root last.
    levels: Vec<Vec<Bounds>>,
}

impl BoxTree {
    pub(super) fn new(boxes: &[Bounds]) -> Self {
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

    pub(super) fn leaf_count(&self) -> usize {
        self.levels[0].len()
    }

    /// The ranks of the items in a leaf.
    pub(super) fn leaf(&self, leaf: usize) -> Range<usize> {
        GROUP * leaf..(GROUP * (leaf + 1)).min(self.items.len())
    }

    /// The item at a rank.
    #[inline]
    pub(super) fn item(&self, rank: usize) -> usize {
        self.items[rank] as usize
    }

    /// The ranks of the items in `leaves` whose boxes overlap that of the item at `rank`, itself
    /// included if it has an area.
    pub(super) fn overlapping<'a>(
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
    pub(super) fn overlapping_leaves(&self, leaf: usize, first: usize, found: &mut Vec<usize>) {
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
            let children = GROUP * node..(GROUP * (node + 1)).min(self.levels[level - 1].len());
            stack.extend(children.rev().map(|child| (level - 1, child)));
        }
    }
}

fn groups(boxes: &[Bounds]) -> Vec<Bounds> {
    boxes
        .chunks(GROUP)
        .map(|group| group.iter().fold(Bounds::EMPTY, Bounds::join))
        .collect()
}

/// The interleaved bits of the centre's coordinates, 32 each.
fn morton_key(bounds: &Bounds, all: &Bounds) -> u64 {
    let extent = (all.high - all.low).max(DVec2::splat(f64::MIN_POSITIVE));
    let centre = 0.5 * (bounds.low + bounds.high);
    let place = (centre - all.low) / extent * f64::from(u32::MAX);
    spread(place.x) | spread(place.y) << 1
}

/// Moves bit `k` of a number in `0.0..=2^32 - 1` to bit `2k`.
#[allow(clippy::cast_sign_loss)] // `as` clamps, and a place on the curve need not be exact
fn spread(place: f64) -> u64 {
    let mut bits = u64::from(place as u32);
    for (shift, mask) in [
        (16, 0x0000_ffff_0000_ffff),
        (8, 0x00ff_00ff_00ff_00ff),
        (4, 0x0f0f_0f0f_0f0f_0f0f),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    #[test]
    fn the_tree_finds_every_overlapping_pair() {
        let mut noise = Noise::new(3);
        for count in [0, 1, 7, 8, 9, 64, 65, 700] {
            let boxes: Vec<_> = (0..count)
                .map(|_| {
                    let low = DVec2::new(noise.unit(), noise.unit());
                    let size = DVec2::new(noise.unit(), noise.unit()) * 0.1 * noise.unit();
                    Bounds {
                        low,
                        high: low + size,
                    }
                })
                .collect();
            let tree = BoxTree::new(&boxes);
            let mut pairs = Vec::new();
            let mut found = Vec::new();
            for leaf in 0..tree.leaf_count() {
                tree.overlapping_leaves(leaf, leaf, &mut found);
                for i in tree.leaf(leaf) {
                    for j in tree.overlapping(i, &found).filter(|&j| i < j) {
                        let (a, b) = (tree.item(i), tree.item(j));
                        pairs.push((a.min(b), a.max(b)));
                    }
                }
            }
            pairs.sort_unstable();
            let expected: Vec<_> = (0..count)
                .flat_map(|a| (a + 1..count).map(move |b| (a, b)))
                .filter(|&(a, b)| boxes[a].overlaps(&boxes[b]))
                .collect();
            assert_eq!(pairs, expected);
        }
    }
}
