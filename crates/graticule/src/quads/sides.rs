use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::overlay::NONE;
use crate::mesh::Polygons;

/// Cost of leading a chain over a side.
const CROSSING: f64 = 1.0;

/// Cost of leading a chain round a corner of a quad, which makes a vertex with three edges and one
/// with five; straight across, the quad becomes two.
const TURN: f64 = 1.5;

/// Cost of leading a chain over a line, whose vertices stay where they are straight.
const LINE_CROSSING: f64 = 8.0;

/// Cost of a chain that ends in a triangle over a line: a quad with a straight corner is left.
const FLAT_END: f64 = 40.0;

/// The sides of polygons and how they meet; side `c` runs from corner `c` to the next one of its
/// polygon.
pub(super) struct Sides {
    /// The polygon of each side.
    polygons: Vec<u32>,
    /// The side of the neighbour; [`NONE`] on the boundary.
    twins: Vec<u32>,
}

impl Sides {
    /// For polygons that form a manifold.
    pub(super) fn of(polygons: &Polygons) -> Self {
        let mut owners = Vec::with_capacity(polygons.corner_count());
        let mut ends = Vec::with_capacity(polygons.corner_count());
        for polygon in 0..polygons.len() {
            let vertices = polygons.vertices(polygon);
            for (index, &from) in vertices.iter().enumerate() {
                let to = vertices[(index + 1) % vertices.len()];
                ends.push((from.min(to), from.max(to), owners.len() as u32));
                owners.push(polygon as u32);
            }
        }
        ends.sort_unstable();
        let mut twins = vec![NONE; owners.len()];
        for pair in ends.windows(2) {
            let [(a, b, side), (c, d, other)] = [pair[0], pair[1]];
            if (a, b) == (c, d) {
                twins[side as usize] = other;
                twins[other as usize] = side;
            }
        }
        Self {
            polygons: owners,
            twins,
        }
    }

    /// Whether there is no polygon beyond a side.
    pub(super) fn is_border(&self, side: u32) -> bool {
        self.twins[side as usize] == NONE
    }

    fn beyond(&self, side: u32) -> Option<usize> {
        let twin = self.twins[side as usize];
        (self.polygons.get(twin as usize)).map(|&polygon| polygon as usize)
    }
}

/// Finds the sides to split so that every polygon gets an even number of them.
pub(super) struct Parity<'a> {
    polygons: &'a Polygons,
    sides: Sides,
    /// What it costs to lead a chain over each side.
    costs: Vec<f64>,
    odd: Vec<bool>,
    /// The cost of reaching each side in the search at hand.
    reached: Vec<f64>,
    came_by: Vec<u32>,
}

/// The way of a chain: its cost, and the sides that it crosses, from its end back.
struct Chain {
    cost: f64,
    sides: Vec<u32>,
}

impl<'a> Parity<'a> {
    /// For polygons that form a manifold, some of whose sides lie on features.
    pub(super) fn new(polygons: &'a Polygons, is_feature: impl Fn([u32; 2]) -> bool) -> Self {
        let sides = Sides::of(polygons);
        let mut costs = Vec::with_capacity(polygons.corner_count());
        for polygon in 0..polygons.len() {
            let vertices = polygons.vertices(polygon);
            for (index, side) in polygons.corner_range(polygon).enumerate() {
                let ends = [vertices[index], vertices[(index + 1) % vertices.len()]];
                let is_line = sides.is_border(side as u32) || is_feature(ends);
                let beyond = sides.beyond(side as u32);
                let is_triangle = [Some(polygon), beyond]
                    .into_iter()
                    .flatten()
                    .any(|polygon| polygons.vertices(polygon).len() == 3);
                costs.push(match (is_line, is_triangle) {
                    (false, _) => CROSSING,
                    (true, false) => LINE_CROSSING,
                    (true, true) => FLAT_END,
                });
            }
        }
        let count = costs.len();
        Self {
            odd: (0..polygons.len())
                .map(|polygon| !polygons.vertices(polygon).len().is_multiple_of(2))
                .collect(),
            polygons,
            sides,
            costs,
            reached: vec![f64::INFINITY; count],
            came_by: vec![NONE; count],
        }
    }

    /// Whether a side lies on a feature or on the boundary.
    pub(super) fn is_line(&self, side: usize) -> bool {
        self.costs[side] >= LINE_CROSSING
    }

    /// For each side whether it is split; both sides of an edge are.
    ///
    /// Chains of sides lead from one odd polygon to another, or out over the boundary: the cheapest
    /// first. They go straight through quads and keep off features and the boundary where they can.
    pub(super) fn into_split(mut self) -> Vec<bool> {
        let mut split = vec![false; self.costs.len()];
        let mut queue: BinaryHeap<_> = (0..self.polygons.len())
            .filter(|&polygon| self.odd[polygon])
            .map(|polygon| Reverse((0, polygon)))
            .collect();
        while let Some(Reverse((known, start))) = queue.pop() {
            if !self.odd[start] {
                continue;
            }
            let Some(chain) = self.cheapest_chain(start) else {
                self.odd[start] = false;
                continue;
            };
            // Costs are not negative, so that their bits are in their order.
            let cost = chain.cost.to_bits();
            if cost > known {
                queue.push(Reverse((cost, start)));
                continue;
            }
            self.odd[start] = false;
            if let Some(&last) = chain.sides.first()
                && let Some(end) = self.sides.beyond(last)
            {
                self.odd[end] = false;
            }
            for side in chain.sides {
                split[side as usize] ^= true;
                if let Some(twin) = split.get_mut(self.sides.twins[side as usize] as usize) {
                    *twin ^= true;
                }
            }
        }
        split
    }

