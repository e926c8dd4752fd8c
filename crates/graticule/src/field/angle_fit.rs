//! The smoothest angles for given jumps: least squares, without any choice of branch left.

use std::sync::Arc;

use glam::DVec3;

use super::matching::Matching;
use super::{FieldDomain, FieldError, Guidance};
use crate::mesh::{EdgeId, HalfedgeId, PerCorner, PerVertex, VertexId};
use crate::solve::{Cholesky, Placement, Symbolic, SymmetricMatrix};
use crate::tolerance::{ANGLE_ANCHOR, EDGE_WEIGHT_RANGE, WIDEST_TURN};

/// Solves for guidance, whose pull weakens where the field cannot follow: each needs the one before.
const GUIDED_SOLVES: usize = 2;

/// Solves in which edges that turn too far are stiffened, where a fit should not give up.
pub(super) const STIFFENED_SOLVES: usize = 8;

/// By what an edge that turns too far is stiffened each time.
const STIFFENING: f64 = 6.0;

/// Stands for no place among the free vertices.
const HELD: u32 = u32::MAX;

/// Finds angles that minimise `ρ Σ w turn² + (1 - ρ) Σ mass pull (1 - cos(N off)) / (N² / 2)` over
/// some vertices with the others held: the energy of [`smooth_field`](super::smooth_field()) in
/// angles, for which jumps are given rather than found.
pub(super) struct AngleFit<'a> {
    domain: &'a FieldDomain<'a>,
    guidance: &'a Guidance,
    smoothing: f64,
    mean_area: f64,
    /// What sizes add to the transports.
    graded: Option<PerCorner<f64>>,
    /// For each vertex its place among the free ones, or [`HELD`].
    places: PerVertex<u32>,
}

impl<'a> AngleFit<'a> {
    pub(super) fn new(domain: &'a FieldDomain<'a>, guidance: &'a Guidance, smoothing: f64) -> Self {
        let areas = domain.areas();
        Self {
            mean_area: areas.iter().sum::<f64>() / areas.len() as f64,
            graded: guidance.graded_turns(domain.triangulation()),
            places: PerVertex::filled(areas.len(), HELD),
            domain,
            guidance,
            smoothing,
        }
    }

    /// Replaces the angles of the `free` vertices.
    ///
    /// Edges at these vertices turn by less than half a step afterwards, if that can be had with so
    /// many solves more: then the jumps are those that anyone would read off the angles.
    pub(super) fn fit(
        &mut self,
        angles: &mut PerVertex<f64>,
        matching: &Matching,
        free: &[VertexId],
        stiffened_solves: usize,
    ) -> Result<(), FieldError> {
        for (place, &vertex) in free.iter().enumerate() {
            self.places[vertex] = place as u32;
        }
        let fitted = self.solve_all(angles, matching, free, stiffened_solves);
        for &vertex in free {
            self.places[vertex] = HELD;
        }
        fitted
    }

    fn solve_all(
        &self,
        angles: &mut PerVertex<f64>,
        matching: &Matching,
        free: &[VertexId],
        stiffened_solves: usize,
    ) -> Result<(), FieldError> {
        let mut run = Run {
            fit: self,
            matching,
            free,
            edges: self.edges_of(free),
            symbolic: None,
        };
        run.solve(angles, 0.0)?;
        if free.iter().any(|&v| self.guidance.pull(v).length() > 0.0) {
            for _ in 0..GUIDED_SOLVES {
                run.solve(angles, 1.0)?;
            }
        }
        let mut guided = 1.0;
        for _ in 0..stiffened_solves {
            if !run.stiffen(angles) {
                break;
            }
            run.solve(angles, guided)?;
            // Guidance lets go little by little: it may be what turns the edges.
            guided /= 2.0;
        }
        Ok(())
    }

    /// The edges at the free vertices with their weights.
    fn edges_of(&self, free: &[VertexId]) -> Vec<(EdgeId, f64)> {
        let mesh = self.domain.surface().mesh();
        let mut edges = Vec::with_capacity(4 * free.len());
        for &vertex in free {
            for halfedge in mesh.outgoing(vertex) {
                // The last edge round a boundary vertex only arrives.
                for side in [halfedge, halfedge.previous()] {
                    let [from, to] = mesh.ends(side);
                    if from == vertex || mesh.is_boundary_edge(mesh.edge(side)) {
                        let other = if from == vertex { to } else { from };
                        // Once for each edge: at the end that comes first.
                        if self.places[vertex] < self.places[other] {
                            edges.push(mesh.edge(side));
                        }
                    }
                }
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let weighted = edges.into_iter();
        weighted
            .map(|edge| (edge, stable_weight(self.domain, edge)))
            .collect()
    }

    /// The area of a vertex over the mean.
    fn mass(&self, vertex: VertexId) -> f64 {
        self.domain.areas()[vertex] / self.mean_area
    }
}

/// One fit: its edges, and the plan of a matrix whose pattern stays the same.
struct Run<'a> {
    fit: &'a AngleFit<'a>,
    matching: &'a Matching,
    free: &'a [VertexId],
    edges: Vec<(EdgeId, f64)>,
    symbolic: Option<Arc<Symbolic>>,
}

impl Run<'_> {
    /// One linear solve, guidance with this share of its weight.
    fn solve(&mut self, angles: &mut PerVertex<f64>, guided: f64) -> Result<(), FieldError> {
        let (matrix, side) = self.system(angles, guided)?;
        let symbolic = if let Some(symbolic) = &self.symbolic {
            Arc::clone(symbolic)
        } else {
            let positions = self.fit.domain.surface().positions();
            let points: Vec<DVec3> = self.free.iter().map(|&v| positions[v]).collect();
            let ordering = Placement::at(&points).ordering(matrix.lower().pattern())?;
            let symbolic = Symbolic::new(&matrix, &ordering)?;
            Arc::clone(self.symbolic.insert(symbolic))
        };
        let solution = Cholesky::factor(&symbolic, &matrix)?.solve(&side)?;
        for (&vertex, angle) in self.free.iter().zip(solution.values) {
            angles[vertex] = angle;
        }
        Ok(())
    }

