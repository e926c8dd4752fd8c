//! Rims: connected pieces of boundary and seam. Cut open, the surface has one loop for each.

use crate::mesh::{DisjointSets, EdgeId, Element, PerVertex, TriangleMesh, VertexId, number_names};

/// The rims of a surface, each shrunk to one node; every other vertex is a node of its own.
pub(super) struct Rims {
    nodes: PerVertex<u32>,
    /// Vertices less edges of the rim at each node; `None` where there is none.
    characteristics: Vec<Option<i32>>,
}

impl Rims {
    /// The rims that open edges make.
    pub(super) fn of(mesh: &TriangleMesh, is_open: impl Fn(EdgeId) -> bool) -> Self {
        let open = || mesh.edges().filter(|&edge| is_open(edge));
        let ends = |edge: EdgeId| mesh.ends(mesh.edge_halfedge(edge));
        let mut sets = DisjointSets::new(mesh.vertex_count());
        let mut on_rim = PerVertex::filled(mesh.vertex_count(), false);
        for [from, to] in open().map(ends) {
            sets.join(from.0, to.0);
            [on_rim[from], on_rim[to]] = [true; 2];
        }
        let mut names = sets.into_names();
        let count = number_names(&mut names);
        let nodes = PerVertex::new(names);
        let mut characteristics = vec![None; count];
        for vertex in mesh.vertices().filter(|&vertex| on_rim[vertex]) {
            *characteristics[nodes[vertex] as usize].get_or_insert(0) += 1;
        }
        for [from, _] in open().map(ends) {
            *characteristics[nodes[from] as usize].get_or_insert(0) -= 1;
        }
        Self {
            nodes,
            characteristics,
        }
    }

    /// One vertex as the only rim.
    pub(super) fn point(mesh: &TriangleMesh, vertex: VertexId) -> Self {
        let mut characteristics = vec![None; mesh.vertex_count()];
        characteristics[vertex.index()] = Some(1);
        Self {
            nodes: PerVertex::from_fn(mesh.vertex_count(), |vertex| vertex.0),
            characteristics,
        }
    }

    pub(super) fn node_count(&self) -> usize {
        self.characteristics.len()
    }

    pub(super) fn node(&self, vertex: VertexId) -> usize {
        self.nodes[vertex] as usize
    }

    /// The nodes that are rims, with vertices less edges of each.
    pub(super) fn rims(&self) -> impl Iterator<Item = (usize, i32)> + '_ {
        let nodes = self.characteristics.iter().enumerate();
        nodes.filter_map(|(node, characteristic)| Some((node, (*characteristic)?)))
    }
}
