use std::collections::VecDeque;

use super::overlay::NONE;
use crate::mesh::Polygons;

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

    /// The sides to split so that every polygon gets an even number of them: chains of sides that
    /// lead from one odd polygon to the nearest other, or out over the boundary. For each side
    /// whether it is split; both sides of an edge are.
    pub(super) fn to_split(&self, polygons: &Polygons) -> Vec<bool> {
        let mut odd: Vec<bool> = (0..polygons.len())
            .map(|polygon| !polygons.vertices(polygon).len().is_multiple_of(2))
            .collect();
        let mut split = vec![false; self.twins.len()];
        let mut came_by = vec![NONE; polygons.len()];
        for start in 0..polygons.len() {
            if std::mem::take(&mut odd[start]) {
                let chain = self.way_out(polygons, start, &odd, &mut came_by);
                if let Some(&last) = chain.last()
                    && let Some(end) = self.beyond(last)
                {
                    odd[end] = false;
                }
                for side in chain {
                    split[side as usize] ^= true;
                    if let Some(twin) = split.get_mut(self.twins[side as usize] as usize) {
                        *twin ^= true;
                    }
                }
            }
        }
        split
    }

    /// Whether there is no polygon beyond a side.
    pub(super) fn is_border(&self, side: u32) -> bool {
        self.twins[side as usize] == NONE
    }

    fn beyond(&self, side: u32) -> Option<usize> {
        let twin = self.twins[side as usize];
        (self.polygons.get(twin as usize)).map(|&polygon| polygon as usize)
    }

    /// The sides crossed on the shortest way from a polygon to an odd one or over the boundary.
    fn way_out(
        &self,
        polygons: &Polygons,
        start: usize,
        odd: &[bool],
        came_by: &mut [u32],
    ) -> Vec<u32> {
        let mut reached = vec![start];
        let mut queue = VecDeque::from([start]);
        let mut last = None;
        'search: while let Some(polygon) = queue.pop_front() {
            for side in polygons.corner_range(polygon) {
                let side = side as u32;
                let Some(next) = self.beyond(side) else {
                    last = Some(side);
                    break 'search;
                };
                if next == start || came_by[next] != NONE {
                    continue;
                }
                came_by[next] = side;
                reached.push(next);
                if odd[next] {
                    last = Some(side);
                    break 'search;
                }
                queue.push_back(next);
            }
        }
        let step_back = |&side: &u32| {
            let before = came_by[self.polygons[side as usize] as usize];
            (before != NONE).then_some(before)
        };
        let mut chain: Vec<u32> = std::iter::successors(last, step_back).collect();
        chain.reverse();
        for polygon in reached {
            came_by[polygon] = NONE;
        }
        chain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_far_apart_are_joined_by_one_chain() {
        // A triangle, three quads in a row, a triangle; all round them is boundary. Ways along the
        // row and over the boundary are both allowed: in the end every polygon is even.
        let mut polygons = Polygons::default();
        polygons.push(&[0, 1, 2]);
        for row in 0..3 {
            let first = 1 + 2 * row;
            polygons.push(&[first + 1, first, first + 2, first + 3]);
        }
        polygons.push(&[8, 7, 9]);
        let split = Sides::of(&polygons).to_split(&polygons);
        for polygon in 0..polygons.len() {
            let range = polygons.corner_range(polygon);
            let added = range.clone().filter(|&side| split[side]).count();
            assert!((range.len() + added).is_multiple_of(2), "polygon {polygon}");
        }
    }
}
