use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::mesh::{Element, FaceId, HalfedgeId, Surface};

/// Where a path of triangles may end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// In a triangle.
    Face(FaceId),
    /// Across a boundary edge.
    Rim(HalfedgeId),
}

/// A way from triangle to triangle: the halfedges by which it leaves them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FacePath {
    pub(super) end: End,
    pub(super) crossed: Vec<HalfedgeId>,
    pub(super) length: f64,
}

/// Finds shortest ways between triangles, through the middles of their edges, again and again
/// without allocating anew.
pub(super) struct FacePathFinder<'a> {
    surface: &'a Surface,
    best: Vec<f64>,
    /// The halfedge by which the triangle was entered from its neighbour.
    entered: Vec<Option<HalfedgeId>>,
    touched: Vec<FaceId>,
    heap: BinaryHeap<Reached>,
}

impl<'a> FacePathFinder<'a> {
    pub(super) fn new(surface: &'a Surface) -> Self {
        let count = surface.mesh().face_count();
        Self {
            surface,
            best: vec![f64::INFINITY; count],
            entered: vec![None; count],
            touched: Vec::new(),
            heap: BinaryHeap::new(),
        }
    }

    /// The shortest way of at most `limit` from a triangle to an end, through edges that are open.
    pub(super) fn nearest(
        &mut self,
        start: FaceId,
        limit: f64,
        is_open: impl Fn(HalfedgeId) -> bool,
        is_end: impl Fn(End) -> bool,
    ) -> Option<FacePath> {
        self.reach(End::Face(start), 0.0, None);
        let mut found = None;
        while let Some(Reached { length, end }) = self.heap.pop() {
            match end {
                End::Face(face) if length > self.best[face.index()] => {}
                _ if is_end(end) => {
                    found = Some((end, length));
                    break;
                }
                End::Rim(_) => {}
                End::Face(face) => self.cross_sides(face, length, limit, &is_open),
            }
        }
        let path = found.map(|(end, length)| self.path(end, length));
        self.forget();
        path
    }

    fn cross_sides(
        &mut self,
        face: FaceId,
        length: f64,
        limit: f64,
        is_open: &impl Fn(HalfedgeId) -> bool,
    ) {
        let mesh = self.surface.mesh();
        for halfedge in face.halfedges() {
            if !is_open(halfedge) {
                continue;
            }
            let there = self
                .surface
                .position(mesh.origin(halfedge))
                .midpoint(self.surface.position(mesh.destination(halfedge)));
            let mut next = length + self.middle(face).distance(there);
            let end = mesh.twin(halfedge).map_or(End::Rim(halfedge), |twin| {
                next += self.middle(twin.face()).distance(there);
                End::Face(twin.face())
            });
            if next <= limit {
                self.reach(end, next, Some(halfedge));
            }
        }
    }

    fn middle(&self, face: FaceId) -> glam::DVec3 {
        self.surface
            .corner_positions(face)
            .iter()
            .sum::<glam::DVec3>()
            / 3.0
    }

    fn reach(&mut self, end: End, length: f64, by: Option<HalfedgeId>) {
        if let End::Face(face) = end {
            let best = &mut self.best[face.index()];
            if length >= *best {
                return;
            }
            if best.is_infinite() {
                self.touched.push(face);
            }
            *best = length;
            self.entered[face.index()] = by;
        }
        self.heap.push(Reached { length, end });
    }

    fn path(&self, end: End, length: f64) -> FacePath {
        let mut crossed = Vec::new();
        let mut face = match end {
            End::Face(face) => face,
            End::Rim(halfedge) => {
                crossed.push(halfedge);
                halfedge.face()
            }
        };
        while let Some(halfedge) = self.entered[face.index()] {
            crossed.push(halfedge);
            face = halfedge.face();
        }
        crossed.reverse();
        FacePath {
            end,
            crossed,
            length,
        }
    }

    fn forget(&mut self) {
        self.heap.clear();
        for face in self.touched.drain(..) {
            self.best[face.index()] = f64::INFINITY;
            self.entered[face.index()] = None;
        }
    }
}

/// Orders the heap by shortest way, then by smallest element.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Reached {
    length: f64,
    end: End,
}

impl Reached {
    fn number(&self) -> (bool, u32) {
        match self.end {
            End::Face(face) => (false, face.0),
            End::Rim(halfedge) => (true, halfedge.0),
        }
    }
}

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_length = other.length.total_cmp(&self.length);
        by_length.then_with(|| other.number().cmp(&self.number()))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::grid;

    fn strip() -> Surface {
        let strip = grid(10.0, 1.0, 10, 1);
        Surface::from_triangles(strip.positions, &strip.triangles).unwrap()
    }

    #[test]
    fn a_way_crosses_from_triangle_to_triangle() {
        let surface = strip();
        let mesh = surface.mesh();
        let goal = FaceId(19);
        let found = FacePathFinder::new(&surface)
            .nearest(FaceId(0), 100.0, |_| true, |end| end == End::Face(goal))
            .unwrap();
        let mut face = FaceId(0);
        for &halfedge in &found.crossed {
            assert_eq!(halfedge.face(), face);
            face = mesh.twin(halfedge).unwrap().face();
        }
        assert_eq!(face, goal);
        assert!(found.length > 9.0);
    }

    #[test]
    fn limits_and_closed_edges_hold() {
        let surface = strip();
        let mut finder = FacePathFinder::new(&surface);
        let to_goal = |end| end == End::Face(FaceId(19));
        assert!(finder.nearest(FaceId(0), 5.0, |_| true, to_goal).is_none());
        let wall = |halfedge: HalfedgeId| {
            let ends = surface.mesh().ends(halfedge);
            !ends
                .iter()
                .all(|&v| (surface.position(v).x - 5.0).abs() < 1e-9)
        };
        assert!(finder.nearest(FaceId(0), 100.0, wall, to_goal).is_none());
        let rim = finder.nearest(FaceId(0), 100.0, |_| true, |end| matches!(end, End::Rim(_)));
        assert_eq!(rim.unwrap().crossed.len(), 1);
    }
}
