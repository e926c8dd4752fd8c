use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::connection::ConnectionLaplacian;
use super::{CrossField, FieldError, Guidance, Symmetry};
use crate::geometry::{IntrinsicTriangulation, vertex_areas};
use crate::mesh::{Element, PerVertex, VertexId};
use crate::solve::{Cholesky, Graph, Ordering, SymmetricMatrix};
use crate::tolerance::{FIELD_AT_REST, NO_DIRECTION};
use crate::watch::Watch;

/// How a field is smoothed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothingOptions {
    /// The share of smoothness against guidance, ρ of [PGP06] Eq. 21, in `0.0..1.0`.
    pub smoothing: f64,
    /// Most steps of diffusion and normalisation.
    pub steps: usize,
    /// Chooses the directions to start from where there is no guidance.
    pub seed: u64,
}

impl Default for SmoothingOptions {
    fn default() -> Self {
        Self {
            smoothing: 0.8,
            steps: 40,
            seed: 0,
        }
    }
}

/// A smooth field and how it was found.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothField {
    /// The field.
    pub field: CrossField,
    /// The figures.
    pub report: SmoothingReport,
}

/// Figures of a smoothing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SmoothingReport {
    /// Steps taken.
    pub steps: usize,
    /// Mean change of the unit vectors in the last step.
    pub last_change: f64,
    /// How much the field turns, `Σ w |uⱼ - r uᵢ|²`; without unit.
    pub smoothness_energy: f64,
    /// How far it is from its guidance, `Σ weight |u - target|²`, areas in mean vertex areas.
    pub guidance_energy: f64,
    /// Largest relative residual of the linear solves.
    pub residual: f64,
}

/// The smoothest field that follows its guidance: minimises [PGP06] Eq. 21 over unit vectors.
///
/// The norm penalty of the paper keeps vectors from vanishing; here each step diffuses and then
/// normalises: `u ← normalise((A + τM)⁻¹ (f + τM u))` with the matrix `A` and the right side `f` of
/// the quadratic form. That descends the same functional with one matrix for all steps, factored
/// once, and without a start from an eigenvector. Without any guidance the first steps, from seeded
/// phases, are inverse iterations for the smoothest field there is.
///
/// `positions` order the factorisation; they have no influence on the field.
///
/// Cost: one factorisation of two unknowns per vertex, and a solve for each step.
///
/// # Errors
/// [`FieldError`].
pub fn smooth_field(
    triangulation: &IntrinsicTriangulation,
    positions: &PerVertex<DVec3>,
    guidance: &Guidance,
    options: &SmoothingOptions,
    watch: &Watch,
) -> Result<SmoothField, FieldError> {
    if !(0.0..1.0).contains(&options.smoothing) {
        let (name, value) = ("smoothing", options.smoothing);
        return Err(FieldError::Option {
            name,
            value,
            range: "0 to below 1",
        });
    }
    smooth_from(triangulation, positions, guidance, None, options, watch)
}

/// As [`smooth_field`], starting from a field instead of from the guidance.
pub(super) fn relax(
    triangulation: &IntrinsicTriangulation,
    positions: &PerVertex<DVec3>,
    guidance: &Guidance,
    start: &CrossField,
    options: &SmoothingOptions,
    watch: &Watch,
) -> Result<SmoothField, FieldError> {
    smooth_from(
        triangulation,
        positions,
        guidance,
        Some(start),
        options,
        watch,
    )
}

fn smooth_from(
    triangulation: &IntrinsicTriangulation,
    positions: &PerVertex<DVec3>,
    guidance: &Guidance,
    start: Option<&CrossField>,
    options: &SmoothingOptions,
    watch: &Watch,
) -> Result<SmoothField, FieldError> {
    let _stage = watch.stage("field smoothing");
    let system = System::new(triangulation, guidance, options)?;
    let factor = system.factor(triangulation, positions, watch)?;
    let mut run = Diffusion {
        system: &system,
        factor: &factor,
        residual: 0.0,
    };
    let start = match start {
        Some(field) => field.angles().map(|&angle| field.symmetry().power(angle)),
        None => run.start(guidance, options.seed)?,
    };
    let (powers, steps, last_change) = run.descend(start, options.steps, watch)?;
    let residual = run.residual;
    Ok(SmoothField {
        report: SmoothingReport {
            steps,
            last_change,
            smoothness_energy: system.connection.energy(&powers),
            guidance_energy: system.guidance_energy(&powers),
            residual,
        },
        field: CrossField::from_angles(
            guidance.symmetry(),
            powers.map(|&power| guidance.symmetry().root(power)),
        ),
    })
}

/// Step of the diffusion against the dimensionless weights of the edges: long enough to carry
/// directions over some ten edges a step, short enough that the normalisation keeps up.
const DIFFUSION: f64 = 0.02;

/// The quadratic form: smoothness, guidance and diffusion, and what is fixed.
struct System {
    connection: ConnectionLaplacian,
    smoothing: f64,
    /// Area of each vertex over the mean.
    masses: PerVertex<f64>,
    /// Sums of weights × targets and of weights, both with ρ and the areas in.
    pulls: PerVertex<DVec2>,
    weights: PerVertex<f64>,
    fixed: PerVertex<Option<DVec2>>,
}

