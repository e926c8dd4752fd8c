use crate::{ColorMap, Legend};

/// Which values get the ends of the colour map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Range {
    /// The 1st and the 99th percentile, so that a few outliers do not wash out the rest.
    #[default]
    Robust,
    /// These percentiles, in `0.0..=100.0`.
    Percentiles(f64, f64),
    /// The lowest and the highest finite value.
    Full,
    /// These values.
    Fixed(f64, f64),
}

/// How values become colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ColorScale {
    /// The colours.
    pub map: ColorMap,
    /// The values at the ends of the map.
    pub range: Range,
    /// A value that gets the middle of the map; the range is widened to be symmetric around it.
    pub middle: Option<f64>,
    /// The range around [`middle`](Self::middle) is at least this wide, so that a figure that is
    /// neutral up to rounding looks neutral.
    pub least_range: f64,
}

/// A range narrower than this share of its values is rounding and is drawn as one value.
///
/// Figures of an exact map differ by some 1e-13 of their values on the largest meshes.
const ROUNDING: f64 = 1e-11;

impl ColorScale {
    /// Blue, white, red, symmetric around `middle`, over a range of 0.02 at least: a change that
    /// no eye could see in the shape, for figures without unit such as the logarithm of a ratio.
    #[must_use]
    pub fn diverging(middle: f64) -> Self {
        Self {
            map: ColorMap::BlueRed,
            middle: Some(middle),
            least_range: 0.02,
            ..Self::default()
        }
    }

    /// The legend of `values` under this scale. Values that are not numbers count as missing.
    #[must_use]
    pub fn legend(&self, title: &str, values: &[f64]) -> Legend {
        let [low, high] = self.ends(self.bounds(values));
        let mut legend = Legend {
            title: title.into(),
            map: self.map,
            low,
            high,
            below: 0,
            above: 0,
            missing: values.iter().filter(|value| value.is_nan()).count(),
        };
        let count_shares = |is_counted: &dyn Fn(f64) -> bool| {
            let shares = values.iter().map(|&value| legend.share(value));
            shares.filter(|&share| is_counted(share)).count()
        };
        let beyond = [
            count_shares(&|share| share < 0.0),
            count_shares(&|share| share > 1.0),
        ];
        [legend.below, legend.above] = beyond;
        legend
    }

    /// The ends of the range: symmetric around the middle if there is one, and not narrower than
    /// rounding.
    fn ends(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        if let Some(middle) = self.middle.filter(|middle| middle.is_finite()) {
            let reach = (high - middle)
                .max(middle - low)
                .max(self.least_range / 2.0)
                .clamp(0.0, f64::MAX / 4.0);
            let finite = |value: f64| value.clamp(f64::MIN, f64::MAX);
            [finite(middle - reach), finite(middle + reach)]
        } else if high / 2.0 - low / 2.0 <= ROUNDING * low.abs().max(high.abs()) {
            [low / 2.0 + high / 2.0; 2]
        } else {
            [low, high]
        }
    }

    fn bounds(&self, values: &[f64]) -> [f64; 2] {
        let percentiles = match self.range {
            Range::Fixed(low, high) if low.is_finite() && high.is_finite() => {
                return [low.min(high), low.max(high)];
            }
            Range::Robust => [1.0, 99.0],
            Range::Percentiles(low, high) => [low.min(high), low.max(high)],
            Range::Full | Range::Fixed(..) => [0.0, 100.0],
        };
        let mut finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        if finite.is_empty() {
            return [0.0, 0.0];
        }
        percentiles.map(|percentile| percentile_of(&mut finite, percentile))
    }
}

/// The value below which `percentile` percent of the values lie, by the nearest rank.
fn percentile_of(values: &mut [f64], percentile: f64) -> f64 {
    let share = (percentile / 100.0).clamp(0.0, 1.0);
    let rank = (share * (values.len() - 1) as f64).round() as usize;
    *values.select_nth_unstable_by(rank, f64::total_cmp).1
}

impl Legend {
    /// Where `value` lies between the ends, 0 to 1, beyond for values out of range; NaN for NaN.
    /// Where the ends coincide, the middle for values that equal them up to rounding.
    #[must_use]
    pub fn share(&self, value: f64) -> f64 {
        // Halves, because the range of two finite numbers can overflow.
        let range = self.high / 2.0 - self.low / 2.0;
        let above = value / 2.0 - self.low / 2.0;
        if range > 0.0 {
            above / range
        } else if above.abs() <= ROUNDING * self.low.abs() {
            0.5
        } else {
            above * f64::INFINITY
        }
    }

    /// The colour of `value`.
    #[must_use]
    pub fn color(&self, value: f64) -> crate::Color {
        self.map.at(self.share(value))
    }

    /// The values marked under the bar: both ends and the middle, or the one value there is.
    pub(crate) fn ticks(&self) -> Vec<f64> {
        if self.high > self.low {
            vec![self.low, self.low / 2.0 + self.high / 2.0, self.high]
        } else {
            vec![self.low]
        }
    }

