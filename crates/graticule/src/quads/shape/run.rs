mod search;

use std::cell::OnceCell;

use glam::DVec3;
use rayon::prelude::*;

use super::colors::independent_groups;
use super::energy::{CornerTerm, raise, sum_of_powers};
use super::freedom::{Freedom, freedoms};
use super::ground::{Ground, Place};
use super::polygon::{View, least_sine, least_sine_of, regular_angle};
use super::proportions::wanted;
use super::{Net, ShapeError, ShapeOptions, ShapeQuality, ShapeReport, Shaped};
use crate::geometry::slide_towards;
use crate::measure::scaled_jacobian;
use crate::mesh::{PolygonConnectivity, PolygonSoup, SurfacePoint};
use crate::tolerance;
use crate::watch::{Stopped, Watch};

/// Fewest vertices that one thread moves.
const BATCH: usize = 64;

/// The power of the energy that raises poor polygons: near enough to the worst corner alone, and
/// still smooth.
const HIGH_POWER: u32 = 6;

/// Rounds of work on poor polygons at most, and the visits in each by steps and by search.
const RAISING_ROUNDS: usize = 6;
const RAISING_SWEEPS: usize = 6;
const SEARCHING_SWEEPS: usize = 3;

/// The share of a Newton step of the plain energy that is tried first. One vertex after the other,
/// whole steps take long to spread over a mesh; longer ones come further in eight sweeps than whole
/// ones in twelve (D. Young, *Iterative methods for solving partial difference equations of elliptic type*, 1954).
const OVER_RELAXATION: f64 = 1.7;

/// Times that quads are shaped again towards the proportions that they have come to: angles count,
/// and where they went against the proportions that the net began with, these give way. Each takes
/// away about half of what is left to gain.
const RELAXATIONS: usize = 2;

/// How good the polygons around a vertex are.
#[derive(Clone, Copy, Debug)]
struct Judgement {
    energy: f64,
    /// The least sine at a corner that the vertex takes part in.
    own_sine: f64,
    /// The least mean ratio there.
    own_ratio: f64,
    /// The least sine at any corner of the polygons, where the vertex can only turn the normal.
    least_sine: f64,
    /// The least cosine between the normal of a polygon and that of the surface at a corner.
    facing: f64,
}

impl Judgement {
    /// Whether all polygons are above the bounds below which none may become worse.
    fn is_fine(&self, floor: f64) -> bool {
        self.own_sine >= floor && self.least_sine >= floor && self.facing >= tolerance::FACING_QUAD
    }

    /// Whether nothing that was below `floor` has become worse, and nothing else has come below.
    fn is_harmless(&self, before: &Self, floor: f64) -> bool {
        self.own_sine >= before.own_sine.min(floor)
            && self.least_sine >= before.least_sine.min(floor)
            && self.facing >= before.facing.min(tolerance::FACING_QUAD)
    }
}

/// What a sweep aims at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Aim {
    /// The least sum of a power of the energies.
    Energy(u32),
    /// The greatest least mean ratio, by trying.
    Search,
}

/// The state of a run: everything at unit extent.
pub(in crate::quads) struct Run<'a> {
    ground: &'a Ground,
    mesh: PolygonConnectivity,
    freedoms: Vec<Freedom>,
    /// For each quad the length that its first and third side should have over that of the others.
    ratios: Vec<f64>,
    places: Vec<Place>,
    starts: Vec<DVec3>,
    /// For each vertex the mean length of its edges at the beginning.
    scales: Vec<f64>,
    /// How far each vertex may go in all.
    reaches: Vec<f64>,
    groups: Vec<Vec<u32>>,
    options: ShapeOptions,
}

