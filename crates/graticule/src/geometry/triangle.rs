use std::array;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

use glam::{DVec2, DVec3};

use crate::mesh::{Element, FaceId, PerCorner, PerFace, Surface, largest_of};
use crate::tolerance::DEGENERATE_HEIGHT;

use super::GeometryError;

/// The shape of one triangle, without its place in space.
///
/// Side `k` runs from corner `k` to corner `k + 1`. Beside the lengths of the sides it holds, for
/// each corner, the scalar product of the two sides that leave it, and twice the area. Angles,
/// cotangents and edge flips are quotients of these. They follow from the lengths, but not to full
/// accuracy: a height `h` over a side `c` changes the lengths by about `h² / c`, so lengths in
/// double precision know nothing of heights below 1e-8 `c`. Taken from positions, the products
/// keep an absolute error of a few ε times the two sides multiplied, and the area a relative error
/// of a few ε over the sine of the largest angle (ε = 1.1e-16).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleShape {
    lengths: [f64; 3],
    dots: [f64; 3],
    double_area: f64,
}

impl TriangleShape {
    /// The shape of the triangle with these corners.
    ///
    /// The area is that of the parallelogram of the two *shorter* sides, which is exact for
    /// needles and loses least for flat triangles.
    #[must_use]
    pub fn from_positions(corners: [DVec3; 3]) -> Self {
        let sides: [DVec3; 3] = array::from_fn(|k| corners[(k + 1) % 3] - corners[k]);
        let lengths = sides.map(DVec3::length);
        let longest = largest_of(lengths);
        let spanned = sides[(longest + 1) % 3].cross(sides[(longest + 2) % 3]);
        Self {
            lengths,
            dots: array::from_fn(|k| -sides[k].dot(sides[(k + 2) % 3])),
            double_area: spanned.length(),
        }
    }

    /// The shape of the triangle with these lengths of its sides, or `None` if they are not finite,
    /// negative, or break the triangle inequality. Equality is allowed: the area is 0 then.
    ///
    /// The area is accurate to a few ε in terms of the lengths as given, for needles too
    /// (W. Kahan, *Miscalculating Area and Angles of a Needle-like Triangle*, 2014).
    #[must_use]
    pub fn from_lengths(lengths: [f64; 3]) -> Option<Self> {
        if lengths.iter().any(|l| !l.is_finite() || *l < 0.0) {
            return None;
        }
        let [a, b, c] = descending(lengths);
        let excess = c - (a - b);
        if excess < 0.0 {
            return None;
        }
        let product = (a + (b + c)) * excess * (c + (a - b)) * (a + (b - c));
        Some(Self {
            lengths,
            dots: array::from_fn(|k| {
                let (side, opposite, other) =
                    (lengths[k], lengths[(k + 1) % 3], lengths[(k + 2) % 3]);
                let (small, big) = (side.min(other), side.max(other));
                f64::midpoint(small * small, (big - opposite) * (big + opposite))
            }),
            double_area: 0.5 * product.sqrt(),
        })
    }

    pub(super) fn from_parts(lengths: [f64; 3], dots: [f64; 3], double_area: f64) -> Self {
        Self {
            lengths,
            dots,
            double_area,
        }
    }

    /// The same triangle with corner `first` as its corner 0.
    pub(super) fn starting_at(&self, first: usize) -> Self {
        Self {
            lengths: array::from_fn(|k| self.lengths[(k + first) % 3]),
            dots: array::from_fn(|k| self.dots[(k + first) % 3]),
            double_area: self.double_area,
        }
    }

    /// The lengths of the sides.
    #[inline]
    #[must_use]
    pub fn lengths(&self) -> [f64; 3] {
        self.lengths
    }

    /// The length of a side, `0..3`.
    #[inline]
    #[must_use]
    pub fn length(&self, side: usize) -> f64 {
        self.lengths[side]
    }

    /// The scalar product of the two sides that leave a corner, `0..3`.
    #[inline]
    #[must_use]
    pub fn dot(&self, corner: usize) -> f64 {
        self.dots[corner]
    }

    /// Twice the area.
    #[inline]
    #[must_use]
    pub fn double_area(&self) -> f64 {
        self.double_area
    }

    /// The area.
    #[inline]
    #[must_use]
    pub fn area(&self) -> f64 {
        0.5 * self.double_area
    }

    /// Smallest height over longest side, in `0.0..=0.87`; 0 if all corners coincide.
    #[must_use]
    pub fn height_ratio(&self) -> f64 {
        let longest = self.lengths[largest_of(self.lengths)];
        if longest > 0.0 {
            self.double_area / longest / longest
        } else {
            0.0
        }
    }

    /// Whether the height is below [`DEGENERATE_HEIGHT`] of the longest side.
    #[must_use]
    pub fn is_degenerate(&self) -> bool {
        self.height_ratio() < DEGENERATE_HEIGHT
    }

