use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::DVec3;

use crate::{Fixture, Noise, cylinder_patch, grid, icosphere, irregular_disk};

/// The ellipsoid with these half axes, on the triangles of [`icosphere`].
#[must_use]
pub fn ellipsoid(half_axes: DVec3, levels: u32) -> Fixture {
    icosphere(levels).map(|p| p * half_axes)
}

/// A closed cone around the z axis with its tip at `z = height` and a flat base of radius 1 at
/// `z = 0`, from `rings` rings each.
///
/// # Panics
/// If `around` is below 3 or `rings` is 0.
#[must_use]
pub fn cone_closed(height: f64, around: u32, rings: u32) -> Fixture {
    assert!(
        around >= 3 && rings >= 1,
        "a cone needs 3 vertices around and a ring"
    );
    // Levels -rings (middle of the base) .. 0 (its rim) .. rings (the tip).
    let levels = 2 * rings;
    let mut positions = vec![DVec3::ZERO];
    for level in 1..levels {
        let from_tip = f64::from(levels - level) / f64::from(rings);
        let radius = from_tip.min(2.0 - from_tip);
        let z = height * (1.0 - from_tip).max(0.0);
        for step in 0..around {
            let (sin, cos) = (TAU * f64::from(step) / f64::from(around)).sin_cos();
            positions.push(DVec3::new(radius * cos, radius * sin, z));
        }
    }
    let tip = positions.len() as u32;
    positions.push(DVec3::Z * height);
    let vertex = |level: u32, step: u32| 1 + (level - 1) * around + step % around;
    let mut triangles = Vec::new();
    for step in 0..around {
        triangles.push([0, vertex(1, step + 1), vertex(1, step)]);
        triangles.push([tip, vertex(levels - 1, step), vertex(levels - 1, step + 1)]);
        for level in 1..levels - 1 {
            let [a, b] = [vertex(level, step), vertex(level, step + 1)];
            let [c, d] = [vertex(level + 1, step + 1), vertex(level + 1, step)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Fixture {
        positions,
        triangles,
    }
}

/// A hyperboloid of one sheet, `x² + y² = 1 + z²` for `-1.0..=1.0` in z: an annulus of negative
/// curvature. Its triangles are obtuse.
///
/// # Panics
/// If `around` is below 3 or `along` is 0.
#[must_use]
pub fn hyperboloid(around: u32, along: u32) -> Fixture {
    cylinder_patch(1.0, 2.0, around, along).map(|p| {
        let z = p.z - 1.0;
        let radius = (1.0 + z * z).sqrt();
        DVec3::new(p.x * radius, p.y * radius, z)
    })
}

/// A block of unit cubes in a row of `2 · holes + 1` by 3, with a square hole through every second
/// place of the middle row: a closed surface of genus `holes`.
#[must_use]
pub fn block_with_holes(holes: u32) -> Fixture {
    let length = 2 * i64::from(holes) + 1;
    let is_solid = |x: i64, y: i64, z: i64| {
        let inside = (0..length).contains(&x) && (0..3).contains(&y) && z == 0;
        inside && !(y == 1 && x % 2 == 1)
    };
    let mut surface = Fixture {
        positions: Vec::new(),
        triangles: Vec::new(),
    };
    let mut numbers = BTreeMap::new();
    for x in 0..length {
        for y in 0..3 {
            let at = [x, y, 0];
            for (axis, step) in [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)] {
                let mut beside = at;
                beside[axis] += step;
                if is_solid(at[0], at[1], at[2]) && !is_solid(beside[0], beside[1], beside[2]) {
                    add_square(&mut surface, &mut numbers, at, (axis, step));
                }
            }
        }
    }
    surface
}

/// Adds the side of a unit cube that faces along an axis, as two triangles.
fn add_square(
    surface: &mut Fixture,
    numbers: &mut BTreeMap<[i64; 3], u32>,
    cube: [i64; 3],
    (axis, step): (usize, i64),
) {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut square = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(along_u, along_v)| {
        let mut corner = cube;
        corner[axis] += i64::from(step > 0);
        corner[u] += along_u;
        corner[v] += along_v;
        *numbers.entry(corner).or_insert_with(|| {
            let position = corner.map(|coordinate| coordinate as f64);
            surface.positions.push(DVec3::from_array(position));
            surface.positions.len() as u32 - 1
        })
    });
    if step < 0 {
        square.reverse();
    }
    let [a, b, c, d] = square;
    surface.triangles.extend([[a, b, c], [a, c, d]]);
}

/// A flat irregular disk pressed together along one direction to a width of `1 / ratio`: needles and
/// flat triangles of every kind, in the plane z = 0 turned by a seeded angle.
#[must_use]
pub fn needles(rings: u32, ratio: f64, seed: u64) -> Fixture {
    let (sin, cos) = (TAU * Noise::new(seed ^ 0x5eed).unit()).sin_cos();
    irregular_disk(rings, seed).map(|p| {
        let (x, y) = (p.x, p.y / ratio);
        DVec3::new(x * cos - y * sin, x * sin + y * cos, 0.0)
    })
}

/// A flat grid over `0.0..=columns` × `0.0..=rows` that is cut along y = 1 so that the row above has
/// vertices at every half: the gaps are filled with triangles of exactly no area, as models repaired
/// at T-junctions have them. All coordinates are small multiples of 1/2.
///
/// # Panics
/// If there are fewer than 1 column or 2 rows.
#[must_use]
pub fn grid_with_flat_triangles(columns: u32, rows: u32) -> Fixture {
    assert!(
        columns >= 1 && rows >= 2,
        "the cut needs a row on either side"
    );
    let mut surface = grid(f64::from(columns), f64::from(rows), columns, rows);
    let seam: Vec<u32> = (0..=columns).map(|column| columns + 1 + column).collect();
    for pair in seam.windows(2) {
        let [left, right] = [pair[0], pair[1]];
        let middle = surface.positions.len() as u32;
        let [a, b] = [left, right].map(|vertex| surface.positions[vertex as usize]);
        surface.positions.push((a + b) / 2.0);
        split_above(&mut surface.triangles, [left, right], middle);
        surface.triangles.push([left, right, middle]);
    }
    surface
}

/// Splits the triangle that has the directed edge `ends`.
fn split_above(triangles: &mut Vec<[u32; 3]>, ends: [u32; 2], middle: u32) {
    for index in 0..triangles.len() {
        for turn in 0..3 {
            let mut triangle = triangles[index];
            triangle.rotate_left(turn);
            if triangle[..2] == ends {
                let apex = triangle[2];
                triangles[index] = [ends[0], middle, apex];
                triangles.push([middle, ends[1], apex]);
                return;
            }
        }
    }
}

/// A strip of two rows of `count` vertices whose lower row is moved by half its length: every diagonal is
/// far from Delaunay, so that flips must travel.
#[must_use]
pub fn sheared_strip(count: u32) -> Fixture {
    let shift = f64::from(count) / 2.0;
    grid(f64::from(count), 1.0, count, 1).map(|p| DVec3::new(p.x + shift * p.y, p.y, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn euler_characteristic(fixture: &Fixture) -> i64 {
        let count = |count: usize| i64::try_from(count).unwrap();
        let edges: std::collections::BTreeSet<_> = fixture
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect();
        count(fixture.positions.len()) - count(edges.len()) + count(fixture.triangles.len())
    }

    fn volume(fixture: &Fixture) -> f64 {
        let six_fold = fixture.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| fixture.positions[vertex as usize]);
            a.dot(b.cross(c))
        });
        six_fold.sum::<f64>() / 6.0
    }

    #[test]
    fn closed_surfaces_have_their_genus_and_volume() {
        for holes in 0..4 {
            let block = block_with_holes(holes);
            assert_eq!(euler_characteristic(&block), 2 - 2 * i64::from(holes));
            let cubes = f64::from(3 * (2 * holes + 1) - holes);
            assert!((volume(&block) - cubes).abs() < 1e-9);
        }
        let cone = cone_closed(2.0, 200, 3);
        assert_eq!(euler_characteristic(&cone), 2);
        assert!((volume(&cone) - TAU / 3.0).abs() < 1e-2);
        let ellipsoid = ellipsoid(DVec3::new(1.0, 2.0, 3.0), 4);
        assert!((volume(&ellipsoid) - TAU * 4.0).abs() < 0.1);
        assert_eq!(euler_characteristic(&hyperboloid(12, 4)), 0);
    }

    #[test]
    fn flat_triangles_have_exactly_no_area() {
        let surface = grid_with_flat_triangles(4, 3);
        let areas = surface.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| surface.positions[vertex as usize]);
            (b - a).cross(c - a).z
        });
        let areas: Vec<f64> = areas.collect();
        assert!(areas.iter().all(|&area| area >= 0.0));
        assert_eq!(areas.iter().filter(|&&area| area == 0.0).count(), 4);
        assert_eq!(euler_characteristic(&surface), 1);
    }
}
