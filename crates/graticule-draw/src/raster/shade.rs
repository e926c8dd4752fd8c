use glam::{DVec3, Vec3};

use super::{Projected, SAMPLES, STEPS, Vertex, layer_of};
use crate::Color;
use crate::camera::Camera;
use crate::scene::{Checker, Paint, Shading, Triangles};

/// From the surface to the main light, for a viewer who looks along -z: above the left shoulder;
/// and to a faint one on the other side, so that parts in shadow keep their shape.
const LIGHTS: [(Vec3, f32); 2] = [
    (Vec3::new(-0.34, 0.47, 0.814), 0.52),
    (Vec3::new(0.8, -0.1, 0.592), 0.2),
];
/// Brightness of parts turned away from all light.
const AMBIENT: f32 = 0.42;
/// How much of the shade is left on colours that must be compared with a legend.
const SHADE_ON_FIGURES: f32 = 0.6;
/// How much of the colour of the far side is its tint.
const FAR_SIDE_TINT: f32 = 0.6;

/// Colours of the triangles of a panel.
pub(super) struct Shader<'a> {
    layers: &'a [Projected<'a>],
    camera: &'a Camera,
}

/// A place in a triangle, as seen in the image.
struct Fragment {
    /// Shares of the corners in space.
    shares: [f64; 3],
    /// Shares of the corners in the image: their changes for one pixel to the right and down.
    slopes: [[f64; 2]; 3],
    /// Whether the triangle is seen from its near side.
    near_side: bool,
}

impl<'a> Shader<'a> {
    pub(super) fn new(layers: &'a [Projected<'a>], camera: &'a Camera) -> Self {
        Self { layers, camera }
    }

    /// The colour of triangle number `id` at a place in the image, in rounding steps.
    pub(super) fn color(&self, id: u32, place: [f64; 2]) -> Color {
        let projected = layer_of(self.layers, id);
        let triangle = (id - projected.first) as usize;
        let Some(corners) = projected.corners(triangle) else {
            return Color::MISSING;
        };
        let layer = projected.layer;
        let fragment = Fragment::new(corners, place, self.camera);
        let mut color = base_color(layer, triangle, &fragment);
        if let Some(checker) = &layer.checker {
            color = checkered(color, checker, triangle, &fragment);
        }
        let normal = match &layer.shading {
            Shading::Unlit => return color,
            Shading::Flat => flat_normal(layer, triangle, self.camera),
            Shading::Smooth(normals) => normals.get(triangle).map_or(Vec3::Z, |corners| {
                smooth_normal(corners, &fragment, self.camera)
            }),
        };
        lit(color, normal, fragment.near_side, depth_of_shade(layer))
    }
}

impl Fragment {
    fn new(corners: [Vertex; 3], place: [f64; 2], camera: &Camera) -> Self {
        let [a, b, c] = corners.map(|v| [f64::from(v.x), f64::from(v.y)]);
        let cross = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        };
        // Not zero: only triangles that cover a sample are shaded.
        let area = cross(a, b, c);
        let in_image = [(b, c), (c, a), (a, b)].map(|(p, q)| cross(p, q, place) / area);
        let pixel = f64::from(SAMPLES * STEPS) / area;
        let slopes =
            [(b, c), (c, a), (a, b)].map(|(p, q)| [(p[1] - q[1]) * pixel, (q[0] - p[0]) * pixel]);
        let enlarged =
            [0, 1, 2].map(|k| in_image[k] * camera.enlargement(f64::from(corners[k].depth)));
        let sum: f64 = enlarged.iter().sum();
        Self {
            shares: enlarged.map(|share| share / sum),
            slopes,
            // Pixels count downward, which turns counter-clockwise into clockwise.
            near_side: area < 0.0,
        }
    }

    fn interpolate(&self, values: [f64; 3]) -> f64 {
        (0..3).map(|k| self.shares[k] * values[k]).sum()
    }

    /// How much an interpolated value changes within a pixel.
    fn change(&self, values: [f64; 3]) -> f64 {
        let slope = |axis: usize| -> f64 { (0..3).map(|k| self.slopes[k][axis] * values[k]).sum() };
        slope(0).mul_add(slope(0), slope(1) * slope(1)).sqrt()
    }
}

fn base_color(layer: &Triangles, triangle: usize, fragment: &Fragment) -> Color {
    match &layer.paint {
        Paint::Uniform(color) => *color,
        Paint::PerFace(colors) => colors.get(triangle).copied().unwrap_or(Color::MISSING),
        Paint::PerVertex(values, map) => {
            let value = |vertex: u32| {
                let value = values.get(vertex as usize).copied().unwrap_or(f32::NAN);
                f64::from(value)
            };
            map.at(fragment.interpolate(layer.triangles[triangle].map(value)))
        }
    }
}

