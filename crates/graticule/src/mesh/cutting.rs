//! A surface cut open along edges.

use super::disjoint_sets::DisjointSets;
use super::{EdgeId, Element, HalfedgeId, MeshError, PerEdge, PerVertex, Surface, VertexId};

/// A surface cut open. Triangles, and with them halfedges and corners, keep their numbers; vertices
/// along the cut are doubled.
#[derive(Clone, Debug, PartialEq)]
pub struct CutSurface {
    /// The surface with the cut as boundary.
    pub surface: Surface,
    /// The vertex that each vertex was before. They ascend.
    pub vertex_sources: PerVertex<VertexId>,
}

/// Cuts a surface open along edges, as scissors would: a vertex becomes as many as the cut and the
/// boundary leave it parts. Edges of the boundary change nothing.
///
/// The surface may fall into pieces. A single edge inside, from which neither the cut nor the
/// boundary goes on, opens nothing and stays as it is. Cost: near-linear.
///
/// # Panics
/// If an edge is not one of the surface's.
///
/// # Errors
/// None for a sound surface; those of [`Surface::from_triangles`] else.
pub fn cut_along(
    surface: &Surface,
    edges: impl IntoIterator<Item = EdgeId>,
) -> Result<CutSurface, MeshError> {
    let mesh = surface.mesh();
    let mut is_cut = PerEdge::filled(mesh.edge_count(), false);
    for edge in edges {
        is_cut[edge] = true;
    }
    let mut corners = DisjointSets::new(mesh.halfedge_count());
    for halfedge in mesh.halfedges() {
        if let Some(twin) = mesh.twin(halfedge).filter(|_| !is_cut[mesh.edge(halfedge)]) {
            corners.join(halfedge.0, twin.next().0);
        }
    }
    let names = corners.into_names();
    let mut parts: Vec<(VertexId, u32)> = (0_u32..)
        .zip(&names)
        .filter(|&(corner, &name)| corner == name)
        .map(|(corner, _)| (mesh.origin(HalfedgeId(corner)), corner))
        .collect();
    parts.sort_unstable();
    let mut numbers = vec![0; names.len()];
    for (number, &(_, corner)) in (0_u32..).zip(&parts) {
        numbers[corner as usize] = number;
    }
    let vertex = |corner: HalfedgeId| numbers[names[corner.index()] as usize];
    let triangles: Vec<_> = mesh
        .faces()
        .map(|face| face.halfedges().map(vertex))
        .collect();
    let positions = parts.iter().map(|&(source, _)| surface.position(source));
    Ok(CutSurface {
        surface: Surface::from_triangles(positions.collect(), &triangles)?,
        vertex_sources: PerVertex::new(parts.iter().map(|&(source, _)| source).collect()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Topology;
    use graticule_fixtures::{Fixture, cube, disk, torus};

    fn surface(fixture: &Fixture) -> Surface {
        Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap()
    }

    #[test]
    fn without_a_cut_nothing_changes() {
        let whole = surface(&torus(2.0, 0.5, 12, 6));
        let cut = cut_along(&whole, []).unwrap();
        assert_eq!(cut.surface, whole);
    }

    #[test]
    fn one_edge_inside_does_not_open_and_two_do() {
        let whole = surface(&cube());
        let mesh = whole.mesh();
        let first = HalfedgeId(0);
        let one = cut_along(&whole, [mesh.edge(first)]).unwrap();
        assert_eq!(one.surface, whole);
        let two = cut_along(&whole, [mesh.edge(first), mesh.edge(first.next())]).unwrap();
        assert_eq!(two.surface.mesh().vertex_count(), mesh.vertex_count() + 1);
        assert!(Topology::of(two.surface.mesh()).total.is_disk());
    }

    #[test]
    fn cutting_all_edges_leaves_single_triangles_that_know_where_they_came_from() {
        let whole = surface(&disk(2));
        let cut = cut_along(&whole, whole.mesh().edges()).unwrap();
        let topology = Topology::of(cut.surface.mesh());
        assert_eq!(topology.components.len(), whole.mesh().face_count());
        for corner in whole.mesh().halfedges() {
            let vertex = cut.surface.mesh().origin(corner);
            assert_eq!(cut.vertex_sources[vertex], whole.mesh().origin(corner));
        }
    }
}
