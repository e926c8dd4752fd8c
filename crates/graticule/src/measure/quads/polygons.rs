use std::collections::BTreeMap;

use glam::DVec3;
use serde::Serialize;

use crate::measure::MeasureError;
use crate::measure::uv_map::scale_to_unit;
use crate::mesh::{PolygonConnectivity, PolygonSoup, triangulate_polygon};

/// Polygons by their number of corners.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PolygonCounts {
    /// All polygons of the soup.
    pub total: usize,
    /// Those that span no face and are left out of all other figures.
    pub left_out: usize,
    /// Those with three corners.
    pub triangles: usize,
    /// Those with four corners.
    pub quads: usize,
    /// Those with more.
    pub larger: usize,
    /// Number of polygons for each number of corners.
    pub by_corners: BTreeMap<usize, usize>,
    /// Share of quads among the polygons not left out, in `0.0..=1.0`; 0 without any.
    pub quad_share: f64,
    /// Share of the area that is in quads, in `0.0..=1.0`; 0 without area.
    pub quad_area_share: f64,
    /// Area of all polygons, in squared units of the mesh.
    pub area: f64,
}

/// The polygons that span faces, at unit extent.
pub(super) struct Measured {
    pub(super) mesh: PolygonConnectivity,
    pub(super) positions: Vec<DVec3>,
    /// These positions over those given.
    pub(super) scale: f64,
}

impl Measured {
    pub(super) fn new(soup: &PolygonSoup) -> Result<Self, MeasureError> {
        let mesh = PolygonConnectivity::of(soup);
        let corners = (0..mesh.polygon_count()).flat_map(|polygon| mesh.vertices(polygon));
        let [low, high] = corners.fold(
            [DVec3::INFINITY, DVec3::NEG_INFINITY],
            |[low, high], &vertex| {
                let position = soup.positions[vertex as usize];
                [low.min(position), high.max(position)]
            },
        );
        let scale = scale_to_unit("mesh", (high - low).max_element().max(0.0))?;
        let positions = soup.positions.iter().map(|&position| position * scale);
        Ok(Self {
            positions: positions.collect(),
            mesh,
            scale,
        })
    }

    pub(super) fn position(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize]
    }

    pub(super) fn corner_positions(&self, polygon: usize) -> impl Iterator<Item = DVec3> {
        let vertices = self.mesh.vertices(polygon).iter();
        vertices.map(|&vertex| self.position(vertex))
    }

    /// The corners of each quad; `None` for other polygons.
    pub(super) fn quad(&self, polygon: usize) -> Option<[DVec3; 4]> {
        let quad: &[u32; 4] = self.mesh.vertices(polygon).try_into().ok()?;
        Some(quad.map(|vertex| self.position(vertex)))
    }

    /// The triangles that a polygon is cut into.
    pub(super) fn triangles(&self, polygon: usize) -> impl Iterator<Item = [DVec3; 3]> + use<> {
        let corners: Vec<_> = self.corner_positions(polygon).collect();
        let triangles = triangulate_polygon(&corners).into_iter();
        triangles.map(move |triangle| triangle.map(|corner| corners[corner as usize]))
    }
}

pub(super) fn area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

pub(super) fn count(soup: &PolygonSoup, measured: &Measured) -> PolygonCounts {
    let mesh = &measured.mesh;
    let used = mesh.polygon_count();
    let mut by_corners = BTreeMap::new();
    let [mut whole, mut in_quads] = [0.0; 2];
    for polygon in 0..used {
        let corners = mesh.vertices(polygon).len();
        *by_corners.entry(corners).or_insert(0) += 1;
        let area: f64 = measured.triangles(polygon).map(area).sum();
        whole += area;
        in_quads += if corners == 4 { area } else { 0.0 };
    }
    let number = |corners: usize| by_corners.get(&corners).copied().unwrap_or(0);
    let [triangles, quads] = [3, 4].map(number);
    PolygonCounts {
        total: soup.polygons.len(),
        left_out: soup.polygons.len() - used,
        triangles,
        quads,
        larger: used - triangles - quads,
        by_corners,
        quad_share: quads as f64 / used.max(1) as f64,
        quad_area_share: if whole > 0.0 { in_quads / whole } else { 0.0 },
        area: whole / measured.scale / measured.scale,
    }
}
