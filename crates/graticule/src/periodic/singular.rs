use super::Transition;
use super::unroll::{FaceKind, VertexFrames};
use crate::mesh::{EdgeId, FaceId, PerFace, TriangleMesh, VertexId};

/// The elements at which coordinates are no valid planar triangulation ([PGP06] §3.2), in order.
///
/// [PGP06]: crate::papers::PGP06
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SingularElements {
    /// Triangles round which the quarter turns do not close.
    pub field_faces: Vec<FaceId>,
    /// Triangles round which the quarter turns close and the whole shifts do not.
    pub phase_faces: Vec<FaceId>,
    /// Triangles whose coordinates close without turning counter-clockwise.
    pub inverted_faces: Vec<FaceId>,
    /// Edges whose length differs from one side to the other: those of triangles that do not close.
    pub edges: Vec<EdgeId>,
    /// Vertices inside the surface whose angles do not sum to 2π, or round whose neighbours
    /// Algorithm 1 does not close.
    pub vertices: Vec<VertexId>,
}

impl SingularElements {
    /// Finds them.
    #[must_use]
    pub fn of(mesh: &TriangleMesh, frames: &VertexFrames, kinds: &PerFace<FaceKind>) -> Self {
        let of_kind = |wanted| -> Vec<FaceId> {
            let faces = kinds.enumerate().filter(|(_, kind)| **kind == wanted);
            faces.map(|(face, _)| face).collect()
        };
        let opens = |face: FaceId| !kinds[face].closes();
        let is_singular_edge = |&edge: &EdgeId| {
            let halfedge = mesh.edge_halfedge(edge);
            let twin = mesh.twin(halfedge);
            twin.is_some_and(|twin| opens(halfedge.face()) || opens(twin.face()))
        };
        let is_singular_vertex = |&vertex: &VertexId| {
            !mesh.is_boundary_vertex(vertex) && is_singular_vertex(mesh, frames, kinds, vertex)
        };
        Self {
            field_faces: of_kind(FaceKind::FieldSingular),
            phase_faces: of_kind(FaceKind::PhaseSingular),
            inverted_faces: of_kind(FaceKind::Inverted),
            edges: mesh.edges().filter(is_singular_edge).collect(),
            vertices: mesh.vertices().filter(is_singular_vertex).collect(),
        }
    }

    /// The number of triangles of all kinds.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.field_faces.len() + self.phase_faces.len() + self.inverted_faces.len()
    }
}

fn is_singular_vertex(
    mesh: &TriangleMesh,
    frames: &VertexFrames,
    kinds: &PerFace<FaceKind>,
    vertex: VertexId,
) -> bool {
    let mut star = mesh.outgoing(vertex);
    if star.all(|corner| kinds[corner.face()].closes()) {
        // Then the walk round the neighbours closes, too.
        return winding(mesh, frames, vertex) != 1;
    }
    let walk = mesh
        .outgoing(vertex)
        .map(|corner| frames.jump(mesh, corner.next()));
    // Each jump leads back along its edge: the walk's last comes first.
    let round = walk.fold(Transition::identity(), |later, jump| jump.then(later));
    !round.is_identity()
}

/// How often the neighbours wind round a vertex: the sum of its angles over 2π, counted where the
/// sides of triangles pass one direction.
fn winding(mesh: &TriangleMesh, frames: &VertexFrames, vertex: VertexId) -> i32 {
    let own = frames.coordinates[vertex];
    let passes = mesh.outgoing(vertex).map(|corner| {
        let back = corner.previous();
        let next = frames.jump(mesh, corner);
        let next = next.apply(frames.coordinates[mesh.destination(corner)]) - own;
        let last = frames.jump(mesh, back).inverse();
        let last = last.apply(frames.coordinates[mesh.origin(back)]) - own;
        let turn = next.perp_dot(last);
        match (next.y < 0.0, last.y < 0.0) {
            (true, false) if turn > 0.0 => 1,
            (false, true) if turn < 0.0 => -1,
            _ => 0,
        }
    });
    passes.sum()
}
