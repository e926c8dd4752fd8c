use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::{Eye, Frame, Layer, Panel};

/// Distance of the viewer in perspective, in largest extents of the layers.
const DISTANCE: f64 = 4.0;

/// Brings positions to pixels: x to the right, y down, and a depth that grows toward the viewer,
/// is in pixels too, and is affine over the image of any plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    frame: Frame,
    /// Reciprocal of the viewer's distance in extents; 0 without perspective.
    nearness: f64,
    center: DVec3,
    extent: f64,
    scale: f64,
    offset: DVec2,
}

impl Camera {
    /// The camera that shows all layers of the panel in the middle of a rectangle of this width
    /// and height, `margin` pixels from its sides. `None` if there is no finite position, or if
    /// differences of positions overflow.
    pub(crate) fn fit(panel: &Panel, size: DVec2, margin: f64) -> Option<Self> {
        let positions = || panel.layers.par_iter().flat_map(Layer::positions);
        let [low, high] = bounds(positions().copied());
        let extent = (high - low).max_element();
        if !extent.is_finite() || !low.is_finite() {
            return None;
        }
        let (frame, nearness) = match panel.eye {
            Eye::Plane => (Frame::PLANE, 0.0),
            Eye::Orthographic(frame) => (frame, 0.0),
            Eye::Perspective(frame) => (frame, 1.0 / DISTANCE),
        };
        let mut camera = Self {
            frame,
            nearness,
            center: low + (high - low) / 2.0,
            // One point alone is drawn in the middle, at any scale.
            extent: if extent > 0.0 { extent } else { 1.0 },
            scale: 1.0,
            offset: DVec2::ZERO,
        };
        let [low, high] = bounds(positions().map(|&position| camera.project(position)));
        let available = (size - 2.0 * margin).max(DVec2::ONE);
        let image = (high - low).truncate().max(DVec2::splat(f64::EPSILON));
        camera.scale = (available / image).min_element();
        camera.offset = size / 2.0 - (low + high).truncate() / 2.0 * camera.scale;
        Some(camera)
    }

    /// x, y and depth of a position in pixels.
    #[inline]
    pub(crate) fn project(&self, position: DVec3) -> DVec3 {
        let seen = self
            .frame
            .coordinates((position - self.center) / self.extent);
        let enlarged = 1.0 / (1.0 - seen.z * self.nearness);
        DVec3::new(
            (seen.x * enlarged) * self.scale + self.offset.x,
            (-seen.y * enlarged) * self.scale + self.offset.y,
            (seen.z * enlarged) * self.scale,
        )
    }

    /// By how much a point of this depth is enlarged by perspective: affine over the image of any
    /// plane, so that `value * enlarged` interpolates linearly in the image.
    #[inline]
    pub(crate) fn enlargement(&self, depth: f64) -> f64 {
        1.0 + depth / self.scale * self.nearness
    }

    /// Coordinates of a direction: to the right, up, toward the viewer.
    #[inline]
    pub(crate) fn turn(&self, direction: DVec3) -> DVec3 {
        self.frame.coordinates(direction)
    }
}

/// The smallest box around the finite positions. Minima do not depend on the order.
fn bounds(positions: impl ParallelIterator<Item = DVec3>) -> [DVec3; 2] {
    let empty = || [DVec3::INFINITY, DVec3::NEG_INFINITY];
    positions
        .filter(|position| position.is_finite())
        .fold(empty, |[low, high], p| [low.min(p), high.max(p)])
        .reduce(empty, |[a, b], [c, d]| [a.min(c), b.max(d)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Color, Points};

    fn panel(eye: Eye, positions: Vec<DVec3>) -> Panel {
        let points = Points {
            positions,
            color: Color::INK,
            radius: 5.0,
            ring: false,
        };
        Panel::new(eye, vec![points.into()])
    }

    #[test]
    fn everything_is_inside_the_margins_at_any_scale() {
        let frame = Frame::new(DVec3::new(1.0, 2.0, 3.0), DVec3::Y).unwrap();
        for eye in [
            Eye::Plane,
            Eye::Orthographic(frame),
            Eye::Perspective(frame),
        ] {
            for scale in [1e-300, 1e-30, 1.0, 1e30, 1e150] {
                let corner = |bits: u32| {
                    let bit = |k: u32| f64::from((bits >> k) & 1);
                    DVec3::new(1.0 + bit(0), 2.0 * bit(1) - 7.0, bit(2)) * scale
                };
                let panel = panel(eye, (0..8).map(corner).collect());
                let camera = Camera::fit(&panel, DVec2::new(400.0, 300.0), 20.0).unwrap();
                for &position in panel.layers[0].positions() {
                    let pixel = camera.project(position);
                    assert!(pixel.x > 19.9 && pixel.x < 380.1, "{pixel}");
                    assert!(pixel.y > 19.9 && pixel.y < 280.1, "{pixel}");
                }
            }
        }
    }

    #[test]
    fn perspective_keeps_lines_straight_in_depth_too() {
        let frame = Frame::new(DVec3::new(1.0, 0.3, 0.8), DVec3::Y).unwrap();
        let ends = [DVec3::new(-1.0, 0.2, 3.0), DVec3::new(2.0, -0.7, -1.0)];
        let panel = panel(Eye::Perspective(frame), ends.to_vec());
        let camera = Camera::fit(&panel, DVec2::splat(500.0), 0.0).unwrap();
        let [a, b] = ends.map(|end| camera.project(end));
        let middle = camera.project((ends[0] + ends[1]) / 2.0);
        let share = (middle.x - a.x) / (b.x - a.x);
        assert!((a + (b - a) * share - middle).length() < 1e-9);
        let enlarged = |p: DVec3| camera.enlargement(p.z);
        let expected = enlarged(a) / (enlarged(a) + enlarged(b));
        assert!((share - expected).abs() < 1e-12);
    }

    #[test]
    fn a_point_alone_is_in_the_middle_and_nothing_has_no_camera() {
        let size = DVec2::splat(100.0);
        let camera = Camera::fit(&panel(Eye::Plane, vec![DVec3::ONE]), size, 5.0).unwrap();
        assert_eq!(camera.project(DVec3::ONE).truncate(), DVec2::splat(50.0));
        assert!(Camera::fit(&panel(Eye::Plane, vec![DVec3::NAN]), size, 5.0).is_none());
    }
}