    /// The angle at a corner, in `0.0..=π`. The three sum to π for degenerate triangles too.
    #[must_use]
    pub fn angle(&self, corner: usize) -> f64 {
        let dot = self.dots[corner];
        if dot != 0.0 || self.double_area != 0.0 {
            return libm::atan2(self.double_area, dot);
        }
        // A side of length 0: the limit of isosceles, or of equilateral, triangles.
        let coincide = self.lengths.iter().all(|&length| length == 0.0);
        if coincide { FRAC_PI_3 } else { FRAC_PI_2 }
    }

    /// The angles at the corners.
    #[must_use]
    pub fn angles(&self) -> [f64; 3] {
        array::from_fn(|corner| self.angle(corner))
    }

    /// The cotangent of the angle at a corner, or `None` where it is not a finite number.
    #[inline]
    #[must_use]
    pub fn cotangent(&self, corner: usize) -> Option<f64> {
        finite(self.dots[corner] / self.double_area)
    }

    /// The tangent of half the angle at a corner, or `None` where it is not a finite number.
    #[must_use]
    pub fn half_angle_tangent(&self, corner: usize) -> Option<f64> {
        let sides = self.lengths[corner] * self.lengths[(corner + 2) % 3];
        let dot = self.dots[corner];
        // (1 - cos) / sin or sin / (1 + cos), whichever does not cancel.
        if dot > 0.0 {
            finite(self.double_area / (sides + dot))
        } else {
            finite((sides - dot) / self.double_area)
        }
    }

    /// The corners in the plane: corner 0 at the origin, side 0 along the x axis, counter-clockwise.
    #[must_use]
    pub fn corners(&self) -> [DVec2; 3] {
        let base = self.lengths[0];
        let apex = if base > 0.0 {
            DVec2::new(self.dots[0], self.double_area) / base
        } else {
            DVec2::new(0.0, self.lengths[2])
        };
        [DVec2::ZERO, DVec2::new(base, 0.0), apex]
    }

    /// The error that names this triangle as degenerate.
    pub(super) fn degenerate(&self, face: FaceId) -> GeometryError {
        let height_ratio = self.height_ratio();
        GeometryError::DegenerateFace { face, height_ratio }
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

pub(super) fn descending(mut lengths: [f64; 3]) -> [f64; 3] {
    lengths.sort_unstable_by(|a, b| b.total_cmp(a));
    lengths
}

/// The shape of each triangle of a surface.
///
/// Cost: linear, in parallel.
#[must_use]
pub fn face_shapes(surface: &Surface) -> PerFace<TriangleShape> {
    use rayon::prelude::*;
    let faces = 0..surface.mesh().face_count();
    let shape = |face| TriangleShape::from_positions(surface.corner_positions(face));
    PerFace::new(
        faces
            .into_par_iter()
            .map(FaceId::from_index)
            .map(shape)
            .collect(),
    )
}

/// The area of each triangle.
#[must_use]
pub fn face_areas(shapes: &PerFace<TriangleShape>) -> PerFace<f64> {
    shapes.map(TriangleShape::area)
}

/// The sum of the areas.
#[must_use]
pub fn total_area(shapes: &PerFace<TriangleShape>) -> f64 {
    shapes.iter().map(TriangleShape::area).sum()
}

/// The angle at each corner, in `0.0..=π`.
#[must_use]
pub fn corner_angles(shapes: &PerFace<TriangleShape>) -> PerCorner<f64> {
    use rayon::prelude::*;
    let angles = shapes.as_slice().par_iter();
    PerCorner::new(angles.flat_map_iter(TriangleShape::angles).collect())
}

/// The cotangent of the angle at each corner.
///
/// # Errors
/// [`GeometryError::DegenerateFace`] where a triangle has no area.
pub fn corner_cotangents(shapes: &PerFace<TriangleShape>) -> Result<PerCorner<f64>, GeometryError> {
    let mut cotangents = Vec::with_capacity(3 * shapes.len());
    for (face, shape) in shapes.enumerate() {
        for corner in 0..3 {
            let cotangent = shape.cotangent(corner);
            cotangents.push(cotangent.ok_or_else(|| shape.degenerate(face))?);
        }
    }
    Ok(PerCorner::new(cotangents))
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;
    use std::f64::consts::PI;

    fn random_corners(noise: &mut Noise) -> [DVec3; 3] {
        array::from_fn(|_| DVec3::new(noise.signed(), noise.signed(), noise.signed()))
    }

    fn assert_close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance * a.abs().max(b.abs()), "{a} {b}");
    }

