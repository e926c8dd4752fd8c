//! The triangles of a panel as pixels: 3 × 3 samples for each pixel, a depth for each sample in
//! space, the painter's order in the plane.
//!
//! Vertices are rounded to 1/256 of a sample, and coverage is decided in whole numbers (Pineda's
//! edge functions with the top-left rule), so that neighbouring triangles leave no gap, share no
//! sample, and every machine covers the same samples. Bands of pixel rows are filled in parallel,
//! each by one thread and in the order of the triangles.

mod band;
mod shade;

use glam::DVec2;
use rayon::prelude::*;

use crate::camera::Camera;
use crate::scene::Triangles;
use crate::{Eye, Layer, Panel};
use band::{Band, Order};
use shade::Shader;
pub(crate) use shade::{depth_of_shade, flat_normal, lit};

/// Samples along each side of a pixel.
const SAMPLES: i32 = 3;
/// Rounding steps along each side of a sample.
const STEPS: i32 = 256;
/// Pixel rows of a band: few enough to stay in cache, many enough to fill them at a stretch.
const BAND_ROWS: u32 = 16;

/// The image of the triangles of a panel.
#[derive(Clone, Debug)]
pub(crate) struct Raster {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Red, green, blue, each already multiplied by the opacity that stands fourth.
    pub(crate) pixels: Vec<[u8; 4]>,
    /// Depth in the middle of each pixel, negative infinity where there is no triangle.
    depths: Vec<f32>,
}

impl Raster {
    /// The depth of the surface seen at this place; negative infinity where there is none.
    pub(crate) fn depth(&self, place: DVec2) -> f64 {
        let column = (place.x.max(0.0) as usize).min(self.width as usize - 1);
        let row = (place.y.max(0.0) as usize).min(self.height as usize - 1);
        f64::from(self.depths[row * self.width as usize + column])
    }
}

/// A vertex in the image: x and y in rounding steps, depth in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vertex {
    x: i32,
    y: i32,
    depth: f32,
}

impl Vertex {
    /// Marks a position that has no place in the image.
    const NOWHERE: Self = Self {
        x: i32::MIN,
        y: 0,
        depth: 0.0,
    };
}

/// One layer of triangles with its vertices in the image.
struct Projected<'a> {
    layer: &'a Triangles,
    vertices: Vec<Vertex>,
    /// The number of triangles in the layers before.
    first: u32,
}

impl<'a> Projected<'a> {
    fn new(layer: &'a Triangles, camera: &Camera, first: u32) -> Self {
        let steps = f64::from(SAMPLES * STEPS);
        let place = |&position: &glam::DVec3| {
            let pixel = camera.project(position);
            if !pixel.is_finite() {
                return Vertex::NOWHERE;
            }
            Vertex {
                x: (pixel.x * steps).round() as i32,
                y: (pixel.y * steps).round() as i32,
                depth: pixel.z as f32,
            }
        };
        Self {
            layer,
            vertices: layer.positions.par_iter().map(place).collect(),
            first,
        }
    }

    /// The corners of a triangle, unless it has no place in the image.
    fn corners(&self, triangle: usize) -> Option<[Vertex; 3]> {
        let corner = |vertex: u32| self.vertices.get(vertex as usize).copied();
        let [a, b, c] = self.layer.triangles[triangle].map(corner);
        let corners = [a?, b?, c?];
        (!corners.contains(&Vertex::NOWHERE)).then_some(corners)
    }
}

/// Draws the triangles of all layers of the panel.
pub(crate) fn rasterize(panel: &Panel, camera: &Camera, [width, height]: [u32; 2]) -> Raster {
    let layers = project_layers(panel, camera);
    let bands = triangles_by_band(&layers, height);
    let shader = Shader::new(&layers, camera);
    let order = match panel.eye {
        Eye::Plane => Order::LastOnTop,
        _ => Order::NearestOnTop,
    };
    let strips: Vec<_> = bands
        .par_iter()
        .enumerate()
        .map_init(
            || Band::new(width),
            |band, (index, triangles)| {
                let first_row = index as u32 * BAND_ROWS;
                band.begin(first_row, BAND_ROWS.min(height - first_row));
                for &id in triangles {
                    if let Some(corners) = corners_of(&layers, id) {
                        band.fill(id, corners, order);
                    }
                }
                band.resolve(&shader)
            },
        )
        .collect();
    let mut raster = Raster {
        width,
        height,
        pixels: Vec::with_capacity((width * height) as usize),
        depths: Vec::with_capacity((width * height) as usize),
    };
    for (pixels, depths) in strips {
        raster.pixels.extend(pixels);
        raster.depths.extend(depths);
    }
    raster
}

fn project_layers<'a>(panel: &'a Panel, camera: &Camera) -> Vec<Projected<'a>> {
    let mut first = 0;
    let mut layers = Vec::new();
    for layer in &panel.layers {
        if let Layer::Triangles(triangles) = layer {
            layers.push(Projected::new(triangles, camera, first));
            first += triangles.triangles.len() as u32;
        }
    }
    layers
}

/// The layer that triangle number `id` belongs to.
fn layer_of<'a, 'b>(layers: &'a [Projected<'b>], id: u32) -> &'a Projected<'b> {
    let after = layers.partition_point(|layer| layer.first <= id);
    &layers[after - 1]
}

fn corners_of(layers: &[Projected<'_>], id: u32) -> Option<[Vertex; 3]> {
    let layer = layer_of(layers, id);
    layer.corners((id - layer.first) as usize)
}

/// For each band the numbers of the triangles that reach into it, in order.
fn triangles_by_band(layers: &[Projected<'_>], height: u32) -> Vec<Vec<u32>> {
    let band_steps = BAND_ROWS as i32 * SAMPLES * STEPS;
    let count = height.div_ceil(BAND_ROWS) as usize;
    let mut bands = vec![Vec::new(); count];
    for layer in layers {
        for triangle in 0..layer.layer.triangles.len() {
            let Some([a, b, c]) = layer.corners(triangle) else {
                continue;
            };
            let band_at = |y: i32| (y.max(0) / band_steps) as usize;
            let top = band_at(a.y.min(b.y).min(c.y));
            let bottom = band_at(a.y.max(b.y).max(c.y)).min(count - 1);
            for band in bands.iter_mut().take(bottom + 1).skip(top) {
                band.push(layer.first + triangle as u32);
            }
        }
    }
    bands
}
