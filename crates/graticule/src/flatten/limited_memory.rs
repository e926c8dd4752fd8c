//! The inverse of a Hessian, as far as the last steps of a descent tell of it: limited-memory BFGS
//! (J. Nocedal, *Updating quasi-Newton matrices with limited storage*, 1980).

use std::collections::VecDeque;

use glam::DVec2;

use super::boundary_optimal::dot;
use crate::tolerance::ROUNDING;

/// Steps remembered: more gain little.
const REMEMBERED: usize = 12;

/// A step with the change of the gradient along it.
struct Pair {
    step: Vec<DVec2>,
    change: Vec<DVec2>,
    curvature: f64,
}

/// The last steps of a descent.
#[derive(Default)]
pub(super) struct LimitedMemory {
    pairs: VecDeque<Pair>,
}

impl LimitedMemory {
    pub(super) fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Keeps a step along which the gradient has grown; others would spoil the descent.
    pub(super) fn remember(&mut self, step: Vec<DVec2>, change: Vec<DVec2>) {
        let curvature = dot(&step, &change);
        let sizes = dot(&step, &step) * dot(&change, &change);
        if curvature <= ROUNDING * sizes.sqrt() {
            return;
        }
        if self.pairs.len() == REMEMBERED {
            self.pairs.pop_front();
        }
        self.pairs.push_back(Pair {
            step,
            change,
            curvature,
        });
    }

    /// Minus the inverse Hessian times the gradient; `inverse` is what is known of it without any
    /// step, up to a factor.
    pub(super) fn direction<E>(
        &self,
        gradient: &[DVec2],
        inverse: impl Fn(&[DVec2]) -> Result<Vec<DVec2>, E>,
    ) -> Result<Vec<DVec2>, E> {
        let mut rest: Vec<DVec2> = gradient.iter().map(|g| -*g).collect();
        let mut shares = Vec::with_capacity(self.pairs.len());
        for pair in self.pairs.iter().rev() {
            let share = dot(&pair.step, &rest) / pair.curvature;
            add(&mut rest, &pair.change, -share);
            shares.push(share);
        }
        let mut direction = inverse(&rest)?;
        if let Some(last) = self.pairs.back() {
            let own = dot(&last.change, &inverse(&last.change)?);
            let factor = last.curvature / own;
            for d in &mut direction {
                *d *= factor;
            }
        }
        for (pair, share) in self.pairs.iter().zip(shares.into_iter().rev()) {
            let back = dot(&pair.change, &direction) / pair.curvature;
            add(&mut direction, &pair.step, share - back);
        }
        Ok(direction)
    }
}

fn add(sum: &mut [DVec2], term: &[DVec2], factor: f64) {
    for (sum, term) in sum.iter_mut().zip(term) {
        *sum += *term * factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    /// A quadratic with a different curvature along each coordinate.
    fn gradient(at: &[DVec2]) -> Vec<DVec2> {
        let curvature = |k: usize| DVec2::new(1.0 + k as f64, 3.0 + 2.0 * k as f64);
        at.iter()
            .enumerate()
            .map(|(k, x)| *x * curvature(k))
            .collect()
    }

    #[test]
    fn the_last_step_is_answered_by_its_own_change() {
        let mut noise = Noise::new(1);
        let mut random = || -> Vec<DVec2> {
            (0..5)
                .map(|_| DVec2::new(noise.signed(), noise.signed()))
                .collect()
        };
        let mut memory = LimitedMemory::default();
        for _ in 0..20 {
            let step = random();
            let change = gradient(&step);
            memory.remember(step.clone(), change.clone());
            let same = |v: &[DVec2]| Ok::<_, ()>(v.to_vec());
            let answer = memory.direction(&change, same).unwrap();
            let error = answer.iter().zip(&step).map(|(a, s)| (*a + *s).length());
            assert!(error.fold(0.0, f64::max) < 1e-12);
        }
    }

    #[test]
    fn steps_without_curvature_are_not_kept() {
        let mut memory = LimitedMemory::default();
        memory.remember(vec![DVec2::X], vec![-DVec2::X]);
        memory.remember(vec![DVec2::X], vec![DVec2::Y]);
        assert!(memory.is_empty());
    }
}
