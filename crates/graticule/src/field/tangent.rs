//! Between directions in space and angles in the tangent planes of an intrinsic triangulation.

use std::borrow::Cow;
use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{FieldDomain, Symmetry};
use crate::geometry::{IntrinsicTriangulation, TangentFrame, vertex_frames};
use crate::mesh::{HalfedgeId, PerVertex, Surface, VertexId};
use crate::tolerance::{GUIDE_SLANT, ROUNDING};

/// What rounding leaves of an angle that should be 0.
const SLACK: f64 = 32.0 * ROUNDING;

/// Takes directions from the tangent planes of the vertices to space and back, through the planes of
/// the triangles.
///
/// Angles at a vertex count along the surface. Where it has a crease they are not those between the
/// projections to the tangent plane of the frame: a direction along the crease would come out up to
/// ten degrees off. So a direction goes into its own triangle first and is projected from there.
pub(super) struct TangentPlanes<'a> {
    pub(super) surface: &'a Surface,
    pub(super) triangulation: &'a IntrinsicTriangulation,
    pub(super) frames: Cow<'a, PerVertex<TangentFrame>>,
}

impl<'a> TangentPlanes<'a> {
    /// `triangulation` must have the triangles of `surface`.
    pub(super) fn of(surface: &'a Surface, triangulation: &'a IntrinsicTriangulation) -> Self {
        Self {
            surface,
            triangulation,
            frames: Cow::Owned(vertex_frames(surface)),
        }
    }

    /// Those of a domain.
    pub(super) fn on(domain: &'a FieldDomain<'_>) -> Self {
        Self {
            surface: domain.surface(),
            triangulation: domain.triangulation(),
            frames: Cow::Borrowed(domain.frames()),
        }
    }

    /// One of the directions of a field in space: that which fits the images of all of them best.
    pub(super) fn in_space(&self, symmetry: Symmetry, vertex: VertexId, angle: f64) -> DVec3 {
        let image = |angle| self.image(vertex, angle);
        let best = mean(symmetry, angle, image).unwrap_or(angle);
        self.frames[vertex].lift(DVec2::from_angle(best))
    }

    /// The angle along the surface of one direction of a field whose directions have `angle`, and
    /// that turned by steps, in the frame.
    pub(super) fn on_surface(&self, symmetry: Symmetry, vertex: VertexId, angle: f64) -> f64 {
        let sectors = self.sectors(vertex);
        let preimage = |angle| self.preimage(vertex, &sectors, angle);
        mean(symmetry, angle, preimage).unwrap_or(angle)
    }

    /// The angle in the frame of the direction with this angle along the surface.
    fn image(&self, vertex: VertexId, angle: f64) -> Option<f64> {
        let scale = self.triangulation.angle_scale(vertex);
        let inside = self.surface.mesh().outgoing(vertex).find_map(|halfedge| {
            let past = round_down(angle - self.triangulation.direction(halfedge));
            if past > self.width(halfedge, scale) + SLACK {
                return None;
            }
            let [side, next] = self.sides(halfedge)?;
            let across = (next - side * side.dot(next)).try_normalize()?;
            let (sin, cos) = libm::sincos(past / scale);
            polar_angle(self.frames[vertex].project(side * cos + across * sin))
        });
        inside.or_else(|| {
            let [surface, frame] = self.rim(vertex, &self.sectors(vertex))?;
            Some(beyond(surface, frame, angle))
        })
    }

