use super::arcs::TracedArcs;
use super::layout_corners::{WIDEST_CORNER, corner_angle};
use super::{ArcKind, EmbeddedNet, LayoutError};
use crate::mesh::{EdgeId, HalfedgeId, PerEdge, PerVertex, Surface, TriangleMesh, VertexId};

/// Nodes that a closed line without any gets.
const CLOSED_LINE_NODES: usize = 4;

/// The edges along which arcs run, and the vertices that end arcs.
pub(super) struct ArcGraph<'a> {
    pub(super) surface: &'a Surface,
    pub(super) kinds: &'a PerEdge<Option<ArcKind>>,
    is_node: PerVertex<bool>,
    degrees: PerVertex<u32>,
    /// The last two arc edges of each vertex.
    edges: PerVertex<[EdgeId; 2]>,
}

impl<'a> ArcGraph<'a> {
    pub(super) fn of(
        net: &'a EmbeddedNet,
        kinds: &'a PerEdge<Option<ArcKind>>,
    ) -> Result<Self, LayoutError> {
        let surface = &net.refined.surface;
        let count = surface.mesh().vertex_count();
        let mut graph = Self {
            surface,
            kinds,
            is_node: PerVertex::filled(count, false),
            degrees: PerVertex::filled(count, 0),
            edges: PerVertex::filled(count, [EdgeId(0); 2]),
        };
        graph.collect_edges();
        graph.find_nodes(net)?;
        graph.give_closed_lines_nodes();
        graph.make_distinct();
        Ok(graph)
    }

