use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::samples::spread_along;
use crate::geometry::{Bounds, BoxTree, closest_on_segment};

/// Points at which lines are looked at.
const SAMPLES: usize = 4000;

/// Distance from an edge, over the mean edge length, up to which it carries a point of a line.
const NEAR: f64 = 0.1;

/// Cosine of the angle to the line up to which an edge carries it: 20°.
const ALONG: f64 = 0.939_692_620_785_908_4;

/// Distance from an edge, over the diagonal of the reference, up to which a point counts as met.
const MET: f64 = 5e-4;

/// How far lines of a reference are found among the edges of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LineCarrying {
    /// Edges of the reference in these lines.
    pub edges: usize,
    /// Share of their length that an edge of the mesh runs along: no farther than a tenth of the mean
    /// edge length, and turned by no more than 20°. In `0.0..=1.0`.
    pub carried_share: f64,
    /// Share of their length within 0.05 % of the reference's diagonal of an edge of the mesh.
    pub met_share: f64,
    /// Mean distance from the nearest edge, over the mean edge length.
    pub mean_distance: f64,
    /// Largest distance from the nearest edge, in percent of the reference's diagonal.
    pub max_distance: f64,
}

/// Edges of a mesh, to be searched.
pub(super) struct EdgeTree {
    edges: Vec<[DVec3; 2]>,
    mean_length: f64,
    tree: BoxTree<3>,
}

impl EdgeTree {
    pub(super) fn new(edges: Vec<[DVec3; 2]>) -> Self {
        let boxes: Vec<_> = edges.iter().map(|ends| Bounds::<3>::around(ends)).collect();
        let lengths: f64 = edges.iter().map(|[from, to]| from.distance(*to)).sum();
        Self {
            mean_length: lengths / edges.len().max(1) as f64,
            tree: BoxTree::new(&boxes),
            edges,
        }
    }

    fn nearest(&self, point: DVec3) -> Option<(usize, f64)> {
        self.tree.nearest(point.into(), f64::INFINITY, |edge| {
            let [from, to] = self.edges[edge];
            let share = closest_on_segment([from, to], point);
            from.lerp(to, share).distance_squared(point)
        })
    }

    /// How these edges carry lines; `None` if there is no line, no edge, or no length.
    pub(super) fn carrying(&self, lines: &[[DVec3; 2]], diagonal: f64) -> Option<LineCarrying> {
        let direction = |[from, to]: [DVec3; 2]| (to - from).normalize_or_zero();
        let found: Vec<(f64, bool)> = spread_along(lines, SAMPLES)
            .into_par_iter()
            .filter_map(|(line, point)| {
                let (edge, squared) = self.nearest(point)?;
                let cosine = direction(lines[line])
                    .dot(direction(self.edges[edge]))
                    .abs();
                Some((squared.sqrt(), cosine > ALONG))
            })
            .collect();
        if found.is_empty() || self.mean_length == 0.0 {
            return None;
        }
        let count = found.len() as f64;
        let share = |counts: &dyn Fn(&(f64, bool)) -> bool| {
            found.iter().filter(|sample| counts(sample)).count() as f64 / count
        };
        let sum: f64 = found.iter().map(|(distance, _)| distance).sum();
        let most = found
            .iter()
            .map(|(distance, _)| *distance)
            .fold(0.0, f64::max);
        Some(LineCarrying {
            edges: lines.len(),
            carried_share: share(&|&(distance, along)| along && distance < NEAR * self.mean_length),
            met_share: share(&|&(distance, _)| distance <= MET * diagonal),
            mean_distance: sum / count / self.mean_length,
            max_distance: 100.0 * most / diagonal,
        })
    }
}
