//! Smallest vertex separators near a given cut, by maximum flow.
//!
//! Menger: the fewest vertices that part two sets are as many as there are vertex-disjoint paths
//! between them. The paths are found by blocking flows (Dinic 1970) in a band of a few layers on
//! both sides of the cut, with capacity one at each vertex; on unit capacities the number of
//! phases is at most the square root of the band's size, and a handful in practice.

use super::graph::{ABSENT, Graph};

/// Where a vertex lies after the separation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
    Separator,
}

/// Moves as few vertices as possible into the separator so that no edge joins left and right.
///
/// Only vertices within `layers` edges of the cut may move, and at most an eighth of each side
/// besides the vertices at the cut itself.
pub(super) fn separate(graph: &Graph, sides: &mut [Side], layers: usize) {
    let band = Band::around_cut(graph, sides, layers);
    if band.vertices.is_empty() {
        return;
    }
    let mut flow = Flow::new(graph, &band);
    while flow.rank_states() {
        flow.augment();
    }
    for (local, &vertex) in band.vertices.iter().enumerate() {
        let entered = flow.ranks[2 * local] != ABSENT;
        let left = flow.ranks[2 * local + 1] != ABSENT;
        sides[vertex as usize] = match (entered, left) {
            (_, true) => Side::Left,
            (true, false) => Side::Separator,
            (false, false) => Side::Right,
        };
    }
}

/// The vertices around a cut. Everything beyond is thought as merged into the source (left)
/// or the sink (right).
struct Band {
    vertices: Vec<u32>,
    /// Place in `vertices`, or `ABSENT`.
    local: Vec<u32>,
    /// Ends of the band, by place in `vertices`.
    sources: Vec<u32>,
    is_sink: Vec<bool>,
}

impl Band {
    fn around_cut(graph: &Graph, sides: &[Side], layers: usize) -> Self {
        let mut band = Self {
            vertices: Vec::new(),
            local: vec![ABSENT; sides.len()],
            sources: Vec::new(),
            is_sink: Vec::new(),
        };
        let mut rims = [Vec::new(), Vec::new()];
        let mut counts = [0, 0];
        for (vertex, &side) in (0..).zip(sides) {
            let right = usize::from(side == Side::Right);
            counts[right] += 1;
            // Without a branch per neighbour: most vertices are nowhere near the cut.
            let neighbours = graph.neighbours(vertex).iter();
            let across = neighbours.map(|&n| u32::from(sides[n as usize] != side));
            if across.sum::<u32>() > 0 {
                rims[right].push(vertex);
            }
        }
        for right in [0, 1] {
            band.grow(graph, sides, &mut rims[right], layers, counts[right] / 8);
        }
        band.is_sink = vec![false; band.vertices.len()];
        for &vertex in &rims[1] {
            band.is_sink[band.local[vertex as usize] as usize] = true;
        }
        for vertex in &mut rims[0] {
            *vertex = band.local[*vertex as usize];
        }
        band.sources = std::mem::take(&mut rims[0]);
        band
    }

    /// Adds the vertices of one side at the cut, then layers behind them while `allowance` lasts;
    /// `rim` becomes the outermost layer.
    fn grow(
        &mut self,
        graph: &Graph,
        sides: &[Side],
        rim: &mut Vec<u32>,
        layers: usize,
        mut allowance: usize,
    ) {
        self.add(rim);
        for _ in 0..layers {
            let next = self.layer_behind(graph, sides, rim);
            if next.is_empty() || next.len() > allowance {
                for &vertex in &next {
                    self.local[vertex as usize] = ABSENT;
                }
                break;
            }
            allowance -= next.len();
            self.add(&next);
            *rim = next;
        }
    }

    /// Vertices of the rim's side next to it and not in the band yet; marked as if they were.
    fn layer_behind(&mut self, graph: &Graph, sides: &[Side], rim: &[u32]) -> Vec<u32> {
        let mut next = Vec::new();
        for &vertex in rim {
            for &neighbour in graph.neighbours(vertex) {
                let place = &mut self.local[neighbour as usize];
                if *place == ABSENT && sides[neighbour as usize] == sides[vertex as usize] {
                    *place = 0;
                    next.push(neighbour);
                }
            }
        }
        next
    }