impl System {
    fn new(
        triangulation: &IntrinsicTriangulation,
        guidance: &Guidance,
        options: &SmoothingOptions,
    ) -> Result<Self, FieldError> {
        let areas = vertex_areas(triangulation);
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        // A vertex of area 0 must not drop out of the matrix.
        let masses = areas.map(|area| (area / mean).max(f64::EPSILON));
        let fitting = |vertex: VertexId| (1.0 - options.smoothing) * masses[vertex];
        let count = guidance.vertex_count();
        Ok(Self {
            connection: ConnectionLaplacian::new(triangulation, guidance.symmetry())?,
            smoothing: options.smoothing,
            pulls: PerVertex::from_fn(count, |v| guidance.pull(v) * fitting(v)),
            weights: PerVertex::from_fn(count, |v| guidance.weight(v) * fitting(v)),
            fixed: PerVertex::from_fn(count, |v| guidance.fixed(v)),
            masses,
        })
    }

    /// Fixed vertices keep a row of the unit matrix.
    fn factor(
        &self,
        triangulation: &IntrinsicTriangulation,
        positions: &PerVertex<DVec3>,
        watch: &Watch,
    ) -> Result<Cholesky, FieldError> {
        let _stage = watch.stage("factorisation");
        let count = self.masses.len();
        let free = |vertex: VertexId| self.fixed[vertex].is_none();
        let kept = self
            .connection
            .edges
            .iter()
            .flat_map(|edge| edge.lower_entries(free));
        let edges = kept.map(|(row, column, value)| (row, column, self.smoothing * value));
        let diagonal = (0..2 * count).map(|unknown| {
            let vertex = VertexId::from_index(unknown / 2);
            let own = self.weights[vertex] + DIFFUSION * self.masses[vertex];
            (unknown, unknown, if free(vertex) { own } else { 1.0 })
        });
        let matrix = SymmetricMatrix::from_triplets(2 * count, edges.chain(diagonal))?;
        let pairs = triangulation.edges().map(|edge| {
            triangulation
                .ends(triangulation.edge_halfedge(edge))
                .map(|vertex| vertex.0)
        });
        let graph = Graph::from_edges(count, pairs);
        let ordering = Ordering::for_mesh(&graph, positions.as_slice()).expanded(2);
        watch.check()?;
        Ok(Cholesky::new(&matrix, &ordering)?)
    }

    /// The right-hand side: guidance, diffusion from `powers`, and what fixed neighbours bring.
    fn right_side(&self, powers: &PerVertex<DVec2>) -> Vec<f64> {
        let mut sides = PerVertex::from_fn(powers.len(), |vertex: VertexId| {
            let diffused = powers[vertex] * (DIFFUSION * self.masses[vertex]);
            self.fixed[vertex].unwrap_or(self.pulls[vertex] + diffused)
        });
        for edge in &self.connection.edges {
            let [i, j] = edge.ends;
            let weight = self.smoothing * edge.weight;
            match (self.fixed[i], self.fixed[j]) {
                (Some(at_i), None) => sides[j] += edge.rotation.rotate(at_i) * weight,
                (None, Some(at_j)) => sides[i] += edge.conjugate().rotate(at_j) * weight,
                _ => {}
            }
        }
        sides.iter().flat_map(|side| side.to_array()).collect()
    }

    fn guidance_energy(&self, powers: &PerVertex<DVec2>) -> f64 {
        // Σ w |u - t|² = Σ w (2 - 2 u·t) for unit vectors.
        let terms = powers
            .enumerate()
            .map(|(vertex, power)| 2.0 * (self.weights[vertex] - power.dot(self.pulls[vertex])));
        terms.sum::<f64>().max(0.0)
    }
}

struct Diffusion<'a> {
    system: &'a System,
    factor: &'a Cholesky,
    residual: f64,
}

impl Diffusion<'_> {
    /// Guidance carried into the places without; seeded phases where none arrives.
    fn start(&mut self, guidance: &Guidance, seed: u64) -> Result<PerVertex<DVec2>, FieldError> {
        let count = guidance.vertex_count();
        let carried = self.diffuse(&PerVertex::filled(count, DVec2::ZERO))?;
        Ok(PerVertex::from_fn(count, |vertex| {
            let power = carried[vertex];
            if power.length() > NO_DIRECTION {
                power.normalize()
            } else {
                phase(vertex, seed)
            }
        }))
    }

    fn diffuse(&mut self, powers: &PerVertex<DVec2>) -> Result<PerVertex<DVec2>, FieldError> {
        let solution = self.factor.solve(&self.system.right_side(powers))?;
        self.residual = self.residual.max(solution.residual);
        Ok(PerVertex::new(
            solution
                .values
                .chunks_exact(2)
                .map(|pair| DVec2::new(pair[0], pair[1]))
                .collect(),
        ))
    }

    fn descend(
        &mut self,
        start: PerVertex<DVec2>,
        steps: usize,
        watch: &Watch,
    ) -> Result<(PerVertex<DVec2>, usize, f64), FieldError> {
        let mut powers = start;
        let mut change = 0.0;
        for step in 0..steps {
            watch.check()?;
            let diffused = self.diffuse(&powers)?;
            let mut moved = 0.0;
            for (power, next) in powers.as_mut_slice().iter_mut().zip(&diffused) {
                // A vector that vanishes says nothing: keep the one before.
                let next = next.try_normalize().unwrap_or(*power);
                moved += power.distance(next);
                *power = next;
            }
            change = moved / powers.len() as f64;
            watch.progress((step + 1) as f64 / steps as f64);
            if change < FIELD_AT_REST {
                return Ok((powers, step + 1, change));
            }
        }
        Ok((powers, steps, change))
    }
}

/// Phases that neighbours do not share, the same on every machine: multiples of the golden ratio.
fn phase(vertex: VertexId, seed: u64) -> DVec2 {
    let turns =
        (vertex.index() as f64 + 1.0) * 0.618_033_988_749_894_9 + seed as f64 * 0.754_877_666;
    Symmetry::Vector.power(TAU * turns.fract())
}
