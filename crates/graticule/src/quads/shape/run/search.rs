//! The place of a vertex found by trying, where steps along derivatives end.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{Judgement, Place, Run};
use crate::tolerance;

/// Directions and step lengths (over the mean edge length) of a search.
const SEARCH_DIRECTIONS: u32 = 12;
const SEARCH_STEPS: [f64; 4] = [0.3, 0.12, 0.04, 0.012];

impl Run<'_> {
    /// The best place found where the least mean ratio is larger than now: between the neighbours, or
    /// on ever smaller circles around the best one before.
    pub(super) fn search(&self, vertex: usize, floor: f64) -> Option<Place> {
        let [u, v] = self.directions(vertex)?;
        let here = self.places[vertex];
        let before = self.judge(vertex, here, 1, 0.0);
        let corners = self.worst_corners_first(vertex);
        let mut best = (here, before.own_ratio);
        let mut consider = |target: DVec3| {
            if let Some(place) = self.reached(vertex, target)
                && let Some(ratio) =
                    self.raised_ratio((vertex, place), &corners, (best.1, &before), floor)
            {
                best = (place, ratio);
            }
            best.0.position
        };
        let mut centre = consider(self.middle_of_neighbors(vertex));
        for length in SEARCH_STEPS {
            let around = centre;
            for direction in 0..SEARCH_DIRECTIONS {
                let turn = f64::from(direction) / f64::from(SEARCH_DIRECTIONS);
                let (sine, cosine) = libm::sincos(TAU * turn);
                centre =
                    consider(around + (u * cosine + v * sine) * (length * self.scales[vertex]));
            }
        }
        (best.1 > before.own_ratio).then_some(best.0)
    }

    /// The corners at a vertex, those of the polygons with the least mean ratio first: they tell
    /// soonest that a place is no better.
    fn worst_corners_first(&self, vertex: usize) -> Vec<u32> {
        let x = self.places[vertex].position;
        let mut corners: Vec<(f64, u32)> = (self.mesh.corners_at(vertex).iter())
            .map(|&corner| {
                let view = self.view(self.mesh.polygon(corner), |v| &self.places[v as usize]);
                let grades = self.terms_at(corner, view.normal).map(|t| t.grade(x, 0.0));
                let ratios = grades.iter().map(|grade| grade.mean_ratio);
                (ratios.fold(f64::INFINITY, f64::min), corner)
            })
            .collect();
        corners.sort_by(|a, b| a.0.total_cmp(&b.0));
        corners.into_iter().map(|(_, corner)| corner).collect()
    }

    /// The least mean ratio around a vertex with the vertex at `place`, if it is above `least` and
    /// nothing has become worse than `before` below `floor`.
    fn raised_ratio(
        &self,
        (vertex, place): (usize, Place),
        corners: &[u32],
        (least, before): (f64, &Judgement),
        floor: f64,
    ) -> Option<f64> {
        let placed = |other: u32| {
            if other as usize == vertex {
                &place
            } else {
                &self.places[other as usize]
            }
        };
        let mut lowest = f64::INFINITY;
        for &corner in corners {
            let polygon = self.mesh.polygon(corner);
            let view = self.view(polygon, placed);
            let terms = self.terms_at(corner, view.normal);
            let mut own_sine = f64::INFINITY;
            for term in terms {
                let grade = term.grade(place.position, 0.0);
                lowest = lowest.min(grade.mean_ratio);
                own_sine = own_sine.min(grade.sine);
            }
            // Not `<=`: what is not a number is no better either.
            let is_raised = lowest > least;
            if !is_raised || view.facing < before.facing.min(tolerance::FACING_QUAD) {
                return None;
            }
            let least_sine = self.least_sine_away_from(corner, view.normal, placed);
            if own_sine < before.own_sine.min(floor)
                || least_sine.min(own_sine) < before.least_sine.min(floor)
            {
                return None;
            }
        }
        Some(lowest)
    }

    fn middle_of_neighbors(&self, vertex: usize) -> DVec3 {
        let corners = self.mesh.corners_at(vertex);
        let sides = corners
            .iter()
            .flat_map(|&corner| [self.mesh.next(corner), self.mesh.previous(corner)]);
        let sum: DVec3 = sides
            .map(|corner| self.places[self.mesh.origin(corner) as usize].position)
            .sum();
        sum / (2 * corners.len()).max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use graticule_fixtures::{Noise, grid};

    use super::super::super::{Ground, Net, ShapeOptions};
    use super::*;
    use crate::mesh::{Polygons, Surface, SurfacePoint, VertexId};

    /// A net of crooked quads on a plane of triangles twice as fine.
    fn crooked() -> (Surface, Vec<SurfacePoint>, Polygons) {
        let plane = grid(8.0, 8.0, 16, 16);
        let surface = Surface::from_triangles(plane.positions, &plane.triangles).unwrap();
        let mesh = surface.mesh();
        let mut noise = Noise::new(5);
        let mut origins = Vec::new();
        let mut polygons = Polygons::default();
        for y in 0..9_u32 {
            for x in 0..9_u32 {
                let mut place = |at: u32| {
                    let inside = at > 0 && at < 8;
                    2 * at + u32::from(inside && noise.signed() > 0.0)
                };
                let vertex = VertexId(place(y) * 17 + place(x));
                let corner = mesh.halfedges().find(|&side| mesh.origin(side) == vertex);
                origins.push(SurfacePoint::at_corner(corner.unwrap()));
                if x < 8 && y < 8 {
                    let first = y * 9 + x;
                    polygons.push(&[first, first + 1, first + 10, first + 9]);
                }
            }
        }
        (surface, origins, polygons)
    }

    #[test]
    fn a_ratio_judged_early_is_that_of_the_whole_judgement() {
        let (surface, origins, polygons) = crooked();
        let ground = Ground::of(&surface, &[]);
        let net = Net {
            surface: &surface,
            features: &[],
            polygons: &polygons,
            feature_edges: &[],
        };
        let run = Run::new(&ground, &net, &origins, ShapeOptions::default(), |_| false);
        let (floor, mut noise) = (tolerance::POOR_QUAD, Noise::new(6));
        let (mut taken, mut left) = (0, 0);
        for vertex in (0..run.places.len()).filter(|&v| run.directions(v).is_some()) {
            let here = run.places[vertex];
            let before = run.judge(vertex, here, 1, 0.0);
            let corners = run.worst_corners_first(vertex);
            for _ in 0..8 {
                let offset = DVec3::new(noise.signed(), noise.signed(), 0.0);
                let Some(place) = run.reached(vertex, here.position + 0.03 * offset) else {
                    continue;
                };
                let after = run.judge(vertex, place, 1, 0.0);
                let is_better =
                    after.own_ratio > before.own_ratio && after.is_harmless(&before, floor);
                let least = (before.own_ratio, &before);
                let found = run.raised_ratio((vertex, place), &corners, least, floor);
                assert_eq!(found, is_better.then_some(after.own_ratio));
                *(if is_better { &mut taken } else { &mut left }) += 1;
            }
        }
        assert!(taken > 20 && left > 20, "{taken} {left}");
    }
}
