use glam::DVec2;

use super::PeriodicError;
use super::hierarchy::phases_from_coarse;
use super::minimize::{DiffusionOptions, Minimum};
use super::phase_graph::PhaseGraph;
use crate::solve::{ConjugateGradientOptions, conjugate_gradients};
use crate::watch::Watch;

/// Relative residual of a diffusion. The normalisation after it moves the values by far more, and the
/// next step starts from there.
const INNER_TOLERANCE: f64 = 1e-3;

/// Minimises the energy over unit vectors: phases from coarse to fine, then steps of
/// `x ← normalise((Q + τM)⁻¹ (τM x + b))`.
///
/// Each step descends the norm-penalised functional F** of [PGP06] §2.5 in the limit of a strong
/// penalty, with one well-conditioned matrix.
///
/// [PGP06]: crate::papers::PGP06
pub(super) fn diffuse_and_normalise(
    graph: &PhaseGraph,
    options: &DiffusionOptions,
    watch: &Watch,
) -> Result<Minimum, PeriodicError> {
    let mut values = {
        let _stage = watch.stage("phases from coarse to fine");
        phases_from_coarse(graph, options.start, watch)?
    };
    let _stage = watch.stage("diffusion");
    let mut inner_iterations = 0;
    for step in 0..options.steps {
        watch.progress(step as f64 / options.steps as f64);
        let diffused = diffused(graph, &values, options.step_length(step), watch)?;
        inner_iterations += diffused.1;
        for (value, next) in values.iter_mut().zip(&diffused.0) {
            // A vector that vanishes says nothing: keep the one before.
            *value = next.try_normalize().unwrap_or(*value);
        }
        graph.relax_units(&mut values);
    }
    Ok(Minimum {
        steps: options.steps,
        inner_iterations,
        ..Minimum::of_units(graph, values)
    })
}

/// `(Q + τM)⁻¹ (τM x + b)`, and the iterations it took.
fn diffused(
    graph: &PhaseGraph,
    values: &[DVec2],
    step: f64,
    watch: &Watch,
) -> Result<(Vec<DVec2>, usize), PeriodicError> {
    let side = values.iter().zip(&graph.masses).zip(&graph.anchors);
    let side =
        side.flat_map(|((&value, mass), &anchor)| (value * (step * mass) + anchor).to_array());
    let side: Vec<f64> = side.collect();
    let start: Vec<f64> = values.iter().flat_map(DVec2::to_array).collect();
    let form = graph.shifted(step);
    let options = ConjugateGradientOptions {
        start: Some(&start),
        tolerance: INNER_TOLERANCE,
        ..ConjugateGradientOptions::default()
    };
    let solution = conjugate_gradients(&form, &form, &side, options, watch)?;
    let values = solution.values.chunks_exact(2).map(DVec2::from_slice);
    Ok((values.collect(), solution.iterations))
}