impl<'a> Run<'a> {
    /// A run on part of a mesh may have vertices that must stay where they are.
    pub(in crate::quads) fn new(
        ground: &'a Ground,
        net: &Net<'_>,
        origins: &[SurfacePoint],
        options: ShapeOptions,
        is_held: impl Fn(usize) -> bool,
    ) -> Self {
        let places: Vec<_> = origins.iter().map(|&origin| ground.place(origin)).collect();
        let starts: Vec<_> = places.iter().map(|place| place.position).collect();
        let soup = PolygonSoup {
            positions: starts.clone(),
            polygons: net.polygons.clone(),
            ..PolygonSoup::default()
        };
        let mesh = PolygonConnectivity::of(&soup);
        let mut freedoms = freedoms(net, &mesh, ground, origins);
        for (vertex, freedom) in freedoms.iter_mut().enumerate() {
            if is_held(vertex) {
                *freedom = Freedom::Fixed;
            }
        }
        let ratios = wanted(&mesh, &starts, options.keep_proportions);
        let scales = mean_edge_lengths(&mesh, &starts);
        let mean_scale = scales.iter().sum::<f64>() / scales.len().max(1) as f64;
        // Vertices crammed together need more than their own edges to come apart.
        let reach = |scale: &f64| options.reach * scale.max(mean_scale);
        let groups = independent_groups(&mesh, |v| freedoms[v] != Freedom::Fixed);
        Self {
            reaches: scales.iter().map(reach).collect(),
            scales,
            ground,
            mesh,
            freedoms,
            ratios,
            places,
            starts,
            groups,
            options,
        }
    }

    /// Moves the vertices, with so many rounds of work on poor polygons at most; returns the number
    /// of sweeps.
    pub(in crate::quads) fn settle(
        &mut self,
        rounds: usize,
        watch: &Watch,
    ) -> Result<usize, Stopped> {
        let mut active = vec![true; self.places.len()];
        let mut sweeps = 0;
        while sweeps < self.options.sweeps && active.contains(&true) {
            active = self.sweep(&active, Aim::Energy(1), watch)?;
            sweeps += 1;
        }
        for _ in 0..rounds {
            let steps = self.raise_poor(Aim::Energy(HIGH_POWER), RAISING_SWEEPS, watch)?;
            let searches = self.raise_poor(Aim::Search, SEARCHING_SWEEPS, watch)?;
            sweeps += steps + searches;
            if searches == 0 {
                break;
            }
        }
        Ok(sweeps)
    }

    /// For each polygon the least sine of its corners over that of the regular polygon, negative
    /// where the polygon is turned over.
    pub(in crate::quads) fn qualities(&self) -> impl Iterator<Item = f64> {
        (0..self.mesh.polygon_count()).map(|polygon| self.polygon_quality(polygon))
    }

    /// For each vertex its point of the surface.
    pub(in crate::quads) fn origins(&self) -> impl Iterator<Item = SurfacePoint> {
        self.places.iter().map(|place| place.origin)
    }

    pub(super) fn shape(mut self, watch: &Watch) -> Result<Shaped, ShapeError> {
        let before = self.quality();
        let mut sweeps = 0;
        for _ in 0..RELAXATIONS {
            sweeps += self.settle(1, watch)?;
            let reached: Vec<DVec3> = self.places.iter().map(|place| place.position).collect();
            self.ratios = wanted(&self.mesh, &reached, self.options.keep_proportions);
        }
        sweeps += self.settle(RAISING_ROUNDS, watch)?;
        Ok(self.finish(before, sweeps))
    }

    /// Works on the polygons that are still poor, until none of their vertices moves any more.
    fn raise_poor(&mut self, aim: Aim, most: usize, watch: &Watch) -> Result<usize, Stopped> {
        let mut done = 0;
        while done < most {
            let poor = self.vertices_of_poor_polygons(aim);
            if !poor.contains(&true) {
                break;
            }
            done += 1;
            if !self.sweep(&poor, aim, watch)?.contains(&true) {
                break;
            }
        }
        Ok(done)
    }

    fn vertices_of_poor_polygons(&self, aim: Aim) -> Vec<bool> {
        let wanted = match aim {
            Aim::Energy(_) => tolerance::FAIR_QUAD,
            Aim::Search => tolerance::POOR_QUAD,
        };
        let mut marked = vec![false; self.places.len()];
        for polygon in 0..self.mesh.polygon_count() {
            if self.polygon_quality(polygon) < wanted {
                for &vertex in self.mesh.vertices(polygon) {
                    marked[vertex as usize] = true;
                }
            }
        }
        marked
    }

