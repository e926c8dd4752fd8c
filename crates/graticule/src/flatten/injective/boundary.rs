//! The boundary of a map: whether it meets itself, now or on the way.

use glam::DVec2;
use robust::{Coord, orient2d};

use crate::flatten::collapse_time::meeting_time;
use crate::geometry::{Bounds, BoxTree};

/// The boundary of triangles.
pub(super) struct Boundary {
    /// Edges, the surface to their left; each boundary vertex starts one.
    edges: Vec<[u32; 2]>,
}

/// A vertex that is on its way to an edge, where it must not come: the vertex and the ends of the
/// edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Obstacle {
    pub(super) vertices: [u32; 3],
    /// When it gets there, in steps.
    pub(super) time: f64,
}

impl Obstacle {
    /// The pairs of the vertex and an end of the edge.
    pub(super) fn pairs(&self) -> [[u32; 2]; 2] {
        let [vertex, a, b] = self.vertices;
        [[vertex, a], [vertex, b]]
    }
}

impl Boundary {
    pub(super) fn new(triangles: &[[u32; 3]]) -> Self {
        Self {
            edges: boundary_edges(triangles),
        }
    }

    pub(super) fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// Whether the boundary meets itself nowhere. Exact. Near-linear, as long as few boxes around
    /// edges overlap.
    pub(super) fn is_simple(&self, places: &[DVec2]) -> bool {
        let (segments, tree) = self.segments(places);
        !tree.any_overlapping_pair(|first, second| self.meet([first, second], &segments))
    }

    /// The pairs of edges, by their numbers, that meet. Exact; the same order in every run.
    pub(super) fn self_meetings(&self, places: &[DVec2]) -> Vec<[usize; 2]> {
        let (segments, tree) = self.segments(places);
        let mut meetings = Vec::new();
        tree.any_overlapping_pair(|first, second| {
            if self.meet([first, second], &segments) {
                meetings.push([first, second]);
            }
            false
        });
        meetings
    }

    /// Where the edges lie, and a tree of the boxes around them.
    fn segments(&self, places: &[DVec2]) -> (Vec<[DVec2; 2]>, BoxTree<2>) {
        let segments: Vec<_> = self
            .edges
            .iter()
            .map(|edge| edge.map(|v| places[v as usize]))
            .collect();
        let boxes: Vec<_> = segments.iter().map(|ends| grown_box(ends, 0.0)).collect();
        (segments, BoxTree::new(&boxes))
    }

    fn meet(&self, [first, second]: [usize; 2], segments: &[[DVec2; 2]]) -> bool {
        let [[a, b], [c, d]] = [self.edges[first], self.edges[second]];
        let [p, q] = [segments[first], segments[second]];
        match (b == c, a == d) {
            (false, false) => segments_meet(p, q),
            (true, _) => folds_back(p[0], p[1], q[1]),
            (_, true) => folds_back(q[0], q[1], p[1]),
        }
    }

    /// Calls `visit(vertex, edge)`, a vertex by the number of the edge that starts there, for those
    /// within the smaller of both reaches and some farther apart; not for the ends of an edge and
    /// itself. The same order in every run.
    pub(super) fn visit_near(
        &self,
        places: &[DVec2],
        reach: impl Fn(usize) -> f64,
        visit: impl FnMut(usize, usize),
    ) {
        let segment = |edge: &[u32; 2]| edge.map(|v| places[v as usize]);
        let numbered = self.edges.iter().enumerate();
        // Two boxes, each grown by half the reach of its edge, overlap within the smaller reach.
        let boxes: Vec<_> = numbered
            .map(|(index, edge)| grown_box(&segment(edge), 0.5 * reach(index)))
            .collect();
        self.visit_overlapping(&boxes, visit);
    }

    fn visit_overlapping(&self, boxes: &[Bounds<2>], mut visit: impl FnMut(usize, usize)) {
        let is_apart = |vertex: usize, edge: usize| {
            let [start, _] = self.edges[vertex];
            !self.edges[edge].contains(&start)
        };
        BoxTree::new(boxes).any_overlapping_pair(|first, second| {
            for [vertex, edge] in [[first, second], [second, first]] {
                if is_apart(vertex, edge) {
                    visit(vertex, edge);
                }
            }
            false
        });
    }

