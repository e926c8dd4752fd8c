//! Keeps the parts of a boundary from meeting each other.
//!
//! A map that flips no triangle and whose boundary loops cross neither themselves nor each other is
//! one to one: each point is covered as often as the boundary winds around it. So the admissible
//! maps are known exactly; a barrier that grows where a boundary vertex comes near a boundary edge
//! (Smith and Schaefer 2015, §3) lets the descent see the others coming.

use glam::{DVec2, DVec3};

use super::boundary::{Boundary, Obstacle};
use super::objective::{Objective, Triangles};
use super::system::{Mode, NewtonSystem};
use crate::tolerance::{BARRIER_REACH, BARRIER_WEIGHT};

/// Triangles whose boundary must not meet itself.
pub(super) struct Apart<'a> {
    triangles: &'a Triangles,
    boundary: Boundary,
    /// How near something may come to each edge before it is pushed away.
    edge_reach: Vec<f64>,
    /// The same for the vertex that the edge starts from.
    vertex_reach: Vec<f64>,
}

/// A boundary vertex near a boundary edge.
struct Contact {
    /// The vertex and the ends of the edge.
    vertices: [u32; 3],
    /// From the nearest point of the edge to the vertex.
    normal: DVec2,
    /// Where on the edge that point lies, from 0 to 1.
    share: f64,
    distance: f64,
}

/// A contact, and within which distance it matters.
struct Push {
    contact: Contact,
    reach: f64,
}

impl<'a> Apart<'a> {
    /// Watches over the boundary of the triangles, whose vertices lie at `points` in space.
    pub(super) fn new(triangles: &'a Triangles, points: &[DVec3]) -> Self {
        let boundary = Boundary::new(triangles.corners());
        let lengths = boundary
            .edges()
            .iter()
            .map(|edge| points[edge[0] as usize].distance(points[edge[1] as usize]));
        let edge_reach: Vec<f64> = lengths.map(|length| BARRIER_REACH * length).collect();
        let mut shortest = vec![f64::INFINITY; points.len()];
        for (edge, &reach) in boundary.edges().iter().zip(&edge_reach) {
            for &end in edge {
                shortest[end as usize] = reach.min(shortest[end as usize]);
            }
        }
        let starts = boundary.edges().iter().map(|edge| edge[0] as usize);
        Self {
            vertex_reach: starts.map(|vertex| shortest[vertex]).collect(),
            edge_reach,
            boundary,
            triangles,
        }
    }

    /// Whether the boundary meets itself nowhere. Exact.
    pub(super) fn is_simple(&self, places: &[DVec2]) -> bool {
        self.boundary.is_simple(places)
    }

    /// Vertices within reach of edges, in a fixed order; `widened` is a factor on all reaches.
    fn pushes(&self, places: &[DVec2], widened: f64) -> Vec<Push> {
        let mut pushes = Vec::new();
        let edge_reach = |edge: usize| widened * self.edge_reach[edge];
        self.boundary
            .visit_near(places, edge_reach, |vertex, edge| {
                let reach = self.vertex_reach[vertex].min(self.edge_reach[edge]);
                let edges = self.boundary.edges();
                let vertices = [edges[vertex][0], edges[edge][0], edges[edge][1]];
                let contact = Contact::of(vertices, places);
                if contact.distance < widened * reach && contact.distance > 0.0 {
                    pushes.push(Push { contact, reach });
                }
            });
        pushes
    }
}

impl Objective for Apart<'_> {
    fn value(&self, places: &[DVec2]) -> f64 {
        let value = self.triangles.value(places);
        if !value.is_finite() || !self.is_simple(places) {
            return f64::INFINITY;
        }
        let pushes = self.pushes(places, 1.0);
        value + pushes.iter().map(Push::value).sum::<f64>()
    }

    fn expand_into(&self, places: &[DVec2], kept: f64, system: &mut NewtonSystem) {
        self.triangles.expand_into(places, kept, system);
        for push in self.pushes(places, 1.0) {
            push.expand_into(system);
        }
    }

    fn first_obstacle(&self, places: &[DVec2], step: &[DVec2]) -> f64 {
        // No farther than a step goes; longer ones are found out by the value of their map.
        let collapse = self.triangles.first_obstacle(places, step);
        let meetings = self.boundary.meetings(places, step, collapse.min(1.0));
        let times = meetings.iter().map(|meeting| meeting.time);
        times.fold(collapse, f64::min)
    }

    fn obstacles(&self, places: &[DVec2], step: &[DVec2], limit: f64) -> Vec<Obstacle> {
        let mut obstacles = self.triangles.obstacles(places, step, limit);
        obstacles.extend(self.boundary.meetings(places, step, limit));
        obstacles
    }

    fn couplings(&self, places: &[DVec2], widened: f64) -> Vec<[u32; 2]> {
        let pushes = self.pushes(places, widened);
        let pairs = pushes.iter().flat_map(|push| push.contact.pairs());
        pairs.collect()
    }
}

