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
        out.length() * back.length()
    }

    /// The sine of the corner's angle over that of the angle it should have; 0 without sides.
    pub(super) fn sine(&self, x: DVec3) -> f64 {
        let extent = self.extent(x);
        if extent > 0.0 {
            self.area(x) / (extent * self.angle.1)
        } else {
            0.0
        }
    }

    /// The mean ratio: 1 at the best, 0 for a corner without area, negative for an inverted one.
    pub(super) fn mean_ratio(&self, x: DVec3) -> f64 {
        let squares = self.squares(self.sides(x));
        2.0 * self.angle.1 * self.area(x) / squares.max(f64::MIN_POSITIVE)
    }

    /// The inverse mean ratio: 1 at the best, infinite for a corner without area. With a `blur`
    /// above 0 areas are replaced by positive ones that tend to them, as in [Escobar et al. 2003].
    pub(super) fn value(&self, x: DVec3, blur: f64) -> f64 {
        let [out, back] = self.sides(x);
        let area = blurred(out.cross(back).dot(self.normal), blur).0;
        self.squares([out, back]) / (2.0 * self.angle.1 * area)
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
