//! The boundary of a disk that grows vertex by vertex.

use glam::DVec2;

use super::boundary::segments_meet;

const NONE: u32 = u32::MAX;

/// Cells of the grid for each edge of the walk, roughly.
const CELLS_PER_EDGE: usize = 2;

/// A closed walk along boundary vertices.
pub(super) struct Rim {
    next: Vec<u32>,
    first: u32,
    grid: Grid,
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
            grid: Grid::default(),
        }
    }

    /// Notes where the vertices lie, all of which may have moved.
    pub(super) fn locate(&mut self, places: &[DVec2]) {
        let edges: Vec<[u32; 2]> = self.edges().collect();
        let segments: Vec<_> = edges.iter().map(|edge| ends(*edge, places)).collect();
        self.grid = Grid::around(&segments);
        for (edge, segment) in edges.into_iter().zip(segments) {
            self.grid.add(edge, segment);
        }
    }

    /// Puts a vertex between two neighbours.
    pub(super) fn insert(&mut self, vertex: u32, [a, b]: [u32; 2], places: &[DVec2]) {
        let (before, after) = if self.next[a as usize] == b {
            (a, b)
        } else {
            (b, a)
        };
        self.next[before as usize] = vertex;
        self.next[vertex as usize] = after;
        for edge in [[before, vertex], [vertex, after]] {
            self.grid.add(edge, ends(edge, places));
        }
    }

    /// Whether a vertex between two neighbours would keep the walk from meeting itself. Exact, but
    /// for edges that fold back onto the next one.
    pub(super) fn is_clear(&self, between: [u32; 2], place: DVec2, places: &[DVec2]) -> bool {
        let meets = |end: u32, edge: [u32; 2]| {
            let is_there = self.next[edge[0] as usize] == edge[1];
            let is_replaced = edge.iter().all(|end| between.contains(end));
            is_there
                && !is_replaced
                && !edge.contains(&end)
                && segments_meet([places[end as usize], place], ends(edge, places))
        };
        between.iter().all(|&end| {
            let mut near = self.grid.near([places[end as usize], place]);
            !near.any(|edge| meets(end, edge))
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

fn ends(edge: [u32; 2], places: &[DVec2]) -> [DVec2; 2] {
    edge.map(|end| places[end as usize])
}

/// Edges by the square cells that their boxes touch; those outside of the grid are in the cells at
/// its margin. Edges that are no more stay in their cells.
#[derive(Default)]
struct Grid {
    low: DVec2,
    per_length: f64,
    columns: usize,
    cells: Vec<Vec<[u32; 2]>>,
}

impl Grid {
    /// An empty grid around segments.
    fn around(segments: &[[DVec2; 2]]) -> Self {
        let points = || segments.iter().flatten();
        let low = points().fold(DVec2::INFINITY, |low, &p| low.min(p));
        let high = points().fold(DVec2::NEG_INFINITY, |high, &p| high.max(p));
        let size = (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        let across = ((CELLS_PER_EDGE * segments.len()) as f64).sqrt().max(1.0);
        let per_length = across / size.max_element();
        let mut grid = Self {
            low,
            per_length,
            columns: usize::MAX,
            cells: Vec::new(),
        };
        let [columns, rows] = grid.cell(high, usize::MAX);
        grid.columns = columns + 1;
        grid.cells = vec![Vec::new(); (columns + 1) * (rows + 1)];
        grid
    }

    #[expect(clippy::cast_sign_loss, reason = "not below zero")]
    fn cell(&self, point: DVec2, rows: usize) -> [usize; 2] {
        let [x, y] = ((point - self.low) * self.per_length)
            .max(DVec2::ZERO)
            .into();
        [
            (x as usize).min(self.columns - 1),
            (y as usize).min(rows - 1),
        ]
    }

    /// The numbers of the cells that the box of a segment touches.
    fn cells_of(&self, [a, b]: [DVec2; 2]) -> impl Iterator<Item = usize> + use<> {
        let rows = self.cells.len() / self.columns;
        let [left, bottom] = self.cell(a.min(b), rows);
        let [right, top] = self.cell(a.max(b), rows);
        let columns = self.columns;
        (bottom..=top).flat_map(move |row| (left..=right).map(move |column| row * columns + column))
    }

    fn add(&mut self, edge: [u32; 2], segment: [DVec2; 2]) {
        for cell in self.cells_of(segment) {
            self.cells[cell].push(edge);
        }
    }

    /// The edges in the cells of a segment, some several times.
    fn near(&self, segment: [DVec2; 2]) -> impl Iterator<Item = [u32; 2]> {
        let cells = self.cells_of(segment);
        cells.flat_map(|cell| self.cells[cell].iter().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_beyond_another_part_of_the_walk_is_not_clear() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.5, -0.5)];
        let places: Vec<DVec2> = square.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
        let mut rim = Rim::new(0..4, 5);
        rim.locate(&places);
        assert!(rim.is_clear([0, 1], DVec2::new(0.5, -0.5), &places));
        assert!(rim.is_clear([0, 1], DVec2::new(0.5, 0.5), &places));
        assert!(!rim.is_clear([0, 1], DVec2::new(0.5, 1.5), &places));
        assert!(!rim.is_clear([0, 1], DVec2::new(1.0, 0.5), &places));
        rim.insert(4, [1, 0], &places);
        assert_eq!(
            rim.edges().collect::<Vec<_>>(),
            [[0, 4], [4, 1], [1, 2], [2, 3], [3, 0]]
        );
        // The edge that was there is in nobody's way; the new ones are.
        assert!(rim.is_clear([2, 3], DVec2::new(0.5, -0.1), &places));
        assert!(!rim.is_clear([2, 3], DVec2::new(0.5, -0.6), &places));
    }

    #[test]
    fn the_grid_finds_what_meets_wherever_it_lies() {
        let turn = |k: u32, radius: f64| DVec2::from_angle(0.1 * f64::from(k)) * radius;
        let places: Vec<DVec2> = (0..60)
            .map(|k| turn(k, 1.0 + 0.3 * f64::from(k % 3)))
            .collect();
        let mut rim = Rim::new(0..60, 60);
        rim.locate(&places);
        let edges: Vec<[u32; 2]> = rim.edges().collect();
        for k in 0..400 {
            let place = turn(k, 0.01 * f64::from(k));
            let between = edges[(k % 60) as usize];
            let slowly = edges.iter().filter(|edge| **edge != between).all(|&edge| {
                let free = |end: &u32| {
                    edge.contains(end)
                        || !segments_meet([places[*end as usize], place], ends(edge, &places))
                };
                between.iter().all(free)
            });
            assert_eq!(rim.is_clear(between, place, &places), slowly, "{k}");
        }
    }
}