/// Darkens a colour by the share of dark squares in the pixel, so that squares too small to be
/// seen turn to an even grey instead of a moiré.
fn checkered(color: Color, checker: &Checker, triangle: usize, fragment: &Fragment) -> Color {
    let Some(corners) = checker.corners.get(triangle) else {
        return Color::MISSING;
    };
    if !corners.iter().flatten().all(|x| x.is_finite()) {
        return Color::MISSING;
    }
    let mean_sign = |axis: usize| {
        let values = corners.map(|corner| f64::from(corner[axis]));
        square_wave_mean(fragment.interpolate(values), fragment.change(values))
    };
    let dark_share = 0.5 - 0.5 * mean_sign(0) * mean_sign(1);
    color.mix(color.times(checker.dark), dark_share as f32)
}

/// The mean over an interval of this middle and width of the function that is 1 on [0, 1), -1 on
/// [1, 2), and so on.
fn square_wave_mean(middle: f64, width: f64) -> f64 {
    // Below this the interval is all but a point; above, the difference is exact enough.
    let width = width.max(1e-3);
    let integral = |x: f64| 1.0 - (x - 2.0 * (x / 2.0).floor() - 1.0).abs();
    (integral(middle + width / 2.0) - integral(middle - width / 2.0)) / width
}

/// The unit normal of a triangle in the frame of the viewer, toward its near side.
pub(crate) fn flat_normal(layer: &Triangles, triangle: usize, camera: &Camera) -> Vec3 {
    let [a, b, c] = layer.triangles[triangle].map(|vertex| layer.positions[vertex as usize]);
    // In units of the extent of the triangle, so that products neither vanish nor overflow.
    let size = (b - a).abs().max((c - a).abs()).max_element();
    let normal = ((b - a) / size)
        .cross((c - a) / size)
        .normalize_or(DVec3::ZERO);
    camera.turn(normal).as_vec3()
}

fn smooth_normal(corners: &[[f32; 3]; 3], fragment: &Fragment, camera: &Camera) -> Vec3 {
    let normal: DVec3 = (0..3)
        .map(|k| Vec3::from_array(corners[k]).as_dvec3() * fragment.shares[k])
        .sum();
    camera.turn(normal.normalize_or(DVec3::ZERO)).as_vec3()
}

/// The colour under the light; the far side is tinted, so that inside-out parts show.
pub(crate) fn lit(color: Color, normal: Vec3, near_side: bool, depth_of_shade: f32) -> Color {
    let (color, normal) = if near_side {
        (color, normal)
    } else {
        (color.mix(Color::FAR_SIDE, FAR_SIDE_TINT), -normal)
    };
    // A triangle without area has no normal and is lit as if it faced the viewer.
    let normal = if normal == Vec3::ZERO {
        Vec3::Z
    } else {
        normal
    };
    let light: f32 = LIGHTS
        .iter()
        .map(|&(direction, strength)| strength * normal.dot(direction).max(0.0))
        .sum();
    color.scaled(1.0 - depth_of_shade * (1.0 - AMBIENT - light))
}

/// 1 for the full range from light to shade, less where colours carry numbers.
pub(crate) fn depth_of_shade(layer: &Triangles) -> f32 {
    match layer.paint {
        Paint::Uniform(_) => 1.0,
        Paint::PerFace(_) | Paint::PerVertex(..) => SHADE_ON_FIGURES,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_a_square_wave_is_exact() {
        assert!((square_wave_mean(0.5, 0.01) - 1.0).abs() < 1e-12);
        assert!((square_wave_mean(-0.5, 0.01) + 1.0).abs() < 1e-12);
        assert!(square_wave_mean(7.0, 0.4).abs() < 1e-12);
        assert!((square_wave_mean(0.9, 0.4) - 0.5).abs() < 1e-12);
        assert!(square_wave_mean(0.3, 1000.0).abs() < 2e-3);
    }

    #[test]
    fn the_lights_have_unit_length_and_never_bleach() {
        for (direction, _) in LIGHTS {
            assert!((direction.length() - 1.0).abs() < 2e-3);
        }
        let brightest = lit(Color::WHITE, LIGHTS[0].0, true, 1.0);
        assert!(brightest.red > 0.97 && brightest.red < 1.03);
    }
}
