use std::ops::Deref;

use super::{BoundaryLoopId, CornerTable, Element, HalfedgeId, MeshError};

/// Connectivity of an oriented, manifold triangle mesh, with or without boundary, in any number
/// of components; immutable. Read it as the [`CornerTable`] that it is. Held by construction:
///
/// - every vertex belongs to a triangle, and the triangles around it form one fan;
/// - an edge has one triangle (then it lies on the boundary) or two that run along it in opposite
///   directions; its [`edge_halfedge`](CornerTable::edge_halfedge) is the one of smaller number;
/// - no triangle has a vertex twice.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    table: CornerTable,
    boundary_loops: Vec<Vec<HalfedgeId>>,
}

impl Deref for TriangleMesh {
    type Target = CornerTable;

    #[inline]
    fn deref(&self) -> &CornerTable {
        &self.table
    }
}

impl TriangleMesh {
    /// Builds the connectivity of `triangles` over the vertices `0..vertex_count`.
    ///
    /// Cost: near-linear time (halfedges are bucketed by vertex).
    ///
    /// # Errors
    /// [`MeshError`] names the first element that breaks a rule; nothing is repaired here.
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<Self, MeshError> {
        let table = CornerTable::new(vertex_count, triangles)?;
        let boundary_loops = walk_boundary(&table);
        Ok(Self {
            table,
            boundary_loops,
        })
    }

    /// The number of boundary loops.
    #[must_use]
    pub fn boundary_loop_count(&self) -> usize {
        self.boundary_loops.len()
    }

    /// All boundary loops in order.
    #[must_use]
    pub fn boundary_loops(&self) -> impl ExactSizeIterator<Item = BoundaryLoopId> + Clone + use<> {
        (0..self.boundary_loop_count()).map(BoundaryLoopId::from_index)
    }

    /// The halfedges along a boundary loop, the surface to their left; each loop passes a vertex
    /// at most once. Loops are ordered by their smallest halfedge, which comes first.
    #[must_use]
    pub fn boundary_loop(&self, boundary_loop: BoundaryLoopId) -> &[HalfedgeId] {
        &self.boundary_loops[boundary_loop.index()]
    }

    /// The same surface seen from the other side: each triangle `(a, b, c)` becomes `(a, c, b)`.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let triangles: Vec<_> = self
            .faces()
            .map(|face| self.triangle(face))
            .map(|[a, b, c]| [a.0, c.0, b.0])
            .collect();
        Self::new(self.vertex_count(), &triangles)
            .unwrap_or_else(|_| unreachable!("turning every triangle round keeps the mesh sound"))
    }
}