    /// The cheapest chain from a polygon to another odd one or over the boundary.
    fn cheapest_chain(&mut self, start: usize) -> Option<Chain> {
        let mut touched = Vec::new();
        let mut queue = BinaryHeap::new();
        for side in self.polygons.corner_range(start) {
            self.reach(side as u32, self.costs[side], NONE, &mut touched);
            queue.push(Reverse((self.costs[side].to_bits(), side as u32)));
        }
        let mut found = None;
        while let Some(Reverse((bits, side))) = queue.pop() {
            let cost = f64::from_bits(bits);
            if cost > self.reached[side as usize] {
                continue;
            }
            let Some(next) = self
                .sides
                .beyond(side)
                .filter(|&next| !self.odd[next] || next == start)
            else {
                found = Some((cost, side));
                break;
            };
            if next == start {
                continue;
            }
            let entry = self.sides.twins[side as usize];
            for exit in self.polygons.corner_range(next) {
                let total = cost + self.costs[exit] + self.turn(next, [entry, exit as u32]);
                if total < self.reached[exit] {
                    self.reach(exit as u32, total, side, &mut touched);
                    queue.push(Reverse((total.to_bits(), exit as u32)));
                }
            }
        }
        let chain = found.map(|(cost, last)| Chain {
            cost,
            sides: self.way_to(last),
        });
        for side in touched {
            self.reached[side as usize] = f64::INFINITY;
        }
        chain
    }

    fn reach(&mut self, side: u32, cost: f64, from: u32, touched: &mut Vec<u32>) {
        self.reached[side as usize] = cost;
        self.came_by[side as usize] = from;
        touched.push(side);
    }

    /// What it costs to pass a polygon from one side to another.
    fn turn(&self, polygon: usize, [entry, exit]: [u32; 2]) -> f64 {
        if entry == exit {
            f64::INFINITY
        } else if self.polygons.vertices(polygon).len() == 4 && entry.abs_diff(exit) != 2 {
            TURN
        } else {
            0.0
        }
    }

    fn way_to(&self, last: u32) -> Vec<u32> {
        let before = |&side: &u32| Some(self.came_by[side as usize]).filter(|&side| side != NONE);
        std::iter::successors(Some(last), before).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_even_after(polygons: &Polygons, split: &[bool], polygon: usize) -> bool {
        let range = polygons.corner_range(polygon);
        let added = range.clone().filter(|&side| split[side]).count();
        (range.len() + added).is_multiple_of(2)
    }

    /// A row of quads between the vertices `2k`, `2k + 1` and `2k + 2`, `2k + 3`, with a triangle at
    /// either end.
    fn row_between_triangles(quads: u32) -> Polygons {
        let mut polygons = Polygons::default();
        polygons.push(&[0, 1, 2 * quads + 2]);
        for k in 0..quads {
            polygons.push(&[2 * k + 1, 2 * k, 2 * k + 2, 2 * k + 3]);
        }
        polygons.push(&[2 * quads + 1, 2 * quads, 2 * quads + 3]);
        polygons
    }

    #[test]
    fn two_triangles_far_apart_are_joined_by_one_chain_along_the_row() {
        let polygons = row_between_triangles(4);
        let split = Parity::new(&polygons, |_| false).into_split();
        for polygon in 0..polygons.len() {
            assert!(is_even_after(&polygons, &split, polygon), "{polygon}");
        }
        // Five edges inside, each with two sides; none on the boundary.
        assert_eq!(split.iter().filter(|&&split| split).count(), 10);
    }

    #[test]
    fn chains_keep_off_features_and_go_straight_through_quads() {
        // A grid of 5 × 5 quads, two of them cut off at a corner: the triangles lie on both sides of
        // a feature that ends inside, so that a chain can go round its end.
        let at = |x: u32, y: u32| y * 6 + x;
        let mut polygons = Polygons::default();
        for y in 0..5 {
            for x in 0..5 {
                let quad = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
                if y == 2 && (x == 1 || x == 3) {
                    polygons.push(&quad[..3]);
                    polygons.push(&[quad[0], quad[2], quad[3], 36 + x]);
                    continue;
                }
                polygons.push(&quad);
            }
        }
        let feature = [at(3, 2), at(3, 3)];
        let split = Parity::new(&polygons, |ends| {
            [ends[0].min(ends[1]), ends[0].max(ends[1])] == feature
        })
        .into_split();
        for polygon in 0..polygons.len() {
            assert!(is_even_after(&polygons, &split, polygon), "{polygon}");
            let vertices = polygons.vertices(polygon);
            for (index, side) in polygons.corner_range(polygon).enumerate() {
                let ends = [vertices[index], vertices[(index + 1) % vertices.len()]];
                let on_feature = [ends[0].min(ends[1]), ends[0].max(ends[1])] == feature;
                assert!(!(on_feature && split[side]));
            }
        }
    }
}
