use glam::{DVec2, DVec3};

/// A corner of a polygon as a function of one vertex `x`: its sides are `out.0 + out.1 · x` to the
/// next corner and `back.0 + back.1 · x` to the one before.
#[derive(Clone, Copy, Debug)]
pub(super) struct CornerTerm {
    pub(super) out: (DVec3, f64),
    pub(super) back: (DVec3, f64),
    /// The normal of the polygon.
    pub(super) normal: DVec3,
    /// The length that the side out should have, over that of the side back.
    pub(super) ratio: f64,
    /// Cosine and sine of the angle that the corner should have.
    pub(super) angle: (f64, f64),
}

/// How good a corner is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grade {
    /// The inverse mean ratio: 1 at the best, infinite for a corner without area.
    pub(super) value: f64,
    /// The sine of its angle over that of the angle it should have.
    pub(super) sine: f64,
    /// The mean ratio: 1 at the best, 0 for a corner without area, negative for an inverted one.
    pub(super) mean_ratio: f64,
}

/// Value, and derivatives along two directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Derivatives {
    pub(super) value: f64,
    pub(super) gradient: DVec2,
    /// The second derivatives: xx, xy, yy.
    pub(super) hessian: [f64; 3],
}

impl CornerTerm {
    fn sides(&self, x: DVec3) -> [DVec3; 2] {
        [self.out.0 + self.out.1 * x, self.back.0 + self.back.1 * x]
    }

    /// Twice the area that the sides span, negative where the corner is inverted.
    pub(super) fn area(&self, x: DVec3) -> f64 {
        let [out, back] = self.sides(x);
        out.cross(back).dot(self.normal)
    }

    /// The area of the rectangle on the sides.
    pub(super) fn extent(&self, x: DVec3) -> f64 {
        let [out, back] = self.sides(x);
        (out.length_squared() * back.length_squared()).sqrt()
    }

    /// How good the corner is. With a `blur` above 0 its value takes positive areas that tend to the
    /// true ones, as in [Escobar et al. 2003].
    ///
    /// A corner without sides counts as the worst: an inverted one can be turned back, two vertices
    /// in one place seldom part.
    pub(super) fn grade(&self, x: DVec3, blur: f64) -> Grade {
        let sides = self.sides(x);
        let [out, back] = sides;
        let area = out.cross(back).dot(self.normal);
        let extent = (out.length_squared() * back.length_squared()).sqrt();
        let squares = self.squares(sides);
        let sine_wanted = self.angle.1;
        let (sine, mean_ratio) = if extent > 0.0 {
            let ratio = 2.0 * sine_wanted * area / squares.max(f64::MIN_POSITIVE);
            (area / (extent * sine_wanted), ratio)
        } else {
            (-1.0, -1.0)
        };
        Grade {
            value: squares / (2.0 * sine_wanted * blurred(area, blur).0),
            sine,
            mean_ratio,
        }
    }

    fn squares(&self, [out, back]: [DVec3; 2]) -> f64 {
        let lengths = out.length_squared() / self.ratio + back.length_squared() * self.ratio;
        lengths - 2.0 * self.angle.0 * out.dot(back)
    }

