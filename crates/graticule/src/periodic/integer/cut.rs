//! Where coordinates may jump: a graph of edges whose complement is one disk for each component.

use std::collections::VecDeque;

use crate::mesh::{
    FaceId, HalfedgeId, PerCorner, PerEdge, PerFace, PerVertex, TriangleMesh, VertexId,
};
use crate::periodic::QuarterTurn;

/// A spanning tree of the triangles of each component.
#[derive(Clone, Debug)]
pub(super) struct DualForest {
    /// The triangles, each after the one it was entered from, with the halfedge of that one.
    pub(super) order: Vec<(FaceId, Option<HalfedgeId>)>,
    /// Edges that a branch crosses.
    crossed: PerEdge<bool>,
}

impl DualForest {
    /// Breadth first, from the first triangle of each component; edges of `barriers` are crossed
    /// only where all that hangs together without is done.
    ///
    /// So the cut follows lines that are barriers and does not cross them: coordinates that are
    /// constant along a line stay short sums of shifts.
    pub(super) fn of(mesh: &TriangleMesh, barriers: &PerEdge<bool>) -> Self {
        let mut order = Vec::with_capacity(mesh.face_count());
        let mut crossed = PerEdge::filled(mesh.edge_count(), false);
        let mut seen = PerFace::filled(mesh.face_count(), false);
        let mut queue = VecDeque::new();
        let mut beyond = VecDeque::new();
        for root in mesh.faces() {
            queue.push_back((root, None));
            while let Some((face, entered)) = queue.pop_front().or_else(|| beyond.pop_front()) {
                if std::mem::replace(&mut seen[face], true) {
                    continue;
                }
                order.push((face, entered));
                if let Some(from) = entered {
                    crossed[mesh.edge(from)] = true;
                }
                for halfedge in face.halfedges() {
                    let twin = mesh.twin(halfedge).filter(|twin| !seen[twin.face()]);
                    let next = twin.map(|twin| (twin.face(), Some(halfedge)));
                    if barriers[mesh.edge(halfedge)] {
                        beyond.extend(next);
                    } else {
                        queue.extend(next);
                    }
                }
            }
        }
        Self { order, crossed }
    }
}

/// How a halfedge crosses the cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Crossing {
    /// The chain that the edge belongs to.
    pub(super) chain: u32,
    /// Whether the shift of the chain is that from this halfedge's triangle to its twin's, and not
    /// that of the way back.
    pub(super) is_forward: bool,
}

/// The edges across which coordinates jump, in chains along which the jump is the same.
#[derive(Clone, Debug)]
pub(super) struct Cut {
    /// For each halfedge on the cut how it crosses it.
    pub(super) crossings: PerCorner<Option<Crossing>>,
    /// Number of chains.
    pub(super) chains: usize,
    /// Vertices inside the surface where chains end.
    pub(super) nodes: Vec<VertexId>,
}

impl Cut {
    /// The edges that no branch of the forest crosses, less all dead ends that do not lead to a
    /// vertex of `steps` other than 0.
    pub(super) fn of(mesh: &TriangleMesh, forest: &DualForest, steps: &PerVertex<i32>) -> Self {
        let mut graph = CutGraph::of(mesh, forest);
        graph.prune(mesh, steps);
        graph.into_chains(mesh, steps)
    }
}

struct CutGraph {
    is_cut: PerEdge<bool>,
    degrees: PerVertex<u32>,
}

impl CutGraph {
    fn of(mesh: &TriangleMesh, forest: &DualForest) -> Self {
        let is_cut = PerEdge::from_fn(mesh.edge_count(), |edge| {
            !forest.crossed[edge] && !mesh.is_boundary_edge(edge)
        });
        let mut degrees = PerVertex::filled(mesh.vertex_count(), 0);
        for (edge, _) in is_cut.enumerate().filter(|(_, is_cut)| **is_cut) {
            for vertex in mesh.ends(mesh.edge_halfedge(edge)) {
                degrees[vertex] += 1;
            }
        }
        Self { is_cut, degrees }
    }

    fn prune(&mut self, mesh: &TriangleMesh, steps: &PerVertex<i32>) {
        let mut ends: Vec<VertexId> = mesh.vertices().collect();
        while let Some(vertex) = ends.pop() {
            let is_dead_end =
                self.degrees[vertex] == 1 && steps[vertex] == 0 && !mesh.is_boundary_vertex(vertex);
            if !is_dead_end {
                continue;
            }
            let last = self.cut_halfedges(mesh, vertex).next();
            if let Some(halfedge) = last {
                let other = mesh.destination(halfedge);
                self.is_cut[mesh.edge(halfedge)] = false;
                self.degrees[vertex] -= 1;
                self.degrees[other] -= 1;
                ends.push(other);
            }
        }
    }

