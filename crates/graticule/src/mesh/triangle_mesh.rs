use std::array;

use super::{BoundaryLoopId, EdgeId, Element, FaceId, HalfedgeId, MeshError, VertexId};

const NONE: u32 = u32::MAX;

/// Connectivity of an oriented, manifold triangle mesh, with or without boundary, in any number
/// of components; immutable.
///
/// A corner table: each triangle has three halfedges (see [`HalfedgeId`]), each halfedge knows its
/// twin in the neighbouring triangle. Held by construction:
///
/// - every vertex belongs to a triangle, and the triangles around it form one fan;
/// - an edge has one triangle (then it lies on the boundary) or two that run along it in opposite
///   directions;
/// - no triangle has a vertex twice.
///
/// Memory: 48 bytes per triangle and 4 per vertex, roughly.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    origins: Vec<VertexId>,
    twins: Vec<u32>,
    vertex_halfedges: Vec<HalfedgeId>,
    halfedge_edges: Vec<EdgeId>,
    edge_halfedges: Vec<HalfedgeId>,
    boundary_loops: Vec<Vec<HalfedgeId>>,
}

impl TriangleMesh {
    /// Builds the connectivity of `triangles` over the vertices `0..vertex_count`.
    ///
    /// Cost: near-linear time (halfedges are bucketed by vertex).
    ///
    /// # Errors
    /// [`MeshError`] names the first element that breaks a rule; nothing is repaired here.
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<Self, MeshError> {
        check_triangles(vertex_count, triangles)?;
        let origins: Vec<_> = triangles
            .iter()
            .flatten()
            .map(|&index| VertexId(index))
            .collect();
        let twins = match_twins(vertex_count, &origins)?;
        let vertex_halfedges = choose_vertex_halfedges(vertex_count, &origins, &twins)?;
        let (halfedge_edges, edge_halfedges) = number_edges(&twins);
        let boundary_loops = Vec::new();
        let mut mesh = Self {
            origins,
            twins,
            vertex_halfedges,
            halfedge_edges,
            edge_halfedges,
            boundary_loops,
        };
        mesh.check_fans()?;
        mesh.boundary_loops = mesh.walk_boundary();
        Ok(mesh)
    }

