//! The lines of a mesh file on its surface.

use graticule::mesh::{EdgeId, NO_VALUE, PolygonSoup, Repaired, TriangleMesh, VertexId};

/// The segments of the polylines of a file: those that run along edges of its surface, and others.
pub(crate) struct Lines {
    /// The edges that segments run along, in the order of the file.
    pub(crate) edges: Vec<EdgeId>,
    /// The other segments, by vertices of the file.
    pub(crate) beside: Vec<[u32; 2]>,
}

impl Lines {
    pub(crate) fn of(soup: &PolygonSoup, repaired: &Repaired) -> Self {
        let (mut edges, mut beside) = (Vec::new(), Vec::new());
        if soup.polylines.is_empty() {
            return Self { edges, beside };
        }
        let mesh = repaired.surface.mesh();
        let vertices = repaired.mesh_vertices(soup);
        let steps = soup.polylines.iter().flat_map(|line| line.windows(2));
        for step in steps.map(|step| [step[0], step[1]]) {
            let ends = step.map(|vertex| vertices.get(vertex as usize).copied());
            let edge = match ends.map(|end| end.filter(|&end| end != NO_VALUE)) {
                [Some(from), Some(to)] => edge_between(mesh, VertexId(from), VertexId(to)),
                _ => None,
            };
            match edge {
                Some(edge) => edges.push(edge),
                None => beside.push(step),
            }
        }
        Self { edges, beside }
    }
}

fn edge_between(mesh: &TriangleMesh, from: VertexId, to: VertexId) -> Option<EdgeId> {
    let side = mesh.halfedge_between(from, to);
    let side = side.or_else(|| mesh.halfedge_between(to, from));
    side.map(|side| mesh.edge(side))
}
