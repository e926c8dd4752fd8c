//! Diffusion and normalisation of a field over the vertices that are not fixed.

use std::f64::consts::TAU;

use faer::c64;
use glam::{DVec2, DVec3};

use super::connection::ConnectionLaplacian;
use super::mirror_order::MirrorOrder;
use super::phase_graph::{Coupling, PhaseGraph};
use super::{FieldError, Guidance, Symmetry};
use crate::geometry::{IntrinsicTriangulation, vertex_areas};
use crate::mesh::{Element, PerVertex, VertexId};
use crate::solve::{HermitianCholesky, HermitianMatrix, Placement, SymmetricMatrix};
use crate::tolerance::{DIFFUSION_STEP, FAINT_GUIDANCE, NO_DIRECTION};
use crate::watch::Watch;

/// Stands for no place among the free vertices.
const FIXED: usize = usize::MAX;

/// The quadratic form: smoothness, guidance and diffusion, and what is fixed.
pub(super) struct System {
    pub(super) connection: ConnectionLaplacian,
    pub(super) smoothing: f64,
    /// Area of each vertex over the mean.
    pub(super) masses: PerVertex<f64>,
    /// Sums of weights × targets and of weights, both with ρ and the areas in.
    pub(super) pulls: PerVertex<DVec2>,
    pub(super) weights: PerVertex<f64>,
    fixed: PerVertex<Option<DVec2>>,
    /// The vertices that are not fixed, and for each vertex its place among them or [`FIXED`].
    pub(super) free: Vec<VertexId>,
    places: PerVertex<usize>,
    /// Whether a free vertex may be the mirror image of the one before.
    is_image: Vec<bool>,
}

impl System {
    /// `positions` order the vertices; they have no other influence.
    pub(super) fn new(
        triangulation: &IntrinsicTriangulation,
        positions: &PerVertex<DVec3>,
        guidance: &Guidance,
        smoothing: f64,
    ) -> Result<Self, FieldError> {
        let areas = vertex_areas(triangulation);
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        // A vertex of area 0 must not drop out of the matrix.
        let masses = areas.map(|area| (area / mean).max(f64::EPSILON));
        let fitting = |vertex: VertexId| (1.0 - smoothing) * masses[vertex];
        let count = guidance.vertex_count();
        let is_free = |vertex: &VertexId| guidance.fixed(*vertex).is_none();
        let order = MirrorOrder::of(positions, is_free);
        let free = order.vertices;
        let mut places = PerVertex::filled(count, FIXED);
        for (place, &vertex) in free.iter().enumerate() {
            places[vertex] = place;
        }
        Ok(Self {
            connection: ConnectionLaplacian::new(triangulation, guidance)?,
            smoothing,
            pulls: PerVertex::from_fn(count, |v| guidance.pull(v) * fitting(v)),
            weights: PerVertex::from_fn(count, |v| guidance.weight(v) * fitting(v)),
            fixed: PerVertex::from_fn(count, |v| guidance.fixed(v)),
            masses,
            free,
            places,
            is_image: order.is_image,
        })
    }

    /// The form over the free vertices, guidance and what fixed neighbours bring as anchors; the
    /// weights of guidance are not in its diagonal.
    pub(super) fn graph(&self) -> PhaseGraph {
        let mut diagonal = vec![0.0; self.free.len()];
        for edge in &self.connection.edges {
            for place in edge.ends.map(|vertex| self.places[vertex]) {
                if place != FIXED {
                    diagonal[place] += self.smoothing * edge.weight;
                }
            }
        }
        let links = self.connection.edges.iter().filter(|edge| {
            edge.weight > 0.0 && edge.ends.iter().all(|&end| self.places[end] != FIXED)
        });
        let rows = links.flat_map(|edge| {
            let [i, j] = edge.ends.map(|vertex| self.places[vertex] as u32);
            let weight = self.smoothing * edge.weight;
            let coupling = |node, rotation| Coupling {
                node,
                is_mirrored: false,
                factor: rotation * weight,
            };
            [
                (i, coupling(j, edge.conjugate())),
                (j, coupling(i, edge.rotation)),
            ]
        });
        let masses = self.at_free(&self.masses);
        let starts_from = vec![DVec2::X; masses.len()];
        let side = self.constant_side();
        let mut graph = PhaseGraph::from_rows(rows, diagonal, side, masses, starts_from);
        graph.is_image.clone_from(&self.is_image);
        graph
    }

