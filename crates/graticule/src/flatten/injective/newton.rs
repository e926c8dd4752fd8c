//! Projected Newton descent that never leaves the admissible maps.

use glam::DVec2;
use serde::Serialize;

use super::objective::Objective;
use super::system::NewtonSystem;
use crate::solve::SolveError;
use crate::tolerance::{SHARE_TO_COLLAPSE, SUFFICIENT_DECREASE};
use crate::watch::Watch;

/// Halvings of a step after which there is no way down to rounding.
const MOST_HALVINGS: usize = 40;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    /// Half the Newton decrement over the energy: the share of the energy that the next step
    /// would gain.
    pub(super) gain: f64,
    pub(super) iterations: usize,
}

/// One step of a descent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NewtonStep {
    /// The energy before the step: the mean over the surface.
    pub energy: f64,
    /// The largest derivative of the energy by the place of a vertex, in unit lengths.
    pub gradient: f64,
    /// The share of the energy that a full Newton step gains by its quadratic model.
    pub expected_gain: f64,
    /// The share of the Newton step that was made; 0 for the last one.
    pub step: f64,
}

/// What a descent did.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Descent {
    /// Whether the expected gain fell below the goal, or nothing but rounding was left to gain.
    pub converged: bool,
    /// The steps.
    pub history: Vec<NewtonStep>,
    /// Largest relative residual of a linear system.
    pub residual: f64,
}

/// Moves `places`, which must be admissible, down to a minimum of the objective.
pub(super) fn descend(
    objective: &impl Objective,
    system: &mut NewtonSystem,
    places: &mut Vec<DVec2>,
    goal: Goal,
    watch: &Watch,
) -> Result<Descent, SolveError> {
    let mut descent = Descent::default();
    let mut energy = objective.value(places);
    for iteration in 0..=goal.iterations {
        watch.check()?;
        watch.progress(iteration as f64 / goal.iterations as f64);
        system.clear();
        objective.expand_into(places, system);
        let gradient = system.largest_force();
        let direction = system.direction()?;
        descent.residual = descent.residual.max(direction.residual);
        let expected_gain = -0.5 * direction.slope / energy;
        descent.converged = expected_gain <= goal.gain;
        let mut step = 0.0;
        if !descent.converged && iteration < goal.iterations {
            let search = Search {
                objective,
                places,
                direction: &direction.step,
                slope: direction.slope,
            };
            if let Some(found) = search.run(energy) {
                descent.history.push(NewtonStep {
                    energy,
                    gradient,
                    expected_gain,
                    step: found.step,
                });
                (*places, energy) = (found.places, found.energy);
                continue;
            }
            // No step lowers the energy: what is left is rounding.
            descent.converged = true;
            step = 0.0;
        }
        descent.history.push(NewtonStep {
            energy,
            gradient,
            expected_gain,
            step,
        });
        break;
    }
    Ok(descent)
}

/// A line search from an admissible map.
struct Search<'a, O> {
    objective: &'a O,
    places: &'a [DVec2],
    direction: &'a [DVec2],
    slope: f64,
}

struct Found {
    step: f64,
    places: Vec<DVec2>,
    energy: f64,
}

impl<O: Objective> Search<'_, O> {
    /// The first of ever shorter steps that lowers the energy enough.
    fn run(&self, energy: f64) -> Option<Found> {
        let obstacle = self.objective.first_obstacle(self.places, self.direction);
        let mut step = (SHARE_TO_COLLAPSE * obstacle).min(1.0);
        for _ in 0..MOST_HALVINGS {
            let pairs = self.places.iter().zip(self.direction);
            let places: Vec<DVec2> = pairs.map(|(&p, &d)| p + d * step).collect();
            let value = self.objective.value(&places);
            if value <= energy + SUFFICIENT_DECREASE * step * self.slope && value < energy {
                return Some(Found {
                    step,
                    places,
                    energy: value,
                });
            }
            step *= 0.5;
        }
        None
    }
}
