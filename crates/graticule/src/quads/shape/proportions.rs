use glam::DVec3;

use crate::mesh::PolygonConnectivity;

/// Times that the proportions of quads are averaged with those of their neighbours.
const AVERAGINGS: usize = 3;

/// Proportions beyond this are not aimed at.
const MOST: f64 = 8.0;

/// For each quad the length of its first and third side over that of the others, averaged over
/// neighbours and raised to `power`; 1 for other polygons.
pub(super) fn wanted(mesh: &PolygonConnectivity, positions: &[DVec3], power: f64) -> Vec<f64> {
    let count = mesh.polygon_count();
    let mut logarithms: Vec<f64> = (0..count)
        .map(|polygon| proportion(mesh.vertices(polygon), positions))
        .collect();
    for _ in 0..AVERAGINGS {
        logarithms = (0..count)
            .map(|polygon| averaged(mesh, polygon, &logarithms))
            .collect();
    }
    logarithms.iter().map(|l| libm::exp(power * l)).collect()
}

/// The logarithm of the proportion of a quad; 0 for other polygons.
fn proportion(vertices: &[u32], positions: &[DVec3]) -> f64 {
    let &[a, b, c, d] = vertices else {
        return 0.0;
    };
    let [a, b, c, d] = [a, b, c, d].map(|vertex| positions[vertex as usize]);
    let along = a.distance(b) + c.distance(d);
    let across = b.distance(c) + d.distance(a);
    if along > 0.0 && across > 0.0 {
        libm::log((along / across).clamp(1.0 / MOST, MOST))
    } else {
        0.0
    }
}

/// The mean over a quad (counted twice) and the quads beside it, seen in its own directions.
fn averaged(mesh: &PolygonConnectivity, polygon: usize, logarithms: &[f64]) -> f64 {
    let own = mesh.corners(polygon);
    if own.len() != 4 {
        return 0.0;
    }
    let [mut sum, mut weight] = [2.0 * logarithms[polygon], 2.0];
    for side in own.clone() {
        let Some(twin) = mesh.twin(side) else {
            continue;
        };
        let other = mesh.polygon(twin);
        let others = mesh.corners(other);
        if others.len() == 4 {
            let alike = (side - own.start + twin - others.start).is_multiple_of(2);
            sum += if alike {
                logarithms[other]
            } else {
                -logarithms[other]
            };
            weight += 1.0;
        }
    }
    sum / weight
}
