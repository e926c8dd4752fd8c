use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::mesh::{Element, Surface, VertexId};
use crate::tolerance::DISK_DETOUR;

/// A vertex of a geodesic disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DiskVertex {
    pub(super) vertex: VertexId,
    /// Straight distance to the middle over the radius, in `0.0..=1.0`.
    pub(super) reach: f64,
}

/// The edges at each vertex with their lengths, side by side in memory.
pub(super) struct EdgeGraph<'a> {
    surface: &'a Surface,
    starts: Vec<u32>,
    ends: Vec<(VertexId, f64)>,
}

impl<'a> EdgeGraph<'a> {
    pub(super) fn of(surface: &'a Surface) -> Self {
        let mesh = surface.mesh();
        let mut starts = Vec::with_capacity(mesh.vertex_count() + 1);
        let mut ends = Vec::with_capacity(2 * mesh.edge_count());
        for vertex in mesh.vertices() {
            starts.push(ends.len() as u32);
            let here = surface.position(vertex);
            let length = |neighbor| surface.position(neighbor).distance(here);
            ends.extend(mesh.neighbors(vertex).map(|other| (other, length(other))));
        }
        starts.push(ends.len() as u32);
        Self {
            surface,
            starts,
            ends,
        }
    }

    fn at(&self, vertex: VertexId) -> &[(VertexId, f64)] {
        let [start, end] = [0, 1].map(|k| self.starts[vertex.index() + k] as usize);
        &self.ends[start..end]
    }
}

/// Finds the vertices around a vertex, again and again, without allocating anew.
///
/// A vertex is in the disk if a path along edges inside the ball leads to it that is at most
/// [`DISK_DETOUR`] radii long: that keeps the other side of a thin wall out. Paths along edges are up to
/// 15 % longer than the surface's own distances, and longer in some directions than in others; the
/// straight distance, which decides on the weights, has no such bias.
pub(super) struct DiskFinder<'a> {
    graph: &'a EdgeGraph<'a>,
    best: Vec<f64>,
    queue: Vec<Near>,
    heap: BinaryHeap<Near>,
    touched: Vec<VertexId>,
}

impl<'a> DiskFinder<'a> {
    pub(super) fn new(graph: &'a EdgeGraph<'a>) -> Self {
        let best = vec![f64::INFINITY; graph.surface.mesh().vertex_count()];
        Self {
            graph,
            best,
            queue: Vec::new(),
            heap: BinaryHeap::new(),
            touched: Vec::new(),
        }
    }

    /// Fills `disk` with the vertices around `center`, at most `limit` of them: if there are more,
    /// those with the shortest paths. The middle itself comes first. Returns the radius: the given
    /// one, or the straight distance to the farthest vertex if the limit was met.
    pub(super) fn find(
        &mut self,
        center: VertexId,
        radius: f64,
        limit: usize,
        disk: &mut Vec<DiskVertex>,
    ) -> f64 {
        disk.clear();
        let radius = if self.find_all(center, radius, limit, disk) {
            radius
        } else {
            self.find_nearest(center, radius, limit, disk)
        };
        for entry in disk.iter_mut() {
            entry.reach = (entry.reach / radius).min(1.0);
        }
        radius
    }

    /// The whole disk, or `false` if it is larger than the limit. Paths are shortened until none
    /// can be; in a small disk that is faster than taking the shortest first.
    fn find_all(
        &mut self,
        center: VertexId,
        radius: f64,
        limit: usize,
        disk: &mut Vec<DiskVertex>,
    ) -> bool {
        let origin = self.graph.surface.position(center);
        self.reach(center, 0.0);
        let mut next = 0;
        while let Some(&Near { path, vertex }) = self.queue.get(next) {
            next += 1;
            if path <= self.best[vertex.index()] {
                self.visit_neighbors(vertex, path, origin, radius);
            }
            if self.touched.len() >= limit {
                self.forget();
                return false;
            }
        }
        disk.extend(self.touched.iter().map(|&vertex| DiskVertex {
            vertex,
            reach: self.graph.surface.position(vertex).distance(origin),
        }));
        self.forget();
        true
    }

    /// The nearest vertices up to the limit; returns the distance to the farthest of them.
    fn find_nearest(
        &mut self,
        center: VertexId,
        radius: f64,
        limit: usize,
        disk: &mut Vec<DiskVertex>,
    ) -> f64 {
        let origin = self.graph.surface.position(center);
        self.reach(center, 0.0);
        self.heap.extend(self.queue.drain(..));
        let mut farthest = 0.0_f64;
        while let Some(Near { path, vertex }) = self.heap.pop() {
            if path > self.best[vertex.index()] {
                continue;
            }
            let reach = self.graph.surface.position(vertex).distance(origin);
            disk.push(DiskVertex { vertex, reach });
            farthest = farthest.max(reach);
            if disk.len() == limit {
                break;
            }
            self.visit_neighbors(vertex, path, origin, radius);
            self.heap.extend(self.queue.drain(..));
        }
        self.forget();
        farthest
    }

    fn visit_neighbors(&mut self, vertex: VertexId, path: f64, origin: glam::DVec3, radius: f64) {
        let graph = self.graph;
        for &(neighbor, length) in graph.at(vertex) {
            let longer = path + length;
            if longer <= DISK_DETOUR * radius
                && longer < self.best[neighbor.index()]
                && graph.surface.position(neighbor).distance(origin) <= radius
            {
                self.reach(neighbor, longer);
            }
        }
    }

    fn reach(&mut self, vertex: VertexId, path: f64) {
        let best = &mut self.best[vertex.index()];
        if best.is_infinite() {
            self.touched.push(vertex);
        }
        *best = path;
        self.queue.push(Near { path, vertex });
    }

    fn forget(&mut self) {
        self.heap.clear();
        self.queue.clear();
        for vertex in self.touched.drain(..) {
            self.best[vertex.index()] = f64::INFINITY;
        }
    }
}

/// Orders the heap by shortest path, then by smallest vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Near {
    path: f64,
    vertex: VertexId,
}

impl Eq for Near {}

impl Ord for Near {
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .path
            .total_cmp(&self.path)
            .then(other.vertex.cmp(&self.vertex))
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
    use graticule_fixtures::grid;

    #[test]
    fn a_disk_in_the_plane_holds_what_is_near() {
        let grid = grid(20.0, 20.0, 20, 20);
        let surface = Surface::from_triangles(grid.positions, &grid.triangles).unwrap();
        let center = VertexId(10 * 21 + 10);
        let mut disk = Vec::new();
        let radius = DiskFinder::new(&EdgeGraph::of(&surface)).find(center, 3.1, 1000, &mut disk);
        assert_eq!(radius, 3.1);
        assert_eq!(
            disk[0],
            DiskVertex {
                vertex: center,
                reach: 0.0
            }
        );
        let near = |v: &VertexId| surface.position(*v).distance(surface.position(center)) <= 3.1;
        assert_eq!(disk.len(), surface.mesh().vertices().filter(near).count());
    }

    #[test]
    fn a_limit_shrinks_the_disk() {
        let grid = grid(20.0, 20.0, 20, 20);
        let surface = Surface::from_triangles(grid.positions, &grid.triangles).unwrap();
        let graph = EdgeGraph::of(&surface);
        let mut finder = DiskFinder::new(&graph);
        let mut disk = Vec::new();
        let radius = finder.find(VertexId(220), 10.0, 25, &mut disk);
        assert_eq!(disk.len(), 25);
        assert!(radius < 4.0);
        assert!(disk.iter().all(|entry| entry.reach <= 1.0));
    }
}
