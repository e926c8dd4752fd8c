//! Shortest paths along edges.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::geometry::EdgeLengths;
use crate::mesh::{EdgeId, HalfedgeId, PerEdge, PerVertex, Surface, TriangleMesh, VertexId};

/// The edges of a surface with their lengths, those left out that may not be cut.
pub(in crate::flatten) struct EdgeGraph<'a> {
    mesh: &'a TriangleMesh,
    lengths: EdgeLengths,
    may_cut: &'a PerEdge<bool>,
}

impl<'a> EdgeGraph<'a> {
    pub(in crate::flatten) fn new(surface: &'a Surface, may_cut: &'a PerEdge<bool>) -> Self {
        Self {
            mesh: surface.mesh(),
            lengths: EdgeLengths::of(surface),
            may_cut,
        }
    }

    pub(in crate::flatten) fn mesh(&self) -> &'a TriangleMesh {
        self.mesh
    }

    pub(in crate::flatten) fn length(&self, edge: EdgeId) -> f64 {
        self.lengths[edge]
    }

    pub(in crate::flatten) fn may_cut(&self, edge: EdgeId) -> bool {
        self.may_cut[edge]
    }

    /// The edges at a vertex that may be cut, with their other ends.
    fn neighbors(&self, vertex: VertexId) -> impl Iterator<Item = (EdgeId, VertexId)> + '_ {
        let mesh = self.mesh;
        let sides = mesh
            .outgoing(vertex)
            .flat_map(|side| [side, side.previous()]);
        let other = move |side: HalfedgeId| {
            let [from, to] = mesh.ends(side);
            (mesh.edge(side), if from == vertex { to } else { from })
        };
        sides.map(other).filter(|&(edge, _)| self.may_cut[edge])
    }

    /// The shortest ways from the nearest of the vertices that `is_source` names to all others
    /// (Dijkstra). O(n log n). Edges of the boundary cost nothing: they are open already.
    pub(in crate::flatten) fn shortest_paths(
        &self,
        is_source: impl Fn(VertexId) -> bool,
    ) -> Paths<'a> {
        let count = self.mesh.vertex_count();
        let mut paths = Paths {
            mesh: self.mesh,
            distances: PerVertex::filled(count, f64::INFINITY),
            last_edges: PerVertex::filled(count, None),
        };
        let mut is_settled = PerVertex::filled(count, false);
        let mut queue = BinaryHeap::new();
        for source in self.mesh.vertices().filter(|&vertex| is_source(vertex)) {
            paths.distances[source] = 0.0;
            queue.push(Reverse((0, source)));
        }
        while let Some(Reverse((_, vertex))) = queue.pop() {
            let distance = paths.distances[vertex];
            let mut reached = vec![vertex];
            while let Some(vertex) = reached.pop() {
                if std::mem::replace(&mut is_settled[vertex], true) {
                    continue;
                }
                for (edge, neighbor) in self.neighbors(vertex) {
                    if is_settled[neighbor] || is_source(neighbor) {
                        continue;
                    }
                    // A loop of the boundary is reached as a whole, even where another way to it is
                    // as short: two ways would part the surface.
                    let open = self.mesh.is_boundary_edge(edge);
                    let length = if open { 0.0 } else { self.length(edge) };
                    if open || distance + length < paths.distances[neighbor] {
                        paths.distances[neighbor] = distance + length;
                        paths.last_edges[neighbor] = Some(edge);
                        if open {
                            reached.push(neighbor);
                        } else {
                            // Bits of numbers that are not negative are ordered as the numbers.
                            queue.push(Reverse(((distance + length).to_bits(), neighbor)));
                        }
                    }
                }
            }
        }
        paths
    }
}

/// Shortest paths from some vertices to all.
pub(in crate::flatten) struct Paths<'a> {
    mesh: &'a TriangleMesh,
    /// How far each vertex is.
    pub(in crate::flatten) distances: PerVertex<f64>,
    /// The edge by which each vertex is reached; none at the sources.
    pub(in crate::flatten) last_edges: PerVertex<Option<EdgeId>>,
}

impl Paths<'_> {
    /// The edges from a vertex back to the source it is reached from.
    pub(in crate::flatten) fn path_to(
        &self,
        vertex: VertexId,
    ) -> impl Iterator<Item = EdgeId> + '_ {
        let mut at = vertex;
        std::iter::from_fn(move || {
            let edge = self.last_edges[at]?;
            let [from, to] = self.mesh.ends(self.mesh.edge_halfedge(edge));
            at = if from == at { to } else { from };
            Some(edge)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::grid;

    #[test]
    fn a_loop_is_reached_once_however_many_ways_to_it_are_equally_short() {
        let mut fixture = grid(5.0, 5.0, 5, 5);
        let place = |vertex: u32| fixture.positions[vertex as usize];
        let is_window = |triangle: &[u32; 3]| {
            let middle = triangle.iter().map(|&v| place(v)).sum::<glam::DVec3>() / 3.0;
            (middle - place(0))
                .truncate()
                .cmpgt(glam::DVec2::splat(2.0))
                .all()
                && (middle - place(0))
                    .truncate()
                    .cmplt(glam::DVec2::splat(3.0))
                    .all()
        };
        let rest: Vec<_> = fixture
            .triangles
            .iter()
            .filter(|t| !is_window(t))
            .copied()
            .collect();
        assert_eq!(rest.len() + 2, fixture.triangles.len());
        fixture.triangles = rest;
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let mesh = surface.mesh();
        let all = PerEdge::filled(mesh.edge_count(), true);
        let graph = EdgeGraph::new(&surface, &all);
        // Two neighbours on the way to the window, each as far from it as the other.
        let low = surface.bounding_box()[0].truncate();
        let roots = [glam::DVec2::new(2.0, 1.0), glam::DVec2::new(3.0, 1.0)];
        let is_root = |vertex: VertexId| {
            let at = surface.position(vertex).truncate() - low;
            roots.iter().any(|root| root.distance(at) < 1e-9)
        };
        let paths = graph.shortest_paths(is_root);
        let window = |vertex: &VertexId| {
            let at = surface.position(*vertex).truncate() - low;
            mesh.is_boundary_vertex(*vertex) && at.min_element() > 0.5 && at.max_element() < 4.5
        };
        let entered = mesh.vertices().filter(window).filter(|&vertex| {
            let last = paths.last_edges[vertex];
            last.is_some_and(|edge| !mesh.is_boundary_edge(edge))
        });
        assert_eq!(entered.count(), 1);
    }
}