    /// A number with as many digits as tell the marks apart.
    pub(crate) fn format(&self, value: f64) -> String {
        let largest = self.low.abs().max(self.high.abs());
        let range = if self.high > self.low {
            self.high / 2.0 - self.low / 2.0
        } else {
            largest
        };
        if value == 0.0 || range == 0.0 {
            return "0".into();
        }
        let [range_digits, value_digits] = [range, largest].map(|x| libm::log10(x).floor() as i32);
        if value_digits > 5 || range_digits < -5 {
            let digits = (value_digits - range_digits + 2).clamp(1, 9) as usize;
            let text = format!("{value:.digits$e}");
            let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
            let exponent = exponent.replace('-', MINUS);
            return format!("{}e{exponent}", trimmed(mantissa));
        }
        let decimals = (2 - range_digits).clamp(0, 9) as usize;
        trimmed(&format!("{value:.decimals$}"))
    }
}

const MINUS: &str = "\u{2212}";

/// A decimal number without trailing zeros and without a minus before nothing.
fn trimmed(number: &str) -> String {
    let number = if number.contains('.') {
        number.trim_end_matches('0').trim_end_matches('.')
    } else {
        number
    };
    let number = if number == "-0" { "0" } else { number };
    number.replace('-', MINUS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn legend(scale: ColorScale, values: &[f64]) -> Legend {
        scale.legend("figure", values)
    }

    #[test]
    fn a_robust_range_leaves_outliers_out_and_counts_them() {
        let mut values: Vec<f64> = (0..1000).map(f64::from).collect();
        values.extend([1e9, f64::INFINITY, f64::NAN]);
        let legend = legend(ColorScale::default(), &values);
        assert!(legend.low >= 5.0 && legend.high <= 999.0);
        assert!(legend.above >= 2 && legend.below >= 5);
        assert_eq!(legend.missing, 1);
        assert_eq!(legend.color(f64::INFINITY), ColorMap::Viridis.at(1.0));
    }

    #[test]
    fn a_middle_gets_the_middle_of_the_map() {
        let legend = legend(ColorScale::diverging(0.0), &[-1.0, 0.5, 3.0]);
        assert!((legend.low + 3.0).abs() < 1e-15 && (legend.high - 3.0).abs() < 1e-15);
        assert!((legend.share(0.0) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn a_range_of_nothing_has_one_mark_and_the_middle_colour() {
        let constant = legend(ColorScale::default(), &[2.5; 4]);
        assert_eq!(constant.ticks(), [2.5]);
        assert_eq!(constant.format(2.5), "2.5");
        assert!((constant.share(2.5) - 0.5).abs() < 1e-15);
        let none = legend(ColorScale::default(), &[f64::NAN]);
        assert!(none.low.abs() < 1e-15 && none.high.abs() < 1e-15);
    }

    #[test]
    fn rounding_has_no_colours() {
        let noise = [1.0, 1.0 + 3e-15, 1.0 - 1e-14];
        let constant = ColorScale::default().legend("error", &noise);
        assert_eq!(constant.ticks().len(), 1);
        assert!(constant.below == 0 && constant.above == 0);
        let spike = ColorScale::default().legend("error", &[&[2.0; 500][..], &[3.0]].concat());
        assert_eq!((spike.ticks().len(), spike.above), (1, 1));
        assert_eq!(spike.color(3.0), spike.map.at(1.0));
        let neutral = ColorScale::diverging(0.0);
        let neutral = neutral.legend("log area", &[1e-14, -3e-14]);
        assert!((neutral.high - 0.01).abs() < 1e-15);
        assert_eq!(neutral.below + neutral.above, 0);
        assert!((neutral.share(-3e-14) - 0.5).abs() < 1e-9);
    }

    #[test]
    fn the_widest_range_does_not_overflow() {
        let full = ColorScale {
            range: Range::Full,
            ..ColorScale::default()
        };
        let legend = legend(full, &[-f64::MAX, 0.0, f64::MAX]);
        assert!((legend.share(0.0) - 0.5).abs() < 1e-15);
        assert!(legend.ticks().iter().all(|tick| tick.is_finite()));
        let symmetric = ColorScale {
            middle: Some(1.0),
            ..full
        };
        assert!(
            symmetric
                .legend("", &[-f64::MAX, f64::MAX])
                .high
                .is_finite()
        );
    }

    #[test]
    fn numbers_have_the_digits_that_tell_them_apart() {
        let format = |low: f64, high: f64| {
            let legend = legend(
                ColorScale {
                    range: Range::Fixed(low, high),
                    ..ColorScale::default()
                },
                &[],
            );
            legend
                .ticks()
                .iter()
                .map(|&v| legend.format(v))
                .collect::<Vec<_>>()
        };
        assert_eq!(format(0.0, 1.0), ["0", "0.5", "1"]);
        assert_eq!(format(1.0, 1.0004), ["1", "1.0002", "1.0004"]);
        assert_eq!(format(-2.0, 2.0), ["\u{2212}2", "0", "2"]);
        assert_eq!(format(0.0, 3e7), ["0", "1.5e7", "3e7"]);
        assert_eq!(format(0.0, 2e-8), ["0", "1e\u{2212}8", "2e\u{2212}8"]);
    }
}
