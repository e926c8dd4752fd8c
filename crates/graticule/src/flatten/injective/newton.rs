//! Projected Newton descent that never leaves the admissible maps.

use glam::DVec2;
use serde::Serialize;

use super::boundary::Obstacle;
use super::contacts::gap;
use super::objective::Objective;
use super::system::{Direction, NewtonSystem};
use crate::solve::SolveError;
use crate::tolerance::{OBSTACLE_STIFFNESS, SHARE_TO_COLLAPSE, SUFFICIENT_DECREASE};
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
    /// The energy above which no more than [`PATIENT_STEPS`] steps are made.
    pub(super) patience: f64,
}

/// Steps after which an energy tells whether a descent jams: after 15 some are still on their way.
const PATIENT_STEPS: usize = 40;

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
///
/// Far from it the Hessian is made positive triangle by triangle, which is safe but stiff: steps
/// are shorter than they could be. Near it the Hessian as it is, or with part of its negative
/// curvatures, is positive as a whole, and the steps are Newton's own; that is tried from time to
/// time.
pub(super) fn descend(
    objective: &impl Objective,
    system: &mut NewtonSystem,
    places: &mut Vec<DVec2>,
    goal: Goal,
    watch: &Watch,
) -> Result<Descent, SolveError> {
    let mut descent = Descent::default();
    let mut energy = objective.value(places);
    let mut trust = Trust::default();
    for iteration in 0..=goal.iterations {
        watch.check()?;
        watch.progress(iteration as f64 / goal.iterations.max(1) as f64);
        couple(objective, places, system)?;
        let Newton {
            direction,
            kept,
            gradient,
        } = trust.direction(objective, places, energy, system)?;
        descent.residual = descent.residual.max(direction.residual);
        let expected_gain = -0.5 * direction.slope / energy;
        trust.last_gain = expected_gain;
        descent.converged = expected_gain <= goal.gain;
        let is_given_up = iteration >= PATIENT_STEPS && energy > goal.patience;
        let found = if descent.converged || is_given_up || iteration == goal.iterations {
            None
        } else {
            let direction = around_obstacles(objective, places, direction, kept, system)?;
            let search = Search {
                objective,
                places,
                direction: &direction.step,
                slope: direction.slope,
            };
            let found = search.run(energy);
            // Where no step lowers the energy, what is left is rounding.
            descent.converged = found.is_none();
            found
        };
        descent.history.push(NewtonStep {
            energy,
            gradient,
            expected_gain,
            step: found.as_ref().map_or(0.0, |found| found.step),
        });
        let Some(found) = found else {
            break;
        };
        (*places, energy) = (found.places, found.energy);
    }
    Ok(descent)
}

/// By how much reaches are widened when the system is planned, so that the plan lasts.
const WIDENED: f64 = 2.0;

/// Sees that the system couples what the Hessian couples at this map.
fn couple(
    objective: &impl Objective,
    places: &[DVec2],
    system: &mut NewtonSystem,
) -> Result<(), SolveError> {
    if system.couples(&objective.couplings(places, 1.0)) {
        return Ok(());
    }
    system.plan(&objective.couplings(places, WIDENED), places)
}

/// Times that a direction is led around what it would meet.
const MOST_DETOURS: usize = 3;

/// The share of itself by which the distance to an obstacle may shrink.
const CLOSED: f64 = 0.5;

/// The share of itself by which it is asked to grow where it may not shrink.
const PARTED: f64 = 1.0;

/// By how much an obstacle that is met again becomes stiffer.
const STIFFENING: f64 = 10.0;

/// The share of the step before which an obstacle is worth a detour.
const SOON: f64 = 0.2;

/// Obstacles that come after so many times as long as the first are left for the next step.
const HORIZON: f64 = 10.0;

/// Leads a direction around obstacles that would end the step soon, as one place in trouble would
/// hold all others up: the distance to each is asked to shrink by half only. Of the direct way and
/// the detours that is taken which gains most before it meets something.
fn around_obstacles(
    objective: &impl Objective,
    places: &[DVec2],
    direct: Direction,
    kept: f64,
    system: &mut NewtonSystem,
) -> Result<Direction, SolveError> {
    let mut best = Detour::of(objective, places, direct);
    let mut first = best.first;
    let mut step = best.direction.step.clone();
    let mut obstacles: Vec<Avoided> = Vec::new();
    for _ in 0..MOST_DETOURS {
        if first >= SOON {
            break;
        }
        let horizon = (HORIZON * first).min(1.0);
        let met = objective.obstacles(places, &step, horizon);
        // Where it is as good as there, the direction away from it is not known.
        let is_apart = |obstacle: &Obstacle| gap(obstacle.vertices, places).0 > 0.0;
        for obstacle in met.into_iter().filter(is_apart) {
            let is_same = |known: &&mut Avoided| known.obstacle.vertices == obstacle.vertices;
            match obstacles.iter_mut().find(is_same) {
                Some(known) => known.met_again += 1,
                None => obstacles.push(Avoided {
                    obstacle,
                    met_again: 0,
                }),
            }
        }
        let mut detour = around(objective, places, &obstacles, kept, -CLOSED, system)?;
        if detour.slope >= 0.0 {
            // Closing costs more than all the rest gains: what is too close shall part.
            detour = around(objective, places, &obstacles, kept, PARTED, system)?;
        }
        if detour.slope >= 0.0 {
            break;
        }
        let detour = Detour::of(objective, places, detour);
        (first, step) = (detour.first, detour.direction.step.clone());
        if detour.gain() > best.gain() {
            best = detour;
        }
    }
    Ok(best.direction)
}

