use glam::DVec3;
use serde::Serialize;

use super::polygons::Measured;
use crate::measure::statistics::{Sample, weighted_quantiles};

/// Corner angle, in degrees, above which a corner counts as straight.
const STRAIGHT: f64 = 170.0;

/// Cosine of the turn from which on an edge counts as folded: 120°.
const FOLD_COSINE: f64 = -0.5;

/// Shape of the quads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct QuadQuality {
    /// Scaled Jacobians, see [`scaled_jacobian`].
    pub scaled_jacobian: ScaledJacobian,
    /// What the angles of all corners miss 90° by, in degrees.
    pub angle_deviation: AngleDeviation,
    /// Longest side over shortest, of the quads without a side of length zero; `None` if there is
    /// none.
    pub aspect: Option<Aspect>,
    /// Distance of the two diagonals in space over their mean length, in percent.
    pub planarity: Planarity,
}

/// Scaled Jacobians of quads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ScaledJacobian {
    /// The least.
    pub min: f64,
    /// The value that 5 % of the quads do not exceed.
    pub p05: f64,
    /// The mean.
    pub mean: f64,
    /// How many are not positive.
    pub non_positive: usize,
}

/// What angles miss 90° by, in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AngleDeviation {
    /// The mean.
    pub mean: f64,
    /// The largest.
    pub max: f64,
}

/// Longest side over shortest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Aspect {
    /// The mean.
    pub mean: f64,
    /// The value that 95 % of the quads do not exceed.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

/// Distance of the diagonals over their mean length, in percent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Planarity {
    /// The mean.
    pub mean: f64,
    /// The largest.
    pub max: f64,
}

/// Lengths of edges.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EdgeLengthSpread {
    /// The mean, in units of the mesh.
    pub mean: f64,
    /// Standard deviation over mean.
    pub variation: f64,
}

/// The scaled Jacobian of a quad, in `-1.0..=1.0`: the least sine of a corner's angle, seen along
/// the normal of the quad's two bimedians; negative where a corner is inverted, 1 for a rectangle.
///
/// 0 where a side has no length or the bimedians are parallel. Sides from 1e-70 to 1e70.
#[must_use]
pub fn scaled_jacobian(corners: [DVec3; 4]) -> f64 {
    let [a, b, c, d] = corners;
    // The bimedians' cross product is twice that of the diagonals.
    let normal = (c - a).cross(d - b).normalize_or_zero();
    let sides = [b - a, c - b, d - c, a - d].map(DVec3::normalize_or_zero);
    let sine = |corner: usize| sides[(corner + 3) % 4].cross(sides[corner]).dot(normal);
    (0..4).map(sine).fold(f64::INFINITY, f64::min)
}

/// For each polygon its scaled Jacobian; NaN for all but quads.
pub(super) fn scaled_jacobians(measured: &Measured) -> Vec<f64> {
    let of_polygon = |polygon: usize| measured.quad(polygon).map_or(f64::NAN, scaled_jacobian);
    (0..measured.mesh.polygon_count()).map(of_polygon).collect()
}

