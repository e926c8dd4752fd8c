use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::{Fixture, Noise, cells};

/// A flat grid over `0.0..=width` × `0.0..=height` in the plane z = 0, each cell cut in two along
/// diagonals that alternate.
///
/// # Panics
/// If there is no cell.
#[must_use]
pub fn grid(width: f64, height: f64, columns: u32, rows: u32) -> Fixture {
    assert!(columns >= 1 && rows >= 1, "a grid needs a cell");
    let mut positions = Vec::new();
    for row in 0..=rows {
        for column in 0..=columns {
            let x = width * f64::from(column) / f64::from(columns);
            let y = height * f64::from(row) / f64::from(rows);
            positions.push(DVec3::new(x, y, 0.0));
        }
    }
    let vertex = |row: u32, column: u32| row * (columns + 1) + column;
    let mut triangles = Vec::new();
    for (number, [a, b, c, d]) in (0..).zip(cells(rows, columns, vertex)) {
        if (number / columns + number % columns).is_multiple_of(2) {
            triangles.extend([[a, b, c], [a, c, d]]);
        } else {
            triangles.extend([[a, b, d], [b, c, d]]);
        }
    }
    Fixture {
        positions,
        triangles,
    }
}

/// The flat unit disk from `rings` rings around a middle vertex; ring `k` has `6k` vertices.
///
/// # Panics
/// If `rings` is 0.
#[must_use]
pub fn disk(rings: u32) -> Fixture {
    assert!(rings >= 1, "a disk needs a ring");
    let start = |ring: u32| {
        if ring == 0 {
            0
        } else {
            1 + 3 * ring * (ring - 1)
        }
    };
    let mut positions = vec![DVec3::ZERO];
    for ring in 1..=rings {
        for step in 0..6 * ring {
            let (sin, cos) = (TAU * f64::from(step) / f64::from(6 * ring)).sin_cos();
            positions.push(DVec3::new(cos, sin, 0.0) * f64::from(ring) / f64::from(rings));
        }
    }
    let vertex = |ring: u32, step: u32| {
        if ring == 0 {
            0
        } else {
            start(ring) + step % (6 * ring)
        }
    };
    let mut triangles = Vec::new();
    for ring in 1..=rings {
        for sector in 0..6 {
            for step in 0..ring {
                let outer = sector * ring + step;
                let inner = sector * (ring - 1) + step;
                let inside = vertex(ring - 1, inner);
                triangles.push([inside, vertex(ring, outer), vertex(ring, outer + 1)]);
                if step + 1 < ring {
                    let next = vertex(ring - 1, inner + 1);
                    triangles.push([inside, vertex(ring, outer + 1), next]);
                }
            }
        }
    }
    Fixture {
        positions,
        triangles,
    }
}

/// The cap of the unit sphere within `polar_angle` of its north pole, from `rings` rings spaced
/// evenly along the meridians. Its conformal map onto a disk is the stereographic projection from
/// the south pole.
#[must_use]
pub fn spherical_cap(polar_angle: f64, rings: u32) -> Fixture {
    disk(rings).map(|p| {
        let (sin, cos) = (polar_angle * p.length()).sin_cos();
        let direction = p.normalize_or_zero();
        DVec3::new(direction.x * sin, direction.y * sin, cos)
    })
}

/// A cone with its tip at the origin, opening downward, whose surface is a flat disk of slant
/// radius 1 with a sector taken out: `total_angle` (below 2π) is left around the tip.
#[must_use]
pub fn cone_patch(total_angle: f64, rings: u32) -> Fixture {
    let sin = total_angle / TAU;
    let cos = (1.0 - sin * sin).max(0.0).sqrt();
    disk(rings).map(|p| DVec3::new(p.x * sin, p.y * sin, -p.length() * cos))
}

