use glam::{DVec2, DVec3};
use graticule::mesh::{FaceId, PerCorner, Surface};

use crate::{Color, Lines};

/// How iso-lines are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsoLineStyle {
    /// Lines for each whole number.
    pub lines_per_unit: u32,
    /// Colors of the lines of both coordinates.
    pub colors: [Color; 2],
    /// Width in pixels.
    pub width: f64,
}

impl Default for IsoLineStyle {
    fn default() -> Self {
        Self {
            lines_per_unit: 2,
            colors: [Color::hex(0x00b8_4a1c), Color::hex(0x001f_5f8b)],
            width: 1.2,
        }
    }
}

/// Lines of a coordinate in one triangle at most: more could not be told apart.
const MOST_LINES: f64 = 256.0;

/// The lines on which each of two coordinates has a multiple of `1 / lines_per_unit`, computed in
/// each triangle on its own: crisp whatever the transitions between triangles.
///
/// Triangles of which `is_left_out` holds, and those with coordinates that are not finite, have none.
#[must_use]
pub fn iso_lines(
    surface: &Surface,
    coordinates: &PerCorner<DVec2>,
    is_left_out: impl Fn(FaceId) -> bool,
    style: &IsoLineStyle,
) -> [Lines; 2] {
    [0, 1].map(|coordinate| {
        let mut lines = Lines::new(style.colors[coordinate], style.width);
        for face in surface.mesh().faces().filter(|&face| !is_left_out(face)) {
            let positions = surface.corner_positions(face);
            let values = face
                .halfedges()
                .map(|corner| coordinates[corner][coordinate] * f64::from(style.lines_per_unit));
            for segment in level_segments(positions, values) {
                lines.push(segment);
            }
        }
        lines
    })
}

/// The segments on which the linear function with these values at the corners is whole.
fn level_segments(positions: [DVec3; 3], values: [f64; 3]) -> Vec<[DVec3; 2]> {
    let low = values.into_iter().fold(f64::INFINITY, f64::min).ceil();
    let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max).floor();
    let is_drawn = values.iter().all(|value| value.is_finite()) && high - low < MOST_LINES;
    let mut segments = Vec::new();
    let mut level = low;
    while is_drawn && level <= high {
        let crossings: Vec<DVec3> = (0..3)
            .filter_map(|side| {
                let [from, to] = [values[side], values[(side + 1) % 3]];
                // Half-open, so that a line through a corner meets two sides.
                let crosses = (from < level) != (to < level);
                let share = (level - from) / (to - from);
                crosses.then(|| positions[side].lerp(positions[(side + 1) % 3], share))
            })
            .collect();
        if let [from, to] = crossings[..] {
            segments.push([from, to]);
        }
        level += 1.0;
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_ends_on_the_sides_it_crosses() {
        let corners = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
        let segments = level_segments(corners, [-0.5, 1.5, -0.5]);
        assert_eq!(segments.len(), 2);
        for (segment, x) in segments.iter().zip([1.0, 3.0]) {
            assert!(
                segment.iter().all(|p| (p.x - x).abs() < 1e-12),
                "{segment:?}"
            );
            assert!((segment[0].distance(segment[1]) - (4.0 - x)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_triangle_between_two_lines_and_one_without_numbers_have_none() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        assert!(level_segments(corners, [0.1, 0.9, 0.4]).is_empty());
        assert!(level_segments(corners, [0.1, f64::NAN, 7.4]).is_empty());
        assert!(level_segments(corners, [0.0, 1e300, 7.4]).is_empty());
    }
}
