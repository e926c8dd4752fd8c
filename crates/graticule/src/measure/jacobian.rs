use glam::{DVec2, DVec3};

use crate::mesh::largest_of;
use crate::tolerance;

/// `a * b - c * d` with an error of at most 1.5 units in the last place (Kahan; the bound is by
/// Jeannerod, Louvet and Muller 2013).
fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let cd = c * d;
    let error = (-c).mul_add(d, cd);
    a.mul_add(b, -cd) + error
}

/// `a.perp_dot(b)` without cancellation.
pub(super) fn accurate_perp_dot(a: DVec2, b: DVec2) -> f64 {
    difference_of_products(a.x, b.y, a.y, b.x)
}

fn accurate_cross(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(
        difference_of_products(a.y, b.z, a.z, b.y),
        difference_of_products(a.z, b.x, a.x, b.z),
        difference_of_products(a.x, b.y, a.y, b.x),
    )
}

/// A triangle of a surface, laid in the plane without distortion: the domain of a linear map.
///
/// Its longest side, the base, lies on the x axis from the origin, which keeps needles and caps
/// accurate; corners keep the numbers that they were given with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SourceTriangle {
    /// The corner at the start of the base.
    first: usize,
    base: f64,
    height: f64,
    /// Distances from the foot of the height to the start and to the end of the base. The smaller
    /// is known much better than its difference from the base on needles.
    feet: [f64; 2],
}

impl SourceTriangle {
    /// Lays the triangle with these corners.
    ///
    /// `None` where it has no measurable shape: it is flatter than
    /// [`tolerance::FLAT_TRIANGLE`], or not finite.
    #[must_use]
    pub fn from_positions(corners: [DVec3; 3]) -> Option<Self> {
        let [p, q, r] = corners;
        let sides = [q - p, r - q, p - r];
        let first = largest_of(sides.map(DVec3::length_squared));
        let base = sides[first].length();
        let (after, before) = (sides[(first + 1) % 3], sides[(first + 2) % 3]);
        let height = accurate_cross(after, before).length() / base;
        let feet = [before, after].map(|side| -sides[first].dot(side) / base);
        Self::checked(first, base, height, feet)
    }

    /// Lays the triangle whose side `k`, from corner `k` to corner `k + 1`, has length
    /// `lengths[k]`.
    ///
    /// The area is computed as by Kahan (*Miscalculating Area and Angles of a Needle-like
    /// Triangle*): accurate for needles too. `None` where the lengths break the triangle inequality
    /// or as for [`from_positions`](Self::from_positions).
    #[must_use]
    pub fn from_lengths(lengths: [f64; 3]) -> Option<Self> {
        let first = largest_of(lengths);
        let (base, after, before) = (
            lengths[first],
            lengths[(first + 1) % 3],
            lengths[(first + 2) % 3],
        );
        let (middle, short) = (after.max(before), after.min(before));
        let product = (base + (middle + short))
            * (short - (base - middle))
            * (short + (base - middle))
            * (base + (middle - short));
        let excess = (before - after) * (before + after) / base;
        let feet = [base + excess, base - excess].map(|double| 0.5 * double);
        Self::checked(first, base, 0.5 * product.sqrt() / base, feet)
    }

    fn checked(first: usize, base: f64, height: f64, feet: [f64; 2]) -> Option<Self> {
        let finite = base.is_finite() && height.is_finite() && feet.iter().all(|x| x.is_finite());
        let measurable = finite && base > 0.0 && height > tolerance::FLAT_TRIANGLE * base;
        measurable.then_some(Self {
            first,
            base,
            height,
            feet,
        })
    }

    /// The area.
    #[must_use]
    pub fn area(&self) -> f64 {
        0.5 * self.base * self.height
    }

    /// The corners in the plane, counter-clockwise, in the order given.
    #[must_use]
    pub fn corners(&self) -> [DVec2; 3] {
        let mut corners = [
            DVec2::ZERO,
            DVec2::new(self.base, 0.0),
            DVec2::new(self.feet[0], self.height),
        ];
        corners.rotate_right(self.first);
        corners
    }

    /// The gradient of the linear function that is 1 at a corner and 0 at the others, for each
    /// corner in the order given.
    ///
    /// A figure that depends on the Jacobian J has the derivative `∂E/∂J · gradient` by the
    /// image of the corner: see [`Jacobian2::symmetric_dirichlet_derivative`].
    #[must_use]
    pub fn corner_gradients(&self) -> [DVec2; 3] {
        let [by_start, by_end] = self.feet.map(|foot| -foot / self.base / self.height);
        let mut gradients = [
            DVec2::new(-1.0 / self.base, by_end),
            DVec2::new(1.0 / self.base, by_start),
            DVec2::new(0.0, 1.0 / self.height),
        ];
        gradients.rotate_right(self.first);
        gradients
    }

