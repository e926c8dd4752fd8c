use rayon::prelude::*;

/// Items summed in one go. Fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 4096;

/// One partial result for each run of `CHUNK` items, in order.
pub(super) fn by_chunks<T: Sync, A: Send>(
    items: &[T],
    part: impl Fn(&[T]) -> A + Sync + Send,
) -> Vec<A> {
    items.par_chunks(CHUNK).map(part).collect()
}

/// The sum of a figure over all items, the same for any number of threads.
pub(super) fn sum<T: Sync>(items: &[T], figure: impl Fn(&T) -> f64 + Sync + Send) -> f64 {
    by_chunks(items, |chunk| chunk.iter().map(&figure).sum::<f64>())
        .into_iter()
        .sum()
}

/// A figure and the area that it holds for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) value: f64,
    pub(super) weight: f64,
}

/// The values that `shares` of the weight do not exceed; 0 without samples. Changes the samples' order.
///
/// A quantile is always one of the values: the first, in ascending order, at which the weight so far
/// reaches the share. Linear time.
pub(super) fn weighted_quantiles<const N: usize>(
    samples: &mut [Sample],
    shares: [f64; N],
) -> [f64; N] {
    let total = sum(samples, |sample| sample.weight);
    shares.map(|share| value_at_weight(samples, share * total))
}

/// The first value, in ascending order, at which the sum of weights reaches `weight`.
fn value_at_weight(mut samples: &mut [Sample], mut weight: f64) -> f64 {
    // Samples that compare equal are identical, so that their order does not matter.
    let ascending = |a: &Sample, b: &Sample| {
        let by_value = a.value.total_cmp(&b.value);
        by_value.then(a.weight.total_cmp(&b.weight))
    };
    while samples.len() > 1 {
        let middle = samples.len() / 2;
        let (lower, ..) = samples.select_nth_unstable_by(middle, ascending);
        let below: f64 = lower.iter().map(|sample| sample.weight).sum();
        if below >= weight {
            samples = &mut samples[..middle];
        } else {
            weight -= below;
            samples = &mut samples[middle..];
        }
    }
    samples.first().map_or(0.0, |sample| sample.value)
}

/// The least and the greatest value; 0 without samples.
pub(super) fn extremes(samples: &[Sample]) -> [f64; 2] {
    let values = || samples.iter().map(|sample| sample.value);
    [values().reduce(f64::min), values().reduce(f64::max)].map(Option::unwrap_or_default)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::float_cmp)] // a quantile is one of the values
    fn a_quantile_is_the_value_at_which_the_weight_reaches_the_share() {
        let mut samples =
            [(3.0, 1.0), (1.0, 2.0), (2.0, 1.0)].map(|(value, weight)| Sample { value, weight });
        let quantiles = weighted_quantiles(&mut samples, [0.0, 0.5, 0.51, 0.75, 1.0]);
        assert_eq!(quantiles, [1.0, 1.0, 2.0, 2.0, 3.0]);
        assert_eq!(extremes(&samples), [1.0, 3.0]);
        assert_eq!(weighted_quantiles(&mut [], [0.5]), [0.0]);
        assert_eq!(extremes(&[]), [0.0, 0.0]);
    }

    #[test]
    #[allow(clippy::float_cmp)] // a quantile is one of the values
    fn quantiles_of_many_samples_are_those_of_the_sorted_ones() {
        let mut noise = graticule_fixtures::Noise::new(3);
        let mut samples: Vec<_> = (0..5000)
            .map(|_| Sample {
                value: (20.0 * noise.unit()).floor() + noise.unit().round() * noise.unit(),
                weight: noise.unit(),
            })
            .collect();
        let shares = [0.001, 0.2, 0.5, 0.95, 0.999];
        let found = weighted_quantiles(&mut samples, shares);
        samples.sort_by(|a, b| a.value.total_cmp(&b.value));
        let total: f64 = samples.iter().map(|sample| sample.weight).sum();
        for (share, found) in shares.into_iter().zip(found) {
            let mut reached = 0.0;
            let first = samples.iter().find(|sample| {
                reached += sample.weight;
                reached >= share * total
            });
            assert_eq!(first.unwrap().value, found);
        }
    }
}
