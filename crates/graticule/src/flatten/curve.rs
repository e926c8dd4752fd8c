//! Curves that the outer boundary can be laid on.

use std::f64::consts::TAU;

use glam::DVec2;

use crate::mesh::{Element, VertexId};
use crate::tolerance::{BOUNDARY_STEP, LARGEST_ASPECT, SIDE_BOW};
use crate::watch::{Stopped, Watch};

use super::corners::{Corners, choose_corners};
use super::diameter::farthest_pair;
use super::{BoundaryError, BoundaryPositions, Patch};

/// A convex curve for the outer boundary.
///
/// The vertices follow it by arc length: their distances along the curve are proportional to
/// those along the boundary (along each side, for a rectangle). It is centred at the origin and
/// encloses the area of the patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoundaryCurve {
    /// A circle. One of the two vertices of the outer loop that are farthest apart in space lies at
    /// its leftmost point.
    Circle,
    /// A square.
    Square(Corners),
    /// A rectangle.
    Rectangle {
        /// Width over height; by default that of the mean lengths of opposite sides.
        aspect: Option<f64>,
        /// Which boundary vertices lie at its corners.
        corners: Corners,
    },
}

/// Lays the outer boundary loop on a curve.
///
/// A straight side cannot hold all corners of a triangle. Where an edge inside the patch joins two
/// vertices of one side of a rectangle, what it cuts off (mostly a single triangle) would collapse:
/// that stretch of the side is bowed outward, by [`SIDE_BOW`] of its length, and a warning
/// (`bowed-side`) says how many there are.
///
/// # Errors
/// [`BoundaryError`] for corners or an aspect ratio that cannot be used.
pub fn boundary_on_curve(
    patch: &Patch,
    curve: &BoundaryCurve,
    watch: &Watch,
) -> Result<BoundaryPositions, BoundaryError> {
    let _stage = watch.stage("lay down boundary");
    watch.check()?;
    let outline = Outline::of(patch, watch)?;
    match curve {
        BoundaryCurve::Circle => Ok(outline.on_circle(patch)),
        BoundaryCurve::Square(corners) => outline.on_rectangle(patch, Some(1.0), corners, watch),
        BoundaryCurve::Rectangle { aspect, corners } => {
            outline.on_rectangle(patch, *aspect, corners, watch)
        }
    }
}

/// The outer loop with the length of each of its edges.
pub(super) struct Outline {
    pub(super) vertices: Vec<VertexId>,
    /// Distance from each vertex to the next one; none is 0.
    pub(super) steps: Vec<f64>,
    /// Place at which the loop begins if nothing else decides: one of the two points farthest apart.
    pub(super) default_start: usize,
}

impl Outline {
    pub(super) fn of(patch: &Patch, watch: &Watch) -> Result<Self, Stopped> {
        let outer = patch.outer_loop();
        let vertices: Vec<_> = patch.loop_vertices(outer).collect();
        let mut steps: Vec<_> = patch.unit_steps(outer).collect();
        let shortest = BOUNDARY_STEP * steps.iter().sum::<f64>() / steps.len() as f64;
        // All lengths 0: then any curve is as good as another.
        let shortest = if shortest > 0.0 { shortest } else { 1.0 };
        for step in &mut steps {
            *step = step.max(shortest);
        }
        let position = |&vertex| patch.unit_surface().position(vertex);
        let points: Vec<_> = vertices.iter().map(position).collect();
        let farthest = farthest_pair(&points, watch)?;
        Ok(Self {
            vertices,
            steps,
            default_start: farthest.map_or(0, |[start, _]| start),
        })
    }

    fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Renumbers the loop so that it begins with the vertex that was at `start`.
    fn rotate(&mut self, start: usize) {
        self.vertices.rotate_left(start);
        self.steps.rotate_left(start);
    }

    fn on_circle(mut self, patch: &Patch) -> BoundaryPositions {
        self.rotate(self.default_start);
        let radius = (patch.unit_area() * 2.0 / TAU).sqrt() * patch.unit_length();
        let shares = shares(&self.steps);
        let place = |share: &f64| {
            let (sin, cos) = libm::sincos(TAU * share);
            DVec2::new(-cos, -sin) * radius
        };
        let places = shares.iter().map(place);
        BoundaryPositions::on_curve(self.vertices.into_iter().zip(places).collect(), true)
    }