    /// The Jacobian of the linear map that takes the corners to `images`.
    ///
    /// Its error is that of the images' rounding, magnified by the ratio of side and height.
    #[must_use]
    pub fn jacobian(&self, images: [DVec2; 3]) -> Jacobian2 {
        let [base, from_start, from_end] = self.image_sides(images);
        let along = base / self.base;
        let (rise, leg) = if self.feet[0] <= self.feet[1] {
            (from_start - along * self.feet[0], from_start)
        } else {
            (from_end + along * self.feet[1], from_end)
        };
        let across = rise / self.height;
        let determinant = accurate_perp_dot(base, leg) / self.base / self.height;
        Jacobian2 {
            gradients: [DVec2::new(along.x, across.x), DVec2::new(along.y, across.y)],
            determinant,
        }
    }

    /// The mean over the three corners of the change of angle between this triangle and the
    /// triangle of `images`, without regard to orientation, in radians.
    #[must_use]
    pub fn angle_change(&self, images: [DVec2; 3]) -> f64 {
        let [base, from_start, from_end] = self.image_sides(images);
        let leg = if self.feet[0] <= self.feet[1] {
            from_start
        } else {
            from_end
        };
        let double_area = accurate_perp_dot(base, leg).abs();
        let first = angle_between(
            [self.feet[0], self.height],
            [base.dot(from_start), double_area],
        );
        let second = angle_between(
            [self.feet[1], self.height],
            [-base.dot(from_end), double_area],
        );
        // The angles of both triangles sum to π, so that the changes sum to 0.
        (first.abs() + second.abs() + (first + second).abs()) / 3.0
    }

    /// The images of the base, of the vector from its start to the apex, and from its end.
    fn image_sides(&self, images: [DVec2; 3]) -> [DVec2; 3] {
        let [start, end, apex] = [0, 1, 2].map(|step| images[(self.first + step) % 3]);
        [end - start, apex - start, apex - end]
    }
}

/// The angle from the first direction to the second one, both in the upper half-plane.
fn angle_between(first: [f64; 2], second: [f64; 2]) -> f64 {
    // Products of directions of any length would underflow.
    let scaled = |[x, y]: [f64; 2]| {
        let size = x.abs() + y;
        if size > 0.0 {
            DVec2::new(x / size, y / size)
        } else {
            DVec2::X
        }
    };
    let [a, b] = [scaled(first), scaled(second)];
    libm::atan2(accurate_perp_dot(a, b), a.dot(b))
}

/// The Jacobian of a linear map of the plane, by the gradients of its two coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jacobian2 {
    gradients: [DVec2; 2],
    determinant: f64,
}

impl Jacobian2 {
    /// The map with these gradients of its coordinates u and v.
    #[must_use]
    pub fn new(gradients: [DVec2; 2]) -> Self {
        let determinant = accurate_perp_dot(gradients[0], gradients[1]);
        Self {
            gradients,
            determinant,
        }
    }

    /// The gradients of the coordinates u and v: the rows of the matrix.
    #[must_use]
    pub fn gradients(&self) -> [DVec2; 2] {
        self.gradients
    }

    /// The scale of areas, below 0 where the map turns the triangle over.
    #[must_use]
    pub fn determinant(&self) -> f64 {
        self.determinant
    }

    /// The sum of squares of the entries: |∇u|² + |∇v|².
    #[must_use]
    pub fn norm_squared(&self) -> f64 {
        let [u, v] = self.gradients;
        u.length_squared() + v.length_squared()
    }

    /// The greatest and the least factor by which lengths change, both at least 0.
    ///
    /// The larger is the sum of the conformal and the anticonformal part; the smaller is the
    /// determinant over the larger, which does not cancel as their difference does.
    #[must_use]
    pub fn singular_values(&self) -> [f64; 2] {
        let [u, v] = self.gradients;
        let conformal = 0.5 * DVec2::new(u.x + v.y, v.x - u.y).length();
        let anticonformal = 0.5 * DVec2::new(u.x - v.y, v.x + u.y).length();
        let larger = conformal + anticonformal;
        if larger > 0.0 {
            [larger, (self.determinant.abs() / larger).min(larger)]
        } else {
            [0.0, 0.0]
        }
    }

