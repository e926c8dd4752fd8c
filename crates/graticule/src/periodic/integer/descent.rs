//! Unconstrained minimisation of small smooth functions.

use std::collections::VecDeque;

/// A function of several variables.
pub(super) trait Objective {
    /// Its value; overwrites `gradient` by the derivative.
    fn value(&self, point: &[f64], gradient: &mut [f64]) -> f64;
}

/// Limited-memory BFGS with backtracking (J. Nocedal, S. Wright, *Numerical Optimization*, 2006,
/// §7.2).
pub(super) struct Descent {
    /// Steps at most.
    steps: usize,
    /// Pairs of differences kept.
    memory: usize,
    /// Relative decrease in one step at which it ends.
    decrease: f64,
}

impl Default for Descent {
    fn default() -> Self {
        Self {
            steps: 60,
            memory: 8,
            decrease: 1e-7,
        }
    }
}

/// A step and the change of the gradient along it.
struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
    curvature: f64,
}

impl Descent {
    /// Steps at most.
    pub(super) fn steps(&self) -> usize {
        self.steps
    }

    /// Moves the point downhill; gives by which share of itself the value fell.
    pub(super) fn run(&self, objective: &impl Objective, point: &mut Vec<f64>) -> f64 {
        let mut gradient = vec![0.0; point.len()];
        let first = objective.value(point, &mut gradient);
        let mut value = first;
        let mut pairs = VecDeque::new();
        for _ in 0..self.steps {
            let mut direction = direction(&gradient, &pairs);
            if dot(&direction, &gradient) >= 0.0 {
                pairs.clear();
                direction = gradient.iter().map(|slope| -slope).collect();
            }
            let Some(next) = search(objective, point, &gradient, value, &direction) else {
                break;
            };
            let fell = (value - next.value) / value.abs().max(f64::MIN_POSITIVE);
            let step: Vec<f64> = next.point.iter().zip(&*point).map(|(a, b)| a - b).collect();
            let change: Vec<f64> = next
                .gradient
                .iter()
                .zip(&gradient)
                .map(|(a, b)| a - b)
                .collect();
            let curvature = dot(&step, &change);
            if curvature > 0.0 {
                pairs.push_back(Pair {
                    step,
                    change,
                    curvature,
                });
                if pairs.len() > self.memory {
                    pairs.pop_front();
                }
            }
            (*point, gradient, value) = (next.point, next.gradient, next.value);
            if fell < self.decrease {
                break;
            }
        }
        (first - value) / first.abs().max(f64::MIN_POSITIVE)
    }
}

/// The gradient, negated, times the inverse Hessian that the pairs suggest.
fn direction(gradient: &[f64], pairs: &VecDeque<Pair>) -> Vec<f64> {
    let mut direction: Vec<f64> = gradient.iter().map(|slope| -slope).collect();
    let mut shares = Vec::with_capacity(pairs.len());
    for pair in pairs.iter().rev() {
        let share = dot(&pair.step, &direction) / pair.curvature;
        add(&mut direction, -share, &pair.change);
        shares.push(share);
    }
    if let Some(last) = pairs.back() {
        let scale = last.curvature / dot(&last.change, &last.change).max(f64::MIN_POSITIVE);
        for part in &mut direction {
            *part *= scale;
        }
    }
    for (pair, share) in pairs.iter().zip(shares.into_iter().rev()) {
        let other = dot(&pair.change, &direction) / pair.curvature;
        add(&mut direction, share - other, &pair.step);
    }
    direction
}

struct Place {
    point: Vec<f64>,
    gradient: Vec<f64>,
    value: f64,
}

/// Halves the step until the value falls enough; `None` where it never does.
fn search(
    objective: &impl Objective,
    point: &[f64],
    gradient: &[f64],
    value: f64,
    direction: &[f64],
) -> Option<Place> {
    let slope = dot(gradient, direction);
    let largest = direction
        .iter()
        .fold(0.0_f64, |most, part| most.max(part.abs()));
    let mut length = (LONGEST_STEP / largest.max(f64::MIN_POSITIVE)).min(1.0);
    let mut gradient = vec![0.0; point.len()];
    for _ in 0..MOST_HALVINGS {
        let mut moved = point.to_vec();
        add(&mut moved, length, direction);
        let reached = objective.value(&moved, &mut gradient);
        if reached <= value + SUFFICIENT * length * slope {
            return Some(Place {
                point: moved,
                gradient,
                value: reached,
            });
        }
        length /= 2.0;
    }
    None
}

/// The longest step of a variable, in line spacings.
const LONGEST_STEP: f64 = 1.0;

const MOST_HALVINGS: usize = 40;

/// The share of the decrease that the slope promises.
const SUFFICIENT: f64 = 1e-4;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn add(to: &mut [f64], factor: f64, other: &[f64]) {
    for (to, other) in to.iter_mut().zip(other) {
        *to += factor * other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The valley of Rosenbrock, whose least value is 0 at (1, 1).
    struct Valley;

    impl Objective for Valley {
        fn value(&self, point: &[f64], gradient: &mut [f64]) -> f64 {
            let [x, y] = [point[0], point[1]];
            let across = y - x * x;
            gradient[0] = -2.0 * (1.0 - x) - 400.0 * x * across;
            gradient[1] = 200.0 * across;
            (1.0 - x).powi(2) + 100.0 * across * across
        }
    }

    #[test]
    fn the_end_of_a_curved_valley_is_found() {
        let mut point = vec![-1.2, 1.0];
        let descent = Descent {
            steps: 200,
            decrease: 0.0,
            ..Descent::default()
        };
        let fell = descent.run(&Valley, &mut point);
        assert!(fell > 0.999_999);
        assert!(point.iter().all(|x| (x - 1.0).abs() < 1e-5), "{point:?}");
    }
}
