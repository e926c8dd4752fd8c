//! Polygons cut into triangles.
//!
//! Ears are clipped best first [Meisters 1975], with exact predicates in the coordinate plane that
//! the polygon faces most, so that collinear corners are seen as such; a tree over the reflex
//! corners keeps the cost near n log n. Then diagonals are exchanged while that raises the worse
//! of the two triangles beside them, as in Lawson's algorithm.

mod apex;
mod ears;
mod exchange;

use glam::{DVec2, DVec3};
use robust::{Coord, orient2d};

use crate::tolerance;

pub use apex::fan_apex;

/// Cuts a polygon in space into triangles, as indices into `positions`; the triangles turn the
/// same way as the polygon and every corner belongs to one.
///
/// A polygon with `n` corners gives `n - 2` triangles, none for less than 3. A polygon whose
/// projection onto its best plane is simple is covered exactly; collinear, self-crossing and not
/// finite polygons are cut too, without any promise about the shape. Vertices may appear more than
/// once, as in polygons with a hole that is tied to the outer boundary by a pair of bridges.
///
/// Cost: O(n log n) for usual shapes.
///
/// ```
/// use glam::DVec3;
/// // A dart: only the diagonal through its dent lies inside.
/// let dart = [[0., 0.], [2., 1.], [0., 2.], [0.5, 1.]].map(|[x, y]| DVec3::new(x, y, 0.));
/// let triangles = graticule::mesh::triangulate_polygon(&dart);
/// assert!(triangles.iter().all(|triangle| triangle.contains(&1) && triangle.contains(&3)));
/// ```
#[must_use]
pub fn triangulate_polygon(positions: &[DVec3]) -> Vec<[u32; 3]> {
    match positions.len() {
        0..=2 => Vec::new(),
        3 => vec![[0, 1, 2]],
        4 => cut_quad(positions).to_vec(),
        _ => Outline::new(positions).map_or_else(
            || fan(positions.len()),
            |outline| exchange::improve(&outline, ears::clip(&outline)),
        ),
    }
}

/// Cuts along the diagonal whose worse triangle is better; a dart only through its dent.
fn cut_quad(positions: &[DVec3]) -> [[u32; 3]; 2] {
    let first = [[0, 1, 2], [0, 2, 3]];
    let second = [[1, 2, 3], [1, 3, 0]];
    let Some(outline) = Outline::new(positions) else {
        return first;
    };
    let worse = |[one, other]: [[u32; 3]; 2]| outline.quality(one).min(outline.quality(other));
    if worse(second) > worse(first) + tolerance::SHAPE_GAIN {
        second
    } else {
        first
    }
}

fn fan(corners: usize) -> Vec<[u32; 3]> {
    (2..corners as u32)
        .map(|corner| [0, corner - 1, corner])
        .collect()
}

/// A polygon scaled by a power of two so that no product over- or underflows, and its shadow in a
/// coordinate plane, where it turns counter-clockwise on the whole.
struct Outline {
    positions: Vec<DVec3>,
    shadow: Vec<DVec2>,
}

impl Outline {
    /// `None` if the corners lie on a line or a coordinate is not finite.
    fn new(positions: &[DVec3]) -> Option<Self> {
        let largest = positions.iter().fold(0.0_f64, |most, position| {
            most.max(position.abs().max_element())
        });
        let scale = reciprocal_power_of_two(largest);
        let positions: Vec<_> = positions.iter().map(|&position| position * scale).collect();
        let normal = facing(&positions)?;
        let axis = (1..3).fold(0, |best, axis| {
            if normal[axis].abs() > normal[best].abs() {
                axis
            } else {
                best
            }
        });
        let [mut across, mut up] = [(axis + 1) % 3, (axis + 2) % 3];
        if normal[axis] < 0.0 {
            std::mem::swap(&mut across, &mut up);
        }
        let shadow = positions
            .iter()
            .map(|position| DVec2::new(position[across], position[up]))
            .collect();
        Some(Self { positions, shadow })
    }

    fn len(&self) -> usize {
        self.positions.len()
    }

    /// The sign of the turn at `b`, exactly: positive to the left.
    fn turn(&self, [a, b, c]: [u32; 3]) -> f64 {
        let [a, b, c] = [a, b, c].map(|corner| {
            let DVec2 { x, y } = self.shadow[corner as usize];
            Coord { x, y }
        });
        orient2d(a, b, c)
    }

    /// 1 for an equilateral triangle, towards 0 for a thin one, -1 for one whose shadow is turned
    /// over or has no area.
    fn quality(&self, triangle: [u32; 3]) -> f64 {
        if self.turn(triangle) > 0.0 {
            self.shape(triangle)
        } else {
            -1.0
        }
    }

    /// The mean ratio 4√3 · area / Σ length², in `0.0..=1.0`.
    fn shape(&self, triangle: [u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|corner| self.positions[corner as usize]);
        let squares =
            (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
        if squares > 0.0 {
            2.0 * 3.0_f64.sqrt() * (b - a).cross(c - a).length() / squares
        } else {
            0.0
        }
    }
}

/// A power of two that brings `largest` into `1.0..2.0`, as far as there is one.
pub(super) fn reciprocal_power_of_two(largest: f64) -> f64 {
    if largest > 0.0 && largest.is_finite() {
        libm::ldexp(1.0, -libm::ilogb(largest).clamp(-1000, 1000))
    } else {
        1.0
    }
}

/// The direction the polygon faces: its vector area (Newell), or where that vanishes (a figure of
/// eight) the normal of any three of its corners.
fn facing(positions: &[DVec3]) -> Option<DVec3> {
    let origin = positions[0];
    let pairs = positions.windows(2);
    let area: DVec3 = pairs
        .map(|pair| (pair[0] - origin).cross(pair[1] - origin))
        .sum();
    let extent = positions
        .iter()
        .map(|&position| position - origin)
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    let scale = extent.length_squared();
    if !area.is_finite() || !scale.is_finite() {
        return None;
    }
    if area.length() > tolerance::NO_AREA_HEIGHT * scale {
        return Some(area);
    }
    let widest = positions
        .iter()
        .map(|&position| extent.cross(position - origin))
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    (widest.length() > tolerance::NO_AREA_HEIGHT * scale).then_some(widest)
}

#[cfg(test)]
mod tests;