    fn add(&mut self, vertices: &[u32]) {
        for &vertex in vertices {
            self.local[vertex as usize] = self.vertices.len() as u32;
            self.vertices.push(vertex);
        }
    }
}

/// Vertex-disjoint paths through a band, kept as each vertex's place on its path.
///
/// The search walks over two states per vertex: `2v`, entered, and `2v + 1`, left. Passing from
/// one to the other is what has capacity one.
struct Flow<'a> {
    graph: &'a Graph,
    band: &'a Band,
    used: Vec<bool>,
    previous: Vec<u32>,
    /// Steps from the source in the residual graph, or `ABSENT` where it does not reach.
    ranks: Vec<u32>,
    /// Number of the next move to try from each state.
    next_move: Vec<u32>,
}

impl<'a> Flow<'a> {
    fn new(graph: &'a Graph, band: &'a Band) -> Self {
        let count = band.vertices.len();
        Self {
            graph,
            band,
            used: vec![false; count],
            previous: vec![ABSENT; count],
            ranks: vec![ABSENT; 2 * count],
            next_move: vec![0; 2 * count],
        }
    }

    /// The state after move number `index` from `state`: `None` when there are no more,
    /// `Some(ABSENT)` where this one leads nowhere.
    fn step(&self, state: u32, index: u32) -> Option<u32> {
        let vertex = (state / 2) as usize;
        if state.is_multiple_of(2) {
            let to = match (self.used[vertex], self.previous[vertex]) {
                (false, _) => state + 1,
                (true, ABSENT) => ABSENT,
                (true, previous) => 2 * previous + 1,
            };
            return (index == 0).then_some(to);
        }
        if index == 0 {
            return Some(if self.used[vertex] { state - 1 } else { ABSENT });
        }
        let neighbours = self.graph.neighbours(self.band.vertices[vertex]);
        let neighbour = *neighbours.get(index as usize - 1)?;
        let local = self.band.local[neighbour as usize];
        Some(if local == ABSENT { ABSENT } else { 2 * local })
    }

    fn at_sink(&self, state: u32) -> bool {
        state % 2 == 1 && self.band.is_sink[(state / 2) as usize]
    }

    /// Ranks the states by steps from the source; whether the sink is among them.
    fn rank_states(&mut self) -> bool {
        self.ranks.fill(ABSENT);
        let mut queue: Vec<u32> = self.band.sources.iter().map(|&local| 2 * local).collect();
        for &state in &queue {
            self.ranks[state as usize] = 0;
        }
        let mut reached = false;
        let mut head = 0;
        while let Some(&state) = queue.get(head) {
            head += 1;
            reached |= self.at_sink(state);
            let rank = self.ranks[state as usize] + 1;
            for index in 0.. {
                let Some(to) = self.step(state, index) else {
                    break;
                };
                if to != ABSENT && self.ranks[to as usize] == ABSENT {
                    self.ranks[to as usize] = rank;
                    queue.push(to);
                }
            }
        }
        reached
    }

    /// Adds paths along rising ranks until none is left.
    fn augment(&mut self) {
        self.next_move.fill(0);
        let mut path = Vec::new();
        let band = self.band;
        for &source in &band.sources {
            path.clear();
            path.push(2 * source);
            // A path through this source already exists where the first state is spent.
            if self.previous[source as usize] == ABSENT && self.used[source as usize] {
                continue;
            }
            if self.find_path(&mut path) {
                self.apply(&path);
            }
        }
    }

    fn find_path(&mut self, path: &mut Vec<u32>) -> bool {
        while let Some(&state) = path.last() {
            if self.at_sink(state) {
                return true;
            }
            let index = self.next_move[state as usize];
            match self.step(state, index) {
                None => {
                    self.ranks[state as usize] = ABSENT;
                    path.pop();
                }
                Some(to) => {
                    self.next_move[state as usize] += 1;
                    let rises = to != ABSENT
                        && self.ranks[to as usize] != ABSENT
                        && self.ranks[to as usize] == self.ranks[state as usize] + 1;
                    if rises {
                        path.push(to);
                    }
                }
            }
        }
        false
    }

