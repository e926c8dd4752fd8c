//! Lines along a field, evenly spaced (B. Jobard, W. Lefer, *Creating Evenly-Spaced Streamlines of
//! Arbitrary Density*, 1997).

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::curl::matched_headings;
use super::stroke::parts;
use super::{CrossField, Symmetry};
use crate::geometry::{GeometryError, IntrinsicTriangulation, normalized};
use crate::mesh::{Element, FaceId, HalfedgeId, Surface};
use crate::tolerance::EDGE_END;

/// Lines along a field from edge to edge of its triangles, those of one direction some `spacing`
/// apart, in the unit of the positions. Lines of crosses run in both directions; each point but the
/// two ends is on an edge or is the point that the line was begun at.
///
/// A line ends at the boundary, in a singular triangle, and where it comes closer than half the
/// spacing to another, or to itself.
///
/// Cost: linear in the triangles and in the crossings of lines with edges.
///
/// # Errors
/// [`GeometryError::Scale`].
pub fn streamlines(
    surface: &Surface,
    field: &CrossField,
    spacing: f64,
) -> Result<Vec<Vec<DVec3>>, GeometryError> {
    let (unit_surface, similarity) = normalized(surface);
    let spacing = libm::ldexp(spacing, similarity.exponent());
    if !(spacing > 0.0 && spacing.is_finite()) {
        return Ok(Vec::new());
    }
    let mut weaver = Weaver {
        tracer: Tracer {
            triangulation: &IntrinsicTriangulation::of(&unit_surface)?,
            surface: &unit_surface,
            field,
        },
        spacing,
        cells: BTreeMap::new(),
        lines: Vec::new(),
    };
    for face in scattered(unit_surface.mesh().face_count()) {
        weaver.begin_in(face);
    }
    let back = |line: Vec<DVec3>| line.iter().map(|&p| similarity.invert(p)).collect();
    Ok(weaver.lines.into_iter().map(back).collect())
}

/// Share of the spacing up to which a line may come near to another.
const NEAREST: f64 = 0.5;

/// Most edges that a line crosses.
const MOST_CROSSINGS: usize = 10_000;

/// Most places in a triangle at which lines are begun.
const MOST_SEEDS: f64 = 4096.0;

/// Crossings on end without way gained, after which a line is stuck: on an edge from both sides of
/// which the field points at it.
const MOST_STUCK: usize = 8;

/// All triangles, neighbours by number far apart: a step near the golden section of their count,
/// prime to it.
fn scattered(count: usize) -> impl Iterator<Item = FaceId> {
    let common = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let mut step = (count * 618 / 1000).max(1);
    while common(step, count) > 1 {
        step += 1;
    }
    (0..count).map(move |number| FaceId::from_index(number * step % count))
}

/// A place in a triangle with the direction in which a line goes on from there, as an angle from the
/// triangle's first side.
#[derive(Clone, Copy, Debug)]
struct Place {
    face: FaceId,
    point: DVec2,
    heading: f64,
}

/// Follows a field from edge to edge.
struct Tracer<'a> {
    surface: &'a Surface,
    triangulation: &'a IntrinsicTriangulation,
    field: &'a CrossField,
}

