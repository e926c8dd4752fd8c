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

/// Finds the vertices around a vertex, again and again, without allocating anew.
///
/// A vertex is in the disk if a path along edges inside the ball leads to it that is at most
/// [`DISK_DETOUR`] radii long: that keeps the other side of a thin wall out. Paths along edges are up to
/// 15 % longer than the surface's own distances, and longer in some directions than in others; the
/// straight distance, which decides on the weights, has no such bias.
pub(super) struct DiskFinder<'a> {
    surface: &'a Surface,
    best: Vec<f64>,
    heap: BinaryHeap<Near>,
    touched: Vec<VertexId>,
}

impl<'a> DiskFinder<'a> {
    pub(super) fn new(surface: &'a Surface) -> Self {
        let best = vec![f64::INFINITY; surface.mesh().vertex_count()];
        Self {
            surface,
            best,
            heap: BinaryHeap::new(),
            touched: Vec::new(),
        }
    }

    /// Fills `disk` with the vertices around `center`, nearest path first, at most `limit` of them.
    /// The middle itself comes first. Returns the radius: the given one, or the straight distance
    /// to the farthest vertex if the limit was met.
    pub(super) fn find(
        &mut self,
        center: VertexId,
        radius: f64,
        limit: usize,
        disk: &mut Vec<DiskVertex>,
    ) -> f64 {
        disk.clear();
        let origin = self.surface.position(center);
        self.reach(center, 0.0);
        let mut farthest = 0.0_f64;
        while let Some(Near { path, vertex }) = self.heap.pop() {
            if path > self.best[vertex.index()] {
                continue;
            }
            let distance = self.surface.position(vertex).distance(origin);
            disk.push(DiskVertex {
                vertex,
                reach: distance,
            });
            farthest = farthest.max(distance);
            if disk.len() == limit {
                break;
            }
            self.visit_neighbors(vertex, path, origin, radius);
        }
        let radius = if disk.len() == limit {
            farthest
        } else {
            radius
        };
        self.forget();
        for entry in disk.iter_mut() {
            entry.reach = (entry.reach / radius).min(1.0);
        }
        radius
    }

    fn visit_neighbors(&mut self, vertex: VertexId, path: f64, origin: glam::DVec3, radius: f64) {
        let surface = self.surface;
        let here = surface.position(vertex);
        for neighbor in surface.mesh().neighbors(vertex) {
            let there = surface.position(neighbor);
            let longer = path + there.distance(here);
            if longer <= DISK_DETOUR * radius && there.distance(origin) <= radius {
                self.reach(neighbor, longer);
            }
        }
    }

    fn reach(&mut self, vertex: VertexId, path: f64) {
        let best = &mut self.best[vertex.index()];
        if path < *best {
            if best.is_infinite() {
                self.touched.push(vertex);
            }
            *best = path;
            self.heap.push(Near { path, vertex });
        }
    }

    fn forget(&mut self) {
        self.heap.clear();
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
        let radius = DiskFinder::new(&surface).find(center, 3.1, 1000, &mut disk);
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
        let mut finder = DiskFinder::new(&surface);
        let mut disk = Vec::new();
        let radius = finder.find(VertexId(220), 10.0, 25, &mut disk);
        assert_eq!(disk.len(), 25);
        assert!(radius < 4.0);
        assert!(disk.iter().all(|entry| entry.reach <= 1.0));
    }
}
