use glam::DVec2;

use super::layout_corners::orientation;
use super::layout_transition::{ChartTransition, exact_part, nearest_turn};
use super::{ArcKind, ChartKind, EmbeddedNet};
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerEdge, PerFace};
use crate::tolerance::CHART_AGREEMENT;

/// Lays out charts in the plane, triangle by triangle ([PGP06] §3.3).
///
/// [PGP06]: crate::papers::PGP06
pub(super) struct Unrolling<'a> {
    net: &'a EmbeddedNet,
    edges: &'a PerEdge<Option<ArcKind>>,
    /// How coordinates of each triangle become those of the chart.
    frames: PerFace<Option<ChartTransition>>,
    coordinates: PerCorner<Option<DVec2>>,
}

impl<'a> Unrolling<'a> {
    pub(super) fn new(net: &'a EmbeddedNet, edges: &'a PerEdge<Option<ArcKind>>) -> Self {
        let mesh = net.refined.surface.mesh();
        Self {
            net,
            edges,
            frames: PerFace::filled(mesh.face_count(), None),
            coordinates: PerCorner::filled(mesh.halfedge_count(), None),
        }
    }

    pub(super) fn into_coordinates(self) -> PerCorner<Option<DVec2>> {
        self.coordinates
    }

    /// Lays out a chart with four sides, if the map makes a rectangle of it.
    pub(super) fn lay_out(&mut self, sides: &[Vec<HalfedgeId>]) -> ChartKind {
        match self.try_chart(sides) {
            Some(faces) => {
                self.keep(&faces, sides);
                if self.is_rectangle(&faces, sides) {
                    return ChartKind::Regular;
                }
                for corner in faces.iter().flat_map(|face| face.halfedges()) {
                    self.coordinates[corner] = None;
                }
                ChartKind::Singular
            }
            None => ChartKind::Singular,
        }
    }

    /// Finds the frames of a chart's triangles; `None` where one has no coordinates or they do not
    /// close.
    fn try_chart(&mut self, sides: &[Vec<HalfedgeId>]) -> Option<Vec<FaceId>> {
        let mesh = self.net.refined.surface.mesh();
        let first = sides[0][0];
        let [start, ahead] = [first, first.next()].map(|corner| self.net.coordinates[corner]);
        let turn = nearest_turn(ahead? - start?, DVec2::X);
        let shift = -turn.apply(start?);
        self.frames[first.face()] = Some(ChartTransition { turn, shift });
        let mut faces = vec![first.face()];
        let mut next = 0;
        while let Some(&face) = faces.get(next) {
            next += 1;
            for halfedge in face.halfedges() {
                if self.edges[mesh.edge(halfedge)].is_some() {
                    continue;
                }
                let twin = mesh.twin(halfedge)?;
                let here = [halfedge, halfedge.next()].map(|corner| self.laid_out(corner));
                let there = [twin.next(), twin].map(|corner| self.net.coordinates[corner]);
                let ([Some(a), Some(b)], [Some(c), Some(d)]) = (here, there) else {
                    return None;
                };
                if self.frames[twin.face()].is_none() {
                    self.frames[twin.face()] = Some(ChartTransition::between([c, d], [a, b]));
                    faces.push(twin.face());
                }
                let found = [twin.next(), twin].map(|corner| self.laid_out(corner));
                let agree = (found.into_iter().zip([a, b])).all(|(found, point)| {
                    found.is_some_and(|f| f.distance(point) < CHART_AGREEMENT)
                });
                if !agree {
                    return None;
                }
            }
        }
        Some(faces)
    }

    fn laid_out(&self, corner: HalfedgeId) -> Option<DVec2> {
        let frame = self.frames[corner.face()]?;
        self.net.coordinates[corner].map(|point| frame.apply(point))
    }

    /// Writes the coordinates down, those of the border exactly on the rectangle.
    fn keep(&mut self, faces: &[FaceId], sides: &[Vec<HalfedgeId>]) {
        for corner in faces.iter().flat_map(|face| face.halfedges()) {
            self.coordinates[corner] = self.laid_out(corner);
        }
        let Some(far) = self.coordinates[sides[2][0]] else {
            return;
        };
        let far = far.map(exact_part);
        for (side, halfedges) in sides.iter().enumerate() {
            let (axis, level) = [(1, 0.0), (0, far.x), (1, far.y), (0, 0.0)][side];
            for &halfedge in halfedges {
                self.put_on_line(halfedge, axis, level);
                self.put_on_line(halfedge.next(), axis, level);
            }
        }
    }

    /// Puts a vertex of the border on a line, in all triangles of the chart around it.
    fn put_on_line(&mut self, corner: HalfedgeId, axis: usize, level: f64) {
        let mesh = self.net.refined.surface.mesh();
        let settle = |this: &mut Self, corner: HalfedgeId| {
            if let Some(point) = &mut this.coordinates[corner]
                && (point[axis] - level).abs() < CHART_AGREEMENT
            {
                point[axis] = level;
            }
        };
        settle(self, corner);
        let is_inner = |halfedge: HalfedgeId| self.edges[mesh.edge(halfedge)].is_none();
        let left = std::iter::successors(Some(corner), |&corner| {
            (mesh.turn_left(corner)).filter(|_| is_inner(corner.previous()))
        });
        let right = std::iter::successors(Some(corner), |&corner| {
            mesh.twin(corner)
                .filter(|_| is_inner(corner))
                .map(HalfedgeId::next)
        });
        let around: Vec<_> = left.skip(1).chain(right.skip(1)).collect();
        for corner in around {
            settle(self, corner);
        }
    }

    /// Whether each side lies on its line and all triangles are positive.
    fn is_rectangle(&self, faces: &[FaceId], sides: &[Vec<HalfedgeId>]) -> bool {
        let Some(far) = self.coordinates[sides[2][0]] else {
            return false;
        };
        let on_line = |side: usize, point: DVec2| {
            let (axis, level) = [(1, 0.0), (0, far.x), (1, far.y), (0, 0.0)][side];
            (point[axis] - level).abs() == 0.0
        };
        let straight = sides.iter().enumerate().all(|(side, halfedges)| {
            let corners = halfedges.iter().flat_map(|&h| [h, h.next()]);
            corners
                .map(|corner| self.coordinates[corner])
                .all(|point| point.is_some_and(|point| on_line(side, point)))
        });
        straight
            && faces.iter().all(|face| {
                let points = face.halfedges().map(|corner| self.coordinates[corner]);
                matches!(points, [Some(a), Some(b), Some(c)] if orientation([a, b, c]) > 0.0)
            })
    }
}