    /// All vertices that meet edges within the given number of steps, in the same order in every
    /// run.
    pub(super) fn meetings(&self, places: &[DVec2], step: &[DVec2], limit: f64) -> Vec<Obstacle> {
        let boxes: Vec<_> = self
            .edges
            .iter()
            .map(|edge| {
                let [[a, b], [c, d]] = [0.0, limit]
                    .map(|time| edge.map(|v| places[v as usize] + step[v as usize] * time));
                grown_box(&[a, b, c, d], 0.0)
            })
            .collect();
        let mut meetings = Vec::new();
        self.visit_overlapping(&boxes, |vertex, edge| {
            let ([vertex, _], [a, b]) = (self.edges[vertex], self.edges[edge]);
            let vertices = [vertex, a, b];
            let [points, steps] = [places, step].map(|all| vertices.map(|v| all[v as usize]));
            let time = meeting_time(points, steps);
            if time <= limit {
                meetings.push(Obstacle { vertices, time });
            }
        });
        meetings
    }
}

/// A box around points, grown by a length and by so little that boxes of what touches overlap.
fn grown_box(points: &[DVec2], by: f64) -> Bounds<2> {
    let Bounds { low, high } = Bounds::around(points);
    Bounds {
        low: low.map(|x| (x - by).next_down()),
        high: high.map(|x| (x + by).next_up()),
    }
}

/// Sides of triangles that no other triangle has, in the direction of their triangle.
fn boundary_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut sides: Vec<[u32; 4]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[from, to]| [from.min(to), from.max(to), from, to])
        .collect();
    sides.sort_unstable();
    let groups = sides.chunk_by(|a, b| a[..2] == b[..2]);
    groups
        .filter(|group| group.len() == 1)
        .map(|group| [group[0][2], group[0][3]])
        .collect()
}

/// Whether two segments have a point in common. Exact.
pub(super) fn segments_meet([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let apart = |p: DVec2, q: DVec2, r: DVec2, s: DVec2| {
        p.max(q).cmplt(r.min(s)).any() || r.max(s).cmplt(p.min(q)).any()
    };
    if apart(a, b, c, d) {
        return false;
    }
    let one_side = |p: DVec2, q: DVec2, r: DVec2, s: DVec2| {
        let [first, second] = [orientation(p, q, r), orientation(p, q, s)];
        first > 0.0 && second > 0.0 || first < 0.0 && second < 0.0
    };
    !one_side(a, b, c, d) && !one_side(c, d, a, b)
}

/// Whether the way from a by b to c goes back over itself. Exact.
fn folds_back(a: DVec2, b: DVec2, c: DVec2) -> bool {
    orientation(a, b, c) == 0.0 && (a - b).dot(c - b) > 0.0
}

fn orientation(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    orient2d(a, b, c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_meet_at_points_of_either() {
        let s = |a: [f64; 2], b: [f64; 2]| [DVec2::from(a), DVec2::from(b)];
        let base = s([0.0, 0.0], [2.0, 0.0]);
        assert!(segments_meet(base, s([1.0, -1.0], [1.0, 1.0])));
        assert!(segments_meet(base, s([1.0, 0.0], [1.0, 1.0])));
        assert!(segments_meet(base, s([1.0, 0.0], [3.0, 0.0])));
        assert!(!segments_meet(base, s([3.0, 0.0], [4.0, 0.0])));
        assert!(!segments_meet(base, s([1.0, 1e-300], [1.0, 1.0])));
    }

    #[test]
    fn a_tip_on_its_way_to_an_edge_is_met_in_time() {
        let places = [
            (0.0, 0.0),
            (1.0, 0.0),
            (0.5, 1.0),
            (0.0, 3.0),
            (0.5, 1.5),
            (1.0, 3.0),
        ];
        let places = places.map(|(x, y)| DVec2::new(x, y));
        let boundary = Boundary::new(&[[0, 1, 2], [3, 4, 5]]);
        assert!(boundary.is_simple(&places));
        let mut step = [DVec2::ZERO; 6];
        for moved in &mut step[3..] {
            *moved = DVec2::new(0.1, -1.0);
        }
        let first = |limit| {
            let meetings = boundary.meetings(&places, &step, limit);
            meetings
                .iter()
                .map(|m| m.time)
                .fold(f64::INFINITY, f64::min)
        };
        assert!(first(0.4).is_infinite());
        let time = first(1.0);
        let moved = |time: f64| -> Vec<DVec2> {
            places
                .iter()
                .zip(step)
                .map(|(&p, s)| p + s * time)
                .collect()
        };
        assert!(boundary.is_simple(&moved(0.999 * time)));
        assert!(!boundary.is_simple(&moved(1.001 * time)));
    }
}
