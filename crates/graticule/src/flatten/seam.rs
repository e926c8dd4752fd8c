//! A patch cut open along short ways from its outer boundary to given vertices.

use crate::mesh::{EdgeId, PerEdge, PerVertex, VertexId, cut_along};
use crate::watch::Watch;

use super::seam_search::EdgeGraph;
use super::{FlattenError, Patch};

/// The patch cut open so that the given interior vertices come to lie on its outer boundary, and
/// the vertex behind each vertex of the result. Triangles keep their numbers.
///
/// Each way is the shortest to what is boundary already, along edges other than `uncut`; holes are
/// kept apart.
pub(super) fn cut_to(
    patch: &Patch,
    tips: &[VertexId],
    uncut: &[EdgeId],
    watch: &Watch,
) -> Result<(Patch, PerVertex<VertexId>), FlattenError> {
    let _stage = watch.stage("cut to cones");
    let cut = ways_to(patch, tips, uncut, watch)?;
    let opened = cut_along(patch.surface(), cut)?;
    let sources = opened.vertex_sources;
    let opened = Patch::new(opened.surface, watch)?;
    let start = patch.loop_vertices(patch.outer_loop()).next();
    let mut loops = opened.mesh().boundary_loops();
    let outer = loops.find(|&boundary_loop| {
        let mut vertices = opened.loop_vertices(boundary_loop);
        vertices.any(|vertex| Some(sources[vertex]) == start)
    });
    let outer = outer.unwrap_or(opened.outer_loop());
    Ok((opened.with_outer_loop(outer)?, sources))
}

/// The edges to cut along.
fn ways_to(
    patch: &Patch,
    tips: &[VertexId],
    uncut: &[EdgeId],
    watch: &Watch,
) -> Result<Vec<EdgeId>, FlattenError> {
    let mesh = patch.mesh();
    let mut is_open = PerVertex::filled(mesh.vertex_count(), false);
    for vertex in patch.loop_vertices(patch.outer_loop()) {
        is_open[vertex] = true;
    }
    let on_hole = |vertex| mesh.is_boundary_vertex(vertex) && !is_open[vertex];
    let mut may_cut = PerEdge::from_fn(mesh.edge_count(), |edge| {
        let ends = mesh.ends(mesh.edge_halfedge(edge));
        !ends.into_iter().any(on_hole)
    });
    for &edge in uncut {
        may_cut[edge] = false;
    }
    let graph = EdgeGraph::new(patch.unit_surface(), &may_cut);
    let mut cut = Vec::new();
    for &tip in tips {
        watch.check()?;
        let paths = graph.shortest_paths(|vertex| is_open[vertex]);
        if paths.distances[tip].is_infinite() {
            let reason = "cannot be reached from the outer boundary along edges that may be cut";
            return Err(FlattenError::BadTarget {
                vertex: tip,
                reason,
            });
        }
        for edge in paths.path_to(tip) {
            for end in mesh.ends(mesh.edge_halfedge(edge)) {
                is_open[end] = true;
            }
            cut.push(edge);
        }
    }
    Ok(cut)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Surface, Topology};
    use graticule_fixtures::{Fixture, annulus, disk};

    fn patch(fixture: Fixture) -> Patch {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        Patch::new(surface, &Watch::new()).unwrap()
    }

    #[test]
    fn cutting_to_inner_vertices_brings_them_to_the_boundary_of_a_disk() {
        let disk = patch(disk(5));
        let mesh = disk.mesh();
        let inner = mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v));
        let inner: Vec<_> = inner.collect();
        let tips = [inner[0], inner[10], inner[11], inner[25]];
        let (cut, sources) = cut_to(&disk, &tips, &[], &Watch::new()).unwrap();
        assert_eq!(cut.mesh().boundary_loop_count(), 1);
        assert_eq!(Topology::of(cut.mesh()).components.len(), 1);
        let outer = cut.loop_vertices(cut.outer_loop());
        let on_loop: Vec<_> = outer.map(|vertex| sources[vertex]).collect();
        assert!(tips.iter().all(|tip| on_loop.contains(tip)));
    }

    #[test]
    fn the_cut_runs_around_what_may_not_be_cut() {
        let disk = patch(disk(5));
        let mesh = disk.mesh();
        let inner = |vertex: &VertexId| !mesh.is_boundary_vertex(*vertex);
        let tip = mesh.vertices().find(inner).unwrap();
        let direct = ways_to(&disk, &[tip], &[], &Watch::new()).unwrap();
        let around = ways_to(&disk, &[tip], &direct, &Watch::new()).unwrap();
        assert!(around.iter().all(|edge| !direct.contains(edge)));
        let every: Vec<EdgeId> = mesh.edges().collect();
        assert!(ways_to(&disk, &[tip], &every, &Watch::new()).is_err());
    }

    #[test]
    fn holes_stay_holes() {
        let ring = patch(annulus(0.3, 1.0, 16, 5));
        let mesh = ring.mesh();
        let tip = mesh
            .vertices()
            .find(|&v| !mesh.is_boundary_vertex(v))
            .unwrap();
        let (cut, sources) = cut_to(&ring, &[tip], &[], &Watch::new()).unwrap();
        assert_eq!(cut.mesh().boundary_loop_count(), 2);
        let mut outer = cut.loop_vertices(cut.outer_loop());
        assert!(outer.any(|vertex| sources[vertex] == tip));
    }
}
