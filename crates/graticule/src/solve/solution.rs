//! Solutions and their residuals.

use super::SolveError;
use crate::tolerance;

/// The solution of a linear system for one or several right-hand sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// The unknowns of each right-hand side, one column after the other.
    pub values: Vec<f64>,
    /// Largest relative residual `‖A x − b‖ / (‖A‖ ‖x‖ + ‖b‖)` over the right-hand sides, in the
    /// maximum norm, of the values as returned.
    pub residual: f64,
}

impl Solution {
    /// The unknowns of each right-hand side, given the number of unknowns.
    pub fn columns(&self, unknowns: usize) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(unknowns.max(1))
    }
}

/// A factored system: an approximate inverse and what the residual is measured with.
pub(super) trait Factored {
    fn order(&self) -> usize;

    /// Largest sum of absolute values in a row of the matrix.
    fn norm(&self) -> f64;

    /// `output = A * input`.
    fn multiply_into(&self, input: &[f64], output: &mut [f64]);

    /// Overwrites right-hand sides, one column after the other, by approximate solutions.
    fn solve_in_place(&self, columns: &mut [f64]) -> Result<(), SolveError>;
}

/// Solves for all right-hand sides, refines where the residual asks for it, and checks.
pub(super) fn solve_checked(
    system: &impl Factored,
    right_sides: &[f64],
    most_refinements: usize,
) -> Result<Solution, SolveError> {
    let order = system.order();
    let count = count_columns(right_sides, order)?;
    let (scaled, scales) = scaled_columns(right_sides, order);
    let mut values = scaled.clone();
    if count > 0 {
        system.solve_in_place(&mut values)?;
    }
    let (mut corrections, mut residual) = residuals(system, &scaled, &values);
    for _ in 0..most_refinements {
        if residual <= tolerance::REFINED_RESIDUAL {
            break;
        }
        system.solve_in_place(&mut corrections)?;
        for (correction, value) in corrections.iter_mut().zip(&values) {
            *correction += value;
        }
        let refined = residuals(system, &scaled, &corrections);
        // Not `>`: a residual that is not a number must not count as progress.
        let better = refined.1 < residual || residual.is_nan();
        if !better {
            break;
        }
        values = corrections;
        (corrections, residual) = refined;
    }
    for (column, scale) in values.chunks_exact_mut(order.max(1)).zip(scales) {
        for value in column {
            *value *= scale;
        }
    }
    check_solution(values, residual)
}

/// Refuses a solution that does not fulfil its system or is not finite.
pub(super) fn check_solution(values: Vec<f64>, residual: f64) -> Result<Solution, SolveError> {
    let finite = values.iter().all(|value| value.is_finite());
    if finite && residual <= tolerance::LINEAR_RESIDUAL {
        return Ok(Solution { values, residual });
    }
    Err(SolveError::Inaccurate {
        residual: if finite { residual } else { f64::INFINITY },
        tolerance: tolerance::LINEAR_RESIDUAL,
    })
}

/// Number of columns of `order` numbers; all must be finite.
pub(super) fn count_columns(right_sides: &[f64], order: usize) -> Result<usize, SolveError> {
    let count = right_sides.len().checked_div(order).unwrap_or(0);
    SolveError::check_length("numbers on the right", right_sides.len(), count * order)?;
    if let Some(index) = right_sides.iter().position(|value| !value.is_finite()) {
        return Err(SolveError::NonFiniteRightSide {
            row: index % order,
            column: index / order,
            value: right_sides[index],
        });
    }
    Ok(count)
}

/// Columns divided by powers of two so that their largest entries are near one; the powers.
fn scaled_columns(right_sides: &[f64], order: usize) -> (Vec<f64>, Vec<f64>) {
    let mut scaled = right_sides.to_vec();
    let scales = scaled
        .chunks_exact_mut(order.max(1))
        .map(|column| {
            let scale = power_of_two(largest(column));
            for value in column {
                *value /= scale;
            }
            scale
        })
        .collect();
    (scaled, scales)
}

/// `b − A x` of each column and the largest relative residual.
fn residuals(system: &impl Factored, right_sides: &[f64], values: &[f64]) -> (Vec<f64>, f64) {
    let order = system.order().max(1);
    let norm = system.norm();
    let mut all = vec![0.0; values.len()];
    let mut worst = 0.0_f64;
    for ((b, x), residual) in right_sides
        .chunks_exact(order)
        .zip(values.chunks_exact(order))
        .zip(all.chunks_exact_mut(order))
    {
        system.multiply_into(x, residual);
        for (r, &b) in residual.iter_mut().zip(b) {
            *r = b - *r;
        }
        let relative = relative_to(largest(residual), norm * largest(x) + largest(b));
        // `max` would drop a residual that is not a number.
        worst = if relative > worst || relative.is_nan() {
            relative
        } else {
            worst
        };
    }
    (all, worst)
}

/// `part / whole`, zero where there is nothing at all.
pub(super) fn relative_to(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}

/// Largest absolute value; not a number if one of them is not.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, value| {
        if value.abs() > most || value.is_nan() {
            value.abs()
        } else {
            most
        }
    })
}

/// The power of two at or below a positive number; 1 for zero.
pub(super) fn power_of_two(number: f64) -> f64 {
    if number == 0.0 || !number.is_finite() {
        return 1.0;
    }
    // Subnormal numbers have no exponent bits: the least normal power serves them.
    let bits = number.abs().max(f64::MIN_POSITIVE).to_bits();
    f64::from_bits(bits & 0x7ff0_0000_0000_0000)
}
