use std::collections::BTreeMap;
use std::ops::ControlFlow;

use glam::{DVec2, DVec3};

use super::guide::at_vertex;
use super::tangent::TangentPlanes;
use super::{FieldDomain, FieldError, Guidance, Strength};
use crate::mesh::{Element, PointTree, VertexId};
use crate::tolerance::STROKE_REACH;

/// A line drawn on a surface, or near it, that the field should run along.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Its points in order. Those farther than [`STROKE_REACH`] mean edge lengths from every vertex
    /// say nothing.
    pub points: Vec<DVec3>,
    /// How strongly the field is held to it.
    pub strength: Strength,
}

/// Distance between the places where a stroke is looked at, over the mean edge length: no vertex
/// along it is missed.
const SAMPLING: f64 = 0.5;

/// Most such places in a stroke: one far longer than the surface must not take for ever.
const MOST_SAMPLES: f64 = 1e6;

impl Guidance {
    /// Asks the field to run along strokes at the vertices nearest to them. Points count in the unit
    /// of the domain's surface.
    ///
    /// Cost: linear in the vertices, and their logarithm for each half edge length of the strokes.
    ///
    /// # Errors
    /// [`FieldError::Stroke`] names a stroke that is nowhere near the surface, has less than two
    /// points, or a coordinate or weight that is no number.
    pub fn follow_strokes(
        &mut self,
        domain: &FieldDomain<'_>,
        strokes: &[Stroke],
    ) -> Result<(), FieldError> {
        if strokes.is_empty() {
            return Ok(());
        }
        let tree = PointTree::new(domain.surface().positions().as_slice().to_vec());
        let planes = TangentPlanes::on(domain);
        for (number, stroke) in strokes.iter().enumerate() {
            check(number, stroke)?;
            let wishes = self.along(stroke, domain.mean_edge_length(), &tree, &planes);
            if wishes.is_empty() {
                let what = "is nowhere along the surface";
                return Err(FieldError::Stroke { number, what });
            }
            for (vertex, power) in wishes {
                self.follow(vertex, self.symmetry().root(power), stroke.strength);
            }
        }
        Ok(())
    }

    /// The vertices that a stroke passes with the sum of its directions there.
    fn along(
        &self,
        stroke: &Stroke,
        mean_edge_length: f64,
        tree: &PointTree,
        planes: &TangentPlanes<'_>,
    ) -> BTreeMap<VertexId, DVec2> {
        let mut sums = BTreeMap::<VertexId, DVec2>::new();
        for ends in stroke.points.windows(2) {
            let along = ends[1] - ends[0];
            let samples = parts(along.length(), SAMPLING * mean_edge_length, MOST_SAMPLES);
            for sample in 0..=samples {
                let place = ends[0] + along * (f64::from(sample) / f64::from(samples));
                let vertex = nearest(tree, place, STROKE_REACH * mean_edge_length);
                let wish = vertex.and_then(|v| {
                    at_vertex(self.symmetry(), along, v, planes)
                        .into_iter()
                        .next()
                });
                if let Some((vertex, angle)) = wish {
                    *sums.entry(vertex).or_default() += self.symmetry().power(angle);
                }
            }
        }
        sums.retain(|_, sum| sum.length() > 0.0);
        sums
    }
}

fn check(number: usize, stroke: &Stroke) -> Result<(), FieldError> {
    let fault = |what| Err(FieldError::Stroke { number, what });
    if stroke.points.len() < 2 {
        return fault("has less than two points");
    }
    if !stroke.points.iter().all(|point| point.is_finite()) {
        return fault("has a coordinate that is no number");
    }
    match stroke.strength {
        Strength::Soft(weight) if !(weight > 0.0 && weight.is_finite()) => {
            fault("has a weight that is no positive number")
        }
        _ => Ok(()),
    }
}

/// Into how many parts of at most `unit` something of this size is to be cut: at least one, at most
/// `most`.
#[allow(clippy::cast_sign_loss, reason = "the number is at least one by then")]
pub(super) fn parts(size: f64, unit: f64, most: f64) -> u32 {
    (size / unit).ceil().clamp(1.0, most) as u32
}

/// The vertex nearest to a place, the first of those equally near; `None` if none is within `reach`.
fn nearest(tree: &PointTree, place: DVec3, reach: f64) -> Option<VertexId> {
    let best = std::cell::Cell::new((reach * reach, u32::MAX));
    let may_hold =
        |low: DVec3, high: DVec3| place.distance_squared(place.clamp(low, high)) <= best.get().0;
    tree.search::<()>(may_hold, |point| {
        let found = (tree.point(point).distance_squared(place), point);
        if found.0 < best.get().0 || (found.0 <= best.get().0 && point < best.get().1) {
            best.set(found);
        }
        ControlFlow::Continue(())
    });
    let (_, vertex) = best.get();
    (vertex != u32::MAX).then(|| VertexId::from_index(vertex as usize))
}