    /// Moves each active vertex once; returns which ones are near a vertex that moved.
    fn sweep(&mut self, active: &[bool], aim: Aim, watch: &Watch) -> Result<Vec<bool>, Stopped> {
        let floor = self.least_of_quads().max(tolerance::POOR_QUAD);
        let mut stirred = vec![false; active.len()];
        let groups = std::mem::take(&mut self.groups);
        for group in &groups {
            watch.check()?;
            let movable: Vec<u32> = group
                .iter()
                .copied()
                .filter(|&vertex| active[vertex as usize])
                .collect();
            let better = |&vertex: &u32| self.better_place(vertex as usize, aim, floor);
            // A call into the pool costs more than the moves of a few vertices.
            let moves: Vec<Option<Place>> = if movable.len() < 2 * BATCH {
                movable.iter().map(better).collect()
            } else {
                let several = movable.par_iter().with_min_len(BATCH);
                several.map(better).collect()
            };
            for (vertex, better) in movable.into_iter().zip(moves) {
                if let Some(place) = better {
                    self.put(vertex as usize, place, &mut stirred);
                }
            }
        }
        self.groups = groups;
        Ok(stirred)
    }

    fn put(&mut self, vertex: usize, place: Place, stirred: &mut [bool]) {
        let way = place.position.distance(self.places[vertex].position);
        self.places[vertex] = place;
        if way <= tolerance::VERTEX_AT_REST * self.scales[vertex] {
            return;
        }
        for &corner in self.mesh.corners_at(vertex) {
            for &other in self.mesh.vertices(self.mesh.polygon(corner)) {
                stirred[other as usize] = true;
            }
        }
    }

    /// A place for the vertex that is better than the one it has.
    fn better_place(&self, vertex: usize, aim: Aim, floor: f64) -> Option<Place> {
        match aim {
            Aim::Energy(power) => self.step(vertex, power, floor),
            Aim::Search => self.search(vertex, floor),
        }
    }

    /// One Newton step, shortened until it helps.
    fn step(&self, vertex: usize, power: u32, floor: f64) -> Option<Place> {
        let here = self.places[vertex];
        let directions = self.directions(vertex)?;
        let terms = self.terms(vertex);
        let x = here.position;
        let blur = blur(&terms, x);
        let derivatives = terms
            .iter()
            .map(|term| term.derivatives(x, blur, directions));
        let mut derivatives = sum_of_powers(derivatives, power);
        if directions[1] == DVec3::ZERO {
            derivatives.hessian[2] = derivatives.hessian[0];
        }
        let step = derivatives.newton_step();
        let step = step.clamp_length_max(0.5 * self.scales[vertex]);
        if step.length() <= 0.1 * tolerance::VERTEX_AT_REST * self.scales[vertex] {
            return None;
        }
        let before = OnceCell::new();
        let before = || *before.get_or_init(|| self.judge(vertex, here, power, blur));
        let first = if power == 1 { OVER_RELAXATION } else { 1.0 };
        [first, 0.4, 0.1].into_iter().find_map(|share| {
            let target = x + directions[0] * (share * step.x) + directions[1] * (share * step.y);
            let place = self.reached(vertex, target)?;
            let after = self.judge(vertex, place, power, blur);
            let is_better = after.energy < derivatives.value
                && (after.is_fine(floor) || after.is_harmless(&before(), floor));
            is_better.then_some(place)
        })
    }

    /// The directions in which the vertex may go; the second one is zero on lines.
    fn directions(&self, vertex: usize) -> Option<[DVec3; 2]> {
        let here = self.places[vertex];
        match self.freedoms[vertex] {
            Freedom::Surface => {
                let normal = here.normal.try_normalize()?;
                let u = normal.any_orthonormal_vector();
                Some([u, normal.cross(u)])
            }
            Freedom::Line => {
                let halfedge = self
                    .ground
                    .lines
                    .halfedge_at(&self.ground.surface, here.origin)?;
                let along = self.ground.surface.halfedge_vector(halfedge);
                Some([along.try_normalize()?, DVec3::ZERO])
            }
            Freedom::Fixed => None,
        }
    }

