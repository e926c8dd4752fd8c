//! Keeps the parts of a boundary from meeting each other.
//!
//! A map that flips no triangle and whose boundary loops cross neither themselves nor each other is
//! one to one: each point is covered as often as the boundary winds around it. So the admissible
//! maps are known exactly; a barrier that grows where a boundary vertex comes near a boundary edge
//! (Smith and Schaefer 2015, §3) lets the descent see the others coming.

use glam::{DVec2, DVec3};
use robust::{Coord, orient2d};

use super::objective::{Objective, Triangles};
use super::system::NewtonSystem;
use crate::tolerance::{BARRIER_REACH, BARRIER_WEIGHT};

/// Triangles whose boundary must not meet itself.
pub(super) struct Apart<'a> {
    triangles: &'a Triangles,
    boundary: Boundary,
}

/// The boundary of triangles.
pub(super) struct Boundary {
    /// Edges of the boundary, the surface to their left; each boundary vertex starts one.
    rim: Vec<[u32; 2]>,
    /// How near something may come to each edge before it is pushed away.
    edge_reach: Vec<f64>,
    /// The same for the vertex that the edge starts from.
    vertex_reach: Vec<f64>,
}

/// A boundary vertex near a boundary edge.
struct Contact {
    vertex: u32,
    ends: [u32; 2],
    /// From the nearest point of the edge to the vertex.
    normal: DVec2,
    /// Where on the edge that point lies, from 0 to 1.
    share: f64,
    distance: f64,
    reach: f64,
}

impl Boundary {
    /// The boundary of triangles whose vertices lie at `points` in space.
    pub(super) fn new(triangles: &[[u32; 3]], points: &[DVec3]) -> Self {
        let rim = boundary_edges(triangles);
        let lengths: Vec<f64> = rim
            .iter()
            .map(|edge| points[edge[0] as usize].distance(points[edge[1] as usize]))
            .collect();
        let mut shortest = vec![f64::INFINITY; points.len()];
        for (edge, &length) in rim.iter().zip(&lengths) {
            for &end in edge {
                shortest[end as usize] = length.min(shortest[end as usize]);
            }
        }
        let vertex_reach = rim
            .iter()
            .map(|edge| BARRIER_REACH * shortest[edge[0] as usize]);
        Self {
            vertex_reach: vertex_reach.collect(),
            edge_reach: lengths
                .iter()
                .map(|length| BARRIER_REACH * length)
                .collect(),
            rim,
        }
    }

    /// Whether the boundary meets itself nowhere. Exact.
    pub(super) fn is_simple(&self, places: &[DVec2]) -> bool {
        let segments: Vec<_> = self
            .rim
            .iter()
            .map(|edge| edge.map(|v| places[v as usize]))
            .collect();
        let mut order: Vec<usize> = (0..segments.len()).collect();
        let left = |index: usize| segments[index][0].x.min(segments[index][1].x);
        order.sort_by(|&a, &b| left(a).total_cmp(&left(b)));
        for (rank, &first) in order.iter().enumerate() {
            let right = segments[first][0].x.max(segments[first][1].x);
            let later = order[rank + 1..]
                .iter()
                .take_while(|&&second| left(second) <= right);
            for &second in later {
                if self.meet(first, second, &segments) {
                    return false;
                }
            }
        }
        true
    }

    fn meet(&self, first: usize, second: usize, segments: &[[DVec2; 2]]) -> bool {
        let [[a, b], [c, d]] = [self.rim[first], self.rim[second]];
        let [p, q] = [segments[first], segments[second]];
        match (b == c, a == d) {
            (false, false) => segments_meet(p, q),
            (true, _) => folds_back(p[0], p[1], q[1]),
            (_, true) => folds_back(q[0], q[1], p[1]),
        }
    }

    /// Vertices within reach of edges, in a fixed order.
    fn contacts(&self, places: &[DVec2]) -> Vec<Contact> {
        let at = |vertex: u32| places[vertex as usize];
        let left = |edge: &[u32; 2]| at(edge[0]).x.min(at(edge[1]).x);
        let mut order: Vec<usize> = (0..self.rim.len()).collect();
        order.sort_by(|&a, &b| left(&self.rim[a]).total_cmp(&left(&self.rim[b])));
        let widest = self
            .rim
            .iter()
            .map(|e| (at(e[0]).x - at(e[1]).x).abs())
            .fold(0.0, f64::max);
        let mut contacts = Vec::new();
        for (index, &[vertex, _]) in self.rim.iter().enumerate() {
            let (place, reach) = (at(vertex), self.vertex_reach[index]);
            let first = order.partition_point(|&e| left(&self.rim[e]) < place.x - reach - widest);
            let near = order[first..]
                .iter()
                .take_while(|&&e| left(&self.rim[e]) <= place.x + reach);
            contacts.extend(near.filter_map(|&edge| {
                let reach = reach.min(self.edge_reach[edge]);
                contact(
                    vertex,
                    self.rim[edge],
                    [place, at(self.rim[edge][0]), at(self.rim[edge][1])],
                    reach,
                )
            }));
        }
        contacts
    }
}

impl<'a> Apart<'a> {
    /// Watches over the boundary of the triangles, whose vertices lie at `points` in space.
    pub(super) fn new(triangles: &'a Triangles, points: &[DVec3]) -> Self {
        Self {
            boundary: Boundary::new(triangles.corners(), points),
            triangles,
        }
    }