    /// |cos| of the angle between the gradients of u and v, in `0.0..=1.0`; 0 where one of them
    /// vanishes. Source: the shear column of Table I in [`PGP06`].
    ///
    /// [`PGP06`]: crate::papers::PGP06
    #[must_use]
    pub fn shear(&self) -> f64 {
        let [u, v] = self.gradients;
        let lengths = u.length() * v.length();
        if lengths > 0.0 {
            (u.dot(v).abs() / lengths).min(1.0)
        } else {
            0.0
        }
    }

    /// The squared L² stretch (σ₁⁻² + σ₂⁻²) / 2 of the inverse map. Source: [`SSGH01`] §3.
    ///
    /// [`SSGH01`]: crate::papers::SSGH01
    #[must_use]
    pub fn squared_stretch(&self) -> f64 {
        0.5 * self.norm_squared() / (self.determinant * self.determinant)
    }

    /// The derivative of [`squared_stretch`](Self::squared_stretch) by the rows of the matrix.
    #[must_use]
    pub fn squared_stretch_derivative(&self) -> [DVec2; 2] {
        let square = self.determinant * self.determinant;
        let by_determinant = -self.norm_squared() / (square * self.determinant);
        self.combine(1.0 / square, by_determinant)
    }

    /// The symmetric Dirichlet energy per area, σ₁² + σ₂² + σ₁⁻² + σ₂⁻²; 4 for an isometry.
    /// Source: [`SS15`].
    ///
    /// [`SS15`]: crate::papers::SS15
    #[must_use]
    pub fn symmetric_dirichlet(&self) -> f64 {
        self.norm_squared() + 2.0 * self.squared_stretch()
    }

    /// The derivative of [`symmetric_dirichlet`](Self::symmetric_dirichlet) by the rows of the
    /// matrix.
    #[must_use]
    pub fn symmetric_dirichlet_derivative(&self) -> [DVec2; 2] {
        let square = self.determinant * self.determinant;
        let by_determinant = -2.0 * self.norm_squared() / (square * self.determinant);
        self.combine(2.0 + 2.0 / square, by_determinant)
    }

