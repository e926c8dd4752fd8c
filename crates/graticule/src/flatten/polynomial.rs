//! Polynomials of degree four and their least values, in closed form.

use std::f64::consts::TAU;

use crate::tolerance::ROUNDING;

/// `c₀ + c₁ x + c₂ x² + c₃ x³ + c₄ x⁴`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Quartic(pub(super) [f64; 5]);

impl Quartic {
    /// Adds the square of `a + b x + c x²`, times `weight`.
    pub(super) fn add_square(&mut self, [a, b, c]: [f64; 3], weight: f64) {
        let square = [a * a, 2.0 * a * b, 2.0 * a * c + b * b, 2.0 * b * c, c * c];
        for (sum, term) in self.0.iter_mut().zip(square) {
            *sum += weight * term;
        }
    }

    pub(super) fn value(&self, x: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, c| sum * x + c)
    }

    /// Where the slope is zero: one to three places, none if it is zero everywhere or nowhere.
    pub(super) fn critical_points(&self) -> Vec<f64> {
        let [_, b, c, d, e] = self.0;
        cubic_roots([b, 2.0 * c, 3.0 * d, 4.0 * e])
    }
}

/// The real roots of `c₀ + c₁ x + c₂ x² + c₃ x³`, ascending.
///
/// In closed form (three real roots by cosines, one by cube roots), then improved by Newton's
/// method. A leading coefficient that is rounding beside the others counts as zero.
pub(super) fn cubic_roots(coefficients: [f64; 4]) -> Vec<f64> {
    let largest = coefficients.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return Vec::new();
    }
    let c = coefficients.map(|c| c / largest);
    let mut roots = if c[3].abs() > ROUNDING {
        monic_cubic_roots([c[0] / c[3], c[1] / c[3], c[2] / c[3]])
    } else if c[2].abs() > ROUNDING {
        quadratic_roots([c[0], c[1], c[2]])
    } else if c[1].abs() > ROUNDING {
        vec![-c[0] / c[1]]
    } else {
        Vec::new()
    };
    for root in &mut roots {
        *root = polished(c, *root);
    }
    roots.retain(|root| root.is_finite());
    roots.sort_by(f64::total_cmp);
    roots
}

/// Two steps of Newton's method, each taken only if it makes the value smaller.
fn polished(c: [f64; 4], mut root: f64) -> f64 {
    let value = |x: f64| ((c[3] * x + c[2]) * x + c[1]) * x + c[0];
    for _ in 0..2 {
        let slope = (3.0 * c[3] * root + 2.0 * c[2]) * root + c[1];
        let next = root - value(root) / slope;
        if value(next).abs() < value(root).abs() {
            root = next;
        }
    }
    root
}

fn quadratic_roots([c, b, a]: [f64; 3]) -> Vec<f64> {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return Vec::new();
    }
    // The larger root by a sum without cancellation, the other from their product.
    let sum = -0.5 * (b + discriminant.sqrt().copysign(b));
    if sum == 0.0 {
        return vec![0.0];
    }
    vec![sum / a, c / sum]
}

/// Roots of `c + b x + a x² + x³`.
fn monic_cubic_roots([c, b, a]: [f64; 3]) -> Vec<f64> {
    let shift = a / 3.0;
    let p = b - a * shift;
    let q = c + shift * (2.0 * shift * shift - b);
    let half = 0.5 * q;
    let third = p / 3.0;
    let discriminant = half * half + third * third * third;
    if discriminant > 0.0 {
        let u = -(half + discriminant.sqrt().copysign(half));
        let u = libm::cbrt(u);
        let v = if u == 0.0 { 0.0 } else { -third / u };
        return vec![u + v - shift];
    }
    let radius = (-third).sqrt();
    if radius == 0.0 {
        return vec![-shift];
    }
    let cosine = (-half / (radius * radius * radius)).clamp(-1.0, 1.0);
    let angle = libm::acos(cosine) / 3.0;
    let root = |turn: f64| 2.0 * radius * libm::cos(angle + turn) - shift;
    vec![root(0.0), root(TAU / 3.0), root(2.0 * TAU / 3.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    #[test]
    fn cubics_have_the_roots_that_they_were_made_from() {
        let mut noise = Noise::new(5);
        for _ in 0..2000 {
            let mut made = [0, 1, 2].map(|_| 3.0 * noise.signed());
            made.sort_by(f64::total_cmp);
            let [r, s, t] = made;
            let k = 10.0_f64.powf(8.0 * noise.signed());
            let cubic = [
                -k * r * s * t,
                k * (r * s + s * t + t * r),
                -k * (r + s + t),
                k,
            ];
            let found = cubic_roots(cubic);
            assert_eq!(found.len(), 3, "{made:?} {found:?}");
            let gap = (s - r).min(t - s);
            for (found, made) in found.iter().zip(made) {
                assert!(
                    (found - made).abs() < 1e-13 / gap.min(1.0).powi(2),
                    "{made} {found}"
                );
            }
        }
    }

    #[test]
    fn cubics_with_one_real_root_and_lower_degrees_are_solved() {
        let [root] = cubic_roots([-2.0, 0.0, 0.0, 1.0])[..] else {
            panic!("not one root");
        };
        assert!((root - 2.0_f64.cbrt()).abs() < 1e-15);
        let close = |cubic: [f64; 4], expected: &[f64]| {
            let found = cubic_roots(cubic);
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-14);
            }
        };
        close([2.0, -3.0, 1.0, 0.0], &[1.0, 2.0]);
        close([3.0, -2.0, 0.0, 0.0], &[1.5]);
        close([0.0, 0.0, 0.0, 1.0], &[0.0]);
        assert!(cubic_roots([1.0, 0.0, 1.0, 0.0]).is_empty());
        assert!(cubic_roots([1.0, 0.0, 0.0, 0.0]).is_empty());
        assert!(cubic_roots([0.0; 4]).is_empty());
    }

    #[test]
    fn the_least_critical_point_of_a_quartic_is_its_minimum() {
        let mut noise = Noise::new(6);
        for _ in 0..300 {
            let mut quartic = Quartic::default();
            for _ in 0..4 {
                quartic.add_square([noise.signed(), noise.signed(), noise.signed()], 1.0);
            }
            let values = quartic.critical_points().into_iter();
            let best = values
                .map(|x| quartic.value(x))
                .fold(f64::INFINITY, f64::min);
            for k in -4000..=4000 {
                let x = f64::from(k) * 1e-3;
                assert!(quartic.value(x) >= best - 1e-12);
            }
        }
    }
}
