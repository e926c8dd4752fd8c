use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec3;

use crate::mesh::{PerVertex, Surface, VertexId};
use crate::solve::along_curve;
use crate::tolerance::DISK_DETOUR;

/// A vertex of a geodesic disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DiskVertex {
    /// Its rank in the [`EdgeGraph`].
    pub(super) rank: u32,
    /// Square of the straight distance to the middle over the radius, in `0.0..=1.0`.
    pub(super) square: f64,
}

/// The edges at each vertex with their lengths, near in memory to those of near vertices.
#[derive(Clone, Debug)]
pub(super) struct EdgeGraph {
    /// The vertices along a curve that fills space; a vertex's rank is its place here.
    vertices: Vec<VertexId>,
    ranks: PerVertex<u32>,
    points: Vec<DVec3>,
    starts: Vec<u32>,
    ends: Vec<(u32, f64)>,
}

impl EdgeGraph {
    pub(super) fn of(surface: &Surface) -> Self {
        let mesh = surface.mesh();
        let order = along_curve(surface.positions().as_slice()).into_iter();
        let vertices: Vec<VertexId> = order.map(VertexId).collect();
        let mut ranks = PerVertex::filled(mesh.vertex_count(), 0);
        for (rank, &vertex) in (0..).zip(&vertices) {
            ranks[vertex] = rank;
        }
        let mut starts = Vec::with_capacity(mesh.vertex_count() + 1);
        let mut ends = Vec::with_capacity(2 * mesh.edge_count());
        for &vertex in &vertices {
            starts.push(ends.len() as u32);
            let here = surface.position(vertex);
            let length = |neighbor| surface.position(neighbor).distance(here);
            let neighbors = mesh.neighbors(vertex);
            ends.extend(neighbors.map(|other| (ranks[other], length(other))));
        }
        starts.push(ends.len() as u32);
        Self {
            points: vertices.iter().map(|&v| surface.position(v)).collect(),
            vertices,
            ranks,
            starts,
            ends,
        }
    }

    /// The vertices by rank.
    pub(super) fn vertices(&self) -> &[VertexId] {
        &self.vertices
    }

    pub(super) fn rank(&self, vertex: VertexId) -> u32 {
        self.ranks[vertex]
    }

    /// The mean length of the edges at each vertex, by rank; 0 without any.
    pub(super) fn mean_lengths(&self) -> Vec<f64> {
        let mean = |rank: u32| {
            let ends = self.at(rank);
            let sum: f64 = ends.iter().map(|(_, length)| length).sum();
            sum / ends.len().max(1) as f64
        };
        (0..self.vertices.len() as u32).map(mean).collect()
    }

    pub(super) fn at(&self, rank: u32) -> &[(u32, f64)] {
        let [start, end] = [0, 1].map(|k| self.starts[rank as usize + k] as usize);
        &self.ends[start..end]
    }
}

/// Stands for no place among the vertices found.
const ABSENT: u32 = u32::MAX;

/// Stands for a vertex outside of the ball.
const OUTSIDE: u32 = u32::MAX - 1;

/// Finds the vertices around a vertex, again and again, without allocating anew.
///
/// A vertex is in the disk if a path along edges inside the ball leads to it that is at most
/// [`DISK_DETOUR`] radii long: that keeps the other side of a thin wall out. Paths along edges are up to
/// 15 % longer than the surface's own distances, and longer in some directions than in others; the
/// straight distance, which decides on the weights, has no such bias.
pub(super) struct DiskFinder<'a> {
    graph: &'a EdgeGraph,
    /// For each vertex its place in `found`, [`ABSENT`] or [`OUTSIDE`].
    places: Vec<u32>,
    found: Vec<Found>,
    outside: Vec<u32>,
    /// Places of vertices whose edges are to be gone over again, as their paths became shorter.
    waiting: Vec<u32>,
    heap: BinaryHeap<Near>,
}

/// A vertex inside the ball.
#[derive(Clone, Copy, Debug)]
struct Found {
    rank: u32,
    /// Length of the shortest path known.
    path: f64,
    /// Square of the straight distance.
    square: f64,
}

impl<'a> DiskFinder<'a> {
    pub(super) fn new(graph: &'a EdgeGraph) -> Self {
        Self {
            graph,
            places: vec![ABSENT; graph.vertices.len()],
            found: Vec::new(),
            outside: Vec::new(),
            waiting: Vec::new(),
            heap: BinaryHeap::new(),
        }
    }

