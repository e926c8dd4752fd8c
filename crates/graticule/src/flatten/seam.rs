//! A patch cut open along short ways from its outer boundary to given vertices.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::mesh::{EdgeId, Element, HalfedgeId, PerVertex, Surface, TriangleMesh, VertexId};
use crate::watch::Watch;

use super::{FlattenError, Patch};

/// The patch cut open so that the given interior vertices come to lie on its outer boundary, and
/// the vertex behind each vertex of the result. Triangles keep their numbers.
///
/// Each way is the shortest along edges to what is boundary already; holes are kept apart.
pub(super) fn cut_to(
    patch: &Patch,
    tips: &[VertexId],
    watch: &Watch,
) -> Result<(Patch, PerVertex<VertexId>), FlattenError> {
    let _stage = watch.stage("cut to cones");
    let mesh = patch.mesh();
    let mut is_cut = vec![false; mesh.edge_count()];
    let mut is_source = vec![false; mesh.vertex_count()];
    for vertex in patch.loop_vertices(patch.outer_loop()) {
        is_source[vertex.index()] = true;
    }
    for &tip in tips {
        watch.check()?;
        if is_source[tip.index()] {
            continue;
        }
        let way = shortest_way(patch, &is_source, tip);
        if way.is_empty() {
            let reason = "cannot be reached from the outer boundary without crossing a hole";
            return Err(FlattenError::BadTarget {
                vertex: tip,
                reason,
            });
        }
        for halfedge in way {
            is_cut[mesh.edge(halfedge).index()] = true;
            for end in mesh.ends(halfedge) {
                is_source[end.index()] = true;
            }
        }
    }
    let (triangles, sources) = opened(mesh, &is_cut);
    let positions = sources.map(|&source| patch.surface().position(source));
    let opened = TriangleMesh::new(sources.len(), &triangles)?;
    let cut = Patch::new(Surface::new(opened, positions)?, watch)?;
    let start = patch.loop_vertices(patch.outer_loop()).next();
    let loops = cut.mesh().boundary_loops();
    let mut holding = loops.filter(|&boundary_loop| {
        let mut vertices = cut.loop_vertices(boundary_loop);
        vertices.any(|vertex| Some(sources[vertex]) == start)
    });
    let outer = holding.next().unwrap_or(cut.outer_loop());
    drop(holding);
    Ok((cut.with_outer_loop(outer)?, sources))
}

/// The edges of the shortest way from a vertex to a source (E. W. Dijkstra 1959), around holes.
fn shortest_way(patch: &Patch, is_source: &[bool], tip: VertexId) -> Vec<HalfedgeId> {
    let mesh = patch.mesh();
    let mut back: Vec<Option<HalfedgeId>> = vec![None; mesh.vertex_count()];
    let mut distance = vec![f64::INFINITY; mesh.vertex_count()];
    distance[tip.index()] = 0.0;
    // Distances are not negative: their bits order as they do.
    let mut waiting = BinaryHeap::from([Reverse((0, tip))]);
    let mut reached = None;
    while let Some(Reverse((bits, vertex))) = waiting.pop() {
        let here = f64::from_bits(bits);
        if here > distance[vertex.index()] {
            continue;
        }
        if is_source[vertex.index()] {
            reached = Some(vertex);
            break;
        }
        for halfedge in mesh.outgoing(vertex) {
            let other = mesh.destination(halfedge);
            let on_hole = mesh.is_boundary_vertex(other) && !is_source[other.index()];
            let length = patch.unit_surface().halfedge_vector(halfedge).length();
            if !on_hole && here + length < distance[other.index()] {
                distance[other.index()] = here + length;
                back[other.index()] = Some(halfedge);
                waiting.push(Reverse(((here + length).to_bits(), other)));
            }
        }
    }
    let mut way = Vec::new();
    let mut vertex = reached;
    while let Some(halfedge) = vertex.and_then(|vertex| back[vertex.index()]) {
        way.push(halfedge);
        vertex = Some(mesh.origin(halfedge));
    }
    way
}

/// The triangles of a mesh cut along edges, and the vertex behind each of their vertices.
fn opened(mesh: &TriangleMesh, is_cut: &[bool]) -> (Vec<[u32; 3]>, PerVertex<VertexId>) {
    let mut sources: Vec<VertexId> = mesh.vertices().collect();
    let mut name_of_corner = vec![0; mesh.halfedge_count()];
    let cut = |edge: EdgeId| is_cut[edge.index()];
    for vertex in mesh.vertices() {
        let mut name = vertex.0;
        let mut corners: Vec<HalfedgeId> = mesh.outgoing(vertex).collect();
        if !mesh.is_boundary_vertex(vertex) {
            let first = corners.iter().position(|&corner| cut(mesh.edge(corner)));
            corners.rotate_left(first.unwrap_or(0));
        }
        for (place, &corner) in corners.iter().enumerate() {
            if place > 0 && cut(mesh.edge(corner)) {
                name = sources.len() as u32;
                sources.push(vertex);
            }
            name_of_corner[corner.index()] = name;
        }
    }
    let corners = |face: crate::mesh::FaceId| face.halfedges().map(|h| name_of_corner[h.index()]);
    (mesh.faces().map(corners).collect(), PerVertex::new(sources))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Topology;
    use graticule_fixtures::{annulus, disk};

    fn patch(fixture: graticule_fixtures::Fixture) -> Patch {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        Patch::new(surface, &Watch::new()).unwrap()
    }

    #[test]
    fn cutting_to_inner_vertices_keeps_a_disk_and_its_triangles() {
        let disk = patch(disk(5));
        let mesh = disk.mesh();
        let inner: Vec<_> = mesh
            .vertices()
            .filter(|&v| !mesh.is_boundary_vertex(v))
            .collect();
        let tips = [inner[0], inner[10], inner[11], inner[25]];
        let (cut, sources) = cut_to(&disk, &tips, &Watch::new()).unwrap();
        assert_eq!(cut.mesh().boundary_loop_count(), 1);
        assert_eq!(Topology::of(cut.mesh()).components.len(), 1);
        assert!(cut.mesh().vertex_count() > mesh.vertex_count());
        for face in mesh.faces() {
            let named = cut.mesh().triangle(face).map(|vertex| sources[vertex]);
            assert_eq!(named, mesh.triangle(face));
        }
        for tip in tips {
            assert!(cut.mesh().is_boundary_vertex(tip));
        }
    }

    #[test]
    fn holes_stay_holes() {
        let ring = patch(annulus(0.3, 1.0, 16, 5));
        let mesh = ring.mesh();
        let tip = mesh
            .vertices()
            .find(|&v| !mesh.is_boundary_vertex(v))
            .unwrap();
        let (cut, _) = cut_to(&ring, &[tip], &Watch::new()).unwrap();
        assert_eq!(cut.mesh().boundary_loop_count(), 2);
        assert!(
            cut.loop_vertices(cut.outer_loop())
                .any(|vertex| vertex == tip)
        );
    }
}