/// The distance between a vertex and an edge, given by its ends, and the derivative.
pub(super) fn gap(vertices: [u32; 3], places: &[DVec2]) -> (f64, Mode) {
    let contact = Contact::of(vertices, places);
    (contact.distance, contact.mode())
}

impl Contact {
    fn of(vertices: [u32; 3], places: &[DVec2]) -> Self {
        let [p, a, b] = vertices.map(|vertex| places[vertex as usize]);
        let along = b - a;
        let share = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let gap = p - a.lerp(b, share);
        let distance = gap.length();
        Self {
            vertices,
            normal: gap / distance,
            share,
            distance,
        }
    }

    /// The derivative of the distance.
    fn mode(&self) -> Mode {
        let n = self.normal;
        Mode {
            vertices: self.vertices,
            moves: [n, n * (self.share - 1.0), n * -self.share],
        }
    }

    /// The pairs of vertices that push each other.
    fn pairs(&self) -> [[u32; 2]; 2] {
        let [vertex, a, b] = self.vertices;
        [[vertex, a], [vertex, b]]
    }
}

impl Push {
    /// (reach / distance − 1)², times a weight that grows with the area in question.
    fn value(&self) -> f64 {
        self.weight() * (self.reach / self.contact.distance - 1.0).powi(2)
    }

    fn weight(&self) -> f64 {
        BARRIER_WEIGHT * self.reach * self.reach
    }

    /// Adds gradient and stiffness, without the part from the distance's own second derivatives:
    /// that is negative between vertices, and elsewhere of either sign.
    fn expand_into(&self, system: &mut NewtonSystem) {
        let (d, r) = (self.contact.distance, self.reach);
        let slope = -2.0 * self.weight() * (r / d - 1.0) * r / (d * d);
        let curvature =
            self.weight() * (2.0 * r * r / d.powi(4) + 4.0 * (r / d - 1.0) * r / d.powi(3));
        let mode = self.contact.mode();
        system.add_force(&mode, slope);
        system.add_stiffness(&mode, curvature);
    }
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
    fn the_barrier_has_the_slope_of_differences() {
        let (triangles, points, places) = pair([1.0, 1.9]);
        let apart = Apart::new(&triangles, &points);
        let mut places = places;
        places[4].x += 0.03;
        let barrier = |places: &[DVec2]| apart.value(places) - triangles.value(places);
        assert!(barrier(&places) > 0.0);
        let mut system = NewtonSystem::new(triangles.corners(), &points, vec![false; 6]).unwrap();
        system
            .plan(&apart.couplings(&places, 1.0), &places)
            .unwrap();
        system.clear();
        for push in apart.pushes(&places, 1.0) {
            push.expand_into(&mut system);
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
    fn a_stiff_aim_leads_a_step_the_way_asked_for() {
        let (triangles, points, places) = pair([1.0, 1.5]);
        let apart = Apart::new(&triangles, &points);
        let mut system = NewtonSystem::new(triangles.corners(), &points, vec![false; 6]).unwrap();
        let vertices = [4, 0, 2];
        let pairs = [[4, 0], [4, 2]];
        assert!(!system.couples(&pairs));
        system.plan(&pairs, &places).unwrap();
        assert!(system.couples(&pairs));
        system.clear();
        apart.expand_into(&places, 0.0, &mut system);
        let (distance, mode) = gap(vertices, &places);
        system.add_aim(&mode, -0.5 * distance, 1e3);
        let step = system.direction().unwrap().step;
        let along = mode.vertices.iter().zip(mode.moves);
        let closed: f64 = along.map(|(&v, m)| step[v as usize].dot(m)).sum();
        assert!(
            (closed + 0.5 * distance).abs() < 0.01 * distance,
            "{closed}"
        );
    }

    #[test]
    fn what_is_in_the_way_is_the_boundary_and_collapsing_triangles() {
        let (triangles, points, places) = pair([1.0, 1.5]);
        let apart = Apart::new(&triangles, &points);
        // The upper triangle comes down by 2, the tip of the lower one by 4.
        let step: Vec<DVec2> = [0.0, 0.0, -4.0, -2.0, -2.0, -2.0]
            .map(|y| DVec2::new(0.0, y))
            .into();
        let obstacles = apart.obstacles(&places, &step, 1.0);
        let first = apart.first_obstacle(&places, &step);
        // As a triangle, by its longest side, and as a vertex and an edge of the boundary.
        for vertices in [[0, 1, 2], [2, 0, 1]] {
            let met = obstacles.iter().find(|o| o.vertices == vertices);
            assert!((met.unwrap().time - 0.25).abs() < 1e-12);
        }
        assert!((first - 0.25).abs() < 1e-12, "{first}");
        assert!(
            obstacles
                .iter()
                .any(|o| o.vertices[0] == 4 && o.time > 0.25)
        );
        assert!(apart.obstacles(&places, &step, 0.2).is_empty());
    }
}
