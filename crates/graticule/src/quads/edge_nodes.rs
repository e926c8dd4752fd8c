use std::cmp::Ordering;

use super::QuadsError;
use super::line::{Lines, NO_LINE, STEPS, Share, Steps, corner_steps, lines_beyond, lines_through};
use crate::mesh::{EdgeId, Element, HalfedgeId, PerEdge, TriangleMesh};
use crate::periodic::GridMap;

/// Largest number of places where lines meet edges: node and dart numbers stay within 32 bits.
const MOST_NODES: u64 = 1 << 28;

/// A place inside an edge that a line passes.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeNode {
    /// How far along [`EdgeNodes::side`].
    pub(super) share: f64,
    /// The lines through it, in the coordinates of the triangle of [`EdgeNodes::side`].
    pub(super) lines: Lines,
}

/// Where lines meet the insides of edges: found once per edge, so that both triangles share the very
/// same places (reading of [PGP06] Algorithm 2).
///
/// [PGP06]: crate::papers::PGP06
pub(super) struct EdgeNodes {
    sides: PerEdge<HalfedgeId>,
    /// The lines that run along the edge.
    along: PerEdge<Lines>,
    starts: Vec<u32>,
    nodes: Vec<EdgeNode>,
}

impl EdgeNodes {
    /// # Errors
    /// [`QuadsError::TooFine`].
    pub(super) fn of(mesh: &TriangleMesh, map: &GridMap) -> Result<Self, QuadsError> {
        let sides = PerEdge::from_fn(mesh.edge_count(), |edge| chosen_side(mesh, map, edge));
        // Without coordinates an edge is a point between lines, which nothing passes.
        let nowhere = [[1; 2]; 2];
        let ends = |edge: EdgeId| {
            let side: HalfedgeId = sides[edge];
            if map.is_left_out(side.face()) {
                nowhere
            } else {
                [side, side.next()].map(|corner| corner_steps(map, corner))
            }
        };
        let crossings: u64 = mesh.edges().map(|edge| crossing_bound(ends(edge))).sum();
        if crossings > MOST_NODES {
            return Err(QuadsError::TooFine {
                crossings,
                limit: MOST_NODES,
            });
        }
        let mut found = Self {
            along: PerEdge::from_fn(mesh.edge_count(), |edge| lines_along(ends(edge))),
            sides: sides.clone(),
            starts: vec![0],
            nodes: Vec::with_capacity(crossings as usize),
        };
        for edge in mesh.edges() {
            found.add_crossings(ends(edge), found.along[edge]);
        }
        Ok(found)
    }

    fn add_crossings(&mut self, ends: [Steps; 2], along: Lines) {
        let [mut first, mut second] = [0, 1].map(|axis| crossings(axis, ends).peekable());
        loop {
            let order = match (first.peek(), second.peek()) {
                (Some((_, a)), Some((_, b))) => a.compare(*b),
                (Some(_), None) => Ordering::Less,
                (None, Some(_)) => Ordering::Greater,
                (None, None) => break,
            };
            let mut lines = along;
            let mut share = 0.0;
            if order.is_le()
                && let Some((line, at)) = first.next()
            {
                (lines[0], share) = (line, at.value());
            }
            if order.is_ge()
                && let Some((line, at)) = second.next()
            {
                (lines[1], share) = (line, at.value());
            }
            self.nodes.push(EdgeNode { share, lines });
        }
        self.starts.push(self.nodes.len() as u32);
    }

    /// The number of places of all edges.
    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The number of pieces into which the places cut the edges.
    pub(super) fn piece_count(&self) -> usize {
        self.nodes.len() + self.along.len()
    }

    /// The halfedge along which the places of the edge are ordered.
    pub(super) fn side(&self, edge: EdgeId) -> HalfedgeId {
        self.sides[edge]
    }

    /// Whether a line runs along the edge.
    pub(super) fn is_along(&self, edge: EdgeId) -> bool {
        self.along[edge] != [NO_LINE; 2]
    }

    /// The number of the first place of the edge.
    pub(super) fn first(&self, edge: EdgeId) -> usize {
        self.starts[edge.index()] as usize
    }

    /// The number of the first piece of the edge.
    pub(super) fn first_piece(&self, edge: EdgeId) -> usize {
        self.first(edge) + edge.index()
    }

    /// The places of the edge, along its side.
    pub(super) fn of_edge(&self, edge: EdgeId) -> &[EdgeNode] {
        let index = edge.index();
        &self.nodes[self.starts[index] as usize..self.starts[index + 1] as usize]
    }

    /// Each place inside the halfedge in its direction: its number, its share of the way along the
    /// halfedge, and the lines through it in the coordinates of the halfedge's triangle.
    pub(super) fn along_halfedge(
        &self,
        mesh: &TriangleMesh,
        map: &GridMap,
        halfedge: HalfedgeId,
    ) -> impl Iterator<Item = (usize, f64, Lines)> {
        let edge = mesh.edge(halfedge);
        let (first, nodes, side) = (self.first(edge), self.of_edge(edge), self.sides[edge]);
        let over = map.transition(side);
        (0..nodes.len()).map(move |index| {
            if side == halfedge {
                let node = nodes[index];
                (first + index, node.share, node.lines)
            } else {
                let index = nodes.len() - 1 - index;
                let node = nodes[index];
                let lines = over.map_or([NO_LINE; 2], |over| lines_beyond(node.lines, over));
                (first + index, 1.0 - node.share, lines)
            }
        })
    }
}

/// The side of the edge whose triangle has coordinates; the one of smaller number if both have.
fn chosen_side(mesh: &TriangleMesh, map: &GridMap, edge: EdgeId) -> HalfedgeId {
    let first = mesh.edge_halfedge(edge);
    match mesh.twin(first) {
        Some(twin) if map.is_left_out(first.face()) => twin,
        _ => first,
    }
}

/// The lines along which both ends lie.
fn lines_along([from, to]: [Steps; 2]) -> Lines {
    let through = lines_through(from);
    [0, 1].map(|axis| {
        if from[axis] == to[axis] {
            through[axis]
        } else {
            NO_LINE
        }
    })
}

/// The lines of a family that pass strictly between the ends, in the order of the way.
fn crossings(axis: usize, [from, to]: [Steps; 2]) -> impl Iterator<Item = (i32, Share)> {
    let [from, to] = [from[axis], to[axis]];
    let (low, high) = (from.min(to), from.max(to));
    let first = low.div_euclid(STEPS) + 1;
    let end = -(-high).div_euclid(STEPS);
    (first..end).map(move |line| {
        let line = (if from < to {
            line
        } else {
            first + end - 1 - line
        }) as i32;
        (line, Share::at(line, from, to))
    })
}

/// At least as many as lines cross between the ends.
fn crossing_bound([from, to]: [Steps; 2]) -> u64 {
    let lines = |axis: usize| (to[axis].abs_diff(from[axis])).div_ceil(STEPS.cast_unsigned());
    lines(0) + lines(1)
}