    /// `by_matrix` · J + `by_determinant` · ∂(det J)/∂J.
    fn combine(&self, by_matrix: f64, by_determinant: f64) -> [DVec2; 2] {
        let [u, v] = self.gradients;
        [
            u * by_matrix + DVec2::new(v.y, -v.x) * by_determinant,
            v * by_matrix + DVec2::new(-u.y, u.x) * by_determinant,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    fn close(a: f64, b: f64, tolerance: f64) -> bool {
        (a - b).abs() <= tolerance * b.abs().max(1.0)
    }

    fn random(noise: &mut Noise) -> DVec2 {
        DVec2::new(noise.signed(), noise.signed())
    }

    #[test]
    fn a_triangle_laid_in_the_plane_keeps_its_sides_and_its_corner_numbers() {
        let corners = [
            DVec3::ZERO,
            DVec3::new(1.0, 2.0, 2.0),
            DVec3::new(-5.0, 0.0, 1.0),
        ];
        for turn in 0..3 {
            let mut turned = corners;
            turned.rotate_left(turn);
            let lengths = [0, 1, 2].map(|k: usize| turned[k].distance(turned[(k + 1) % 3]));
            for source in [
                SourceTriangle::from_positions(turned).unwrap(),
                SourceTriangle::from_lengths(lengths).unwrap(),
            ] {
                let laid = source.corners();
                for k in 0..3 {
                    assert!(close(
                        laid[k].distance(laid[(k + 1) % 3]),
                        lengths[k],
                        1e-14
                    ));
                }
                assert!((laid[1] - laid[0]).perp_dot(laid[2] - laid[0]) > 0.0);
                assert!(close(
                    source.area(),
                    0.5 * corners[1].cross(corners[2]).length(),
                    1e-14
                ));
            }
        }
    }

    #[test]
    fn the_jacobian_of_a_linear_map_is_its_matrix_up_to_a_rotation_of_the_domain() {
        let mut noise = Noise::new(1);
        for _ in 0..200 {
            let flat = [(); 3].map(|()| random(&mut noise));
            let [row_u, row_v] = [random(&mut noise), random(&mut noise)];
            let images = flat.map(|p| DVec2::new(row_u.dot(p), row_v.dot(p)));
            let source = SourceTriangle::from_positions(flat.map(|p| p.extend(0.0))).unwrap();
            let jacobian = source.jacobian(images);
            let condition = source.base / source.height;
            let [u, v] = jacobian.gradients();
            assert!(close(u.length(), row_u.length(), 1e-13 * condition));
            assert!(close(v.length(), row_v.length(), 1e-13 * condition));
            assert!(close(u.dot(v), row_u.dot(row_v), 1e-13 * condition));
            let [larger, smaller] = jacobian.singular_values();
            let determinant = row_u.perp_dot(row_v);
            assert!(close(
                larger * smaller,
                determinant.abs(),
                1e-13 * condition
            ));
            let squares = row_u.length_squared() + row_v.length_squared();
            assert!(close(
                larger * larger + smaller * smaller,
                squares,
                1e-12 * condition
            ));
            let by_gradients = (0..3).fold([DVec2::ZERO; 2], |[a, b], k| {
                let gradient = source.corner_gradients()[k];
                [a + images[k].x * gradient, b + images[k].y * gradient]
            });
            assert!(by_gradients[0].distance(u) <= 1e-13 * condition * condition);
            assert!(by_gradients[1].distance(v) <= 1e-13 * condition * condition);
        }
    }

    #[test]
    fn needles_and_caps_are_measured_at_any_scale() {
        for scale in [1e-30, 1.0, 1e30] {
            for thin in [1e-3, 1e-6, 1e-9] {
                let needle = [DVec2::ZERO, DVec2::X, DVec2::new(1.0, thin)];
                let cap = [DVec2::ZERO, DVec2::new(0.37, thin), DVec2::X];
                let short = [DVec2::new(0.0, thin), DVec2::ZERO, DVec2::X];
                for flat in [needle, cap, short] {
                    let corners = flat.map(|p| (p * scale).extend(0.0));
                    let source = SourceTriangle::from_positions(corners).unwrap();
                    let images = flat.map(|p| DVec2::new(3.0 * p.x, p.y) / scale);
                    let [larger, smaller] = source.jacobian(images).singular_values();
                    let unit = scale * scale;
                    assert!(close(larger * unit, 3.0, 1e-12), "{larger} {scale} {thin}");
                    assert!(
                        close(smaller * unit, 1.0, 1e-12),
                        "{smaller} {scale} {thin}"
                    );
                    assert!(source.angle_change(flat) < 1e-14);
                }
            }
        }
    }

    #[test]
    fn a_triangle_without_shape_is_refused() {
        let line = [DVec3::ZERO, DVec3::splat(1.0), DVec3::splat(3.0)];
        assert_eq!(SourceTriangle::from_positions(line), None);
        assert_eq!(SourceTriangle::from_positions([DVec3::ONE; 3]), None);
        assert_eq!(SourceTriangle::from_lengths([1.0, 1.0, 2.5]), None);
        assert_eq!(SourceTriangle::from_lengths([0.0; 3]), None);
        assert_eq!(SourceTriangle::from_lengths([f64::NAN, 1.0, 1.0]), None);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let mut noise = Noise::new(7);
        let step = 1e-6;
        for _ in 0..50 {
            let rows = [
                random(&mut noise) + DVec2::X * 2.0,
                random(&mut noise) + DVec2::Y * 2.0,
            ];
            let jacobian = Jacobian2::new(rows);
            let derivatives = [
                jacobian.symmetric_dirichlet_derivative(),
                jacobian.squared_stretch_derivative(),
            ];
            let figures = [Jacobian2::symmetric_dirichlet, Jacobian2::squared_stretch];
            for (derivative, figure) in derivatives.into_iter().zip(figures) {
                for entry in 0..4 {
                    let shifted = |by: f64| {
                        let mut rows = rows;
                        rows[entry / 2][entry % 2] += by;
                        figure(&Jacobian2::new(rows))
                    };
                    let difference = (shifted(step) - shifted(-step)) / (2.0 * step);
                    let value = derivative[entry / 2][entry % 2];
                    assert!(close(value, difference, 1e-6), "{value} {difference}");
                }
            }
        }
    }

    #[test]
    fn the_angle_change_of_an_equilateral_triangle_stretched_to_a_right_one_is_known() {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::new(0.5, 0.75_f64.sqrt())];
        let source = SourceTriangle::from_positions(corners.map(|p| p.extend(0.0))).unwrap();
        let right = [DVec2::ZERO, DVec2::X, DVec2::Y];
        // 60° to 90°, 45°, 45°: changes 30°, 15°, 15°.
        assert!(close(
            source.angle_change(right),
            20_f64.to_radians(),
            1e-14
        ));
        let mirrored = right.map(|p| DVec2::new(-p.x, p.y));
        assert!(close(
            source.angle_change(mirrored),
            20_f64.to_radians(),
            1e-14
        ));
    }
}