    /// The number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.vertex_halfedges.len()
    }

    /// The number of edges.
    #[must_use]
    pub fn edge_count(&self) -> usize {
        self.edge_halfedges.len()
    }

    /// The number of triangles.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.origins.len() / 3
    }

    /// The number of halfedges, which is that of corners: three for each triangle.
    #[must_use]
    pub fn halfedge_count(&self) -> usize {
        self.origins.len()
    }

    /// All vertices in order.
    #[must_use]
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = VertexId> + Clone + use<> {
        (0..self.vertex_count()).map(VertexId::from_index)
    }

    /// All edges in order.
    #[must_use]
    pub fn edges(&self) -> impl ExactSizeIterator<Item = EdgeId> + Clone + use<> {
        (0..self.edge_count()).map(EdgeId::from_index)
    }

    /// All triangles in order.
    #[must_use]
    pub fn faces(&self) -> impl ExactSizeIterator<Item = FaceId> + Clone + use<> {
        (0..self.face_count()).map(FaceId::from_index)
    }

    /// All halfedges (corners) in order.
    #[must_use]
    pub fn halfedges(&self) -> impl ExactSizeIterator<Item = HalfedgeId> + Clone + use<> {
        (0..self.halfedge_count()).map(HalfedgeId::from_index)
    }

    /// The vertex that the halfedge leaves from.
    #[inline]
    #[must_use]
    pub fn origin(&self, halfedge: HalfedgeId) -> VertexId {
        self.origins[halfedge.index()]
    }

    /// The vertex that the halfedge runs to.
    #[inline]
    #[must_use]
    pub fn destination(&self, halfedge: HalfedgeId) -> VertexId {
        self.origin(halfedge.next())
    }

    /// The ends of the halfedge: origin, destination.
    #[inline]
    #[must_use]
    pub fn ends(&self, halfedge: HalfedgeId) -> [VertexId; 2] {
        [self.origin(halfedge), self.destination(halfedge)]
    }

    /// The vertex of the halfedge's triangle that does not lie on the halfedge.
    #[inline]
    #[must_use]
    pub fn opposite_vertex(&self, halfedge: HalfedgeId) -> VertexId {
        self.origin(halfedge.previous())
    }

    /// The halfedge of the neighbouring triangle along the same edge, or `None` on the boundary.
    #[inline]
    #[must_use]
    pub fn twin(&self, halfedge: HalfedgeId) -> Option<HalfedgeId> {
        let twin = self.twins[halfedge.index()];
        (twin != NONE).then_some(HalfedgeId(twin))
    }

    /// The edge that the halfedge runs along.
    #[inline]
    #[must_use]
    pub fn edge(&self, halfedge: HalfedgeId) -> EdgeId {
        self.halfedge_edges[halfedge.index()]
    }

    /// The halfedge of the edge that has the smaller number; the only one on the boundary.
    #[inline]
    #[must_use]
    pub fn edge_halfedge(&self, edge: EdgeId) -> HalfedgeId {
        self.edge_halfedges[edge.index()]
    }

    /// Whether the edge has one triangle only.
    #[inline]
    #[must_use]
    pub fn is_boundary_edge(&self, edge: EdgeId) -> bool {
        self.twin(self.edge_halfedge(edge)).is_none()
    }

    /// Whether the vertex lies on the boundary.
    #[inline]
    #[must_use]
    pub fn is_boundary_vertex(&self, vertex: VertexId) -> bool {
        self.twin(self.vertex_halfedge(vertex)).is_none()
    }

    /// The vertices of the triangle, counter-clockwise.
    #[inline]
    #[must_use]
    pub fn triangle(&self, face: FaceId) -> [VertexId; 3] {
        let first = 3 * face.index();
        array::from_fn(|corner| self.origins[first + corner])
    }

    /// A halfedge that leaves from the vertex; on the boundary the one that lies on the boundary,
    /// so that turning counter-clockwise from it meets all triangles of the vertex.
    #[inline]
    #[must_use]
    pub fn vertex_halfedge(&self, vertex: VertexId) -> HalfedgeId {
        self.vertex_halfedges[vertex.index()]
    }

    /// The halfedge that leaves the same vertex, one triangle on counter-clockwise; `None` where
    /// the boundary is met.
    #[inline]
    #[must_use]
    pub fn turn_left(&self, halfedge: HalfedgeId) -> Option<HalfedgeId> {
        self.twin(halfedge.previous())
    }

    /// The halfedges that leave from the vertex, counter-clockwise, one for each of its triangles,
    /// from [`vertex_halfedge`](Self::vertex_halfedge) on.
    pub fn outgoing(&self, vertex: VertexId) -> impl Iterator<Item = HalfedgeId> + '_ {
        let first = self.vertex_halfedge(vertex);
        std::iter::successors(Some(first), move |&halfedge| {
            self.turn_left(halfedge).filter(|&left| left != first)
        })
    }

    /// The vertices joined to the vertex by an edge, counter-clockwise; on the boundary from the
    /// one after it to the one before it along its loop.
    pub fn neighbors(&self, vertex: VertexId) -> impl Iterator<Item = VertexId> + '_ {
        self.outgoing(vertex).flat_map(move |halfedge| {
            let before = halfedge.previous();
            let last = self.twin(before).is_none().then(|| self.origin(before));
            std::iter::once(self.destination(halfedge)).chain(last)
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

    fn check_fans(&self) -> Result<(), MeshError> {
        let mut corners = vec![0_u32; self.vertex_count()];
        for origin in &self.origins {
            corners[origin.index()] += 1;
        }
        let broken = self
            .vertices()
            .find(|&vertex| self.outgoing(vertex).count() != corners[vertex.index()] as usize);
        broken.map_or(Ok(()), |vertex| {
            Err(MeshError::NonManifoldVertex { vertex })
        })
    }

    fn walk_boundary(&self) -> Vec<Vec<HalfedgeId>> {
        let mut visited = vec![false; self.halfedge_count()];
        let mut loops = Vec::new();
        for first in self.halfedges() {
            if visited[first.index()] || self.twin(first).is_some() {
                continue;
            }
            let walk = std::iter::successors(Some(first), |&halfedge| {
                Some(self.vertex_halfedge(self.destination(halfedge))).filter(|&next| next != first)
            });
            let boundary_loop: Vec<_> = walk.collect();
            for halfedge in &boundary_loop {
                visited[halfedge.index()] = true;
            }
            loops.push(boundary_loop);
        }
        loops
    }
}

fn check_triangles(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<(), MeshError> {
    if triangles.is_empty() {
        return Err(MeshError::NoFaces);
    }
    let limit = NONE as usize - 1;
    if triangles.len() > limit / 3 {
        return Err(MeshError::TooLarge {
            corners: 3 * triangles.len(),
            limit,
        });
    }
    for (face, triangle) in triangles.iter().enumerate() {
        if let Some(&index) = triangle
            .iter()
            .find(|&&index| index as usize >= vertex_count)
        {
            return Err(MeshError::IndexOutOfRange {
                face,
                index,
                vertices: vertex_count,
            });
        }
        let [a, b, c] = *triangle;
        if a == b || a == c {
            return Err(MeshError::RepeatedVertex {
                face,
                vertex: VertexId(a),
            });
        }
        if b == c {
            return Err(MeshError::RepeatedVertex {
                face,
                vertex: VertexId(b),
            });
        }
    }
    Ok(())
}

/// The twin of each halfedge, by bucketing the halfedges by the smaller of their ends.
fn match_twins(vertex_count: usize, origins: &[VertexId]) -> Result<Vec<u32>, MeshError> {
    let ends = |halfedge: u32| {
        [
            origins[halfedge as usize],
            origins[HalfedgeId(halfedge).next().index()],
        ]
    };
    let smaller = |halfedge: u32| {
        let [from, to] = ends(halfedge);
        from.min(to).index()
    };
    let halfedges = 0..origins.len() as u32;
    let mut starts = vec![0_u32; vertex_count + 1];
    for halfedge in halfedges.clone() {
        starts[smaller(halfedge) + 1] += 1;
    }
    for vertex in 0..vertex_count {
        starts[vertex + 1] += starts[vertex];
    }
    let mut filled = starts.clone();
    let mut bucketed = vec![(VertexId(0), 0_u32); origins.len()];
    for halfedge in halfedges {
        let slot = &mut filled[smaller(halfedge)];
        let [from, to] = ends(halfedge);
        bucketed[*slot as usize] = (from.max(to), halfedge);
        *slot += 1;
    }
    let mut twins = vec![NONE; origins.len()];
    for vertex in 0..vertex_count {
        let bucket = &mut bucketed[starts[vertex] as usize..starts[vertex + 1] as usize];
        bucket.sort_unstable();
        for group in bucket.chunk_by(|a, b| a.0 == b.0) {
            match *group {
                [_] => {}
                [(_, first), (_, second)] if ends(first) != ends(second) => {
                    twins[first as usize] = second;
                    twins[second as usize] = first;
                }
                [(_, first), (_, second)] => {
                    return Err(MeshError::InconsistentOrientation {
                        ends: ends(first),
                        faces: [first, second].map(|h| HalfedgeId(h).face().index()),
                    });
                }
                _ => {
                    let ends = ends(group[0].1);
                    return Err(MeshError::NonManifoldEdge {
                        ends,
                        faces: group.len(),
                    });
                }
            }
        }
    }
    Ok(twins)
}

fn choose_vertex_halfedges(
    vertex_count: usize,
    origins: &[VertexId],
    twins: &[u32],
) -> Result<Vec<HalfedgeId>, MeshError> {
    let mut chosen = vec![HalfedgeId(NONE); vertex_count];
    for (halfedge, origin) in origins.iter().enumerate() {
        let slot = &mut chosen[origin.index()];
        if slot.0 == NONE || twins[halfedge] == NONE {
            *slot = HalfedgeId::from_index(halfedge);
        }
    }
    match chosen.iter().position(|halfedge| halfedge.0 == NONE) {
        Some(vertex) => Err(MeshError::IsolatedVertex {
            vertex: VertexId::from_index(vertex),
        }),
        None => Ok(chosen),
    }
}

/// Numbers the edges in the order of their smaller halfedge.
fn number_edges(twins: &[u32]) -> (Vec<EdgeId>, Vec<HalfedgeId>) {
    let mut halfedge_edges = Vec::with_capacity(twins.len());
    let mut edge_halfedges = Vec::with_capacity(twins.len() / 2);
    for (halfedge, &twin) in twins.iter().enumerate() {
        if (twin as usize) < halfedge {
            halfedge_edges.push(halfedge_edges[twin as usize]);
        } else {
            halfedge_edges.push(EdgeId::from_index(edge_halfedges.len()));
            edge_halfedges.push(HalfedgeId::from_index(halfedge));
        }
    }
    (halfedge_edges, edge_halfedges)
}

#[cfg(test)]
mod tests {
    use super::*;

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
