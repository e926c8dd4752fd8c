//! The graph of a sparse symmetric matrix: which unknowns meet in an equation.

use crate::solve::Pattern;

/// An undirected graph without loops and multiple edges; neighbours ascend.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Graph {
    pub(super) starts: Vec<u32>,
    pub(super) neighbours: Vec<u32>,
}

impl Graph {
    pub(super) fn with_capacity(vertices: usize, neighbours: usize) -> Self {
        let mut starts = Vec::with_capacity(vertices + 1);
        starts.push(0);
        Self {
            starts,
            neighbours: Vec::with_capacity(neighbours),
        }
    }

    /// The graph of `A + Aᵀ` for a square matrix `A` with this pattern; either triangle suffices.
    ///
    /// # Panics
    /// If the pattern is not square.
    #[must_use]
    pub fn of_pattern(pattern: &Pattern) -> Self {
        assert_eq!(pattern.rows(), pattern.columns(), "square pattern");
        Self::from_edges(pattern.columns(), entries(pattern))
    }

    /// The graph of groups of unknowns; `group_of` has one entry for each unknown, or for the first
    /// ones if only these are in groups.
    pub(super) fn of_groups(pattern: &Pattern, groups: usize, group_of: &[u32]) -> Self {
        let grouped = group_of.len() as u32;
        let edges = entries(pattern).filter(|&[row, column]| row.max(column) < grouped);
        let edges = edges.map(|ends| ends.map(|end| group_of[end as usize]));
        Self::from_edges(groups, edges)
    }

    /// The graph on `vertices` vertices with the given edges, in any order and direction, loops and
    /// repetitions ignored. Linear time.
    ///
    /// # Panics
    /// If an edge names a vertex that is not there.
    #[must_use]
    pub fn from_edges(vertices: usize, edges: impl Iterator<Item = [u32; 2]> + Clone) -> Self {
        let edges = edges.filter(|[a, b]| a != b);
        let mut starts = vec![0_u32; vertices + 1];
        for [a, b] in edges.clone() {
            starts[a as usize + 1] += 1;
            starts[b as usize + 1] += 1;
        }
        for vertex in 0..vertices {
            starts[vertex + 1] += starts[vertex];
        }
        let mut next = starts.clone();
        let mut neighbours = vec![0_u32; starts[vertices] as usize];
        for [a, b] in edges {
            for (from, to) in [(a, b), (b, a)] {
                neighbours[next[from as usize] as usize] = to;
                next[from as usize] += 1;
            }
        }
        Self { starts, neighbours }.without_repetitions()
    }

    fn without_repetitions(mut self) -> Self {
        let mut kept = 0;
        let mut start = 0;
        for vertex in 0..self.vertices() {
            let end = self.starts[vertex + 1] as usize;
            self.neighbours[start..end].sort_unstable();
            let first = kept;
            for index in start..end {
                let neighbour = self.neighbours[index];
                if kept == first || self.neighbours[kept - 1] != neighbour {
                    self.neighbours[kept] = neighbour;
                    kept += 1;
                }
            }
            start = end;
            self.starts[vertex + 1] = kept as u32;
        }
        self.neighbours.truncate(kept);
        self
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Number of edges.
    #[must_use]
    pub fn edges(&self) -> usize {
        self.neighbours.len() / 2
    }

    /// Neighbours of a vertex, ascending.
    ///
    /// # Panics
    /// If the vertex is out of range.
    #[must_use]
    pub fn neighbours(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.neighbours[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// The subgraph on `kept` vertices, numbered in the order given. `new_of_old` is scratch of one
    /// entry per vertex, all [`ABSENT`], and is left so.
    ///
    /// Neighbours ascend in the result where `kept` ascends; see [`sorted`](Self::sorted).
    pub(super) fn induced(&self, kept: &[u32], new_of_old: &mut [u32]) -> Self {
        let mut entries = 0;
        for (new, &old) in (0..).zip(kept) {
            new_of_old[old as usize] = new;
            entries += self.neighbours(old).len();
        }
        let mut subgraph = Self::with_capacity(kept.len(), entries);
        for &old in kept {
            let numbers = self.neighbours(old).iter().map(|&n| new_of_old[n as usize]);
            subgraph
                .neighbours
                .extend(numbers.filter(|&new| new != ABSENT));
            subgraph.starts.push(subgraph.neighbours.len() as u32);
        }
        for &old in kept {
            new_of_old[old as usize] = ABSENT;
        }
        subgraph
    }

    /// The same graph with each vertex's neighbours ascending.
    pub(super) fn sorted(mut self) -> Self {
        for vertex in 0..self.vertices() {
            let range = self.starts[vertex] as usize..self.starts[vertex + 1] as usize;
            self.neighbours[range].sort_unstable();
        }
        self
    }

    /// Vertices of each connected component, ascending within each; components by first vertex.
    pub(super) fn components(&self) -> Vec<Vec<u32>> {
        let mut component_of = vec![ABSENT; self.vertices()];
        let mut sizes = Vec::new();
        let mut queue = Vec::new();
        for root in 0..self.vertices() as u32 {
            if component_of[root as usize] != ABSENT {
                continue;
            }
            let component = sizes.len() as u32;
            component_of[root as usize] = component;
            queue.push(root);
            let mut size = 0;
            while let Some(vertex) = queue.pop() {
                size += 1;
                for &neighbour in self.neighbours(vertex) {
                    if component_of[neighbour as usize] == ABSENT {
                        component_of[neighbour as usize] = component;
                        queue.push(neighbour);
                    }
                }
            }
            sizes.push(size);
        }
        let mut components: Vec<Vec<u32>> = sizes.into_iter().map(Vec::with_capacity).collect();
        for (vertex, &component) in component_of.iter().enumerate() {
            components[component as usize].push(vertex as u32);
        }
        components
    }
}

fn entries(pattern: &Pattern) -> impl Iterator<Item = [u32; 2]> + Clone {
    (0..pattern.columns() as u32).flat_map(|column| {
        let rows = pattern.column(column as usize).iter();
        rows.map(move |&row| [row, column])
    })
}

/// Marks a vertex that is not in a subgraph.
pub(super) const ABSENT: u32 = u32::MAX;
