//! The search for the density that meets a number of quads.

use crate::periodic::GridDensity;
use crate::tolerance::{COUNT_MISS, FAIR_COUNT_ROUNDS};
use crate::watch::Watch;

/// The one part of the number wanted that a map is asked for at least. Where that gives too many quads
/// still, they are at details that have no room between the lines: fewer lines would cost all the rest
/// its shape and leave these as they are.
const LEAST_PART: usize = 2;

/// What to ask of the map so that so many quads come out.
///
/// What is cut or joined after the map is a share that hardly changes; so the number found corrects
/// the one asked for. Once a number too small and one too large are known, the next one lies between.
pub(super) struct CountSearch {
    wanted: usize,
    /// The greatest number asked for that gave too few quads, and how many those were.
    below: Option<[usize; 2]>,
    /// The least that gave too many.
    above: Option<[usize; 2]>,
    rounds: usize,
}

impl CountSearch {
    /// `None` where no number was asked for.
    pub(super) fn new(density: GridDensity) -> Option<Self> {
        let GridDensity::Quads(wanted) = density else {
            return None;
        };
        Some(Self {
            wanted,
            below: None,
            above: None,
            rounds: 0,
        })
    }

    /// How far a number is from the one wanted, as a share of it.
    pub(super) fn miss(&self, found: usize) -> f64 {
        (found as f64 / self.wanted as f64 - 1.0).abs()
    }

    /// The number to ask for next after `tried` gave `found`; `None` where that is near enough, or
    /// nothing better can be hoped for.
    pub(super) fn next(&mut self, tried: usize, found: usize) -> Option<usize> {
        self.rounds += 1;
        if self.miss(found) <= COUNT_MISS || self.rounds >= FAIR_COUNT_ROUNDS || found == 0 {
            return None;
        }
        let bound = if found < self.wanted {
            &mut self.below
        } else {
            &mut self.above
        };
        *bound = Some([tried, found]);
        let next = match (self.below, self.above) {
            (Some(below), Some(above)) => between(below, above, self.wanted)?,
            _ => scaled(tried, found, self.wanted).max(self.wanted.div_ceil(LEAST_PART)),
        };
        (next != tried).then_some(next)
    }

    /// Warns where the best number found is not near enough.
    pub(super) fn warn(&self, found: usize, watch: &Watch) {
        if self.miss(found) > COUNT_MISS {
            let message = format!(
                "{} quads were asked for, {found} is as near as the net comes",
                self.wanted
            );
            watch.warn("quad-count", message);
        }
    }
}

#[expect(clippy::cast_sign_loss, reason = "it is 1 at least")]
fn scaled(tried: usize, found: usize, wanted: usize) -> usize {
    (tried as f64 * wanted as f64 / found as f64)
        .round()
        .max(1.0) as usize
}

/// The number between two that a straight line through what they gave leads to.
#[expect(clippy::cast_sign_loss, reason = "it is between two numbers")]
fn between(below: [usize; 2], above: [usize; 2], wanted: usize) -> Option<usize> {
    let [low, high] = [below[0].min(above[0]), below[0].max(above[0])];
    if high - low < 2 {
        return None;
    }
    let share = (wanted - below[1]) as f64 / (above[1] - below[1]) as f64;
    let next = below[0] as f64 + share * (above[0] as f64 - below[0] as f64);
    Some((next.round() as usize).clamp(low + 1, high - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is found when the map makes so many more quads than it is asked for, in steps.
    fn found_by(wanted: usize, mut made: impl FnMut(usize) -> usize) -> (usize, usize) {
        let mut search = CountSearch::new(GridDensity::Quads(wanted)).unwrap();
        let (mut tried, mut best) = (wanted, None::<usize>);
        let mut rounds = 0;
        loop {
            rounds += 1;
            let found = made(tried);
            if best.is_none_or(|best| search.miss(found) < search.miss(best)) {
                best = Some(found);
            }
            match search.next(tried, found) {
                Some(next) => tried = next,
                None => return (best.unwrap(), rounds),
            }
        }
    }

    #[test]
    fn one_correction_is_enough_where_the_miss_is_a_share() {
        assert_eq!(found_by(5000, |tried| tried * 6 / 5), (5000, 2));
        assert_eq!(found_by(5000, |tried| tried), (5000, 1));
    }

    #[test]
    fn steps_over_the_number_are_narrowed_down() {
        // Corrections by the share alone would go to and fro between 450 and 550.
        let made = |tried: usize| match tried {
            0..470 => 450,
            470..500 => 505,
            _ => 550,
        };
        let (found, rounds) = found_by(500, made);
        assert!(
            found == 505 && rounds <= FAIR_COUNT_ROUNDS,
            "{found} {rounds}"
        );
    }

    #[test]
    fn details_that_take_quads_at_any_density_do_not_coarsen_the_rest() {
        let mut coarsest = usize::MAX;
        let made = |tried: usize| {
            coarsest = coarsest.min(tried);
            tried + 4000
        };
        let (found, rounds) = found_by(2000, made);
        assert_eq!((coarsest, found, rounds), (1000, 5000, 2));
    }

    #[test]
    fn the_nearest_is_taken_where_none_is_near_enough() {
        let (found, rounds) = found_by(100, |tried| if tried < 100 { 80 } else { 110 });
        assert!(
            found == 110 && rounds <= FAIR_COUNT_ROUNDS,
            "{found} {rounds}"
        );
    }
}
