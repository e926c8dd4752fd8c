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
        let mut queue = BinaryHeap::new();
        for source in self.mesh.vertices().filter(|&vertex| is_source(vertex)) {
            paths.distances[source] = 0.0;
            queue.push(Reverse((0, source)));
        }
        while let Some(Reverse((bits, vertex))) = queue.pop() {
            let distance = paths.distances[vertex];
            if bits != distance.to_bits() {
                continue;
            }
            for (edge, neighbor) in self.neighbors(vertex) {
                let open = self.mesh.is_boundary_edge(edge);
                let length = if open { 0.0 } else { self.length(edge) };
                if distance + length < paths.distances[neighbor] {
                    paths.distances[neighbor] = distance + length;
                    paths.last_edges[neighbor] = Some(edge);
                    // Bits of numbers that are not negative are ordered as the numbers.
                    queue.push(Reverse(((distance + length).to_bits(), neighbor)));
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