pub(super) fn measure(measured: &Measured, scaled_jacobians: &[f64]) -> Option<QuadQuality> {
    let values: Vec<f64> = scaled_jacobians
        .iter()
        .copied()
        .filter(|value| !value.is_nan())
        .collect();
    let ([least, p05], mean) = (quantiles(&values, [0.0, 0.05])?, mean(&values));
    let quads: Vec<_> = (0..measured.mesh.polygon_count())
        .filter_map(|polygon| measured.quad(polygon))
        .collect();
    let angles: Vec<f64> = quads.iter().flat_map(|&quad| deviations(quad)).collect();
    let planarities: Vec<f64> = quads.iter().map(|&quad| planarity(quad)).collect();
    let aspects: Vec<f64> = quads.iter().filter_map(|&quad| aspect(quad)).collect();
    Some(QuadQuality {
        scaled_jacobian: ScaledJacobian {
            min: least,
            p05,
            mean,
            non_positive: values.iter().filter(|&&value| value <= 0.0).count(),
        },
        angle_deviation: AngleDeviation {
            mean: self::mean(&angles),
            max: largest(&angles),
        },
        aspect: quantiles(&aspects, [0.95]).map(|[p95]| Aspect {
            mean: self::mean(&aspects),
            p95,
            max: largest(&aspects),
        }),
        planarity: Planarity {
            mean: self::mean(&planarities),
            max: largest(&planarities),
        },
    })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// The values that `shares` of all do not exceed.
fn quantiles<const N: usize>(values: &[f64], shares: [f64; N]) -> Option<[f64; N]> {
    let mut samples: Vec<_> = values
        .iter()
        .map(|&value| Sample { value, weight: 1.0 })
        .collect();
    (!samples.is_empty()).then(|| weighted_quantiles(&mut samples, shares))
}

/// What the angles of a quad miss 90° by.
fn deviations(quad: [DVec3; 4]) -> [f64; 4] {
    [0, 1, 2, 3].map(|corner| {
        let angle = angle_degrees(quad[(corner + 3) % 4], quad[corner], quad[(corner + 1) % 4]);
        (angle - 90.0).abs()
    })
}

/// The angle at `corner`, in degrees, in `0.0..=180.0`.
fn angle_degrees(before: DVec3, corner: DVec3, after: DVec3) -> f64 {
    let [out, back] = [after - corner, before - corner].map(DVec3::normalize_or_zero);
    libm::atan2(out.cross(back).length(), out.dot(back)).to_degrees()
}

fn aspect([a, b, c, d]: [DVec3; 4]) -> Option<f64> {
    let sides = [b - a, c - b, d - c, a - d].map(DVec3::length);
    let least = sides.iter().copied().fold(f64::INFINITY, f64::min);
    (least > 0.0).then(|| largest(&sides) / least)
}

fn planarity([a, b, c, d]: [DVec3; 4]) -> f64 {
    let [first, second] = [c - a, d - b];
    let mean_length = 0.5 * (first.length() + second.length());
    let distance = (b - a).dot(first.cross(second).normalize_or_zero()).abs();
    100.0 * distance / mean_length.max(f64::MIN_POSITIVE)
}

pub(super) fn edge_lengths(measured: &Measured) -> Option<EdgeLengthSpread> {
    let mesh = &measured.mesh;
    let lengths = mesh.edges().map(|sides| {
        let [from, to] = mesh.edge(sides[0]).map(|vertex| measured.position(vertex));
        from.distance(to)
    });
    let lengths: Vec<f64> = lengths.collect();
    let mean = (!lengths.is_empty()).then(|| mean(&lengths))?;
    let squares: f64 = lengths
        .iter()
        .map(|length| (length - mean) * (length - mean))
        .sum();
    let deviation = (squares / lengths.len() as f64).sqrt();
    Some(EdgeLengthSpread {
        mean: mean / measured.scale,
        variation: if mean > 0.0 { deviation / mean } else { 0.0 },
    })
}

pub(super) fn straight_corners(measured: &Measured) -> usize {
    let mesh = &measured.mesh;
    let corners = (0..mesh.polygon_count()).flat_map(|polygon| mesh.corners(polygon));
    let is_straight = |&corner: &u32| {
        let [before, at, after] = [mesh.previous(corner), corner, mesh.next(corner)]
            .map(|corner| measured.position(mesh.origin(corner)));
        angle_degrees(before, at, after) > STRAIGHT
    };
    corners.filter(is_straight).count()
}

pub(super) fn folds(measured: &Measured) -> usize {
    let mesh = &measured.mesh;
    let normals: Vec<DVec3> = (0..mesh.polygon_count())
        .map(|polygon| vector_area(measured.corner_positions(polygon)).normalize_or_zero())
        .collect();
    let is_fold = |sides: &&[u32]| match **sides {
        [first, second] => {
            normals[mesh.polygon(first)].dot(normals[mesh.polygon(second)]) < FOLD_COSINE
        }
        _ => false,
    };
    mesh.edges().filter(is_fold).count()
}

/// Twice the vector area of a polygon (Newell); for a quad along the normal of its bimedians.
pub(crate) fn vector_area(mut corners: impl Iterator<Item = DVec3>) -> DVec3 {
    let Some(first) = corners.next() else {
        return DVec3::ZERO;
    };
    let mut previous = DVec3::ZERO;
    let mut sum = DVec3::ZERO;
    for corner in corners {
        let arm = corner - first;
        sum += previous.cross(arm);
        previous = arm;
    }
    sum
}
