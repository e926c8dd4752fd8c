use std::f64::consts::TAU;

use glam::DVec3;

use crate::{Fixture, cells};

/// The faces of a cube whose corner `n` lies at the coordinates that are the bits of `n`.
pub const CUBE_QUADS: [[u32; 4]; 6] = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
];

/// The tetrahedron of the origin and the unit points of the axes: the smallest closed surface.
#[must_use]
pub fn tetrahedron() -> Fixture {
    Fixture {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    }
}

/// The unit cube `0.0..=1.0` in each coordinate: 8 vertices, 12 triangles.
#[must_use]
pub fn cube() -> Fixture {
    let coordinate = |bit: u32| f64::from(bit & 1);
    let positions = (0..8)
        .map(|corner| {
            DVec3::new(
                coordinate(corner),
                coordinate(corner >> 1),
                coordinate(corner >> 2),
            )
        })
        .collect();
    let triangles = CUBE_QUADS
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    Fixture {
        positions,
        triangles,
    }
}

/// The unit sphere from an icosahedron whose triangles are split in four `levels` times:
/// 20 · 4^levels triangles.
#[must_use]
pub fn icosphere(levels: u32) -> Fixture {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let positions = [(0, 1), (1, 2), (2, 0)]
        .into_iter()
        .flat_map(|(short, long)| {
            [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(s, l)| {
                let mut position = DVec3::ZERO;
                position[short] = s;
                position[long] = l * golden;
                position.normalize()
            })
        })
        .collect::<Vec<_>>();
    let triangles = icosahedron_faces(&positions);
    let mut sphere = Fixture {
        positions,
        triangles,
    };
    for _ in 0..levels {
        sphere = sphere.subdivided().map(DVec3::normalize);
    }
    sphere
}

/// The 20 triples of mutually nearest vertices, facing outward.
fn icosahedron_faces(positions: &[DVec3]) -> Vec<[u32; 3]> {
    let near = |a: usize, b: usize| positions[a].distance_squared(positions[b]) < 1.3;
    let mut faces = Vec::with_capacity(20);
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let [p, q, r] = [positions[a], positions[b], positions[c]];
                    let outward = (q - p).cross(r - p).dot(p) > 0.0;
                    let face = if outward { [a, b, c] } else { [a, c, b] };
                    faces.push(face.map(|vertex| vertex as u32));
                }
            }
        }
    }
    faces
}

/// A sphere with bumps of several sizes: each face of an icosahedron is split into `frequency`² triangles, 20 times as
/// many in all.
///
/// # Panics
/// If `frequency` is 0.
#[must_use]
pub fn bumpy_sphere(frequency: u32) -> Fixture {
    assert!(frequency > 0, "a face is split into one triangle at least");
    split_faces(&icosphere(0), frequency).map(|place| {
        let p = place.normalize();
        let waves = [3.0, 7.0, 17.0].map(|k: f64| {
            let [x, y, z] = [p.x, p.y, p.z].map(|x| (k * x + k).sin());
            (x + y * z) / k
        });
        p * (1.0 + 0.2 * waves.iter().sum::<f64>())
    })
}