fn walk_boundary(table: &CornerTable) -> Vec<Vec<HalfedgeId>> {
    let mut visited = vec![false; table.halfedge_count()];
    let mut loops = Vec::new();
    for first in table.halfedges() {
        if visited[first.index()] || table.twin(first).is_some() {
            continue;
        }
        let walk = std::iter::successors(Some(first), |&halfedge| {
            Some(table.vertex_halfedge(table.destination(halfedge))).filter(|&next| next != first)
        });
        let boundary_loop: Vec<_> = walk.collect();
        for halfedge in &boundary_loop {
            visited[halfedge.index()] = true;
        }
        loops.push(boundary_loop);
    }
    loops
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::VertexId;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    fn vertices(indices: &[u32]) -> Vec<VertexId> {
        indices.iter().copied().map(VertexId).collect()
    }

    #[test]
    fn a_tetrahedron_is_closed_and_counts_right() {
        let mesh = TriangleMesh::new(4, &TETRAHEDRON).unwrap();
        assert_eq!(
            [mesh.vertex_count(), mesh.edge_count(), mesh.face_count()],
            [4, 6, 4]
        );
        assert_eq!(mesh.boundary_loop_count(), 0);
        for halfedge in mesh.halfedges() {
            let twin = mesh.twin(halfedge).unwrap();
            assert_eq!(mesh.twin(twin), Some(halfedge));
            assert_eq!(
                mesh.ends(twin),
                [mesh.destination(halfedge), mesh.origin(halfedge)]
            );
            assert_eq!(mesh.edge(twin), mesh.edge(halfedge));
        }
        for vertex in mesh.vertices() {
            assert_eq!(mesh.neighbors(vertex).count(), 3);
            assert!(
                mesh.outgoing(vertex)
                    .all(|halfedge| mesh.origin(halfedge) == vertex)
            );
        }
    }

    #[test]
    fn the_halfedge_between_two_vertices_is_found_from_either_end() {
        let fan = TriangleMesh::new(5, &[[0, 1, 2], [3, 0, 2], [0, 3, 4]]).unwrap();
        for from in fan.vertices() {
            for to in fan.vertices() {
                let mut all = fan.halfedges();
                let expected = all.find(|&halfedge| fan.ends(halfedge) == [from, to]);
                assert_eq!(fan.halfedge_between(from, to), expected);
            }
        }
    }

    #[test]
    fn neighbors_turn_counter_clockwise_and_cover_the_boundary() {
        // A fan around vertex 0, open between 4 and 1.
        let fan = TriangleMesh::new(5, &[[0, 1, 2], [3, 0, 2], [0, 3, 4]]).unwrap();
        assert_eq!(
            fan.neighbors(VertexId(0)).collect::<Vec<_>>(),
            vertices(&[1, 2, 3, 4])
        );
        assert!(fan.is_boundary_vertex(VertexId(0)));
        // The same fan, closed.
        let closed = TriangleMesh::new(5, &[[0, 1, 2], [3, 0, 2], [0, 3, 4], [4, 1, 0]]).unwrap();
        let around: Vec<_> = closed.neighbors(VertexId(0)).collect();
        assert_eq!(around.len(), 4);
        assert!(!closed.is_boundary_vertex(VertexId(0)));
    }

    #[test]
    fn a_boundary_loop_keeps_the_surface_to_its_left() {
        let mesh = TriangleMesh::new(4, &[[0, 1, 2], [0, 2, 3]]).unwrap();
        assert_eq!(mesh.boundary_loop_count(), 1);
        let origins: Vec<_> = mesh
            .boundary_loop(BoundaryLoopId(0))
            .iter()
            .map(|&halfedge| mesh.origin(halfedge))
            .collect();
        assert_eq!(origins, vertices(&[0, 1, 2, 3]));
    }

    #[test]
    fn turning_a_mesh_round_twice_gives_it_back() {
        let mesh = TriangleMesh::new(4, &TETRAHEDRON).unwrap();
        assert_ne!(mesh.reversed(), mesh);
        assert_eq!(mesh.reversed().reversed(), mesh);
    }

    #[test]
    fn each_broken_rule_is_named() {
        let refusal =
            |count, triangles: &[[u32; 3]]| TriangleMesh::new(count, triangles).unwrap_err();
        assert_eq!(refusal(3, &[]), MeshError::NoFaces);
        assert_eq!(
            refusal(3, &[[0, 1, 3]]),
            MeshError::IndexOutOfRange {
                face: 0,
                index: 3,
                vertices: 3
            }
        );
        assert_eq!(
            refusal(3, &[[0, 1, 1]]),
            MeshError::RepeatedVertex {
                face: 0,
                vertex: VertexId(1)
            }
        );
        assert_eq!(
            refusal(4, &[[0, 1, 2]]),
            MeshError::IsolatedVertex {
                vertex: VertexId(3)
            }
        );
        assert_eq!(
            refusal(4, &[[0, 1, 2], [0, 1, 3]]),
            MeshError::InconsistentOrientation {
                ends: [VertexId(0), VertexId(1)],
                faces: [0, 1]
            }
        );
        assert_eq!(
            refusal(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]),
            MeshError::NonManifoldEdge {
                ends: [VertexId(0), VertexId(1)],
                faces: 3
            }
        );
        assert_eq!(
            refusal(5, &[[0, 1, 2], [0, 3, 4]]),
            MeshError::NonManifoldVertex {
                vertex: VertexId(0)
            }
        );
    }
}