/// A cylinder around the z axis, open at both ends: an annulus without curvature.
///
/// # Panics
/// If `around` is below 3 or `along` is 0.
#[must_use]
pub fn cylinder_patch(radius: f64, height: f64, around: u32, along: u32) -> Fixture {
    assert!(
        around >= 3 && along >= 1,
        "a cylinder needs 3 vertices around and 1 step along"
    );
    let mut cylinder = crate::cylinder_closed(radius, height, around, along);
    let side_vertices = (around * (along + 1)) as usize;
    cylinder.positions.truncate(side_vertices);
    cylinder.triangles.retain(|triangle| {
        triangle
            .iter()
            .all(|&vertex| (vertex as usize) < side_vertices)
    });
    cylinder
}

/// A surface of revolution around the z axis, open at both ends: of height 4 and radius
/// `1 + waist · cos(π z)`, so that it has two waists and a belly between them.
///
/// # Panics
/// If `around` is below 3, `along` is 0, or `waist` is not between -1 and 1.
#[must_use]
pub fn vase(waist: f64, around: u32, along: u32) -> Fixture {
    assert!(waist.abs() < 1.0, "a vase has a radius above 0");
    cylinder_patch(1.0, 4.0, around, along).map(|p| {
        let radius = 1.0 + waist * (std::f64::consts::PI * p.z).cos();
        DVec3::new(p.x * radius, p.y * radius, p.z)
    })
}

/// The flat ring between two circles around the origin.
///
/// # Panics
/// If `around` is below 3 or `rings` is 0.
#[must_use]
pub fn annulus(inner_radius: f64, outer_radius: f64, around: u32, rings: u32) -> Fixture {
    cylinder_patch(1.0, 1.0, around, rings).map(|p| {
        let radius = outer_radius + (inner_radius - outer_radius) * p.z;
        DVec3::new(p.x * radius, p.y * radius, 0.0)
    })
}

/// The saddle z = (x² − y²)/2 over the square of side 2 around the origin.
#[must_use]
pub fn saddle_patch(cells: u32) -> Fixture {
    grid(2.0, 2.0, cells, cells).map(|p| {
        let (x, y) = (p.x - 1.0, p.y - 1.0);
        DVec3::new(x, y, (x * x - y * y) / 2.0)
    })
}

/// The flat unit disk with interior vertices moved at random along the disk by up to a third of
/// their distance to their neighbours: irregular, obtuse triangles included, none flipped.
#[must_use]
pub fn irregular_disk(rings: u32, seed: u64) -> Fixture {
    let mut noise = Noise::new(seed);
    let step = 1.0 / f64::from(rings);
    let mut result = disk(rings);
    for position in &mut result.positions {
        let shift = DVec2::new(noise.signed(), noise.signed()) * step * 0.3;
        if position.length() < 1.0 - step / 2.0 {
            *position += shift.extend(0.0);
        }
    }
    result
}

/// An irregular disk lifted by smooth bumps: a patch without symmetry.
#[must_use]
pub fn bumpy_patch(rings: u32, seed: u64) -> Fixture {
    irregular_disk(rings, seed).map(|p| {
        let height =
            0.4 * (2.1 * p.x + 0.3).sin() * (1.7 * p.y).cos() + 0.15 * (5.0 * p.x * p.y).sin();
        p + DVec3::Z * height
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the signed area of each triangle, seen from +z.
    fn areas(fixture: &Fixture) -> impl Iterator<Item = f64> {
        fixture.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| fixture.positions[vertex as usize]);
            (b - a).cross(c - a).z
        })
    }

    #[test]
    fn flat_patches_face_up_and_have_their_area() {
        let total = |fixture: &Fixture| areas(fixture).sum::<f64>() / 2.0;
        assert!((total(&grid(2.0, 3.0, 4, 5)) - 6.0).abs() < 1e-12);
        assert!((total(&disk(40)) - TAU / 2.0).abs() < 1e-2);
        for seed in 0..20 {
            assert!(areas(&irregular_disk(12, seed)).all(|area| area > 0.0));
        }
        assert!(areas(&annulus(0.5, 1.0, 30, 4)).all(|area| area > 0.0));
    }

    #[test]
    fn a_disk_counts_right() {
        let disk = disk(5);
        assert_eq!(disk.positions.len(), 1 + 3 * 5 * 6);
        assert_eq!(disk.triangles.len(), 6 * 25);
    }
}