    /// Whether the boundary meets itself nowhere. Exact.
    pub(super) fn is_simple(&self, places: &[DVec2]) -> bool {
        self.boundary.is_simple(places)
    }
}

impl Objective for Apart<'_> {
    fn value(&self, places: &[DVec2]) -> f64 {
        let value = self.triangles.value(places);
        if !value.is_finite() || !self.is_simple(places) {
            return f64::INFINITY;
        }
        value
            + self
                .boundary
                .contacts(places)
                .iter()
                .map(Contact::value)
                .sum::<f64>()
    }

    fn expand_into(&self, places: &[DVec2], kept: f64, system: &mut NewtonSystem) {
        self.triangles.expand_into(places, kept, system);
        for contact in self.boundary.contacts(places) {
            contact.expand_into(system);
        }
    }

    fn first_obstacle(&self, places: &[DVec2], step: &[DVec2]) -> f64 {
        // Steps through the boundary are found by the value of the map they lead to.
        self.triangles.first_obstacle(places, step)
    }
}

fn contact(vertex: u32, ends: [u32; 2], [p, a, b]: [DVec2; 3], reach: f64) -> Option<Contact> {
    if ends.contains(&vertex) {
        return None;
    }
    let along = b - a;
    let share = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    let gap = p - a.lerp(b, share);
    let distance = gap.length();
    (distance < reach && distance > 0.0).then(|| Contact {
        vertex,
        ends,
        normal: gap / distance,
        share,
        distance,
        reach,
    })
}

impl Contact {
    /// (reach / distance − 1)², times a weight that grows with the area in question.
    fn value(&self) -> f64 {
        self.weight() * (self.reach / self.distance - 1.0).powi(2)
    }

    fn weight(&self) -> f64 {
        BARRIER_WEIGHT * self.reach * self.reach
    }

    /// Adds gradient and stiffness. Vertices stay uncoupled in the matrix: with v the derivative of
    /// the distance, v vᵀ is at most 2 |vᵢ| n nᵀ at each vertex i, as the lengths sum to 2.
    fn expand_into(&self, system: &mut NewtonSystem) {
        let (d, r) = (self.distance, self.reach);
        let slope = -2.0 * self.weight() * (r / d - 1.0) * r / (d * d);
        let curvature =
            self.weight() * (2.0 * r * r / d.powi(4) + 4.0 * (r / d - 1.0) * r / d.powi(3));
        let n = self.normal;
        let lengths = [1.0, 1.0 - self.share, self.share];
        let [a, b] = self.ends;
        for ((vertex, length), sign) in [self.vertex, a, b]
            .into_iter()
            .zip(lengths)
            .zip([1.0, -1.0, -1.0])
        {
            let stiffness = 2.0 * length * curvature;
            let entries = [n.x * n.x, n.x * n.y, n.y * n.y].map(|entry| stiffness * entry);
            system.add_at_vertex(vertex, n * (sign * length * slope), entries);
        }
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
    use crate::flatten::injective::energy::DistortionEnergy;
    use crate::measure::SourceTriangle;

    /// Two triangles on edge (0, 1), their tips at the given height over the middle.
    fn pair(tips: [f64; 2]) -> (Triangles, Vec<DVec3>, Vec<DVec2>) {
        let corners = vec![[0, 1, 2], [3, 4, 5]];
        let regular = SourceTriangle::from_lengths([1.0; 3]).unwrap();
        let places = [
            (0.0, 0.0),
            (1.0, 0.0),
            (0.5, tips[0]),
            (0.0, 3.0),
            (0.5, 3.0 - tips[1]),
            (1.0, 3.0),
        ];
        let places: Vec<DVec2> = places.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
        let points = places.iter().map(|p| p.extend(0.0)).collect();
        let triangles = Triangles::new(
            DistortionEnergy::default(),
            corners,
            vec![regular; 2],
            vec![1.0; 2],
        );
        (triangles, points, places)
    }

    #[test]
    fn tips_that_cross_an_edge_are_not_admitted() {
        for (tips, simple) in [
            ([1.0, 1.0], true),
            ([1.0, 1.9], true),
            ([1.0, 2.0], false),
            ([2.0, 2.0], false),
        ] {
            let (triangles, points, places) = pair(tips);
            let apart = Apart::new(&triangles, &points);
            assert_eq!(apart.is_simple(&places), simple, "{tips:?}");
            assert_eq!(apart.value(&places).is_finite(), simple);
        }
    }

    #[test]
    fn the_barrier_has_the_slope_of_differences_and_a_stiffness_above_theirs() {
        let (triangles, points, places) = pair([1.0, 1.9]);
        let apart = Apart::new(&triangles, &points);
        let mut places = places;
        places[4].x += 0.03;
        let barrier = |places: &[DVec2]| apart.value(places) - triangles.value(places);
        assert!(barrier(&places) > 0.0);
        let mut system = NewtonSystem::new(triangles.corners(), &points, vec![false; 6]).unwrap();
        system.clear();
        for contact in apart.boundary.contacts(&places) {
            contact.expand_into(&mut system);
        }
        let step = 1e-6;
        for vertex in 0..6 {
            for axis in [DVec2::X, DVec2::Y] {
                let at = |by: f64| {
                    let mut moved = places.clone();
                    moved[vertex] += axis * by;
                    barrier(&moved)
                };
                let difference = (at(step) - at(-step)) / (2.0 * step);
                let slope = system.gradient[vertex].dot(axis);
                assert!(
                    (difference - slope).abs() < 1e-5,
                    "{vertex}: {difference} {slope}"
                );
            }
        }
    }

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
}