    /// The value with its derivatives along the two directions. The second derivative of the
    /// blurred area is left out, so that the Hessian is positive for any blur.
    pub(super) fn derivatives(&self, x: DVec3, blur: f64, [u, v]: [DVec3; 2]) -> Derivatives {
        let [out, back] = self.sides(x);
        let [with_out, with_back] = [self.out.1, self.back.1];
        let cosine = self.angle.0;
        let [weight_out, weight_back] = [1.0 / self.ratio, self.ratio];
        let (area, slope) = blurred(out.cross(back).dot(self.normal), blur);
        let along = |w: DVec3| DVec2::new(w.dot(u), w.dot(v));
        let squares_gradient = along(
            2.0 * (weight_out * with_out * out + weight_back * with_back * back)
                - 2.0 * cosine * (with_out * back + with_back * out),
        );
        let area_gradient = along(
            slope * (with_out * back.cross(self.normal) + with_back * self.normal.cross(out)),
        );
        let bend = 2.0 * (weight_out * with_out * with_out + weight_back * with_back * with_back)
            - 4.0 * cosine * with_out * with_back;
        let scale = 1.0 / (2.0 * self.angle.1 * area);
        let value = self.squares([out, back]) * scale;
        let gradient = squares_gradient * scale - area_gradient * (value / area);
        let [g, a] = [gradient, area_gradient / area];
        Derivatives {
            value,
            gradient,
            hessian: [
                bend * scale * u.length_squared() - 2.0 * g.x * a.x,
                bend * scale * u.dot(v) - g.x * a.y - g.y * a.x,
                bend * scale * v.length_squared() - 2.0 * g.y * a.y,
            ],
        }
    }
}

/// A positive number that tends to `area` where that is large beside `blur`, and its derivative.
fn blurred(area: f64, blur: f64) -> (f64, f64) {
    if blur == 0.0 {
        let usable = area.max(0.0);
        return (usable, 1.0);
    }
    let root = (area * area + 4.0 * blur * blur).sqrt();
    // For negative areas the sum would cancel.
    let value = if area >= 0.0 {
        0.5 * (area + root)
    } else {
        2.0 * blur * blur / (root - area)
    };
    (value, value / root)
}

/// The sum of a power of the values of terms, with its derivatives.
pub(super) fn sum_of_powers(terms: impl Iterator<Item = Derivatives>, power: u32) -> Derivatives {
    let degree = f64::from(power);
    let mut sum = Derivatives::default();
    for term in terms {
        let raised = raise(term.value, power);
        let first = degree * raised / term.value;
        let second = (degree - 1.0) / term.value;
        let g = term.gradient;
        sum.value += raised;
        sum.gradient += first * g;
        let products = [g.x * g.x, g.x * g.y, g.y * g.y];
        for (slot, (bend, product)) in sum
            .hessian
            .iter_mut()
            .zip(term.hessian.iter().zip(products))
        {
            *slot += first * (bend + second * product);
        }
    }
    sum
}

/// A power, by multiplications that are the same on every machine.
pub(super) fn raise(value: f64, power: u32) -> f64 {
    (1..power).fold(value, |product, _| product * value)
}