/// What a direction is led around.
struct Avoided {
    obstacle: Obstacle,
    /// Times that it was met although the distance to it was seen to.
    met_again: i32,
}

/// A direction, and when it meets the first obstacle.
struct Detour {
    direction: Direction,
    first: f64,
}

impl Detour {
    fn of(objective: &impl Objective, places: &[DVec2], direction: Direction) -> Self {
        Self {
            first: objective.first_obstacle(places, &direction.step),
            direction,
        }
    }

    /// What the quadratic model gains on the way to the first obstacle.
    fn gain(&self) -> f64 {
        let share = (SHARE_TO_COLLAPSE * self.first).min(1.0);
        -self.direction.slope * share * (1.0 - 0.5 * share)
    }
}

/// The Newton direction in which the distances to obstacles grow by about a share of themselves.
/// What is met all the same slides along the obstacle farther than the distance is wide, so that its
/// first derivative tells little: such a vertex is asked to keep its place along the edge, too.
fn around(
    objective: &impl Objective,
    places: &[DVec2],
    obstacles: &[Avoided],
    kept: f64,
    growth: f64,
    system: &mut NewtonSystem,
) -> Result<Direction, SolveError> {
    let pairs: Vec<_> = obstacles
        .iter()
        .flat_map(|avoided| avoided.obstacle.pairs())
        .collect();
    if !system.couples(&pairs) {
        let all = [system.coupled(), &pairs].concat();
        system.plan(&all, places)?;
    }
    system.clear();
    objective.expand_into(places, kept, system);
    let stiffness = |avoided: &Avoided| -> f64 {
        let vertices = avoided.obstacle.vertices.iter();
        let own: f64 = vertices.map(|&v| system.stiffness(v)).sum();
        OBSTACLE_STIFFNESS * STIFFENING.powi(avoided.met_again) * own
    };
    let stiffnesses: Vec<f64> = obstacles.iter().map(stiffness).collect();
    for (avoided, stiffness) in obstacles.iter().zip(stiffnesses) {
        let (distance, mode) = gap(avoided.obstacle.vertices, places);
        system.add_aim(&mode, growth * distance, stiffness);
        if avoided.met_again > 0 {
            system.add_aim(&mode.across(), 0.0, stiffness);
        }
    }
    system.direction()
}

/// Shares of the negative curvatures that are tried, before none.
const KEPT: [f64; 2] = [1.0, 0.5];

/// The expected gain below which negative curvatures are tried.
const NEAR: f64 = 3e-3;

/// By how much the expected gain must fall before what failed is tried again.
const RETRIED: f64 = 0.2;

/// A Newton direction.
struct Newton {
    direction: Direction,
    /// The share of negative curvatures that is left in its Hessian.
    kept: f64,
    /// The largest force on a vertex.
    gradient: f64,
}

/// Which Hessians are worth trying.
struct Trust {
    last_gain: f64,
    /// The expected gain below which each share is tried.
    bounds: [f64; KEPT.len()],
}

impl Default for Trust {
    fn default() -> Self {
        Self {
            last_gain: f64::INFINITY,
            bounds: [NEAR; KEPT.len()],
        }
    }
}

impl Trust {
    /// The direction by the most exact Hessian that is positive.
    fn direction(
        &mut self,
        objective: &impl Objective,
        places: &[DVec2],
        energy: f64,
        system: &mut NewtonSystem,
    ) -> Result<Newton, SolveError> {
        for (&kept, bound) in KEPT.iter().zip(&mut self.bounds) {
            if self.last_gain > *bound {
                continue;
            }
            system.clear();
            objective.expand_into(places, kept, system);
            let gradient = system.largest_force();
            let direction = system.exact_direction()?;
            let far = NEAR * energy;
            match direction.filter(|direction| -0.5 * direction.slope < far) {
                Some(direction) => {
                    return Ok(Newton {
                        direction,
                        kept,
                        gradient,
                    });
                }
                None => *bound = RETRIED * self.last_gain,
            }
        }
        system.clear();
        objective.expand_into(places, 0.0, system);
        let gradient = system.largest_force();
        Ok(Newton {
            direction: system.direction()?,
            kept: 0.0,
            gradient,
        })
    }
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
    /// The first of ever shorter steps that lowers the energy enough; of a full step its doubles,
    /// as long as they lower it further.
    fn run(&self, energy: f64) -> Option<Found> {
        let first = self.objective.first_obstacle(self.places, self.direction);
        let most = SHARE_TO_COLLAPSE * first;
        let mut step = most.min(1.0);
        for _ in 0..MOST_HALVINGS {
            let found = self.at(step);
            let enough = SUFFICIENT_DECREASE * step * self.slope;
            if found.energy <= energy + enough && found.energy < energy {
                return Some(self.stretched(found, most));
            }
            step *= 0.5;
        }
        None
    }

    fn stretched(&self, mut found: Found, most: f64) -> Found {
        while found.step >= 1.0 && 2.0 * found.step <= most {
            let longer = self.at(2.0 * found.step);
            // Not `>=`: what is not a number is no progress.
            let better = longer.energy < found.energy;
            if !better {
                break;
            }
            found = longer;
        }
        found
    }

    fn at(&self, step: f64) -> Found {
        let pairs = self.places.iter().zip(self.direction);
        let places: Vec<DVec2> = pairs.map(|(&p, &d)| p + d * step).collect();
        Found {
            energy: self.objective.value(&places),
            step,
            places,
        }
    }
}