    fn on_rectangle(
        mut self,
        patch: &Patch,
        aspect: Option<f64>,
        corners: &Corners,
        watch: &Watch,
    ) -> Result<BoundaryPositions, BoundaryError> {
        let mut corners = choose_corners(patch, &self, corners)?;
        let start = corners[0];
        self.rotate(start);
        for corner in &mut corners {
            *corner = (*corner + self.len() - start) % self.len();
        }
        let sides = self.sides(corners);
        let aspect = aspect.unwrap_or_else(|| self.aspect(&sides));
        if !(LARGEST_ASPECT.recip()..=LARGEST_ASPECT).contains(&aspect) {
            return Err(BoundaryError::BadAspect { aspect });
        }
        let mut places = self.along_sides(&sides, rectangle(patch, aspect));
        let bowed = self.bow_cut_off_stretches(patch, &sides, &mut places);
        if bowed > 0 {
            let message = format!(
                "{bowed} stretches of the rectangle's sides are bowed outward: edges inside the \
                 patch join two vertices of one side, and what they cut off would collapse"
            );
            watch.warn("bowed-side", message);
        }
        let places = self.vertices.into_iter().zip(places).collect();
        Ok(BoundaryPositions::on_curve(places, true))
    }

    /// The loop's places along each side, both corners included; the last side ends at `len`.
    fn sides(&self, corners: [usize; 4]) -> [std::ops::RangeInclusive<usize>; 4] {
        let [a, b, c, d] = corners;
        [a..=b, b..=c, c..=d, d..=self.len()]
    }

    fn aspect(&self, sides: &[std::ops::RangeInclusive<usize>; 4]) -> f64 {
        let [bottom, right, top, left] = sides
            .each_ref()
            .map(|side| self.steps[*side.start()..*side.end()].iter().sum::<f64>());
        (bottom + top) / (right + left)
    }

    fn along_sides(
        &self,
        sides: &[std::ops::RangeInclusive<usize>; 4],
        corners: [DVec2; 4],
    ) -> Vec<DVec2> {
        let mut places = Vec::with_capacity(self.len());
        for (k, side) in sides.iter().enumerate() {
            let shares = shares(&self.steps[*side.start()..*side.end()]);
            let (from, to) = (corners[k], corners[(k + 1) % 4]);
            places.extend(shares.iter().map(|&share| from.lerp(to, share)));
        }
        places
    }

    /// Bows each stretch of a side that an inner edge cuts off; returns their number.
    fn bow_cut_off_stretches(
        &self,
        patch: &Patch,
        sides: &[std::ops::RangeInclusive<usize>; 4],
        places: &mut [DVec2],
    ) -> usize {
        let stretches = outermost(self.cut_off_stretches(patch, sides));
        for &[start, end] in &stretches {
            let (from, to) = (places[start], places[end % places.len()]);
            let shares = shares(&self.steps[start..end]);
            for (place, share) in places[start..end].iter_mut().zip(shares) {
                let outward = -(to - from).perp();
                *place += outward * (4.0 * SIDE_BOW * share * (1.0 - share));
            }
        }
        stretches.len()
    }

    fn cut_off_stretches(
        &self,
        patch: &Patch,
        sides: &[std::ops::RangeInclusive<usize>; 4],
    ) -> Vec<[usize; 2]> {
        let mut place_on_loop = vec![usize::MAX; patch.mesh().vertex_count()];
        for (place, vertex) in self.vertices.iter().enumerate() {
            place_on_loop[vertex.index()] = place;
        }
        let mut stretches = Vec::new();
        for edge in patch.dividing_edges() {
            let mesh = patch.mesh();
            let ends = mesh.ends(mesh.edge_halfedge(edge));
            let [mut a, mut b] = ends.map(|end| place_on_loop[end.index()]);
            (a, b) = (a.min(b), a.max(b));
            // The first corner also ends the last side.
            let choices = if a == 0 {
                [[a, b], [b, self.len()]]
            } else {
                [[a, b]; 2]
            };
            let on_one_side = |[start, end]: &[usize; 2]| {
                sides
                    .iter()
                    .any(|side| side.contains(start) && side.contains(end))
            };
            stretches.extend(choices.into_iter().find(on_one_side));
        }
        stretches
    }
}

/// The stretches that lie in no other. Inner edges do not cross, so two stretches are nested or
/// share an end at most.
fn outermost(mut stretches: Vec<[usize; 2]>) -> Vec<[usize; 2]> {
    stretches.sort_unstable_by_key(|&[start, end]| (start, std::cmp::Reverse(end)));
    let mut kept: Vec<[usize; 2]> = Vec::new();
    for stretch in stretches {
        if kept.last().is_none_or(|last| stretch[0] >= last[1]) {
            kept.push(stretch);
        }
    }
    kept
}

/// Share of the whole length that lies before each step: from 0 on, below 1.
fn shares(steps: &[f64]) -> Vec<f64> {
    let total: f64 = steps.iter().sum();
    let before = steps.iter().scan(0.0, |sum, step| {
        let before = *sum;
        *sum += step;
        Some(before / total)
    });
    before.collect()
}

/// The corners of the rectangle around the origin with the patch's area, from the lower left on.
fn rectangle(patch: &Patch, aspect: f64) -> [DVec2; 4] {
    let height = (patch.unit_area() / aspect).sqrt();
    let half = DVec2::new(height * aspect, height) * (patch.unit_length() / 2.0);
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| half * DVec2::new(x, y))
}
