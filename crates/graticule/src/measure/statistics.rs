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

/// The values that `shares` of the weight do not exceed; 0 without samples. Sorts the samples.
///
/// A quantile is always one of the values: the first at which the weight so far reaches the share.
pub(super) fn weighted_quantiles<const N: usize>(
    samples: &mut [Sample],
    shares: [f64; N],
) -> [f64; N] {
    // Samples that compare equal are identical, so that an unstable sort has one result only.
    samples.par_sort_unstable_by(|a, b| {
        a.value
            .total_cmp(&b.value)
            .then(a.weight.total_cmp(&b.weight))
    });
    let mut reached = 0.0;
    let so_far: Vec<f64> = samples
        .iter()
        .map(|sample| {
            reached += sample.weight;
            reached
        })
        .collect();
    shares.map(|share| {
        let index = so_far.partition_point(|&weight| weight < share * reached);
        let index = index.min(samples.len().saturating_sub(1));
        samples.get(index).map_or(0.0, |sample| sample.value)
    })
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
        assert_eq!(weighted_quantiles(&mut [], [0.5]), [0.0]);
    }
}