    /// The place near `target` that the vertex can reach on its surface or line; `None` beyond its
    /// reach.
    fn reached(&self, vertex: usize, target: DVec3) -> Option<Place> {
        let origin = self.places[vertex].origin;
        let origin = match self.freedoms[vertex] {
            Freedom::Surface => slide_towards(&self.ground.surface, origin, target),
            Freedom::Line => {
                let halfedge = self
                    .ground
                    .lines
                    .halfedge_at(&self.ground.surface, origin)?;
                self.ground
                    .lines
                    .slide_towards(&self.ground.surface, halfedge, target)
            }
            Freedom::Fixed => return None,
        };
        let place = self.ground.place(origin);
        let way = place.position.distance(self.starts[vertex]);
        (way <= self.reaches[vertex]).then_some(place)
    }

    /// The corners around a vertex that its position takes part in.
    fn terms(&self, vertex: usize) -> Vec<CornerTerm> {
        let corners = self.mesh.corners_at(vertex);
        let mut terms = Vec::with_capacity(3 * corners.len());
        for &corner in corners {
            let view = self.view(self.mesh.polygon(corner), |v| &self.places[v as usize]);
            terms.extend(self.terms_at(corner, view.normal));
        }
        terms
    }

    /// The corners of a polygon that the vertex of `corner` takes part in.
    fn terms_at(&self, corner: u32, normal: DVec3) -> [CornerTerm; 3] {
        let polygon = self.mesh.polygon(corner);
        let angle = regular_angle(self.mesh.vertices(polygon).len());
        let [next, previous] = [self.mesh.next(corner), self.mesh.previous(corner)];
        let at = |corner: u32| self.places[self.mesh.origin(corner) as usize].position;
        let fixed_out = at(self.mesh.next(next)) - at(next);
        let fixed_back = at(self.mesh.previous(previous)) - at(previous);
        [
            (corner, (at(next), -1.0), (at(previous), -1.0)),
            (next, (fixed_out, 0.0), (-at(next), 1.0)),
            (previous, (-at(previous), 1.0), (fixed_back, 0.0)),
        ]
        .map(|(corner, out, back)| CornerTerm {
            out,
            back,
            normal,
            ratio: self.ratio(polygon, corner),
            angle,
        })
    }

    /// The proportion wanted at a corner: of the side that leaves it to the side that comes to it.
    fn ratio(&self, polygon: usize, corner: u32) -> f64 {
        if (corner - self.mesh.corners(polygon).start).is_multiple_of(2) {
            self.ratios[polygon]
        } else {
            1.0 / self.ratios[polygon]
        }
    }

    /// How good the polygons around a vertex are with the vertex at `place`.
    fn judge(&self, vertex: usize, place: Place, power: u32, blur: f64) -> Judgement {
        let x = place.position;
        let mut judgement = Judgement {
            energy: 0.0,
            own_sine: f64::INFINITY,
            own_ratio: f64::INFINITY,
            least_sine: f64::INFINITY,
            facing: f64::INFINITY,
        };
        let placed = |other: u32| {
            if other as usize == vertex {
                &place
            } else {
                &self.places[other as usize]
            }
        };
        for &corner in self.mesh.corners_at(vertex) {
            let polygon = self.mesh.polygon(corner);
            let view = self.view(polygon, placed);
            judgement.facing = judgement.facing.min(view.facing);
            for term in self.terms_at(corner, view.normal) {
                let grade = term.grade(x, blur);
                judgement.energy += raise(grade.value, power);
                judgement.own_sine = judgement.own_sine.min(grade.sine);
                judgement.own_ratio = judgement.own_ratio.min(grade.mean_ratio);
            }
            let sine = self.least_sine_away_from(corner, view.normal, placed);
            judgement.least_sine = judgement.least_sine.min(sine);
        }
        judgement.least_sine = judgement.least_sine.min(judgement.own_sine);
        judgement
    }

