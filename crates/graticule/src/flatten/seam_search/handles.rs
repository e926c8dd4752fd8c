//! Edges along which a surface with handles becomes a disk: shortest loops by a tree of shortest
//! paths and a tree of triangles (tree and cotree: Eppstein 2003; the greedy choice: Erickson and
//! Whittlesey 2005).

use super::paths::{EdgeGraph, Paths};
use crate::mesh::{DisjointSets, EdgeId, Element, PerEdge, Surface, VertexId};

/// Roots that are tried; the shortest graph counts.
const ROOTS: usize = 4;

/// A cut graph: without its edges, and those of the boundary, the surface is a disk.
pub(super) fn cut_graph(surface: &Surface, graph: &EdgeGraph<'_>) -> Vec<EdgeId> {
    let mesh = surface.mesh();
    let mut best: Option<(f64, Vec<EdgeId>)> = None;
    let mut root = VertexId(0);
    for _ in 0..ROOTS {
        let paths = graph.shortest_paths(|vertex| vertex == root);
        let edges = pruned(graph, cut_graph_from(graph, &paths));
        let length: f64 = edges.iter().map(|&edge| graph.length(edge)).sum();
        // The next root lies where this graph runs, half way through it.
        root = edges
            .get(edges.len() / 2)
            .map_or(root, |&edge| mesh.origin(mesh.edge_halfedge(edge)));
        if best.as_ref().is_none_or(|(least, _)| length < *least) {
            best = Some((length, edges));
        }
    }
    best.map_or_else(Vec::new, |(_, edges)| edges)
}

/// The loops through the root that the two trees leave, as a set of edges; those of the boundary
/// are in it.
fn cut_graph_from(graph: &EdgeGraph<'_>, paths: &Paths<'_>) -> PerEdge<bool> {
    let mesh = graph.mesh();
    let mut in_tree = PerEdge::filled(mesh.edge_count(), false);
    for edge in paths.last_edges.iter().flatten() {
        in_tree[*edge] = true;
    }
    let loop_length = |edge: EdgeId| {
        let [from, to] = mesh.ends(mesh.edge_halfedge(edge));
        if graph.may_cut(edge) {
            paths.distances[from] + paths.distances[to] + graph.length(edge)
        } else {
            f64::INFINITY
        }
    };
    let mut crossable: Vec<(f64, EdgeId)> = mesh
        .edges()
        .filter(|&edge| !in_tree[edge] && !mesh.is_boundary_edge(edge))
        .map(|edge| (loop_length(edge), edge))
        .collect();
    // The longest loops are given up first.
    crossable.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut pieces = DisjointSets::new(mesh.face_count());
    let mut in_graph = PerEdge::from_fn(mesh.edge_count(), |edge| mesh.is_boundary_edge(edge));
    for (_, edge) in crossable {
        let side = mesh.edge_halfedge(edge);
        let faces = mesh.twin(side).map(|twin| [side.face().0, twin.face().0]);
        if faces.is_some_and(|faces| !pieces.join(faces[0], faces[1])) {
            in_graph[edge] = true;
        }
    }
    let loops: Vec<EdgeId> = mesh.edges().filter(|&edge| in_graph[edge]).collect();
    for edge in loops {
        for end in mesh.ends(mesh.edge_halfedge(edge)) {
            for step in paths.path_to(end) {
                in_graph[step] = true;
            }
        }
    }
    in_graph
}

/// The graph without its dead ends and without edges of the boundary, ascending.
fn pruned(graph: &EdgeGraph<'_>, mut in_graph: PerEdge<bool>) -> Vec<EdgeId> {
    let mesh = graph.mesh();
    let ends = |edge| mesh.ends(mesh.edge_halfedge(edge));
    let mut degrees = vec![0_u32; mesh.vertex_count()];
    for edge in mesh.edges().filter(|&edge| in_graph[edge]) {
        for end in ends(edge) {
            degrees[end.index()] += 1;
        }
    }
    let mut dead_ends: Vec<VertexId> = mesh
        .vertices()
        .filter(|v| degrees[v.index()] == 1)
        .collect();
    while let Some(vertex) = dead_ends.pop() {
        let sides = mesh
            .outgoing(vertex)
            .flat_map(|side| [side, side.previous()]);
        let last = sides
            .map(|side| mesh.edge(side))
            .find(|&edge| in_graph[edge]);
        let Some(edge) = last.filter(|_| degrees[vertex.index()] == 1) else {
            continue;
        };
        in_graph[edge] = false;
        for end in ends(edge) {
            degrees[end.index()] -= 1;
            if degrees[end.index()] == 1 {
                dead_ends.push(end);
            }
        }
    }
    let is_inner = |edge: &EdgeId| in_graph[*edge] && !mesh.is_boundary_edge(*edge);
    mesh.edges().filter(is_inner).collect()
}