    fn apply(&mut self, path: &[u32]) {
        self.previous[(path[0] / 2) as usize] = ABSENT;
        for pair in path.windows(2) {
            let [from, to] = [pair[0] / 2, pair[1] / 2];
            match (pair[0] % 2, pair[1] % 2) {
                (0, 1) if from == to => self.used[from as usize] = true,
                (1, 0) if from == to => self.used[from as usize] = false,
                (1, 0) => self.previous[to as usize] = from,
                // The flow into `from` is taken over; its former bringer goes on elsewhere.
                _ => {}
            }
        }
        // Every state of the path is spent for this phase: each vertex passes one path.
        for &state in path {
            self.ranks[state as usize] = ABSENT;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square lattice, vertices numbered row by row.
    fn lattice(columns: u32, rows: u32) -> Graph {
        let vertex = move |column, row| row * columns + column;
        let across = (0..rows).flat_map(move |row| {
            (1..columns).map(move |column| [vertex(column - 1, row), vertex(column, row)])
        });
        let along = (1..rows).flat_map(move |row| {
            (0..columns).map(move |column| [vertex(column, row - 1), vertex(column, row)])
        });
        Graph::from_edges((columns * rows) as usize, across.chain(along))
    }

    fn halves(graph: &Graph, left: impl Fn(u32) -> bool) -> Vec<Side> {
        let side = |vertex| {
            if left(vertex) {
                Side::Left
            } else {
                Side::Right
            }
        };
        (0..graph.vertices() as u32).map(side).collect()
    }

    fn count(sides: &[Side], side: Side) -> usize {
        sides.iter().filter(|&&other| other == side).count()
    }

    fn assert_parted(graph: &Graph, sides: &[Side]) {
        for vertex in 0..graph.vertices() as u32 {
            for &neighbour in graph.neighbours(vertex) {
                let pair = [vertex, neighbour].map(|v| sides[v as usize]);
                assert_ne!(pair, [Side::Left, Side::Right], "{vertex} and {neighbour}");
            }
        }
    }

    #[test]
    fn a_lattice_is_parted_by_one_column() {
        let graph = lattice(30, 12);
        let mut sides = halves(&graph, |vertex| vertex % 30 < 15);
        separate(&graph, &mut sides, 0);
        assert_parted(&graph, &sides);
        assert_eq!(count(&sides, Side::Separator), 12);
    }

    #[test]
    fn a_ragged_cut_is_straightened_within_the_band() {
        // Teeth three columns deep in every other row.
        let graph = lattice(60, 12);
        let mut sides = halves(&graph, |v| v % 60 < if v / 60 % 2 == 0 { 29 } else { 32 });
        separate(&graph, &mut sides, 3);
        assert_parted(&graph, &sides);
        assert_eq!(count(&sides, Side::Separator), 12);
    }

    #[test]
    fn the_neck_of_an_hourglass_is_found() {
        // Rows are missing in the two columns beside the cut.
        let columns = 40;
        let edges: Vec<[u32; 2]> = {
            let whole = lattice(columns, 15);
            let missing = |v: u32| (21..23).contains(&(v % columns)) && v / columns > 3;
            (0..600)
                .flat_map(|v| whole.neighbours(v).iter().map(move |&n| [v, n]))
                .filter(|edge| !edge.iter().any(|&v| missing(v)))
                .collect()
        };
        let graph = Graph::from_edges(600, edges.into_iter());
        let mut sides = halves(&graph, |vertex| vertex % columns < 20);
        separate(&graph, &mut sides, 3);
        assert_parted(&graph, &sides);
        assert_eq!(count(&sides, Side::Separator), 4);
    }

    #[test]
    fn parts_without_edges_between_them_need_no_separator() {
        let graph = Graph::from_edges(4, [[0, 1], [2, 3]].into_iter());
        let mut sides = halves(&graph, |vertex| vertex < 2);
        separate(&graph, &mut sides, 3);
        assert_eq!(count(&sides, Side::Separator), 0);
    }

    #[test]
    fn the_smaller_end_of_a_star_is_its_centre() {
        let graph = Graph::from_edges(9, (1..9).map(|leaf| [0, leaf]));
        let mut sides = halves(&graph, |vertex| vertex == 0);
        separate(&graph, &mut sides, 3);
        assert_parted(&graph, &sides);
        assert_eq!(count(&sides, Side::Separator), 1);
    }
}
