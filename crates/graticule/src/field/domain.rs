use std::sync::OnceLock;

use super::disk::EdgeGraph;
use super::{CrossField, Singularities};
use crate::geometry::{
    EdgeLengths, GeometryError, IntrinsicTriangulation, TangentFrame, face_curvatures,
    intrinsic_delaunay, transport_angles, vertex_areas, vertex_frames,
};
use crate::mesh::{PerCorner, PerFace, PerVertex, Surface};
use crate::watch::Watch;

/// A surface with what every step of making a field on it needs; the steps are its methods.
///
/// Features, curvature and singularities are those of the surface's own triangles; smoothing and
/// curl correction use the intrinsic Delaunay triangulation, where no weight is negative. The two
/// have the same tangent planes, so that an angle means the same in both.
#[derive(Clone, Debug)]
pub struct FieldDomain<'a> {
    surface: &'a Surface,
    triangulation: IntrinsicTriangulation,
    delaunay: IntrinsicTriangulation,
    transports: PerCorner<f64>,
    face_curvatures: PerFace<f64>,
    frames: PerVertex<TangentFrame>,
    areas: PerVertex<f64>,
    mean_edge_length: f64,
    edge_graph: OnceLock<EdgeGraph>,
}

impl<'a> FieldDomain<'a> {
    /// Makes both triangulations. Lengths given to the steps count in the unit of `surface`, which
    /// should be of about unit size.
    ///
    /// # Errors
    /// [`GeometryError`].
    pub fn of(surface: &'a Surface, watch: &Watch) -> Result<Self, GeometryError> {
        let _stage = watch.stage("triangulation");
        let (delaunay, _) = intrinsic_delaunay(surface, watch)?;
        let triangulation = IntrinsicTriangulation::of(surface)?;
        Ok(Self {
            surface,
            transports: transport_angles(&triangulation),
            face_curvatures: face_curvatures(&triangulation),
            frames: vertex_frames(surface),
            areas: vertex_areas(&triangulation),
            mean_edge_length: EdgeLengths::of(surface).mean(),
            triangulation,
            delaunay,
            edge_graph: OnceLock::new(),
        })
    }

    /// The surface.
    #[must_use]
    pub fn surface(&self) -> &'a Surface {
        self.surface
    }

    /// The triangles of the surface.
    #[must_use]
    pub fn triangulation(&self) -> &IntrinsicTriangulation {
        &self.triangulation
    }

    /// The intrinsic Delaunay triangulation of the same surface.
    #[must_use]
    pub fn delaunay(&self) -> &IntrinsicTriangulation {
        &self.delaunay
    }

    /// The mean length of the surface's edges.
    #[must_use]
    pub fn mean_edge_length(&self) -> f64 {
        self.mean_edge_length
    }

    /// Where a field is singular in the triangles of the surface.
    #[must_use]
    pub fn singularities(&self, field: &CrossField) -> Singularities {
        Singularities::on(self, field)
    }

    /// Parallel transport along the halfedges of the surface.
    pub(super) fn transports(&self) -> &PerCorner<f64> {
        &self.transports
    }

    /// [`face_curvatures`] of the surface.
    pub(super) fn face_curvatures(&self) -> &PerFace<f64> {
        &self.face_curvatures
    }

    /// [`vertex_frames`] of the surface.
    pub(super) fn frames(&self) -> &PerVertex<TangentFrame> {
        &self.frames
    }

    /// [`vertex_areas`] of the surface.
    pub(super) fn areas(&self) -> &PerVertex<f64> {
        &self.areas
    }

    /// The edges of the surface, made when first asked for.
    pub(super) fn edge_graph(&self) -> &EdgeGraph {
        self.edge_graph.get_or_init(|| EdgeGraph::of(self.surface))
    }
}
