//! Attributes of the input on a new mesh of its surface.
//!
//! A polygon of the new mesh belongs where its middle lies. From there each corner is walked to
//! without crossing a seam of the attribute: where the way is free the corner has the value of the
//! input at its own point, and where a seam is in the way the value at the seam. So no polygon
//! mixes values of both sides.

mod corners;
mod faces;

#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use self::corners::carry_corners;
use self::faces::Faces;
use crate::mesh::{Attributes, PolygonLabels, PolygonSoup, Polygons, Repaired, SurfacePoint};

/// A mesh that was repaired, and a new one over points of its surface.
#[derive(Clone, Copy, Debug)]
pub struct Carry<'a> {
    /// The mesh as it was read.
    pub original: &'a PolygonSoup,
    /// What repair made of it.
    pub repaired: &'a Repaired,
    /// The new polygons, as indices into the points.
    pub polygons: &'a Polygons,
    /// The points of the repaired surface.
    pub origins: &'a [SurfacePoint],
}

/// A point of an input file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InputPoint {
    /// The polygon.
    pub polygon: u32,
    /// Three vertices of the file.
    pub vertices: [u32; 3],
    /// Their weights, with the sum 1.
    pub weights: [f64; 3],
}

impl Carry<'_> {
    /// The new mesh with the attributes of the original.
    ///
    /// Texture coordinates and normals are taken at each corner, on the side of seams that the polygon
    /// lies on; colours at each vertex; objects, groups, materials and smoothing groups are those
    /// of most of the polygon. Polylines of the original are left out.
    ///
    /// Every origin must be a point of the repaired surface, and every polygon have its vertices
    /// among the origins. Cost: linear in the corners of the new mesh and the size of the original.
    #[must_use]
    pub fn to_soup(&self) -> PolygonSoup {
        let surface = &self.repaired.surface;
        let original = &self.original.attributes;
        let faces = Faces::find(self);
        let labels = |labels: &Option<PolygonLabels>| {
            let labels = labels.as_ref()?;
            Some(faces.majority(labels, &self.repaired.face_polygons))
        };
        PolygonSoup {
            positions: self
                .origins
                .iter()
                .map(|origin| origin.position(surface))
                .collect(),
            polygons: self.polygons.clone(),
            polylines: Vec::new(),
            attributes: Attributes {
                uv_sets: original
                    .uv_sets
                    .iter()
                    .map(|set| carry_corners::<DVec2>(self, &faces, set))
                    .collect(),
                normals: original
                    .normals
                    .as_ref()
                    .map(|set| carry_corners::<DVec3>(self, &faces, set)),
                vertex_colors: original
                    .vertex_colors
                    .as_deref()
                    .and_then(|c| self.colors(c)),
                objects: labels(&original.objects),
                groups: labels(&original.groups),
                materials: labels(&original.materials),
                smoothing_groups: labels(&original.smoothing_groups),
                material_libraries: original.material_libraries.clone(),
            },
        }
    }

    /// For each vertex of the new mesh its point of the input file.
    #[must_use]
    pub fn input_points(&self) -> Vec<InputPoint> {
        let mesh = self.repaired.surface.mesh();
        let point = |origin: &SurfacePoint| InputPoint {
            polygon: self.repaired.face_polygons[origin.face],
            vertices: mesh
                .triangle(origin.face)
                .map(|vertex| self.repaired.vertex_sources[vertex]),
            weights: origin.barycentric,
        };
        self.origins.iter().map(point).collect()
    }

    /// The colour of each vertex; `None` if the original has not one for each of its own.
    fn colors(&self, colors: &[[f32; 4]]) -> Option<Vec<[f32; 4]>> {
        let points = self.input_points();
        let color = |point: &InputPoint| {
            let mut sum = [0.0; 4];
            for (&vertex, weight) in point.vertices.iter().zip(point.weights) {
                let color = colors.get(vertex as usize)?;
                for (sum, channel) in sum.iter_mut().zip(color) {
                    *sum += weight * f64::from(*channel);
                }
            }
            Some(sum.map(|channel| channel as f32))
        };
        points.par_iter().map(color).collect()
    }

    fn position(&self, vertex: u32) -> DVec3 {
        self.origins[vertex as usize].position(&self.repaired.surface)
    }

    /// The mean of a polygon's corners; `None` without any.
    fn middle(&self, polygon: usize) -> Option<DVec3> {
        let vertices = self.polygons.vertices(polygon);
        let sum: DVec3 = vertices.iter().map(|&vertex| self.position(vertex)).sum();
        (!vertices.is_empty()).then(|| sum / vertices.len() as f64)
    }
}