    /// The angle along the surface of the direction with this angle in the frame; `None` where the
    /// projected triangles do not surround an inner vertex.
    fn preimage(&self, vertex: VertexId, sectors: &[Sector], angle: f64) -> Option<f64> {
        let wanted = DVec2::from_angle(angle);
        let scale = self.triangulation.angle_scale(vertex);
        let inside = sectors.iter().find_map(|sector| {
            let [p, q] = sector.sides.map(|side| self.frames[vertex].project(side));
            let (area, of_p, of_q) = (p.perp_dot(q), wanted.perp_dot(q), p.perp_dot(wanted));
            if area <= 0.0 || of_p < 0.0 || of_q < 0.0 {
                return None;
            }
            let [side, next] = sector.sides;
            let vector = (side * (of_p / area) + next * (of_q / area)).try_normalize()?;
            Some(sector.start + scale * side.angle_between(vector))
        });
        inside.or_else(|| {
            let [surface, frame] = self.rim(vertex, sectors)?;
            Some(beyond(frame, surface, angle))
        })
    }

    /// The angles of the two boundary edges at a vertex, the first and the last of its edges: along
    /// the surface, and in the frame. `None` inside.
    fn rim(&self, vertex: VertexId, sectors: &[Sector]) -> Option<[[f64; 2]; 2]> {
        if !self.surface.mesh().is_boundary_vertex(vertex) {
            return None;
        }
        let (first, last) = (sectors.first()?, sectors.last()?);
        let width = last.sides[0].angle_between(last.sides[1]);
        let end = last.start + self.triangulation.angle_scale(vertex) * width;
        let in_frame = |side| polar_angle(self.frames[vertex].project(side));
        let frame = [in_frame(first.sides[0])?, in_frame(last.sides[1])?];
        Some([[first.start, end], frame])
    }

    /// The corners round a vertex, counter-clockwise.
    fn sectors(&self, vertex: VertexId) -> Vec<Sector> {
        let mesh = self.surface.mesh();
        let halfedges = mesh.outgoing(vertex);
        let sides: Vec<_> = halfedges.map(|h| (h, self.unit(h, 1.0))).collect();
        // The next side of each corner is the side of the one after it; a rim ends with another edge.
        let end = sides.last().and_then(|&(last, _)| {
            let goes_round = mesh.turn_left(last).is_some();
            if goes_round {
                sides[0].1
            } else {
                self.unit(last.previous(), -1.0)
            }
        });
        let nexts = sides.iter().skip(1).map(|&(_, side)| side).chain([end]);
        let sectors = sides
            .iter()
            .zip(nexts)
            .filter_map(|(&(halfedge, side), next)| {
                Some(Sector {
                    start: self.triangulation.direction(halfedge),
                    sides: [side?, next?],
                })
            });
        sectors.collect()
    }

    /// The sides of the corner at the origin of a halfedge, as unit vectors.
    fn sides(&self, halfedge: HalfedgeId) -> Option<[DVec3; 2]> {
        Some([
            self.unit(halfedge, 1.0)?,
            self.unit(halfedge.previous(), -1.0)?,
        ])
    }

    /// How wide that corner is along the surface, as directions count.
    fn width(&self, halfedge: HalfedgeId, scale: f64) -> f64 {
        match self.surface.mesh().turn_left(halfedge) {
            Some(left) => {
                let [here, there] = [halfedge, left].map(|side| self.triangulation.direction(side));
                round_down(there - here)
            }
            None => {
                scale
                    * self
                        .triangulation
                        .shape(halfedge.face())
                        .angle(halfedge.side())
            }
        }
    }

    fn unit(&self, halfedge: HalfedgeId, sign: f64) -> Option<DVec3> {
        let vector = self.surface.halfedge_vector(halfedge) * sign;
        (vector / vector.abs().max_element()).try_normalize()
    }
}

/// An angle in `0.0..2π`, just below a whole turn as 0: rounding must not lose a direction between
/// two triangles, or at the boundary.
fn round_down(angle: f64) -> f64 {
    // The remainder of the standard library takes ten times as long, to be exact for large angles.
    let wrapped = angle - TAU * (angle / TAU).floor();
    if wrapped > TAU - SLACK { 0.0 } else { wrapped }
}

/// The corner of a triangle at a vertex.
struct Sector {
    /// The angle of its first side along the surface.
    start: f64,
    /// Its two sides as unit vectors in space, counter-clockwise.
    sides: [DVec3; 2],
}