    fn system(
        &self,
        angles: &PerVertex<f64>,
        guided: f64,
    ) -> Result<(SymmetricMatrix, Vec<f64>), FieldError> {
        let fit = self.fit;
        let mut side = Vec::with_capacity(self.free.len());
        let mut diagonal = Vec::with_capacity(self.free.len());
        for &vertex in self.free {
            let anchor = ANGLE_ANCHOR * fit.mass(vertex).max(f64::EPSILON);
            let (pull, off) = self.pull(angles[vertex], vertex);
            let pull = guided * pull;
            diagonal.push(anchor + pull);
            side.push((anchor + pull) * angles[vertex] - pull * off);
        }
        let mut entries = Vec::with_capacity(self.free.len() + self.edges.len());
        let mesh = fit.domain.surface().mesh();
        let step = fit.guidance.symmetry().step();
        for &(edge, weight) in &self.edges {
            let weight = fit.smoothing.max(ANGLE_ANCHOR) * weight;
            let halfedge = mesh.edge_halfedge(edge);
            let ends = mesh.ends(halfedge);
            // What the second angle should be more than the first.
            let jump = step * f64::from(self.matching.jump(halfedge));
            let graded = fit.graded.as_ref().map_or(0.0, |turns| turns[halfedge]);
            let more = fit.domain.transports()[halfedge] + jump + graded;
            let places = ends.map(|vertex| fit.places[vertex]);
            for (own, other, sign) in [(0, 1, -1.0), (1, 0, 1.0)] {
                if places[own] == HELD {
                    continue;
                }
                let place = places[own] as usize;
                diagonal[place] += weight;
                side[place] += weight * sign * more;
                if places[other] == HELD {
                    side[place] += weight * angles[ends[other]];
                }
            }
            if places.iter().all(|&place| place != HELD) {
                entries.push((places[0] as usize, places[1] as usize, -weight));
            }
        }
        let diagonal = diagonal.into_iter().enumerate();
        entries.extend(diagonal.map(|(place, value)| (place, place, value)));
        Ok((
            SymmetricMatrix::from_triplets(self.free.len(), entries)?,
            side,
        ))
    }

    /// The weight with which guidance draws an angle, and how far it is off: that of a quadratic
    /// with the same slope as `1 - cos(N off)`.
    fn pull(&self, angle: f64, vertex: VertexId) -> (f64, f64) {
        let fit = self.fit;
        let symmetry = fit.guidance.symmetry();
        let pull = fit.guidance.pull(vertex);
        let strength = (1.0 - fit.smoothing) * fit.mass(vertex) * pull.length();
        if strength <= 0.0 {
            return (0.0, 0.0);
        }
        let (off, _) = symmetry.reduce(angle - symmetry.root(pull));
        let turned = f64::from(symmetry.order()) * off;
        let share = if turned.abs() > 1e-4 {
            libm::sin(turned) / turned
        } else {
            1.0
        };
        (strength * share.max(0.0), off)
    }

    /// Gives edges that turn too far more weight; whether there are any.
    fn stiffen(&mut self, angles: &PerVertex<f64>) -> bool {
        let step = self.fit.guidance.symmetry().step();
        let mesh = self.fit.domain.surface().mesh();
        let mut any = false;
        for (edge, weight) in &mut self.edges {
            let halfedge: HalfedgeId = mesh.edge_halfedge(*edge);
            let turn = self.matching.turn(self.fit.domain, angles, step, halfedge);
            if turn.abs() > WIDEST_TURN * step {
                *weight *= STIFFENING;
                any = true;
            }
        }
        any
    }
}

/// The cotangent weight of an edge in the surface's own triangles, kept within a range: an obtuse or
/// a degenerate triangle must neither repel nor tie directions.
fn stable_weight(domain: &FieldDomain<'_>, edge: EdgeId) -> f64 {
    let mesh = domain.surface().mesh();
    let halfedge = mesh.edge_halfedge(edge);
    let sides = [Some(halfedge), mesh.twin(halfedge)];
    let halves = sides.into_iter().flatten().map(|side| {
        let shape = domain.triangulation().shape(side.face());
        shape.cotangent(side.previous().side()).unwrap_or_default() / 2.0
    });
    let [low, high] = EDGE_WEIGHT_RANGE;
    halves.sum::<f64>().clamp(low, high)
}