    /// What the free vertices have.
    pub(super) fn at_free<T: Copy>(&self, values: &PerVertex<T>) -> Vec<T> {
        self.free.iter().map(|&vertex| values[vertex]).collect()
    }

    /// The part of the right-hand side that does not change: guidance, and what fixed neighbours
    /// bring.
    fn constant_side(&self) -> Vec<DVec2> {
        let mut side: Vec<DVec2> = self.free.iter().map(|&v| self.pulls[v]).collect();
        for edge in &self.connection.edges {
            let [i, j] = edge.ends;
            let weight = self.smoothing * edge.weight;
            match (self.fixed[i], self.fixed[j]) {
                (Some(at_i), None) => side[self.places[j]] += edge.rotation.rotate(at_i) * weight,
                (None, Some(at_j)) => {
                    side[self.places[i]] += edge.conjugate().rotate(at_j) * weight;
                }
                _ => {}
            }
        }
        side
    }

    /// The place of a vertex among the free ones.
    pub(super) fn place(&self, vertex: VertexId) -> Option<usize> {
        Some(self.places[vertex]).filter(|&place| place != FIXED)
    }

    /// The unit vectors of all vertices, from those of the free ones.
    pub(super) fn with_fixed(&self, free: &[DVec2]) -> PerVertex<DVec2> {
        PerVertex::from_fn(self.fixed.len(), |vertex: VertexId| {
            self.fixed[vertex].unwrap_or_else(|| free[self.places[vertex]])
        })
    }

    /// Whether so little guides the field that diffusion alone decides where it is singular.
    pub(super) fn is_unguided(&self) -> bool {
        let wished: f64 = self.weights.iter().sum();
        let total: f64 = self.masses.iter().sum();
        self.fixed.iter().all(Option::is_none)
            && wished <= FAINT_GUIDANCE * (1.0 - self.smoothing) * total
    }

    /// How far unit vectors are from the guidance.
    pub(super) fn guidance_energy(&self, powers: &PerVertex<DVec2>) -> f64 {
        // Σ w |u - t|² = Σ w (2 - 2 u·t) for unit vectors.
        let terms = powers
            .enumerate()
            .map(|(vertex, power)| 2.0 * (self.weights[vertex] - power.dot(self.pulls[vertex])));
        terms.sum::<f64>().max(0.0)
    }
}

/// The iteration on a graph, with its factorisation.
pub(super) struct Diffusion<'a> {
    graph: &'a PhaseGraph,
    solver: Option<(HermitianMatrix, HermitianCholesky)>,
    at_rest: f64,
    /// Relative residual of the first solve; all have the same matrix.
    pub(super) residual: f64,
    /// Steps taken so far.
    pub(super) steps: usize,
    /// Mean change in the last of them.
    pub(super) last_change: f64,
}

/// What a graph does not say of its nodes.
pub(super) struct Nodes {
    /// The weights of guidance.
    pub(super) weights: Vec<f64>,
    pub(super) points: Vec<DVec3>,
}

impl<'a> Diffusion<'a> {
    /// Diffusion until the mean change of a step is below `at_rest`.
    pub(super) fn new(
        graph: &'a PhaseGraph,
        nodes: &Nodes,
        at_rest: f64,
        watch: &Watch,
    ) -> Result<Self, FieldError> {
        Ok(Self {
            solver: factored(graph, nodes, watch)?,
            graph,
            at_rest,
            residual: 0.0,
            steps: 0,
            last_change: 0.0,
        })
    }

    /// Guidance carried into the places without; seeded phases where none arrives.
    pub(super) fn start(&mut self, seed: u64) -> Result<Vec<DVec2>, FieldError> {
        let carried = self.diffuse(&vec![DVec2::ZERO; self.graph.count()], true)?;
        let powers = carried.into_iter().enumerate().map(|(node, power)| {
            if power.length() > NO_DIRECTION {
                power.normalize()
            } else {
                phase(VertexId::from_index(node), seed)
            }
        });
        Ok(powers.collect())
    }