    #[test]
    fn lengths_and_positions_give_the_same_shape() {
        let mut noise = Noise::new(1);
        for _ in 0..1000 {
            let placed = TriangleShape::from_positions(random_corners(&mut noise));
            let measured = TriangleShape::from_lengths(placed.lengths()).unwrap();
            // The condition of the area in terms of the lengths is the inverse square of the height.
            let tolerance = 1e-15 / placed.height_ratio().powi(2);
            assert_close(placed.area(), measured.area(), tolerance);
            for corner in 0..3 {
                let difference = placed.dot(corner) - measured.dot(corner);
                let longest = descending(placed.lengths())[0];
                assert!(difference.abs() < 4e-15 * longest * longest);
            }
        }
    }

    #[test]
    fn angles_sum_to_half_a_turn_however_thin_the_triangle() {
        let flat = |height: f64| [DVec3::ZERO, DVec3::X, DVec3::new(0.3, height, 0.0)];
        let needle = |width: f64| [DVec3::ZERO, DVec3::X, DVec3::new(1.0, width, 0.0)];
        let mut cases = vec![[DVec3::ONE; 3], [DVec3::X, DVec3::X, DVec3::Y]];
        for thinness in [1.0, 1e-3, 1e-8, 1e-12, 1e-200, 0.0] {
            cases.extend([flat(thinness), needle(thinness)]);
        }
        for corners in cases {
            let sum: f64 = TriangleShape::from_positions(corners).angles().iter().sum();
            assert!((sum - PI).abs() < 1e-15 * 8.0, "{corners:?}: {sum}");
        }
    }

    #[test]
    fn needles_and_flat_triangles_keep_their_cotangents() {
        for thinness in [1e-3, 1e-6, 1e-9, 1e-12] {
            let flat = TriangleShape::from_positions([
                DVec3::ZERO,
                DVec3::X,
                DVec3::new(0.25, thinness, 0.0),
            ]);
            assert_close(flat.cotangent(0).unwrap(), 0.25 / thinness, 1e-15);
            assert_close(flat.cotangent(1).unwrap(), 0.75 / thinness, 1e-15);
            let needle = TriangleShape::from_positions([
                DVec3::ZERO,
                DVec3::Y * thinness,
                DVec3::new(1.0, 0.0, 0.0),
            ]);
            assert_close(needle.cotangent(1).unwrap(), thinness, 1e-15);
            assert_close(needle.cotangent(2).unwrap(), 1.0 / thinness, 1e-15);
        }
    }

    #[test]
    fn the_area_from_lengths_is_exact_for_needles() {
        // A isosceles needle: base b, legs 1: the height is sqrt(1 - b²/4).
        for base in [1e-3, 1e-8, 1e-15, 1e-100] {
            let needle = TriangleShape::from_lengths([1.0, base, 1.0]).unwrap();
            assert_close(
                needle.area(),
                base / 2.0 * (1.0 - base * base / 4.0).sqrt(),
                1e-15,
            );
            assert_close(needle.dot(1), base * base / 2.0, 1e-15);
        }
    }

    #[test]
    fn half_angle_tangents_agree_with_the_angles() {
        let mut noise = Noise::new(2);
        for _ in 0..1000 {
            let shape = TriangleShape::from_positions(random_corners(&mut noise));
            for corner in 0..3 {
                let tangent = libm::tan(shape.angle(corner) / 2.0);
                assert_close(shape.half_angle_tangent(corner).unwrap(), tangent, 1e-12);
            }
        }
    }

    #[test]
    fn impossible_and_degenerate_triangles_give_no_infinite_number() {
        for lengths in [[1.0, 1.0, 2.1], [1.0, -1.0, 1.0], [f64::NAN, 1.0, 1.0]] {
            assert_eq!(TriangleShape::from_lengths(lengths), None);
        }
        let collinear = TriangleShape::from_lengths([1.0, 1.0, 2.0]).unwrap();
        let point = TriangleShape::from_lengths([0.0; 3]).unwrap();
        for shape in [collinear, point] {
            assert!(shape.is_degenerate());
            assert!((0..3).all(|corner| shape.cotangent(corner).is_none()));
            assert!(shape.corners().iter().all(|corner| corner.is_finite()));
        }
        let shapes = PerFace::new(vec![collinear]);
        assert!(matches!(
            corner_cotangents(&shapes),
            Err(GeometryError::DegenerateFace {
                face: FaceId(0),
                ..
            })
        ));
    }

    #[test]
    #[allow(clippy::float_cmp, reason = "exactness is what is tested")]
    fn scaling_by_a_power_of_two_is_exact() {
        let mut noise = Noise::new(3);
        for exponent in [-40, 40] {
            let scale = 2.0_f64.powi(exponent);
            let corners = random_corners(&mut noise);
            let small = TriangleShape::from_positions(corners);
            let big = TriangleShape::from_positions(corners.map(|corner| corner * scale));
            assert_eq!(small.cotangent(0), big.cotangent(0));
            assert_eq!(small.angles(), big.angles());
            assert_eq!(small.area() * scale * scale, big.area());
        }
    }
}
