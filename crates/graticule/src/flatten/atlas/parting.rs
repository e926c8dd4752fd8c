//! Where to cut a patch whose map overlaps itself.
//!
//! Two edges of the outer boundary that meet in the map lie on different parts of it as soon as a
//! way between the two arcs of the boundary beside them is cut. The shortest one about half way
//! between both is taken, as in fuzzy decompositions of meshes (Katz and Tal 2003, *Hierarchical
//! Mesh Decomposition using Fuzzy Clustering and Cuts*).

use crate::flatten::Patch;
use crate::flatten::seam_search::EdgeGraph;
use crate::mesh::{EdgeId, PerEdge, PerVertex, VertexId};

/// How near to the middle between both edges a cut runs, as a share of the way between them.
const BAND: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];

/// The edges to cut along so that not all of these boundary edges, which meet in pairs, can meet
/// again: from side to side, or from a hole to the outer boundary. Nothing if no way runs along
/// edges that may be cut.
pub(super) fn way_apart(
    patch: &Patch,
    meetings: &[[[VertexId; 2]; 2]],
    mut may_cut: PerEdge<bool>,
) -> Option<Vec<EdgeId>> {
    let mesh = patch.mesh();
    for &side in mesh.boundary_loop(patch.outer_loop()) {
        may_cut[mesh.edge(side)] = false;
    }
    let outline = Outline::of(patch);
    let most_apart = meetings
        .iter()
        .map(|pair| (outline.distance(pair), pair))
        .reduce(|best, next| if next.0 > best.0 { next } else { best })?;
    match most_apart {
        (Some(_), pair) => way_across(patch, &outline, pair, &may_cut),
        (None, pair) => way_out(patch, &outline, pair, &may_cut),
    }
}

/// The outer boundary, by the way along it.
struct Outline {
    /// How far along each vertex lies; `None` for those elsewhere.
    marks: PerVertex<Option<f64>>,
    length: f64,
}

impl Outline {
    fn of(patch: &Patch) -> Self {
        let mut marks = PerVertex::filled(patch.mesh().vertex_count(), None);
        let mut length = 0.0;
        let vertices = patch.loop_vertices(patch.outer_loop());
        for (vertex, step) in vertices.zip(patch.unit_steps(patch.outer_loop())) {
            marks[vertex] = Some(length);
            length += step;
        }
        Self { marks, length }
    }

    /// How far apart two edges of the outline are along it; `None` if one of them is elsewhere.
    fn distance(&self, &[[first, _], [second, _]]: &[[VertexId; 2]; 2]) -> Option<f64> {
        let between = (self.marks[first]? - self.marks[second]?).abs();
        Some(between.min(self.length - between))
    }

    /// Whether a vertex lies on the outline after the end of the first edge and up to the start of
    /// the second.
    fn is_between(&self, vertex: VertexId, from: VertexId, to: VertexId) -> bool {
        let marks = [vertex, from, to].map(|vertex| self.marks[vertex]);
        let [Some(at), Some(from), Some(to)] = marks else {
            return false;
        };
        if from <= to {
            (from..=to).contains(&at)
        } else {
            at >= from || at <= to
        }
    }
}

/// The shortest way from one arc of the outline between two of its edges to the other.
fn way_across(
    patch: &Patch,
    outline: &Outline,
    &[first, second]: &[[VertexId; 2]; 2],
    may_cut: &PerEdge<bool>,
) -> Option<Vec<EdgeId>> {
    let mesh = patch.mesh();
    let everywhere = EdgeGraph::new(patch.unit_surface(), may_cut);
    let [near_first, near_second] = [first, second].map(|ends| {
        everywhere
            .shortest_paths(|vertex| ends.contains(&vertex))
            .distances
    });
    let in_band = |vertex: VertexId| {
        let share = near_first[vertex] / (near_first[vertex] + near_second[vertex]);
        (BAND[0]..=BAND[1]).contains(&share)
    };
    let banded = PerEdge::from_fn(mesh.edge_count(), |edge| {
        let ends = mesh.ends(mesh.edge_halfedge(edge));
        may_cut[edge] && ends.into_iter().all(in_band)
    });
    let starts = |vertex| outline.is_between(vertex, first[1], second[0]);
    let ends = |vertex: &VertexId| outline.is_between(*vertex, second[1], first[0]);
    let shortest = |graph: &EdgeGraph<'_>| {
        let paths = graph.shortest_paths(starts);
        let reached = |vertex: &VertexId| paths.distances[*vertex].is_finite();
        let goals = mesh.vertices().filter(ends).filter(reached);
        let goal = goals.min_by(|&a, &b| paths.distances[a].total_cmp(&paths.distances[b]))?;
        let way: Vec<EdgeId> = paths.path_to(goal).collect();
        (!way.is_empty()).then_some(way)
    };
    shortest(&EdgeGraph::new(patch.unit_surface(), &banded)).or_else(|| shortest(&everywhere))
}

/// The shortest way from the outline to the hole on which one of two edges lies.
fn way_out(
    patch: &Patch,
    outline: &Outline,
    pair: &[[VertexId; 2]; 2],
    may_cut: &PerEdge<bool>,
) -> Option<Vec<EdgeId>> {
    let on_hole = pair.iter().flatten().copied();
    let goal = on_hole.into_iter().find(|&v| outline.marks[v].is_none())?;
    let graph = EdgeGraph::new(patch.unit_surface(), may_cut);
    let paths = graph.shortest_paths(|vertex| outline.marks[vertex].is_some());
    let way: Vec<EdgeId> = paths.path_to(goal).collect();
    (!way.is_empty()).then_some(way)
}