    /// The halfedges on the cut that leave the vertex.
    fn cut_halfedges<'a>(
        &'a self,
        mesh: &'a TriangleMesh,
        vertex: VertexId,
    ) -> impl Iterator<Item = HalfedgeId> + 'a {
        mesh.outgoing(vertex)
            .filter(|&halfedge| self.is_cut[mesh.edge(halfedge)])
    }

    fn into_chains(self, mesh: &TriangleMesh, steps: &PerVertex<i32>) -> Cut {
        let is_node = PerVertex::from_fn(mesh.vertex_count(), |vertex| {
            let degree = self.degrees[vertex];
            let ends = degree != 2 || steps[vertex] != 0 || mesh.is_boundary_vertex(vertex);
            degree > 0 && ends
        });
        let mut cut = Cut {
            crossings: PerCorner::filled(mesh.halfedge_count(), None),
            chains: 0,
            nodes: Vec::new(),
        };
        for vertex in mesh.vertices().filter(|&vertex| is_node[vertex]) {
            if !mesh.is_boundary_vertex(vertex) {
                cut.nodes.push(vertex);
            }
            for halfedge in self.cut_halfedges(mesh, vertex) {
                self.walk(mesh, &is_node, halfedge, &mut cut);
            }
        }
        cut
    }

    /// Follows a chain from its first halfedge to the next node.
    fn walk(
        &self,
        mesh: &TriangleMesh,
        is_node: &PerVertex<bool>,
        first: HalfedgeId,
        cut: &mut Cut,
    ) {
        if cut.crossings[first].is_some() {
            return;
        }
        let chain = cut.chains as u32;
        cut.chains += 1;
        let mut next = Some(first);
        while let Some(halfedge) = next {
            let crossing = |is_forward| Some(Crossing { chain, is_forward });
            cut.crossings[halfedge] = crossing(true);
            if let Some(twin) = mesh.twin(halfedge) {
                cut.crossings[twin] = crossing(false);
            }
            let end = mesh.destination(halfedge);
            let mut onward = self.cut_halfedges(mesh, end);
            next = onward.find(|&h| !is_node[end] && cut.crossings[h].is_none());
        }
    }
}

/// A jump across the cut as it is carried on: the shift of a chain, turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ChainShift {
    pub(super) chain: u32,
    pub(super) turn: QuarterTurn,
}

/// How coordinates of one triangle become those of another: a turn, then a sum of shifts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Jump {
    pub(super) turn: QuarterTurn,
    pub(super) shifts: Vec<ChainShift>,
}

impl Jump {
    /// This jump, then that across a halfedge. Shifts that cancel are dropped.
    pub(super) fn across(
        &mut self,
        turns: &PerCorner<QuarterTurn>,
        cut: &Cut,
        halfedge: HalfedgeId,
    ) {
        let turn = turns[halfedge];
        self.turn = self.turn.then(turn);
        for shift in &mut self.shifts {
            shift.turn = shift.turn.then(turn);
        }
        let Some(Crossing { chain, is_forward }) = cut.crossings[halfedge] else {
            return;
        };
        // The way back of `p ↦ R p + t` shifts by `-R⁻¹ t`.
        let turn = if is_forward {
            QuarterTurn::NONE
        } else {
            turn.then(QuarterTurn::BACK)
        };
        self.push(ChainShift { chain, turn });
    }

    fn push(&mut self, shift: ChainShift) {
        let opposite = ChainShift {
            turn: shift.turn.then(QuarterTurn::BACK),
            ..shift
        };
        match self.shifts.iter().position(|other| *other == opposite) {
            Some(place) => {
                self.shifts.remove(place);
            }
            None => self.shifts.push(shift),
        }
    }

    /// This jump, then the other.
    pub(super) fn then(&self, next: &Self) -> Self {
        let turned = self.shifts.iter().map(|shift| ChainShift {
            turn: shift.turn.then(next.turn),
            ..*shift
        });
        let mut both = Self {
            turn: self.turn.then(next.turn),
            shifts: turned.collect(),
        };
        for &shift in &next.shifts {
            both.push(shift);
        }
        both
    }

    /// The way back.
    pub(super) fn inverse(&self) -> Self {
        let turn = self.turn.inverse();
        let back = |shift: &ChainShift| ChainShift {
            turn: shift.turn.then(turn).then(QuarterTurn::BACK),
            ..*shift
        };
        Self {
            turn,
            shifts: self.shifts.iter().map(back).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_and_its_way_back_are_no_jump() {
        let shift = |chain, quarters| ChainShift {
            chain,
            turn: QuarterTurn::of_quarters(quarters),
        };
        let jump = Jump {
            turn: QuarterTurn::LEFT,
            shifts: vec![shift(3, 1), shift(0, 2), shift(3, 0)],
        };
        assert_eq!(jump.then(&jump.inverse()), Jump::default());
        assert_eq!(jump.inverse().then(&jump), Jump::default());
    }
}
