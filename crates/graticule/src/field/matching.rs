use super::{CrossField, FieldDomain};
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerFace, PerVertex, TriangleMesh};

/// By how many steps of its symmetry the angles of a field are taken to jump along each halfedge;
/// the twin has minus that. Angles and jumps together say how the field turns along edges, and so
/// the jumps alone decide where it is singular.
///
/// [`rotations`](super::rotations()) takes the jumps that leave the least turns. To move, cancel or
/// prescribe singularities, jumps are changed along paths of triangles and angles are found for them.
#[derive(Clone, Debug)]
pub(super) struct Matching {
    jumps: PerCorner<i32>,
}

impl Matching {
    /// The jumps that leave the least turns.
    pub(super) fn nearest(domain: &FieldDomain<'_>, field: &CrossField) -> Self {
        let mesh = domain.surface().mesh();
        let mut jumps = PerCorner::filled(mesh.halfedge_count(), 0);
        for edge in mesh.edges() {
            let halfedge = mesh.edge_halfedge(edge);
            let [from, to] = mesh.ends(halfedge).map(|vertex| field.angle(vertex));
            let turn = to - from - domain.transports()[halfedge];
            let (_, steps) = field.symmetry().reduce(turn);
            jumps[halfedge] = steps;
            if let Some(twin) = mesh.twin(halfedge) {
                jumps[twin] = -steps;
            }
        }
        Self { jumps }
    }

    pub(super) fn jump(&self, halfedge: HalfedgeId) -> i32 {
        self.jumps[halfedge]
    }

    /// The turn along a halfedge of a field with these angles.
    pub(super) fn turn(
        &self,
        domain: &FieldDomain<'_>,
        angles: &PerVertex<f64>,
        step: f64,
        halfedge: HalfedgeId,
    ) -> f64 {
        let [from, to] = (domain.surface().mesh().ends(halfedge)).map(|vertex| angles[vertex]);
        to - from - domain.transports()[halfedge] - step * f64::from(self.jumps[halfedge])
    }

    /// Takes `steps` from the triangle where a path starts to that where it ends. A path is the
    /// halfedges by which it leaves its triangles.
    pub(super) fn carry(&mut self, mesh: &TriangleMesh, path: &[HalfedgeId], steps: i32) {
        for &halfedge in path {
            self.jumps[halfedge] += steps;
            if let Some(twin) = mesh.twin(halfedge) {
                self.jumps[twin] -= steps;
            }
        }
    }

    /// How often the field turns round each triangle, in steps.
    pub(super) fn steps(&self, domain: &FieldDomain<'_>, step: f64) -> PerFace<i32> {
        let curvatures = domain.face_curvatures();
        PerFace::from_fn(curvatures.len(), |face: FaceId| {
            let sides = face.halfedges();
            let carried: f64 = sides.iter().map(|&h| domain.transports()[h]).sum();
            let jumps: i32 = sides.iter().map(|&h| self.jumps[h]).sum();
            ((curvatures[face] - carried) / step).round() as i32 - jumps
        })
    }
}