/// What an angle outside of the boundary becomes: in the same ratio between the two boundary edges,
/// which go from the angles `from` to `to`.
fn beyond(from: [f64; 2], to: [f64; 2], angle: f64) -> f64 {
    let gap = |[first, last]: [f64; 2]| (first - last).rem_euclid(TAU);
    let share = (angle - from[1]).rem_euclid(TAU) / gap(from).max(SLACK);
    to[1] + share.min(1.0) * gap(to)
}

/// The angle that fits the images of all directions of a field best.
fn mean(symmetry: Symmetry, angle: f64, image: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let turns = (0..symmetry.order()).map(|turn| angle + f64::from(turn) * symmetry.step());
    let powers = turns.filter_map(image).map(|image| symmetry.power(image));
    let sum = powers.sum::<DVec2>().try_normalize()?;
    // That next to the angle itself: the representative is kept.
    let (off, _) = symmetry.reduce(symmetry.root(sum) - angle);
    Some(angle + off)
}

fn polar_angle(vector: DVec2) -> Option<f64> {
    let is_clear = vector.length() > GUIDE_SLANT;
    is_clear.then(|| libm::atan2(vector.y, vector.x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::{Fixture, bumpy_patch, cube, disk, icosphere};

    fn check(fixture: Fixture, test: impl Fn(&Surface, &TangentPlanes<'_>, VertexId)) {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let triangulation = IntrinsicTriangulation::of(&surface).unwrap();
        let planes = TangentPlanes::of(&surface, &triangulation);
        for vertex in surface.mesh().vertices() {
            test(&surface, &planes, vertex);
        }
    }

    #[test]
    fn there_and_back_is_nothing() {
        for fixture in [icosphere(2), bumpy_patch(6, 2), cube().subdivided()] {
            check(fixture, |surface, planes, vertex| {
                if surface.mesh().is_boundary_vertex(vertex) {
                    return;
                }
                for step in -3..=3 {
                    let angle = f64::from(step);
                    let image = planes.image(vertex, angle).unwrap();
                    let sectors = planes.sectors(vertex);
                    let back = planes.preimage(vertex, &sectors, image).unwrap();
                    let (off, _) = Symmetry::Vector.reduce(back - angle);
                    assert!(off.abs() < 1e-7, "{vertex}: {angle} {back}");
                }
            });
        }
    }

    #[test]
    fn edges_go_to_themselves() {
        for fixture in [disk(4), bumpy_patch(6, 2), cube().subdivided()] {
            check(fixture, |surface, planes, vertex| {
                for halfedge in surface.mesh().outgoing(vertex) {
                    let angle = planes.triangulation.direction(halfedge);
                    let image = DVec2::from_angle(planes.image(vertex, angle).unwrap());
                    let edge = planes.frames[vertex].project(surface.halfedge_vector(halfedge));
                    assert!(image.distance(edge.normalize()) < 1e-7, "{vertex}");
                }
            });
        }
    }

    #[test]
    fn a_crease_keeps_its_direction() {
        check(
            cube().subdivided().subdivided(),
            |surface, planes, vertex| {
                let inside = surface
                    .position(vertex)
                    .to_array()
                    .map(|x| x > 0.0 && x < 1.0);
                if inside.iter().filter(|x| **x).count() != 1 {
                    return;
                }
                let crease = DVec3::from_array(inside.map(|x| f64::from(u8::from(x))));
                let mut halfedges = surface.mesh().outgoing(vertex);
                let along = halfedges
                    .find(|&h| surface.halfedge_vector(h).normalize().dot(crease) > 0.99)
                    .unwrap();
                let angle = planes.triangulation.direction(along);
                let found = planes.in_space(Symmetry::Cross, vertex, angle);
                assert!(found.distance(crease) < 1e-7, "{vertex}: {found}");
            },
        );
    }
}
