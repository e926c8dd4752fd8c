use glam::DVec3;

use super::lines::Lines;
use crate::geometry::{normalized, vertex_normals};
use crate::mesh::{EdgeId, PerVertex, Surface, SurfacePoint};
use crate::tolerance;

/// A vertex on the surface.
#[derive(Clone, Copy, Debug)]
pub(in crate::quads) struct Place {
    pub(in crate::quads) origin: SurfacePoint,
    pub(in crate::quads) position: DVec3,
    /// The normal of the surface, smoothed.
    pub(super) normal: DVec3,
}

/// What vertices slide along: a surface at unit extent, with its normals and lines.
pub(in crate::quads) struct Ground {
    pub(in crate::quads) surface: Surface,
    normals: PerVertex<DVec3>,
    pub(super) lines: Lines,
}

impl Ground {
    pub(in crate::quads) fn of(surface: &Surface, features: &[EdgeId]) -> Self {
        let (surface, _) = normalized(surface);
        let normals = vertex_normals(&surface);
        let lines = Lines::new(&surface, features, tolerance::LINE_CORNER_COSINE);
        Self {
            surface,
            normals,
            lines,
        }
    }

    /// Lets vertices slide round the corners of lines: an edge may then cut a corner off.
    pub(in crate::quads) fn round_corners(&mut self, features: &[EdgeId]) {
        self.lines = Lines::new(&self.surface, features, f64::NEG_INFINITY);
    }

    pub(in crate::quads) fn place(&self, origin: SurfacePoint) -> Place {
        let corners = self.surface.mesh().triangle(origin.face);
        Place {
            origin,
            position: origin.position(&self.surface),
            normal: origin.interpolate(corners.map(|vertex| self.normals[vertex])),
        }
    }
}