    fn view<'p>(&self, polygon: usize, place: impl Fn(u32) -> &'p Place) -> View {
        let vertices = self.mesh.vertices(polygon).iter();
        View::of(vertices.map(|&vertex| place(vertex)))
    }

    /// The least sine of the polygon of `corner` at those of its corners that the vertex of `corner`
    /// does not take part in.
    fn least_sine_away_from<'p>(
        &self,
        corner: u32,
        normal: DVec3,
        place: impl Fn(u32) -> &'p Place,
    ) -> f64 {
        let polygon = self.mesh.polygon(corner);
        let vertices = self.mesh.vertices(polygon);
        let count = vertices.len();
        let own = (corner - self.mesh.corners(polygon).start) as usize;
        let away = own + 2..own + count - 1;
        least_sine_of(away, count, normal, |k| place(vertices[k]).position)
    }

    /// The quality of a polygon as it is.
    fn polygon_quality(&self, polygon: usize) -> f64 {
        let vertices = self.mesh.vertices(polygon);
        let place = |vertex: u32| &self.places[vertex as usize];
        let normal = self.view(polygon, place).normal;
        least_sine(vertices.len(), normal, |k| place(vertices[k]).position)
    }

    fn least_of_quads(&self) -> f64 {
        (0..self.mesh.polygon_count())
            .into_par_iter()
            .filter(|&polygon| self.mesh.vertices(polygon).len() == 4)
            .map(|polygon| self.polygon_quality(polygon))
            .reduce(|| f64::INFINITY, f64::min)
    }

    fn quality(&self) -> ShapeQuality {
        let quads = (0..self.mesh.polygon_count()).filter_map(|polygon| {
            let quad: &[u32; 4] = self.mesh.vertices(polygon).try_into().ok()?;
            Some(scaled_jacobian(
                quad.map(|vertex| self.places[vertex as usize].position),
            ))
        });
        ShapeQuality::of(&quads.collect::<Vec<_>>())
    }

    fn finish(self, before: ShapeQuality, sweeps: usize) -> Shaped {
        let [low, high] = self.ground.surface.bounding_box();
        let ways = self.places.iter().zip(&self.starts);
        let ways: Vec<f64> = ways
            .map(|(place, start)| place.position.distance(*start))
            .collect();
        let report = ShapeReport {
            before,
            after: self.quality(),
            moved_vertices: ways.iter().filter(|way| **way > 0.0).count(),
            longest_way: 100.0 * ways.iter().copied().fold(0.0, f64::max) / high.distance(low),
            sweeps,
        };
        Shaped {
            origins: self.places.into_iter().map(|place| place.origin).collect(),
            report,
        }
    }
}

/// What inverted corners are blurred by: 0 where all corners have an area.
fn blur(terms: &[CornerTerm], x: DVec3) -> f64 {
    let extent = terms.iter().map(|term| term.extent(x)).sum::<f64>() / terms.len() as f64;
    let least = terms
        .iter()
        .map(|term| term.area(x))
        .fold(f64::INFINITY, f64::min);
    let small = tolerance::FLAT_CORNER * extent;
    if least > small {
        0.0
    } else {
        (small * (2.0 * small - least)).sqrt()
    }
}

fn mean_edge_lengths(mesh: &PolygonConnectivity, positions: &[DVec3]) -> Vec<f64> {
    let mean = |vertex: usize| {
        let corners = mesh.corners_at(vertex);
        let length = |&corner: &u32| {
            let at = |corner: u32| positions[mesh.origin(corner) as usize];
            at(corner).distance(at(mesh.next(corner)))
                + at(corner).distance(at(mesh.previous(corner)))
        };
        corners.iter().map(length).sum::<f64>() / (2.0 * corners.len().max(1) as f64)
    };
    (0..mesh.vertex_count()).map(mean).collect()
}
