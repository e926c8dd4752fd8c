//! Triangles as polygons from back to front, for drawings of few triangles.

use glam::{DVec2, DVec3, Vec3};

use crate::camera::Camera;
use crate::raster::{depth_of_shade, flat_normal, lit};
use crate::scene::{Checker, Paint, Shading, Triangles};
use crate::sheet::Shape;
use crate::{Color, Eye, Layer, Panel};

/// A triangle over more squares than this each way has their mean colour instead.
const MOST_SQUARES: f64 = 48.0;

/// A convex piece of a triangle by the shares of the corners at its own corners.
type Piece = Vec<[f64; 3]>;

/// The polygons of all triangles of a panel, farthest first. Triangles that cut through each other
/// are ordered by their middles.
pub(crate) fn painted_triangles(panel: &Panel, camera: &Camera, corner: DVec2) -> Vec<Shape> {
    let mut polygons = Vec::new();
    for layer in &panel.layers {
        if let Layer::Triangles(triangles) = layer {
            for triangle in 0..triangles.triangles.len() {
                push_polygons(&mut polygons, triangles, triangle, camera);
            }
        }
    }
    if panel.eye != Eye::Plane {
        polygons.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let shape = |(_, points, fill): (f64, Vec<DVec2>, Color)| Shape::Polygon {
        points: points.into_iter().map(|point| point + corner).collect(),
        fill,
        tile: true,
    };
    polygons.into_iter().map(shape).collect()
}

/// The polygons of one triangle with their depth and colour.
fn push_polygons(
    polygons: &mut Vec<(f64, Vec<DVec2>, Color)>,
    layer: &Triangles,
    triangle: usize,
    camera: &Camera,
) {
    let position = |vertex: u32| layer.positions.get(vertex as usize).copied();
    let corners = layer.triangles[triangle].map(|v| position(v).map(|p| camera.project(p)));
    let [Some(a), Some(b), Some(c)] = corners else {
        return;
    };
    let sum = a + b + c;
    if !sum.is_finite() {
        return;
    }
    // Pixels count downward, which turns counter-clockwise into clockwise.
    let near_side = (b - a).truncate().perp_dot((c - a).truncate()) < 0.0;
    let place = |shares: &[f64; 3]| -> DVec2 {
        let place: DVec3 = a * shares[0] + b * shares[1] + c * shares[2];
        place.truncate()
    };
    let base = base_color(layer, triangle);
    for (piece, color) in pieces(layer.checker.as_ref(), triangle, base) {
        let color = shaded(color, layer, triangle, near_side, camera);
        polygons.push((sum.z / 3.0, piece.iter().map(place).collect(), color));
    }
}

/// The colour in the middle of a triangle.
fn base_color(layer: &Triangles, triangle: usize) -> Color {
    match &layer.paint {
        Paint::Uniform(color) => *color,
        Paint::PerFace(colors) => colors.get(triangle).copied().unwrap_or(Color::MISSING),
        Paint::PerVertex(values, map) => {
            let value = |v: u32| values.get(v as usize).map_or(f64::NAN, |&x| f64::from(x));
            map.at(layer.triangles[triangle].map(value).iter().sum::<f64>() / 3.0)
        }
    }
}

fn shaded(
    color: Color,
    layer: &Triangles,
    triangle: usize,
    near_side: bool,
    camera: &Camera,
) -> Color {
    let normal = match &layer.shading {
        Shading::Unlit => return color,
        Shading::Flat => flat_normal(layer, triangle, camera),
        Shading::Smooth(normals) => normals.get(triangle).map_or(Vec3::ZERO, |corners| {
            let sum: Vec3 = corners.iter().map(|&normal| Vec3::from_array(normal)).sum();
            camera
                .turn(sum.as_dvec3().normalize_or(DVec3::ZERO))
                .as_vec3()
        }),
    };
    lit(color, normal, near_side, depth_of_shade(layer))
}

/// The triangle cut along the squares of its checker, each piece with its colour.
fn pieces(checker: Option<&Checker>, triangle: usize, color: Color) -> Vec<(Piece, Color)> {
    let whole: Piece = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let Some(checker) = checker else {
        return vec![(whole, color)];
    };
    let Some(corners) = checker.corners.get(triangle) else {
        return vec![(whole, Color::MISSING)];
    };
    let corners = corners.map(|corner| corner.map(f64::from));
    if !corners.iter().flatten().all(|x| x.is_finite()) {
        return vec![(whole, Color::MISSING)];
    }
    let dark = color.times(checker.dark);
    let [columns, rows] = [0, 1].map(|axis| squares(corners.map(|corner| corner[axis])));
    if columns.end - columns.start > MOST_SQUARES || rows.end - rows.start > MOST_SQUARES {
        return vec![(whole, color.mix(dark, 0.5))];
    }
    let mut result = Vec::new();
    let mut column = columns.start;
    while column < columns.end {
        let strip = between(&whole, corners.map(|corner| corner[0]), column);
        let mut row = rows.start;
        while row < rows.end {
            let piece = between(&strip, corners.map(|corner| corner[1]), row);
            if piece.len() >= 3 {
                let is_dark = (column + row).rem_euclid(2.0) >= 1.0;
                result.push((piece, if is_dark { dark } else { color }));
            }
            row += 1.0;
        }
        column += 1.0;
    }
    result
}

/// The squares that the values reach into.
fn squares(values: [f64; 3]) -> std::ops::Range<f64> {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min).floor();
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    low..high.ceil().max(low + 1.0)
}

/// The part of a piece where the interpolated value lies in `start..=start + 1`.
fn between(piece: &[[f64; 3]], values: [f64; 3], start: f64) -> Piece {
    let value = |shares: &[f64; 3]| -> f64 { (0..3).map(|k| shares[k] * values[k]).sum() };
    let above = clip(piece, |shares| value(shares) - start);
    clip(&above, |shares| start + 1.0 - value(shares))
}

/// The part of a convex piece where an affine function is not negative (Sutherland and Hodgman).
fn clip(piece: &[[f64; 3]], function: impl Fn(&[f64; 3]) -> f64) -> Piece {
    let mut result = Vec::with_capacity(piece.len() + 1);
    for (index, from) in piece.iter().enumerate() {
        let to = &piece[(index + 1) % piece.len()];
        let (at_from, at_to) = (function(from), function(to));
        if at_from >= 0.0 {
            result.push(*from);
        }
        if (at_from < 0.0) != (at_to < 0.0) {
            let share = at_from / (at_from - at_to);
            result.push([0, 1, 2].map(|k| from[k] + (to[k] - from[k]) * share));
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area of a piece as a share of its triangle.
    fn area(piece: &[[f64; 3]]) -> f64 {
        let points: Vec<DVec2> = piece.iter().map(|s| DVec2::new(s[1], s[2])).collect();
        (0..points.len())
            .map(|k| points[k].perp_dot(points[(k + 1) % points.len()]))
            .sum()
    }

    #[test]
    fn the_pieces_of_a_checkered_triangle_tile_it() {
        let checker = Checker {
            corners: vec![[[0.3, -0.2], [5.7, 1.1], [2.0, 4.9]]],
            dark: Color::CHECKER,
        };
        let pieces = pieces(Some(&checker), 0, Color::WHITE);
        let total: f64 = pieces.iter().map(|(piece, _)| area(piece)).sum();
        assert!((total - 1.0).abs() < 1e-12);
        let dark = pieces.iter().filter(|(_, color)| *color != Color::WHITE);
        let dark: f64 = dark.map(|(piece, _)| area(piece)).sum();
        assert!((dark - 0.5).abs() < 0.1);
    }
}