    fn mesh(&self) -> &'a TriangleMesh {
        self.surface.mesh()
    }

    /// The edges that arcs run along, in order.
    pub(super) fn arc_edges(&self) -> impl Iterator<Item = EdgeId> + use<'_> {
        (self.kinds.enumerate()).filter_map(|(edge, kind)| kind.map(|_| edge))
    }

    pub(super) fn is_node(&self, vertex: VertexId) -> bool {
        self.is_node[vertex]
    }

    /// The nodes, in order.
    pub(super) fn nodes(&self) -> Vec<VertexId> {
        let nodes = self.is_node.enumerate().filter(|(_, is_node)| **is_node);
        nodes.map(|(vertex, _)| vertex).collect()
    }

    pub(super) fn ends(&self, edge: EdgeId) -> [VertexId; 2] {
        self.mesh().ends(self.mesh().edge_halfedge(edge))
    }

    fn collect_edges(&mut self) {
        for (edge, _) in self.kinds.enumerate().filter(|(_, kind)| kind.is_some()) {
            for end in self.ends(edge) {
                self.edges[end] = [edge, self.edges[end][0]];
                self.degrees[end] += 1;
            }
        }
    }

    fn find_nodes(&mut self, net: &EmbeddedNet) -> Result<(), LayoutError> {
        for vertex in self.mesh().vertices() {
            let [one, other] = self.edges[vertex].map(|edge| self.kinds[edge]);
            self.is_node[vertex] = match self.degrees[vertex] {
                0 => false,
                1 => return Err(LayoutError::DanglingArc { vertex }),
                2 => one != other || net.nodes[vertex] && self.turns(net, vertex),
                _ => true,
            };
        }
        Ok(())
    }

    /// Whether the border of a chart turns at a vertex that two arc edges meet.
    fn turns(&self, net: &EmbeddedNet, vertex: VertexId) -> bool {
        let mesh = self.mesh();
        let is_arc = |halfedge: HalfedgeId| self.kinds[mesh.edge(halfedge)].is_some();
        let fan: Vec<HalfedgeId> = mesh.outgoing(vertex).collect();
        let first = fan.iter().position(|&leaving| is_arc(leaving));
        let mut angles = Vec::new();
        for &leaving in fan.iter().cycle().skip(first.unwrap_or(0)).take(fan.len()) {
            if is_arc(leaving) || angles.is_empty() {
                angles.push(0.0);
            }
            let last = angles.len() - 1;
            angles[last] += corner_angle(net, leaving);
        }
        angles.iter().any(|&angle| angle < WIDEST_CORNER)
    }

    /// The vertices and edges from a vertex along an edge to the next node, or round to the vertex.
    pub(super) fn follow(&self, from: VertexId, first: EdgeId) -> (Vec<VertexId>, Vec<EdgeId>) {
        let (mut vertices, mut edges) = (vec![from], Vec::new());
        let (mut at, mut edge) = (from, first);
        loop {
            let [one, other] = self.ends(edge);
            at = if one == at { other } else { one };
            vertices.push(at);
            edges.push(edge);
            if self.is_node[at] || at == from {
                return (vertices, edges);
            }
            let [one, other] = self.edges[at];
            edge = if one == edge { other } else { one };
        }
    }

    fn give_closed_lines_nodes(&mut self) {
        let mut seen = PerEdge::filled(self.kinds.len(), false);
        let see = |edges: Vec<EdgeId>, seen: &mut PerEdge<bool>| {
            for edge in edges {
                seen[edge] = true;
            }
        };
        let all: Vec<EdgeId> = self.arc_edges().collect();
        for &edge in &all {
            for node in self.ends(edge).into_iter().filter(|&end| self.is_node[end]) {
                see(self.follow(node, edge).1, &mut seen);
            }
        }
        for edge in all {
            if !seen[edge] {
                let (ring, edges) = self.follow(self.ends(edge)[0], edge);
                see(edges, &mut seen);
                self.is_node[ring[0]] = true;
                self.divide(&ring, CLOSED_LINE_NODES);
            }
        }
    }

    /// Puts nodes into a chain so that it falls into as many parts of similar length, as far as it
    /// has vertices for them.
    fn divide(&mut self, chain: &[VertexId], parts: usize) {
        for index in dividing_places(self.surface, chain, parts) {
            self.is_node[chain[index]] = true;
        }
    }

    /// Puts nodes into arcs that end where they begin, and into those that have the ends of another.
    fn make_distinct(&mut self) {
        let arcs = TracedArcs::of(self).arcs;
        let ends = |chain: &[VertexId]| {
            let [from, to] = [chain[0], chain[chain.len() - 1]];
            [from.min(to), from.max(to)]
        };
        let mut by_ends: Vec<_> = (0_usize..)
            .zip(&arcs)
            .map(|(index, arc)| (ends(&arc.vertices), index))
            .collect();
        by_ends.sort_unstable();
        for group in by_ends.chunk_by(|a, b| a.0 == b.0) {
            for &([from, to], index) in group {
                if from == to {
                    self.divide(&arcs[index].vertices, 3);
                } else if group.len() > 1 {
                    self.divide(&arcs[index].vertices, 2);
                }
            }
        }
    }
}

/// The indices of the inner vertices of a chain that best divide it into parts of the same length;
/// fewer where it has not as many.
pub(super) fn dividing_places(surface: &Surface, chain: &[VertexId], parts: usize) -> Vec<usize> {
    let mut run = vec![0.0];
    for pair in chain.windows(2) {
        let [from, to] = [pair[0], pair[1]].map(|vertex| surface.position(vertex));
        run.push(run[run.len() - 1] + from.distance(to));
    }
    let inner = chain.len() - 2;
    let wanted = (parts - 1).min(inner);
    let mut places = Vec::with_capacity(wanted);
    for part in 1..=wanted {
        let goal = run[chain.len() - 1] * part as f64 / (wanted + 1) as f64;
        let first = places.last().map_or(1, |&last| last + 1);
        let last = inner - (wanted - part);
        let near = |&a: &usize, &b: &usize| {
            let miss = |index: usize| (run[index] - goal).abs();
            miss(a).total_cmp(&miss(b))
        };
        places.extend((first..=last).min_by(near));
    }
    places
}