impl Tracer<'_> {
    /// The direction of the field at a place that is nearest to its heading; `None` where the
    /// triangle is singular or has no area.
    fn heading(&self, place: Place) -> Option<f64> {
        let symmetry = self.field.symmetry();
        let headings = matched_headings(self.triangulation, self.field, place.face)?;
        let weights = self.barycentric(place)?;
        let here: f64 = headings
            .iter()
            .zip(weights)
            .map(|(heading, w)| heading * w)
            .sum();
        let (off, _) = symmetry.reduce(here - place.heading);
        Some(place.heading + off)
    }

    fn barycentric(&self, place: Place) -> Option<[f64; 3]> {
        let [a, b, c] = self.triangulation.shape(place.face).corners();
        let area = (b - a).perp_dot(c - a);
        let of_b = (place.point - a).perp_dot(c - a) / area;
        let of_c = (b - a).perp_dot(place.point - a) / area;
        let weights = [1.0 - of_b - of_c, of_b, of_c];
        weights.iter().all(|w| w.is_finite()).then_some(weights)
    }

    fn in_space(&self, place: Place) -> Option<DVec3> {
        let corners = self.surface.corner_positions(place.face);
        let weights = self.barycentric(place)?;
        Some(corners.iter().zip(weights).map(|(&p, w)| p * w).sum())
    }

    fn direction_in_space(&self, place: Place) -> Option<DVec3> {
        let [a, b, c] = self.surface.corner_positions(place.face);
        let x = (b - a).try_normalize()?;
        let y = (c - a - x * x.dot(c - a)).try_normalize()?;
        let (sin, cos) = libm::sincos(place.heading);
        Some(x * cos + y * sin)
    }

    /// Where a line leaves its triangle: the side, and the share of the side before that point. The
    /// direction is that in the middle of the way, which makes the line exact to second order.
    fn exit(&self, place: Place) -> Option<(HalfedgeId, f64)> {
        let heading = self.heading(place)?;
        let start = Place { heading, ..place };
        let (side, share) = self.straight_exit(start)?;
        let middle = start.point.midpoint(self.on_side(side, share));
        let heading = self.heading(Place {
            point: middle,
            ..start
        })?;
        self.straight_exit(Place { heading, ..start })
    }

    fn straight_exit(&self, place: Place) -> Option<(HalfedgeId, f64)> {
        let corners = self.triangulation.shape(place.face).corners();
        let (sin, cos) = libm::sincos(place.heading);
        let along = DVec2::new(cos, sin);
        let mut nearest: Option<(f64, HalfedgeId, f64)> = None;
        for side in place.face.halfedges() {
            let [a, b] = [corners[side.side()], corners[(side.side() + 1) % 3]];
            let outward = -(b - a).perp();
            let speed = along.dot(outward);
            if speed <= 0.0 {
                continue;
            }
            let way = ((a - place.point).dot(outward) / speed).max(0.0);
            if nearest.is_none_or(|(least, ..)| way < least) {
                let at = place.point + along * way;
                let share = (at - a).dot(b - a) / (b - a).length_squared();
                nearest = Some((way, side, share.clamp(EDGE_END, 1.0 - EDGE_END)));
            }
        }
        nearest.map(|(_, side, share)| (side, share))
    }

    fn on_side(&self, side: HalfedgeId, share: f64) -> DVec2 {
        let corners = self.triangulation.shape(side.face()).corners();
        let [a, b] = [corners[side.side()], corners[(side.side() + 1) % 3]];
        a + (b - a) * share
    }

    /// The same point of a side as a place in the triangle beyond it; `None` at the boundary.
    fn beyond(&self, side: HalfedgeId, share: f64, heading: f64) -> Option<Place> {
        let twin = self.surface.mesh().twin(side)?;
        let angle = |side: HalfedgeId| {
            let along = self.on_side(side, 1.0) - self.on_side(side, 0.0);
            libm::atan2(along.y, along.x)
        };
        Some(Place {
            face: twin.face(),
            point: self.on_side(twin, 1.0 - share),
            heading: heading - angle(side) + angle(twin) + PI,
        })
    }
}

/// A point of a line that is drawn, for those that come near it.
#[derive(Clone, Copy, Debug)]
struct Knot {
    point: DVec3,
    direction: DVec3,
    normal: DVec3,
    line: usize,
    /// Way along the line from where it was begun, negative on its way back.
    way: f64,
}

/// A line on one side of where it was begun.
struct Half {
    line: usize,
    /// 1 onward, -1 backward.
    sign: f64,
    /// Length so far.
    way: f64,
    points: Vec<DVec3>,
}

/// Draws lines that keep away from each other.
struct Weaver<'a> {
    tracer: Tracer<'a>,
    spacing: f64,
    /// The knots in cells as wide as the spacing.
    cells: BTreeMap<[i32; 3], Vec<Knot>>,
    lines: Vec<Vec<DVec3>>,
}

