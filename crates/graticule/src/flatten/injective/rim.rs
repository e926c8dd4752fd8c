//! The boundary of a disk that grows vertex by vertex.

use glam::DVec2;

use super::boundary::segments_meet;

const NONE: u32 = u32::MAX;

/// A closed walk along boundary vertices.
pub(super) struct Rim {
    next: Vec<u32>,
    first: u32,
}

impl Rim {
    /// The walk along these vertices, of `count` that there are or will be.
    pub(super) fn new(vertices: impl Iterator<Item = u32>, count: usize) -> Self {
        let walk: Vec<u32> = vertices.collect();
        let mut next = vec![NONE; count];
        for (index, &vertex) in walk.iter().enumerate() {
            next[vertex as usize] = walk[(index + 1) % walk.len()];
        }
        Self {
            next,
            first: walk[0],
        }
    }

    /// Puts a vertex between two neighbours.
    pub(super) fn insert(&mut self, vertex: u32, [a, b]: [u32; 2]) {
        let (before, after) = if self.next[a as usize] == b {
            (a, b)
        } else {
            (b, a)
        };
        self.next[before as usize] = vertex;
        self.next[vertex as usize] = after;
    }

    /// Whether a vertex between two neighbours would keep the walk from meeting itself. Exact, but
    /// for edges that fold back onto the next one. Linear time.
    pub(super) fn is_clear(&self, between: [u32; 2], place: DVec2, places: &[DVec2]) -> bool {
        let at = |vertex: u32| places[vertex as usize];
        self.edges().all(|edge| {
            let own =
                |end: u32| !edge.contains(&end) && segments_meet([at(end), place], edge.map(at));
            edge.iter().all(|end| between.contains(end)) || !between.iter().any(|&end| own(end))
        })
    }

    fn edges(&self) -> impl Iterator<Item = [u32; 2]> {
        let mut at = Some(self.first);
        std::iter::from_fn(move || {
            let from = at?;
            let to = self.next[from as usize];
            at = (to != self.first).then_some(to);
            Some([from, to])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_beyond_another_part_of_the_walk_is_not_clear() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)];
        let places: Vec<DVec2> = square.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
        let mut rim = Rim::new(0..4, 5);
        assert!(rim.is_clear([0, 1], DVec2::new(0.5, -0.5), &places));
        assert!(rim.is_clear([0, 1], DVec2::new(0.5, 0.5), &places));
        assert!(!rim.is_clear([0, 1], DVec2::new(0.5, 1.5), &places));
        assert!(!rim.is_clear([0, 1], DVec2::new(1.0, 0.5), &places));
        rim.insert(4, [1, 0]);
        assert_eq!(
            rim.edges().collect::<Vec<_>>(),
            [[0, 4], [4, 1], [1, 2], [2, 3], [3, 0]]
        );
    }
}