impl Derivatives {
    /// The step to the minimum of the quadratic function with these derivatives, or down the
    /// gradient where it has none.
    pub(super) fn newton_step(&self) -> DVec2 {
        let [xx, xy, yy] = self.hessian;
        let determinant = xx * yy - xy * xy;
        let g = self.gradient;
        if xx > 0.0 && determinant > 1e-3 * xx * yy {
            return -DVec2::new(yy * g.x - xy * g.y, xx * g.y - xy * g.x) / determinant;
        }
        -g / (xx.abs() + yy.abs()).max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corner of a quad and that of a triangle as functions of the vertex at the corner, and of
    /// the one after it.
    fn terms() -> [CornerTerm; 3] {
        let [after, before] = [DVec3::new(1.1, 0.1, 0.2), DVec3::new(-0.1, 0.8, 0.1)];
        let normal = DVec3::new(0.1, -0.2, 1.0).normalize();
        let corner = CornerTerm {
            out: (after, -1.0),
            back: (before, -1.0),
            normal,
            ratio: 1.7,
            angle: (0.0, 1.0),
        };
        let of_triangle = CornerTerm {
            ratio: 1.0,
            angle: (0.5, 0.75_f64.sqrt()),
            ..corner
        };
        let after_it = CornerTerm {
            out: (DVec3::ZERO, 1.0),
            back: (before, 0.0),
            ..corner
        };
        [corner, of_triangle, after_it]
    }

    const DIRECTIONS: [DVec3; 2] = [DVec3::new(0.8, 0.6, 0.0), DVec3::new(0.0, 0.6, 0.8)];

    #[test]
    fn derivatives_agree_with_differences() {
        let x = DVec3::new(0.15, -0.1, 0.05);
        let step = 1e-5;
        for (term, blur) in terms()
            .into_iter()
            .flat_map(|term| [(term, 0.0), (term, 0.3)])
        {
            let x = x + term.out.1.max(0.0) * DVec3::X;
            let exact = term.derivatives(x, blur, DIRECTIONS);
            assert!((exact.value - term.grade(x, blur).value).abs() < 1e-12);
            for (axis, direction) in DIRECTIONS.into_iter().enumerate() {
                let at =
                    |share: f64| term.derivatives(x + direction * (share * step), blur, DIRECTIONS);
                let slope = (at(1.0).value - at(-1.0).value) / (2.0 * step);
                assert!((slope - exact.gradient[axis]).abs() < 1e-7);
                if blur == 0.0 {
                    let bend = (at(1.0).gradient - at(-1.0).gradient) / (2.0 * step);
                    let [xx, xy, yy] = exact.hessian;
                    let expected = [DVec2::new(xx, xy), DVec2::new(xy, yy)][axis];
                    assert!((bend - expected).length() < 1e-6, "{bend} {expected}");
                }
            }
        }
    }

    #[test]
    fn the_best_corner_has_the_proportions_and_the_angle_wanted() {
        let [corner, of_triangle, _] = terms();
        let rectangle = CornerTerm {
            out: (DVec3::X * 1.7, -1.0),
            back: (DVec3::Y, -1.0),
            normal: DVec3::Z,
            ..corner
        };
        assert!((rectangle.grade(DVec3::ZERO, 0.0).value - 1.0).abs() < 1e-12);
        assert!((rectangle.grade(DVec3::ZERO, 0.0).mean_ratio - 1.0).abs() < 1e-12);
        let equilateral = CornerTerm {
            out: (DVec3::X, -1.0),
            back: (DVec3::new(0.5, 0.75_f64.sqrt(), 0.0), -1.0),
            normal: DVec3::Z,
            ..of_triangle
        };
        assert!((equilateral.grade(DVec3::ZERO, 0.0).value - 1.0).abs() < 1e-12);
        for term in [rectangle, equilateral] {
            let at_best = term.derivatives(DVec3::ZERO, 0.0, [DVec3::X, DVec3::Y]);
            assert!(at_best.gradient.length() < 1e-12);
            assert!(term.grade(DVec3::new(0.1, 0.05, 0.0), 0.0).value > 1.0);
        }
    }

    #[test]
    fn a_newton_step_finds_the_minimum_of_powers_of_convex_terms() {
        // The corner between four neighbours at the ends of a cross that is not quite straight.
        let ends = [[1.0, 0.1], [-0.1, 1.0], [-1.0, 0.0], [0.1, -1.0]];
        let ends = ends.map(|[x, y]| DVec3::new(x, y, 0.0));
        let terms: Vec<_> = (0..4)
            .map(|k| CornerTerm {
                out: (ends[k], -1.0),
                back: (ends[(k + 1) % 4], -1.0),
                normal: DVec3::Z,
                ratio: 1.0,
                angle: (0.0, 1.0),
            })
            .collect();
        for power in [1, 6] {
            let mut x = DVec3::new(0.2, 0.1, 0.0);
            let at = |x: DVec3| {
                let terms = terms
                    .iter()
                    .map(|term| term.derivatives(x, 0.0, [DVec3::X, DVec3::Y]));
                sum_of_powers(terms, power)
            };
            for _ in 0..12 {
                x += at(x).newton_step().extend(0.0);
            }
            assert!(at(x).gradient.length() < 1e-10);
            let around = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
            assert!(
                around
                    .iter()
                    .all(|way| at(x + 0.01 * way).value > at(x).value)
            );
        }
    }
}