    /// One solve. To check it costs nearly as much again.
    fn diffuse(&mut self, powers: &[DVec2], is_checked: bool) -> Result<Vec<DVec2>, FieldError> {
        let Some((matrix, factor)) = &self.solver else {
            return Ok(Vec::new());
        };
        let parts = self
            .graph
            .anchors
            .iter()
            .zip(&self.graph.masses)
            .zip(powers);
        let side = parts.map(|((&anchor, &mass), &power)| {
            let value = anchor + power * (DIFFUSION_STEP * mass);
            c64::new(value.x, value.y)
        });
        let side: Vec<c64> = side.collect();
        let solution = factor.solve(&side)?;
        if is_checked {
            self.residual = relative_residual(matrix, &solution, &side);
        }
        let vectors = solution.iter().map(|value| DVec2::new(value.re, value.im));
        Ok(vectors.collect())
    }

    /// Diffuses and normalises until the field is at rest, at most so many times.
    pub(super) fn descend(
        &mut self,
        start: Vec<DVec2>,
        steps: usize,
        watch: &Watch,
    ) -> Result<Vec<DVec2>, FieldError> {
        let mut powers = start;
        while self.steps < steps && !powers.is_empty() {
            watch.check()?;
            let diffused = self.diffuse(&powers, self.steps == 0)?;
            let mut moved = 0.0;
            for (power, next) in powers.iter_mut().zip(&diffused) {
                // A vector that vanishes says nothing: keep the one before.
                let next = next.try_normalize().unwrap_or(*power);
                moved += power.distance(next);
                *power = next;
            }
            self.last_change = moved / powers.len() as f64;
            self.steps += 1;
            watch.progress(self.steps as f64 / steps as f64);
            if self.last_change < self.at_rest {
                break;
            }
        }
        Ok(powers)
    }
}

fn factored(
    graph: &PhaseGraph,
    nodes: &Nodes,
    watch: &Watch,
) -> Result<Option<(HermitianMatrix, HermitianCholesky)>, FieldError> {
    if graph.count() == 0 {
        return Ok(None);
    }
    let _stage = watch.stage("factorisation");
    let matrix = matrix(graph, &nodes.weights)?;
    let ordering = Placement::at(&nodes.points).ordering(matrix.pattern())?;
    watch.check()?;
    let factor = HermitianCholesky::new(&matrix, &ordering)?;
    Ok(Some((matrix, factor)))
}

/// The matrix of smoothness, guidance and one step of diffusion, complex and Hermitian.
fn matrix(graph: &PhaseGraph, weights: &[f64]) -> Result<HermitianMatrix, FieldError> {
    let own =
        |node: usize| graph.diagonal[node] + weights[node] + DIFFUSION_STEP * graph.masses[node];
    let diagonal = (0..graph.count()).map(|node| (node, node, own(node)));
    let lower = || {
        (0..graph.count()).flat_map(|node| {
            let couplings = graph.couplings(node).iter();
            let before = couplings.filter(move |coupling| (coupling.node as usize) < node);
            before.map(move |coupling| (node, coupling.node as usize, -coupling.factor))
        })
    };
    let real = lower().map(|(row, column, factor)| (row, column, factor.x));
    let real = SymmetricMatrix::from_triplets(graph.count(), real.chain(diagonal))?;
    let imaginary = lower().map(|(row, column, factor)| (row, column, factor.y));
    Ok(HermitianMatrix::new(&real, imaginary)?)
}

/// `|Ax - b| / (|A| |x| + |b|)` in largest entries and row sums.
fn relative_residual(matrix: &HermitianMatrix, solution: &[c64], side: &[c64]) -> f64 {
    let largest = |values: &mut dyn Iterator<Item = c64>| values.map(c64::norm).fold(0.0, f64::max);
    let product = matrix.multiply(solution);
    let rest = largest(&mut product.iter().zip(side).map(|(a, b)| a - b));
    let size = matrix.row_sum_norm() * largest(&mut solution.iter().copied())
        + largest(&mut side.iter().copied());
    if size > 0.0 { rest / size } else { 0.0 }
}

/// Phases that neighbours do not share, the same on every machine: a hash of vertex and seed
/// (S. Vigna's `SplitMix64`).
pub(crate) fn phase(vertex: VertexId, seed: u64) -> DVec2 {
    let number = (vertex.index() as u64).wrapping_add(seed.rotate_left(32));
    let mut bits = number.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^= bits >> 31;
    Symmetry::Vector.power(TAU * (bits >> 11) as f64 / (1_u64 << 53) as f64)
}