/// Each triangle split into `frequency`² flat ones.
fn split_faces(fixture: &Fixture, frequency: u32) -> Fixture {
    let mut split = Fixture {
        positions: Vec::new(),
        triangles: Vec::new(),
    };
    let mut known = std::collections::BTreeMap::new();
    for face in &fixture.triangles {
        let mut vertex = |i: u32, j: u32| {
            // What faces share has the same corners with the same weights.
            let weights = [(face[0], frequency - i - j), (face[1], i), (face[2], j)];
            let mut key =
                weights.map(|(corner, weight)| if weight > 0 { (corner, weight) } else { (0, 0) });
            key.sort_unstable();
            *known.entry(key).or_insert_with(|| {
                let places = key
                    .map(|(corner, weight)| fixture.positions[corner as usize] * f64::from(weight));
                split
                    .positions
                    .push(places.iter().sum::<DVec3>() / f64::from(frequency));
                split.positions.len() as u32 - 1
            })
        };
        for i in 0..frequency {
            for j in 0..frequency - i {
                split
                    .triangles
                    .push([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
                if i + j + 1 < frequency {
                    split.triangles.push([
                        vertex(i + 1, j),
                        vertex(i + 1, j + 1),
                        vertex(i, j + 1),
                    ]);
                }
            }
        }
    }
    split
}

/// A torus around the z axis, `around` vertices along the big circle and `across` along the small.
///
/// # Panics
/// If `around` or `across` is below 3.
#[must_use]
pub fn torus(major_radius: f64, minor_radius: f64, around: u32, across: u32) -> Fixture {
    assert!(
        around >= 3 && across >= 3,
        "a torus needs 3 vertices each way"
    );
    let angle = |step: u32, steps: u32| TAU * f64::from(step) / f64::from(steps);
    let mut positions = Vec::new();
    for i in 0..around {
        let (sin_u, cos_u) = angle(i, around).sin_cos();
        for j in 0..across {
            let (sin_v, cos_v) = angle(j, across).sin_cos();
            let reach = major_radius + minor_radius * cos_v;
            positions.push(DVec3::new(
                reach * cos_u,
                reach * sin_u,
                minor_radius * sin_v,
            ));
        }
    }
    let vertex = |i: u32, j: u32| (i % around) * across + j % across;
    let mut triangles = Vec::new();
    for [a, d, c, b] in cells(around, across, vertex) {
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    Fixture {
        positions,
        triangles,
    }
}

/// A cylinder around the z axis from `z = 0` to `height`, closed by two flat caps with a vertex in
/// the middle of each.
///
/// # Panics
/// If `around` is below 3 or `along` is 0.
#[must_use]
pub fn cylinder_closed(radius: f64, height: f64, around: u32, along: u32) -> Fixture {
    assert!(
        around >= 3 && along >= 1,
        "a cylinder needs 3 vertices around and 1 step along"
    );
    let mut positions = Vec::new();
    for level in 0..=along {
        let z = height * f64::from(level) / f64::from(along);
        for i in 0..around {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(around)).sin_cos();
            positions.push(DVec3::new(radius * cos, radius * sin, z));
        }
    }
    let vertex = |level: u32, i: u32| level * around + i % around;
    let mut triangles = Vec::new();
    for [a, b, c, d] in cells(along, around, vertex) {
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    let bottom = positions.len() as u32;
    let top = bottom + 1;
    positions.extend([DVec3::ZERO, DVec3::Z * height]);
    for i in 0..around {
        triangles.push([bottom, vertex(0, i + 1), vertex(0, i)]);
        triangles.push([top, vertex(along, i), vertex(along, i + 1)]);
    }
    Fixture {
        positions,
        triangles,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Six times the enclosed volume.
    fn volume(fixture: &Fixture) -> f64 {
        let of_triangle = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| fixture.positions[vertex as usize]);
            a.dot(b.cross(c))
        };
        fixture.triangles.iter().map(of_triangle).sum::<f64>() / 6.0
    }

    fn every_edge_has_an_opposite(fixture: &Fixture) -> bool {
        let edges: BTreeSet<_> = fixture
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .collect();
        edges.len() == 3 * fixture.triangles.len()
            && edges.iter().all(|&(a, b)| edges.contains(&(b, a)))
    }

    #[test]
    fn closed_surfaces_are_closed_and_hold_their_volume() {
        let expectations = [
            (cube(), 1.0, 1e-12),
            (icosphere(4), TAU * 2.0 / 3.0, 2e-2),
            (torus(2.0, 0.5, 90, 60), TAU * TAU / 2.0 * 2.0 * 0.25, 5e-2),
            (cylinder_closed(1.0, 2.0, 90, 5), TAU, 1e-2),
            (
                split_faces(&icosphere(0), 16).map(DVec3::normalize),
                TAU * 2.0 / 3.0,
                2e-2,
            ),
        ];
        for (fixture, expected, tolerance) in expectations {
            assert!(every_edge_has_an_opposite(&fixture));
            assert!(
                (volume(&fixture) - expected).abs() < tolerance,
                "{}",
                volume(&fixture)
            );
        }
    }

    #[test]
    fn a_bumpy_sphere_is_closed_and_has_the_triangles_asked_for() {
        for frequency in [1, 2, 7] {
            let sphere = bumpy_sphere(frequency);
            assert_eq!(sphere.triangles.len() as u32, 20 * frequency * frequency);
            assert!(every_edge_has_an_opposite(&sphere));
            assert!(volume(&sphere) > 1.0);
        }
    }
}
