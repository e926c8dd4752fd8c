//! Which triangle lies at each point of a raster.

use glam::DVec2;

use crate::mesh::FaceId;

/// How far outside of a triangle, in weights of its corners, a point still counts as on it: between
/// two triangles rounding must leave no gap.
const OUTSIDE: f64 = 1e-9;

/// A point of a raster on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RasterPoint {
    pub(super) face: FaceId,
    /// The weights of the corners, none negative, with the sum 1.
    pub(super) weights: [f64; 3],
}

/// A raster of points at whole coordinates, from (0, 0) on, row by row.
pub(super) struct TriangleRaster {
    width: u32,
    height: u32,
    points: Vec<Option<RasterPoint>>,
    /// The smallest weight of each point: the triangle where it is largest wins.
    inside: Vec<f64>,
}

impl TriangleRaster {
    pub(super) fn new(width: u32, height: u32) -> Self {
        let count = width as usize * height as usize;
        Self {
            width,
            height,
            points: vec![None; count],
            inside: vec![-OUTSIDE; count],
        }
    }

    /// Draws a triangle with counter-clockwise corners.
    pub(super) fn draw(&mut self, face: FaceId, corners: [DVec2; 3]) {
        let [a, b, c] = corners;
        let area = (b - a).perp_dot(c - a);
        if area.is_nan() || area <= 0.0 {
            return;
        }
        let low = a.min(b).min(c);
        let high = a.max(b).max(c);
        for y in steps(low.y, high.y, self.height) {
            for x in steps(low.x, high.x, self.width) {
                let point = DVec2::new(f64::from(x), f64::from(y));
                let [u, v] =
                    [(c - b, b), (a - c, c)].map(|(side, from)| side.perp_dot(point - from) / area);
                let weights = [u, v, 1.0 - u - v];
                let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
                let index = y as usize * self.width as usize + x as usize;
                let is_better = self.points[index].is_none() && least >= self.inside[index];
                if is_better || least > self.inside[index] {
                    self.inside[index] = least;
                    self.points[index] = Some(RasterPoint {
                        face,
                        weights: clamped(weights),
                    });
                }
            }
        }
    }

    pub(super) fn into_points(self) -> Vec<Option<RasterPoint>> {
        self.points
    }
}

/// The whole numbers between two, within `0..count`.
#[allow(clippy::cast_sign_loss, reason = "clamped to be non-negative")]
fn steps(low: f64, high: f64, count: u32) -> std::ops::Range<u32> {
    let whole = |x: f64| x.clamp(0.0, f64::from(count)) as u32;
    whole((low - OUTSIDE).ceil())..whole((high + OUTSIDE).floor() + 1.0)
}

fn clamped(weights: [f64; 3]) -> [f64; 3] {
    let positive = weights.map(|weight| weight.max(0.0));
    let sum: f64 = positive.iter().sum();
    positive.map(|weight| weight / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_cover_every_point_of_their_square_once() {
        let mut raster = TriangleRaster::new(9, 9);
        let [a, b, c, d] = [[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]].map(DVec2::from);
        raster.draw(FaceId(0), [a, b, c]);
        raster.draw(FaceId(1), [a, c, d]);
        let points = raster.into_points();
        for (index, point) in points.iter().enumerate() {
            let (x, y) = (index % 9, index / 9);
            let RasterPoint { face, weights } = point.unwrap();
            assert!(if x > y {
                face == FaceId(0)
            } else {
                x == y || face == FaceId(1)
            });
            let corners = if face == FaceId(0) {
                [a, b, c]
            } else {
                [a, c, d]
            };
            let place: DVec2 = corners.iter().zip(weights).map(|(p, w)| *p * w).sum();
            assert!(place.distance(DVec2::new(x as f64, y as f64)) < 1e-12);
        }
    }

    #[test]
    fn triangles_outside_and_turned_over_leave_nothing() {
        let mut raster = TriangleRaster::new(4, 4);
        let corners = [[-5.0, -5.0], [-1.0, -5.0], [-1.0, -1.0]].map(DVec2::from);
        raster.draw(FaceId(0), corners);
        raster.draw(
            FaceId(1),
            [[0.0, 0.0], [0.0, 3.0], [3.0, 0.0]].map(DVec2::from),
        );
        assert!(raster.into_points().iter().all(Option::is_none));
    }
}