    /// Fills `disk` with the vertices around the one of rank `center`, at most `limit` of them: if
    /// there are more, those with the shortest paths. The middle itself comes first. Returns the
    /// radius: the given one, or the straight distance to the farthest vertex if the limit was met.
    pub(super) fn find(
        &mut self,
        center: u32,
        radius: f64,
        limit: usize,
        disk: &mut Vec<DiskVertex>,
    ) -> f64 {
        let ball = Ball {
            center: self.graph.points[center as usize],
            radius,
        };
        self.find_in(&ball, &[center], limit, disk)
    }

    /// The same around a point, whose nearest vertices are given.
    pub(super) fn find_in(
        &mut self,
        ball: &Ball,
        nearest: &[u32],
        limit: usize,
        disk: &mut Vec<DiskVertex>,
    ) -> f64 {
        disk.clear();
        let longest = DISK_DETOUR * ball.radius;
        let radius = if self.flood(ball, nearest, limit) {
            if self.found.iter().any(|found| found.path > longest) {
                self.shorten();
            }
            let reached = self.found.iter().filter(|found| found.path <= longest);
            disk.extend(reached.map(Found::in_disk));
            ball.radius
        } else {
            self.forget();
            self.find_nearest(ball, nearest, limit, disk)
        };
        self.forget();
        for entry in disk.iter_mut() {
            entry.square = (entry.square / (radius * radius)).min(1.0);
        }
        radius
    }

    /// Finds all that hangs together inside the ball, with some paths; `false` if that is more than
    /// the limit. On good triangles these paths are short enough already.
    fn flood(&mut self, ball: &Ball, nearest: &[u32], limit: usize) -> bool {
        self.reach_nearest(ball, nearest);
        let mut next = 0;
        while let Some(&Found { rank, path, .. }) = self.found.get(next) {
            next += 1;
            for &(neighbor, length) in self.graph.at(rank) {
                if self.reach(neighbor, path + length, ball) {
                    let place = self.places[neighbor as usize];
                    if (place as usize) < next {
                        self.waiting.push(place);
                    }
                }
            }
            if self.found.len() > limit {
                return false;
            }
        }
        true
    }

    /// Shortens paths until none can be.
    fn shorten(&mut self) {
        let mut next = 0;
        while let Some(&place) = self.waiting.get(next) {
            next += 1;
            let Found { rank, path, .. } = self.found[place as usize];
            for &(neighbor, length) in self.graph.at(rank) {
                let there = self.places[neighbor as usize];
                if there < OUTSIDE && path + length < self.found[there as usize].path {
                    self.found[there as usize].path = path + length;
                    self.waiting.push(there);
                }
            }
        }
    }

    /// The nearest vertices up to the limit, and the radius.
    fn find_nearest(
        &mut self,
        ball: &Ball,
        nearest: &[u32],
        limit: usize,
        disk: &mut Vec<DiskVertex>,
    ) -> f64 {
        self.reach_nearest(ball, nearest);
        let reached = self
            .found
            .iter()
            .map(|&Found { path, rank, .. }| Near { path, rank });
        self.heap.extend(reached);
        let mut farthest = 0.0_f64;
        while let Some(Near { path, rank }) = self.heap.pop() {
            let found = self.found[self.places[rank as usize] as usize];
            if path > found.path {
                continue;
            }
            disk.push(found.in_disk());
            farthest = farthest.max(found.square);
            if disk.len() == limit {
                return farthest.sqrt();
            }
            for &(rank, length) in self.graph.at(rank) {
                let path = path + length;
                if path <= DISK_DETOUR * ball.radius && self.reach(rank, path, ball) {
                    self.heap.push(Near { path, rank });
                }
            }
        }
        ball.radius
    }

    /// The vertices that paths start from, by the straight way.
    fn reach_nearest(&mut self, ball: &Ball, nearest: &[u32]) {
        for &rank in nearest {
            let path = self.graph.points[rank as usize].distance(ball.center);
            self.reach(rank, path, ball);
        }
    }

    /// Whether this is the shortest path so far to a vertex of the ball.
    fn reach(&mut self, rank: u32, path: f64, ball: &Ball) -> bool {
        match self.places[rank as usize] {
            OUTSIDE => false,
            ABSENT => {
                let square = self.graph.points[rank as usize].distance_squared(ball.center);
                let is_inside = square <= ball.radius * ball.radius;
                self.places[rank as usize] = if is_inside {
                    self.found.push(Found { rank, path, square });
                    self.found.len() as u32 - 1
                } else {
                    self.outside.push(rank);
                    OUTSIDE
                };
                is_inside
            }
            place => {
                let known = &mut self.found[place as usize].path;
                let is_shorter = path < *known;
                if is_shorter {
                    *known = path;
                }
                is_shorter
            }
        }
    }

