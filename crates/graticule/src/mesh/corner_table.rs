use std::array;

use super::faces::{Faces, TriangleFaces};
use super::gluing::{EdgeUses, NONE, glue};
use super::{EdgeId, Element, FaceId, HalfedgeId, MeshError, VertexId};

/// Connectivity of oriented, manifold triangles: each triangle has three halfedges (see
/// [`HalfedgeId`]), each halfedge knows its twin in the neighbouring triangle.
///
/// What a [`TriangleMesh`](super::TriangleMesh) and an
/// [`IntrinsicTriangulation`](crate::geometry::IntrinsicTriangulation) have in common; they are the
/// ways to make one. In the latter an edge may join a vertex to itself, two edges may have the same
/// ends, and two sides of a triangle may be the same edge.
///
/// Memory: 48 bytes per triangle and 4 per vertex, roughly.
#[derive(Clone, Debug, PartialEq)]
pub struct CornerTable {
    origins: Vec<VertexId>,
    twins: Vec<u32>,
    vertex_halfedges: Vec<HalfedgeId>,
    halfedge_edges: Vec<EdgeId>,
    edge_halfedges: Vec<HalfedgeId>,
}

impl CornerTable {
    /// The table of `triangles` over the vertices `0..vertex_count`. Near-linear time.
    pub(super) fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<Self, MeshError> {
        check_triangles(vertex_count, triangles)?;
        let corners = triangles.as_flattened();
        let origins: Vec<_> = corners.iter().map(|&index| VertexId(index)).collect();
        let twins = match_twins(vertex_count, triangles)?;
        let vertex_halfedges = choose_vertex_halfedges(vertex_count, &origins, &twins)?;
        let (halfedge_edges, edge_halfedges) = number_edges(&twins);
        let table = Self {
            origins,
            twins,
            vertex_halfedges,
            halfedge_edges,
            edge_halfedges,
        };
        table.check_fans()?;
        Ok(table)
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

    /// The halfedge that leads from one vertex to another. As many steps as the vertex with fewer
    /// triangles has.
    #[must_use]
    pub fn halfedge_between(&self, from: VertexId, to: VertexId) -> Option<HalfedgeId> {
        let leaving = self.outgoing(from);
        let arriving = self.outgoing(to).map(HalfedgeId::previous);
        let mut both = leaving.zip(arriving).flat_map(|(a, b)| [a, b]);
        both.find(|&halfedge| self.ends(halfedge) == [from, to])
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

    /// Replaces the edge between two different triangles by the other diagonal: moves their four
    /// outer sides one place on and turns the diagonal, which keeps its number. Tells the halfedges
    /// of the outer sides before and after.
    pub(crate) fn rotate_diamond(
        &mut self,
        halfedge: HalfedgeId,
        twin: HalfedgeId,
    ) -> [(HalfedgeId, HalfedgeId); 4] {
        let [i, k] = [self.origin(halfedge), self.origin(halfedge.previous())];
        let [j, l] = [self.origin(twin), self.origin(twin.previous())];
        let from = [
            halfedge.next(),
            halfedge.previous(),
            twin.next(),
            twin.previous(),
        ];
        let to = [from[3], from[0], from[1], from[2]];
        self.move_sides(from, to, [j, k, i, l]);
        // The diagonal leaves `i` and `j` no more.
        for (vertex, old, side) in [(i, halfedge, to[2]), (j, twin, to[0])] {
            if self.vertex_halfedges[vertex.index()] == old {
                self.vertex_halfedges[vertex.index()] = side;
            }
        }
        self.origins[halfedge.index()] = l;
        self.origins[twin.index()] = k;
        array::from_fn(|place| (from[place], to[place]))
    }

    /// Gives four sides, with these origins, other places in the table.
    fn move_sides(&mut self, from: [HalfedgeId; 4], to: [HalfedgeId; 4], origins: [VertexId; 4]) {
        let renamed = |old: u32| match from.iter().position(|side| side.0 == old) {
            Some(place) => to[place].0,
            None => old,
        };
        // Read all before writing any: the sides may be glued to each other, and ends may coincide.
        let twins = from.map(|side| renamed(self.twins[side.index()]));
        let edges = from.map(|side| self.edge(side));
        let leaving = origins.map(|origin| self.vertex_halfedge(origin));
        for (place, &side) in to.iter().enumerate() {
            self.origins[side.index()] = origins[place];
            self.twins[side.index()] = twins[place];
            if twins[place] != NONE {
                self.twins[twins[place] as usize] = side.0;
            }
            self.halfedge_edges[side.index()] = edges[place];
            self.edge_halfedges[edges[place].index()] = side;
            if leaving[place] == from[place] {
                self.vertex_halfedges[origins[place].index()] = side;
            }
        }
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

/// The twin of each halfedge.
fn match_twins(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<Vec<u32>, MeshError> {
    let faces = TriangleFaces(triangles);
    let ends = |side| [faces.origin(side), faces.destination(side)].map(VertexId);
    let mut twins = vec![NONE; faces.corner_count()];
    for group in EdgeUses::of(&faces, vertex_count).iter() {
        match *group {
            [_] => {}
            [first, second] if ends(first) != ends(second) => glue(&mut twins, first, second),
            [first, second] => {
                return Err(MeshError::InconsistentOrientation {
                    ends: ends(first),
                    faces: [first, second].map(|side| faces.face(side) as usize),
                });
            }
            _ => {
                return Err(MeshError::NonManifoldEdge {
                    ends: ends(group[0]),
                    faces: group.len(),
                });
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
