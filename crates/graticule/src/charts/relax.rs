//! Relaxation across the borders of squares.

use glam::DVec2;

use super::chart_map::{ChartMaps, SeamSide};
use super::chart_map_polygon::ChartMethod;
use crate::geometry::TriangleShape;
use crate::measure::orientation;
use crate::mesh::{Element, FaceId, HalfedgeId, PerCorner, PerVertex, VertexId};
use crate::watch::{Stopped, Watch};

/// Halvings of a step before a vertex stays where it is.
const HALVINGS: usize = 6;

/// Where a vertex may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Freedom {
    None,
    /// Anywhere in its square.
    Inside,
    /// Along a seam.
    Along(u32),
}

impl ChartMaps {
    /// Moves each vertex, in turn, to the mean of its neighbours with mean value weights
    /// (Khodakovsky, Litke, Schröder 2003): those inside squares without the net's coordinates, and
    /// those on their seams, which slide along them and count neighbours on both sides. A vertex goes
    /// only so far that no triangle flips.
    pub(super) fn relax(&mut self, rounds: u32, watch: &Watch) -> Result<(), Stopped> {
        if rounds == 0 {
            return Ok(());
        }
        let _stage = watch.stage("relax across borders");
        let freedom = self.freedom();
        let tangents = self.half_tangents();
        for round in 0..rounds {
            watch.check()?;
            watch.progress(f64::from(round) / f64::from(rounds));
            for vertex in self.surface().mesh().vertices() {
                match freedom[vertex] {
                    Freedom::None => {}
                    Freedom::Inside => self.move_inside(vertex, &tangents),
                    Freedom::Along(seam) => self.move_along(vertex, seam as usize, &tangents),
                }
            }
        }
        Ok(())
    }

    fn freedom(&self) -> PerVertex<Freedom> {
        let mesh = self.surface().mesh();
        let on_net = |square: usize| self.squares[square].method == ChartMethod::Net;
        let mut freedom = PerVertex::filled(mesh.vertex_count(), Freedom::None);
        for (face, square) in self.square_of.enumerate() {
            if !on_net(square.index()) {
                mesh.triangle(face)
                    .iter()
                    .for_each(|&vertex| freedom[vertex] = Freedom::Inside);
            }
        }
        for (number, seam) in (0..).zip(&self.seams) {
            let free = match seam.sides {
                [Some(left), Some(right)] => {
                    !on_net(left.square.index()) || !on_net(right.square.index())
                }
                _ => false,
            };
            let last = seam.vertices.len() - 1;
            for (step, &vertex) in seam.vertices.iter().enumerate() {
                let slides = free && step > 0 && step < last;
                freedom[vertex] = if slides {
                    Freedom::Along(number)
                } else {
                    Freedom::None
                };
            }
        }
        freedom
    }

    /// The tangent of half the angle at each corner; 0 where rounding leaves no angle.
    fn half_tangents(&self) -> PerCorner<f64> {
        let shape = |corner: HalfedgeId| {
            TriangleShape::from_positions(self.surface().corner_positions(corner.face()))
        };
        let tangent = |corner: HalfedgeId| shape(corner).half_angle_tangent(corner.side());
        let count = self.surface().mesh().halfedge_count();
        PerCorner::from_fn(count, |corner| {
            tangent(corner).filter(|t| t.is_finite()).unwrap_or(0.0)
        })
    }

    /// The corners next to those at a vertex, each with what it counts.
    fn neighbours<'a>(
        &'a self,
        vertex: VertexId,
        tangents: &'a PerCorner<f64>,
    ) -> impl Iterator<Item = (HalfedgeId, f64)> + 'a {
        let outgoing = self.surface().mesh().outgoing(vertex);
        outgoing.flat_map(move |corner| {
            [corner.next(), corner.previous()].map(|other| {
                let side = if other == corner.next() {
                    corner
                } else {
                    other
                };
                let length = self.surface().halfedge_vector(side).length();
                (other, tangents[corner] / length.max(f64::MIN_POSITIVE))
            })
        })
    }

    fn move_inside(&mut self, vertex: VertexId, tangents: &PerCorner<f64>) {
        let (mut sum, mut weights) = (DVec2::ZERO, 0.0);
        for (corner, weight) in self.neighbours(vertex, tangents) {
            sum += self.coordinates[corner] * weight;
            weights += weight;
        }
        let corners: Vec<HalfedgeId> = self.surface().mesh().outgoing(vertex).collect();
        let from = self.coordinates[corners[0]];
        let target = sum / weights;
        self.step(|step| {
            corners
                .iter()
                .map(|&c| (c, from.lerp(target, step)))
                .collect()
        });
    }

    fn move_along(&mut self, vertex: VertexId, seam: usize, tangents: &PerCorner<f64>) {
        let sides = self.seams[seam].sides;
        let side_at = |corner: HalfedgeId| {
            let square = self.square_of[corner.face()];
            sides
                .into_iter()
                .flatten()
                .find(|side| side.square == square)
        };
        let (mut sum, mut weights) = (0.0, 0.0);
        for (corner, weight) in self.neighbours(vertex, tangents) {
            if let Some(side) = side_at(corner) {
                sum += side.share(self.coordinates[corner]) * weight;
                weights += weight;
            }
        }
        let corners = self.surface().mesh().outgoing(vertex);
        let corners: Vec<(HalfedgeId, SeamSide)> = corners
            .filter_map(|corner| Some((corner, side_at(corner)?)))
            .collect();
        let Some((first, side)) = corners.first() else {
            return;
        };
        let from = side.share(self.coordinates[*first]);
        let target = sum / weights;
        let place = |step: f64, side: &SeamSide| side.place(from + (target - from) * step);
        self.step(|step| {
            corners
                .iter()
                .map(|(c, side)| (*c, place(step, side)))
                .collect()
        });
    }

    /// Gives corners the places of a whole step, or of a smaller one that flips nothing.
    fn step(&mut self, places: impl Fn(f64) -> Vec<(HalfedgeId, DVec2)>) {
        let mut step = 1.0;
        for _ in 0..HALVINGS {
            let moved = places(step);
            let before: Vec<DVec2> = moved.iter().map(|&(c, _)| self.coordinates[c]).collect();
            for &(corner, place) in &moved {
                self.coordinates[corner] = place;
            }
            if moved
                .iter()
                .all(|&(corner, _)| self.is_upright(corner.face()))
            {
                return;
            }
            for (&(corner, _), &place) in moved.iter().zip(&before) {
                self.coordinates[corner] = place;
            }
            step *= 0.5;
        }
    }

    fn is_upright(&self, face: FaceId) -> bool {
        let [a, b, c] = face.halfedges().map(|corner| self.coordinates[corner]);
        [a, b, c].iter().all(|place| place.is_finite()) && orientation(a, b, c) > 0
    }
}