impl Weaver<'_> {
    /// Begins lines at places spread over a triangle, in each direction of the field.
    fn begin_in(&mut self, face: FaceId) {
        let shape = self.tracer.triangulation.shape(face);
        let [a, b, c] = shape.corners();
        let seeds = parts(shape.area(), self.spacing * self.spacing, MOST_SEEDS);
        for number in 0..seeds {
            // Multiples of the plastic number's powers fill the square evenly; folded, the triangle.
            let [mut s, mut t] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2]
                .map(|step: f64| (1.0 / 3.0 + f64::from(number) * step).fract());
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            let place = Place {
                face,
                point: a + (b - a) * s + (c - a) * t,
                heading: 0.0,
            };
            let Some(heading) = self.tracer.heading(place) else {
                return;
            };
            let turns = if self.symmetry() == Symmetry::Cross {
                2
            } else {
                1
            };
            for turn in 0..turns {
                let heading = heading + f64::from(turn) * self.symmetry().step();
                self.begin_at(Place { heading, ..place });
            }
        }
    }

    fn symmetry(&self) -> Symmetry {
        self.tracer.field.symmetry()
    }

    fn begin_at(&mut self, place: Place) {
        let line = self.lines.len();
        let Some(knot) = self.knot(place, line, 0.0) else {
            return;
        };
        if self.is_crowded(&knot, self.spacing) {
            return;
        }
        self.tie(knot);
        let half = |sign| Half {
            line,
            sign,
            way: 0.0,
            points: Vec::new(),
        };
        let onward = self.follow(place, half(1.0));
        let heading = place.heading + PI;
        let mut whole = self.follow(Place { heading, ..place }, half(-1.0));
        whole.reverse();
        whole.push(knot.point);
        whole.extend(onward);
        self.lines.push(whole);
    }

    /// The points of half a line beyond where it begins.
    fn follow(&mut self, start: Place, mut half: Half) -> Vec<DVec3> {
        let (mut place, mut stuck) = (start, 0);
        for _ in 0..MOST_CROSSINGS {
            let Some((side, share)) = self.tracer.exit(place) else {
                break;
            };
            let exit = Place {
                point: self.tracer.on_side(side, share),
                ..place
            };
            let Some(heading) = self.tracer.heading(exit) else {
                break;
            };
            let is_stuck = exit.point.distance(place.point) <= EDGE_END * self.spacing;
            stuck = if is_stuck { stuck + 1 } else { 0 };
            if stuck > MOST_STUCK || !self.pass(place, exit, &mut half) {
                break;
            }
            let Some(next) = self.tracer.beyond(side, share, heading) else {
                break;
            };
            place = next;
        }
        half.points
    }

    /// Goes from one place of a triangle to another and ties knots on the way; `false` if another
    /// line is too near.
    fn pass(&mut self, from: Place, to: Place, half: &mut Half) -> bool {
        let length = from.point.distance(to.point);
        let parts = parts(length, NEAREST * self.spacing, MOST_SEEDS);
        for part in 1..=parts {
            let share = f64::from(part) / f64::from(parts);
            let point = from.point.lerp(to.point, share);
            let way = half.sign * (half.way + share * length);
            let Some(knot) = self.knot(Place { point, ..from }, half.line, way) else {
                return false;
            };
            if self.is_crowded(&knot, NEAREST * self.spacing) {
                return false;
            }
            self.tie(knot);
            if part == parts {
                half.points.push(knot.point);
            }
        }
        half.way += length;
        true
    }

    fn knot(&self, place: Place, line: usize, way: f64) -> Option<Knot> {
        let [a, b, c] = self.tracer.surface.corner_positions(place.face);
        Some(Knot {
            point: self.tracer.in_space(place)?,
            direction: self.tracer.direction_in_space(place)?,
            normal: (b - a).cross(c - a).try_normalize()?,
            line,
            way,
        })
    }

    fn cell(&self, point: DVec3) -> [i32; 3] {
        (point / self.spacing).floor().to_array().map(|x| x as i32)
    }

    fn tie(&mut self, knot: Knot) {
        let cell = self.cell(knot.point);
        self.cells.entry(cell).or_default().push(knot);
    }

    /// Whether a line in about the same direction, on the same side of the surface, passes within
    /// this distance. Of the line itself the last few spacings do not count.
    fn is_crowded(&self, knot: &Knot, distance: f64) -> bool {
        let [x, y, z] = self.cell(knot.point);
        let is_near = |other: &Knot| {
            other.point.distance_squared(knot.point) < distance * distance
                && other.direction.dot(knot.direction).abs() > std::f64::consts::FRAC_1_SQRT_2
                && other.normal.dot(knot.normal) > 0.0
                && (other.line != knot.line || (other.way - knot.way).abs() > 3.0 * self.spacing)
        };
        (x - 1..=x + 1)
            .flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y)))
            .flat_map(|(x, y)| (z - 1..=z + 1).map(move |z| [x, y, z]))
            .filter_map(|cell| self.cells.get(&cell))
            .any(|knots| knots.iter().any(is_near))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{FieldOptions, cross_field};
    use crate::watch::Watch;
    use graticule_fixtures::{Fixture, cylinder_patch, grid, icosphere, torus};

    fn lines(fixture: Fixture, spacing: f64) -> (Surface, Vec<Vec<DVec3>>) {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let found = cross_field(&surface, &FieldOptions::default(), &Watch::new()).unwrap();
        let lines = streamlines(&surface, &found.field, spacing).unwrap();
        (surface, lines)
    }

    #[test]
    fn lines_of_a_rectangle_are_straight_and_go_from_side_to_side() {
        let (_, lines) = lines(grid(3.0, 2.0, 15, 10), 0.25);
        assert!(lines.len() > 12, "{}", lines.len());
        for line in &lines {
            let (first, last) = (line[0], line[line.len() - 1]);
            let off = |axis: usize| line.iter().map(move |p| (p[axis] - first[axis]).abs());
            let straight = (0..2).find(|&axis| off(axis).fold(0.0, f64::max) < 1e-6);
            let across = 1 - straight.expect("a line along an axis");
            let length = [3.0, 2.0][across];
            assert!(((last - first)[across].abs() - length).abs() < 1e-6);
        }
    }

    #[test]
    fn points_of_lines_are_on_the_surface() {
        let spacing = 0.3;
        let (_, lines) = lines(icosphere(3), spacing);
        assert!(lines.len() > 8, "{}", lines.len());
        for p in lines.iter().flatten() {
            assert!((0.97..=1.0 + 1e-9).contains(&p.length()));
        }
    }

    #[test]
    fn lines_of_one_direction_keep_half_the_spacing() {
        let (_, lines) = lines(grid(2.0, 2.0, 20, 20), 0.2);
        let rows: Vec<f64> = lines
            .iter()
            .filter(|line| (line[0].y - line[1].y).abs() < 1e-9)
            .map(|line| line[0].y)
            .collect();
        for (number, a) in rows.iter().enumerate() {
            assert!(rows[..number].iter().all(|b| (a - b).abs() >= 0.099));
        }
    }

    #[test]
    fn closed_lines_of_a_torus_end_where_they_began() {
        let (_, lines) = lines(torus(2.0, 0.7, 60, 24), 0.2);
        let closing = |line: &Vec<DVec3>| line[0].distance(line[line.len() - 1]);
        let length = |line: &Vec<DVec3>| line.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>();
        let long: Vec<_> = lines.iter().filter(|line| length(line) > 3.0).collect();
        assert!(long.len() > 20);
        let closed = long.iter().filter(|line| closing(line) < 0.2).count();
        assert!(closed * 10 > long.len() * 9, "{closed} of {}", long.len());
    }

    #[test]
    fn scale_changes_nothing_and_no_spacing_gives_no_lines() {
        let patch = cylinder_patch(1.0, 2.0, 16, 8);
        let (_, reference) = lines(patch.clone(), 0.25);
        let (surface, scaled) = lines(patch.map(|p| p * 1024.0), 256.0);
        let scaled: Vec<Vec<DVec3>> = (scaled.iter())
            .map(|line| line.iter().map(|&p| p / 1024.0).collect())
            .collect();
        assert_eq!(scaled, reference);
        let found = cross_field(&surface, &FieldOptions::default(), &Watch::new()).unwrap();
        for spacing in [0.0, f64::NAN, f64::INFINITY] {
            let none = streamlines(&surface, &found.field, spacing).unwrap();
            assert!(none.is_empty());
        }
    }
}
