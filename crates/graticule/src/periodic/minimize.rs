use glam::DVec2;
use serde::Serialize;

use super::PeriodicError;
use super::diffusion::diffuse_and_normalise;
use super::hierarchy::phases_from_coarse;
use super::newton::newton;
use super::phase_graph::PhaseGraph;
use crate::watch::Watch;

/// How the energy is minimised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Minimizer {
    /// From coarse to fine, each unit vector moved in turn to its best place.
    ///
    /// The default: as few singular triangles as any, in a tenth of the time.
    CoarseToFine(CoarseToFineOptions),
    /// The same with fewer sweeps, then diffusion and normalisation in turn.
    DiffuseAndNormalise(DiffusionOptions),
    /// As published: the linear solution, then Newton's method on the norm-penalised functional.
    Newton(NewtonOptions),
}

impl Default for Minimizer {
    fn default() -> Self {
        Self::CoarseToFine(CoarseToFineOptions::default())
    }
}

/// How [`Minimizer::CoarseToFine`] goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoarseToFineOptions {
    /// Sweeps forth and back on each level.
    pub sweeps: usize,
    /// Chooses the phases to start from on the coarsest level.
    pub seed: u64,
}

impl Default for CoarseToFineOptions {
    fn default() -> Self {
        Self {
            sweeps: 30,
            seed: 0,
        }
    }
}

/// How [`Minimizer::DiffuseAndNormalise`] goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffusionOptions {
    /// The way from coarse to fine that comes first.
    pub start: CoarseToFineOptions,
    /// Steps of diffusion and normalisation.
    pub steps: usize,
    /// τ of the first step, against weights without unit and masses in mean vertex areas: how far a
    /// step carries, some `τ^-½` edges.
    pub first: f64,
    /// τ of the last step; those between are in geometric progression.
    pub last: f64,
}

impl Default for DiffusionOptions {
    fn default() -> Self {
        Self {
            start: CoarseToFineOptions {
                sweeps: 10,
                ..CoarseToFineOptions::default()
            },
            steps: 6,
            first: 0.02,
            last: 0.2,
        }
    }
}

impl DiffusionOptions {
    /// τ of a step.
    pub(super) fn step_length(&self, step: usize) -> f64 {
        let share = step as f64 / self.steps.saturating_sub(1).max(1) as f64;
        self.first * libm::pow(self.last / self.first, share)
    }
}

/// How [`Minimizer::Newton`] goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonOptions {
    /// Weight ε of the norm penalty for a vertex of mean area, against edge weights without unit.
    /// The paper's 10⁻³ has no scale (erratum 5); 0.03 to 1 works.
    pub penalty: f64,
    /// Most iterations.
    pub iterations: usize,
    /// Root mean square of the gradient at which to stop.
    pub tolerance: f64,
    /// Chooses the vector that the linear solution starts from.
    pub seed: u64,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self {
            penalty: 0.1,
            iterations: 50,
            tolerance: 1e-6,
            seed: 0,
        }
    }
}

/// Values of the free nodes, and how they were found.
pub(super) struct Minimum {
    /// Of unit length with diffusion, near it with Newton.
    pub(super) values: Vec<DVec2>,
    /// The lengths that tell where the phase is singular: near 0 there.
    pub(super) moduli: Vec<f64>,
    pub(super) energy: f64,
    pub(super) steps: usize,
    pub(super) inner_iterations: usize,
    /// Root mean square of the gradient of F**, with Newton.
    pub(super) gradient: Option<f64>,
}

/// Figures of a minimisation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MinimizationReport {
    /// "coarse-to-fine", "diffuse-and-normalise" or "newton".
    pub method: &'static str,
    /// Steps of diffusion or of Newton's method.
    pub steps: usize,
    /// Iterations of conjugate gradients in them, or factorisations.
    pub inner_iterations: usize,
    /// Root mean square of the gradient at the end, of Newton's method.
    pub gradient: Option<f64>,
    /// The energy F* of the unit vectors.
    pub energy: f64,
    /// The least and the mean norm of the vectors: with Newton's method as they come out, else of
    /// the mean of what their neighbours want.
    pub moduli: [f64; 2],
}

impl Minimum {
    /// Unit vectors.
    pub(super) fn of_units(graph: &PhaseGraph, values: Vec<DVec2>) -> Self {
        Self {
            energy: graph.energy(&values),
            moduli: graph.agreements(&values),
            values,
            steps: 0,
            inner_iterations: 0,
            gradient: None,
        }
    }
}

fn coarse_to_fine(
    graph: &PhaseGraph,
    options: CoarseToFineOptions,
    watch: &Watch,
) -> Result<Minimum, PeriodicError> {
    let values = phases_from_coarse(graph, options, watch)?;
    Ok(Minimum::of_units(graph, values))
}

impl Minimizer {
    pub(super) fn run(
        &self,
        graph: &PhaseGraph,
        points: &[glam::DVec3],
        watch: &Watch,
    ) -> Result<(Minimum, MinimizationReport), PeriodicError> {
        let _stage = watch.stage("minimisation");
        let (method, found) = match self {
            Self::CoarseToFine(options) => {
                ("coarse-to-fine", coarse_to_fine(graph, *options, watch)?)
            }
            Self::DiffuseAndNormalise(options) => (
                "diffuse-and-normalise",
                diffuse_and_normalise(graph, options, watch)?,
            ),
            Self::Newton(options) => ("newton", newton(graph, points, options, watch)?),
        };
        let least = found.moduli.iter().copied().fold(f64::INFINITY, f64::min);
        let mean = found.moduli.iter().sum::<f64>() / found.moduli.len().max(1) as f64;
        let report = MinimizationReport {
            method,
            steps: found.steps,
            inner_iterations: found.inner_iterations,
            gradient: found.gradient,
            energy: found.energy,
            moduli: [if least.is_finite() { least } else { 0.0 }, mean],
        };
        Ok((found, report))
    }

    /// What chooses the phases to start from.
    pub(super) fn seed(&self) -> u64 {
        match self {
            Self::CoarseToFine(options) => options.seed,
            Self::DiffuseAndNormalise(options) => options.start.seed,
            Self::Newton(options) => options.seed,
        }
    }

    /// Refuses numbers out of range.
    pub(super) fn check(&self) -> Result<(), PeriodicError> {
        let positive = f64::MIN_POSITIVE..=f64::MAX;
        let numbers = match self {
            Self::CoarseToFine(_) => Vec::new(),
            Self::DiffuseAndNormalise(options) => {
                vec![("first τ", options.first), ("last τ", options.last)]
            }
            Self::Newton(options) => {
                vec![
                    ("penalty", options.penalty),
                    ("tolerance", options.tolerance),
                ]
            }
        };
        match numbers
            .into_iter()
            .find(|(_, value)| !positive.contains(value))
        {
            Some((name, value)) => Err(PeriodicError::Option {
                name,
                value,
                range: "above 0, finite",
            }),
            None => Ok(()),
        }
    }
}
