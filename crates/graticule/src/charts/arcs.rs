use super::nodes::ArcGraph;
use super::{Arc, ArcId, ArcKind, Direction};
use crate::mesh::{EdgeId, Element, HalfedgeId, PerEdge, TriangleMesh, VertexId};

/// The arcs of a net, and which one runs along each edge.
pub(super) struct TracedArcs {
    pub(super) arcs: Vec<Arc>,
    /// The arc along each edge, and whether it runs in the direction of the
    /// [`edge_halfedge`](crate::mesh::CornerTable::edge_halfedge).
    of_edge: PerEdge<Option<(ArcId, bool)>>,
}

impl TracedArcs {
    /// Follows the edges from node to node, in the order of edges.
    pub(super) fn of(graph: &ArcGraph<'_>) -> Self {
        let mut traced = Self {
            arcs: Vec::new(),
            of_edge: PerEdge::filled(graph.kinds.len(), None),
        };
        for edge in graph.arc_edges() {
            let start = graph.ends(edge).into_iter().find(|&end| graph.is_node(end));
            if let (None, Some(start)) = (traced.of_edge[edge], start) {
                traced.add(graph, start, edge);
            }
        }
        traced
    }

    fn add(&mut self, graph: &ArcGraph<'_>, start: VertexId, first: EdgeId) {
        let (vertices, edges) = graph.follow(start, first);
        let number = ArcId::from_index(self.arcs.len());
        for (&edge, &from) in edges.iter().zip(&vertices) {
            self.of_edge[edge] = Some((number, graph.ends(edge)[0] == from));
        }
        let kind = graph.kinds[first].unwrap_or(ArcKind::Line);
        self.arcs.push(Arc { vertices, kind });
    }

    /// The arc along a halfedge, and how it is passed.
    pub(super) fn along(
        &self,
        mesh: &TriangleMesh,
        halfedge: HalfedgeId,
    ) -> Option<(ArcId, Direction)> {
        let edge = mesh.edge(halfedge);
        let (arc, ascending) = self.of_edge[edge]?;
        let same = (mesh.edge_halfedge(edge) == halfedge) == ascending;
        let direction = if same {
            Direction::Forward
        } else {
            Direction::Backward
        };
        Some((arc, direction))
    }
}