    fn forget(&mut self) {
        self.heap.clear();
        self.waiting.clear();
        let found = self.found.drain(..).map(|found| found.rank);
        for rank in found.chain(self.outside.drain(..)) {
            self.places[rank as usize] = ABSENT;
        }
    }
}

impl Found {
    /// With the square that is to be divided by that of the radius.
    fn in_disk(&self) -> DiskVertex {
        DiskVertex {
            rank: self.rank,
            square: self.square,
        }
    }
}

/// Where a disk is looked for.
pub(super) struct Ball {
    pub(super) center: DVec3,
    pub(super) radius: f64,
}

/// Orders the heap by shortest path, then by first rank.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Near {
    path: f64,
    rank: u32,
}

impl Eq for Near {}

impl Ord for Near {
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .path
            .total_cmp(&self.path)
            .then(other.rank.cmp(&self.rank))
    }
}

impl PartialOrd for Near {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "exactness is what is tested")]
mod tests {
    use super::*;
    use graticule_fixtures::{Fixture, grid};

    fn surface(fixture: Fixture) -> Surface {
        Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
    }

    fn disk_around(
        surface: &Surface,
        center: VertexId,
        radius: f64,
        limit: usize,
    ) -> (f64, Vec<(VertexId, f64)>) {
        let graph = EdgeGraph::of(surface);
        let mut disk = Vec::new();
        let radius = DiskFinder::new(&graph).find(graph.rank(center), radius, limit, &mut disk);
        let named = disk.iter().map(|entry| {
            let vertex = graph.vertices()[entry.rank as usize];
            (vertex, entry.square)
        });
        (radius, named.collect())
    }

    #[test]
    fn a_disk_in_the_plane_holds_what_is_near() {
        let surface = surface(grid(20.0, 20.0, 20, 20));
        let center = VertexId(10 * 21 + 10);
        let (radius, disk) = disk_around(&surface, center, 3.1, 1000);
        assert_eq!(radius, 3.1);
        assert_eq!(disk[0], (center, 0.0));
        let near = |v: &VertexId| surface.position(*v).distance(surface.position(center)) <= 3.1;
        assert_eq!(disk.len(), surface.mesh().vertices().filter(near).count());
    }

    #[test]
    fn a_limit_shrinks_the_disk() {
        let surface = surface(grid(20.0, 20.0, 20, 20));
        let (radius, disk) = disk_around(&surface, VertexId(220), 10.0, 25);
        assert_eq!(disk.len(), 25);
        assert!(radius < 4.0);
        assert!(disk.iter().all(|&(_, square)| square <= 1.0));
    }

    #[test]
    fn the_other_side_of_a_wall_is_not_near() {
        // A strip folded over: its ends lie a tenth apart, the way round is 20 long.
        let folded = grid(20.0, 4.0, 40, 8).map(|p| {
            let past = (p.x - 10.0).max(0.0);
            DVec3::new(p.x.min(10.0) - past, p.y, 0.1 * (past * 4.0).min(1.0))
        });
        let surface = surface(folded);
        let (_, disk) = disk_around(&surface, VertexId(4 * 41), 2.0, 1000);
        assert!(
            disk.iter()
                .all(|&(vertex, _)| surface.position(vertex).z == 0.0)
        );
        assert!(disk.len() > 20);
    }

    #[test]
    fn a_disk_is_the_same_found_whole_or_one_by_one() {
        // Slanted triangles, on which the first paths found are not the shortest.
        let surface = surface(
            grid(20.0, 20.0, 20, 20)
                .map(|p| DVec3::new(p.x + 1.7 * p.y, p.y, 0.3 * libm::sin(p.x))),
        );
        let graph = EdgeGraph::of(&surface);
        let mut finder = DiskFinder::new(&graph);
        for center in (0..441).step_by(7) {
            let [mut whole, mut nearest] = [Vec::new(), Vec::new()];
            finder.find(center, 4.0, 1000, &mut whole);
            let ball = Ball {
                center: graph.points[center as usize],
                radius: 4.0,
            };
            finder.find_nearest(&ball, &[center], 1000, &mut nearest);
            finder.forget();
            let sorted = |disk: &[DiskVertex]| {
                let mut ranks: Vec<u32> = disk.iter().map(|entry| entry.rank).collect();
                ranks.sort_unstable();
                ranks
            };
            assert_eq!(sorted(&whole), sorted(&nearest));
        }
    }
}
