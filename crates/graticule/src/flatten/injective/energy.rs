//! Energies of a linear map of a triangle that depend on its singular values alone, with their
//! derivatives and a Hessian made positive.
//!
//! The eigenvectors of such a Hessian, taken by the four entries of the map's matrix, are known in
//! closed form (Smith, de Goes, Kim, *Analytic Eigensystems for Isotropic Distortion Energies*,
//! 2019): a turn (twist), its mirror image (flip), and two scalings along the singular directions.

use glam::DVec2;
use serde::Serialize;

use crate::measure::{Jacobian2, SourceTriangle};
use crate::tolerance::LEAST_CURVATURE;

/// What is made small over a surface: a mean by area of a function of the singular values
/// σ₁ ≥ σ₂ > 0 of the map, which grows beyond all bounds where a triangle collapses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DistortionEnergy {
    /// σ₁² + σ₂² + σ₁⁻² + σ₂⁻²: 4 for an isometry. Angles and areas count alike. Source: [`SS15`].
    ///
    /// [`SS15`]: crate::papers::SS15
    #[default]
    SymmetricDirichlet,
    /// σ₁/σ₂ + σ₂/σ₁: 2 for a conformal map, whatever its scale. Only angles count. Source:
    /// [`HG00`].
    ///
    /// [`HG00`]: crate::papers::HG00
    Mips,
}

/// Derivatives of an energy by the singular values, and the curvature for turns of the map.
struct Curvatures {
    /// ∂E/∂σ₁, ∂E/∂σ₂.
    first: [f64; 2],
    /// ∂²E/∂σ₁², ∂²E/∂σ₁∂σ₂, ∂²E/∂σ₂².
    second: [f64; 3],
    /// (E₁ + E₂) / (σ₁ + σ₂).
    twist: f64,
    /// (E₁ − E₂) / (σ₁ − σ₂).
    flip: f64,
}

impl DistortionEnergy {
    /// The least value that a triangle can have.
    #[must_use]
    pub fn least(self) -> f64 {
        match self {
            Self::SymmetricDirichlet => 4.0,
            Self::Mips => 2.0,
        }
    }

    /// The energy of a map with these singular values, per area.
    #[must_use]
    pub fn value(self, [s, t]: [f64; 2]) -> f64 {
        match self {
            Self::SymmetricDirichlet => s * s + t * t + 1.0 / (s * s) + 1.0 / (t * t),
            Self::Mips => s / t + t / s,
        }
    }

    fn curvatures(self, [s, t]: [f64; 2]) -> Curvatures {
        let product = s * t;
        let [plus, minus] = [
            s * s + product + t * t,
            (s - t).mul_add(s - t, product), // s² − st + t²
        ];
        match self {
            Self::SymmetricDirichlet => {
                let [s2, t2] = [s * s, t * t];
                let cube = product * product * product;
                Curvatures {
                    first: [2.0 * (s - 1.0 / (s2 * s)), 2.0 * (t - 1.0 / (t2 * t))],
                    second: [2.0 + 6.0 / (s2 * s2), 0.0, 2.0 + 6.0 / (t2 * t2)],
                    twist: 2.0 - 2.0 * minus / cube,
                    flip: 2.0 + 2.0 * plus / cube,
                }
            }
            Self::Mips => {
                let square = product * product;
                Curvatures {
                    first: [1.0 / t - t / (s * s), 1.0 / s - s / (t * t)],
                    second: [
                        2.0 * t / (s * s * s),
                        -1.0 / (t * t) - 1.0 / (s * s),
                        2.0 * s / (t * t * t),
                    ],
                    twist: 1.0 / product - minus / square,
                    flip: 1.0 / product + plus / square,
                }
            }
        }
    }
}

/// Value, gradient and positive Hessian of a triangle's energy by the images of its corners, per
/// area. Entries are numbered `2 * corner + coordinate`.
pub(super) struct Expansion {
    pub(super) gradient: [f64; 6],
    /// The lower triangle, row by row.
    pub(super) hessian: [f64; 21],
}

/// The energy of the map that takes the triangle's corners to `images`, per area; infinite unless
/// the image has a positive area.
pub(super) fn value(energy: DistortionEnergy, source: &SourceTriangle, images: [DVec2; 3]) -> f64 {
    let jacobian = source.jacobian(images);
    // Not `<=`: what is not a number is not admissible.
    let positive = jacobian.determinant() > 0.0;
    if !positive {
        return f64::INFINITY;
    }
    let value = energy.value(jacobian.singular_values());
    if value.is_finite() {
        value
    } else {
        f64::INFINITY
    }
}

/// Expands the energy about `images`, whose area must be positive. Of negative curvatures the share
/// `kept` stays; with none kept the Hessian is positive.
pub(super) fn expand(
    energy: DistortionEnergy,
    source: &SourceTriangle,
    images: [DVec2; 3],
    kept: f64,
) -> Expansion {
    let jacobian = source.jacobian(images);
    let [s, t] = jacobian.singular_values();
    let curvatures = energy.curvatures([s, t]);
    let frames = Frames::of(&jacobian);
    let gradients = source.corner_gradients();
    let modes = [
        frames.along_first(),
        frames.along_second(),
        frames.twist(),
        frames.flip(),
    ]
    .map(|matrix| by_corners(matrix, gradients));
    let mut expansion = Expansion {
        gradient: [0.0; 6],
        hessian: [0.0; 21],
    };
    for entry in 0..6 {
        let [first, second, ..] = modes;
        expansion.gradient[entry] =
            curvatures.first[0] * first[entry] + curvatures.first[1] * second[entry];
    }
    for (value, [a, b]) in eigenpairs(curvatures.second) {
        let mode = std::array::from_fn(|entry| a * modes[0][entry] + b * modes[1][entry]);
        expansion.add_mode(value, kept, &mode);
    }
    expansion.add_mode(curvatures.twist, kept, &modes[2]);
    expansion.add_mode(curvatures.flip, kept, &modes[3]);
    expansion
}

impl Expansion {
    /// Adds `curvature` · mode modeᵀ; of a negative curvature the share `kept`.
    fn add_mode(&mut self, curvature: f64, kept: f64, mode: &[f64; 6]) {
        let curvature = curvature.max(LEAST_CURVATURE) + kept * curvature.min(0.0);
        let mut entry = 0;
        for row in 0..6 {
            let factor = curvature * mode[row];
            for other in &mode[..=row] {
                self.hessian[entry] += factor * other;
                entry += 1;
            }
        }
    }

    /// Gradient and Hessian by one corner alone: the Hessian's entries xx, xy, yy.
    pub(super) fn of_corner(&self, corner: usize) -> (DVec2, [f64; 3]) {
        let first = 2 * corner;
        let gradient = DVec2::new(self.gradient[first], self.gradient[first + 1]);
        let place = |row: usize, column: usize| self.hessian[row * (row + 1) / 2 + column];
        let hessian = [
            place(first, first),
            place(first + 1, first),
            place(first + 1, first + 1),
        ];
        (gradient, hessian)
    }
}

/// The singular directions of a matrix: `J = U diag(σ₁, σ₂) Vᵀ` with rotations U and V, by their
/// first columns.
struct Frames {
    left: DVec2,
    right: DVec2,
}

impl Frames {
    fn of(jacobian: &Jacobian2) -> Self {
        let [u, v] = jacobian.gradients();
        // The conformal part turns by the difference of both angles, the other by their sum.
        let difference = libm::atan2(v.x - u.y, u.x + v.y);
        let sum = libm::atan2(v.x + u.y, u.x - v.y);
        let direction = |angle: f64| DVec2::new(libm::cos(angle), libm::sin(angle));
        Self {
            left: direction(0.5 * (sum + difference)),
            right: direction(0.5 * (sum - difference)),
        }
    }

    fn along_first(&self) -> [DVec2; 2] {
        outer(self.left, self.right)
    }

    fn along_second(&self) -> [DVec2; 2] {
        outer(self.left.perp(), self.right.perp())
    }

    /// (u₂ v₁ᵀ − u₁ v₂ᵀ) / √2.
    fn twist(&self) -> [DVec2; 2] {
        let [a, b] = self.mixed();
        [a[0] - b[0], a[1] - b[1]]
    }

    /// (u₂ v₁ᵀ + u₁ v₂ᵀ) / √2.
    fn flip(&self) -> [DVec2; 2] {
        let [a, b] = self.mixed();
        [a[0] + b[0], a[1] + b[1]]
    }

    fn mixed(&self) -> [[DVec2; 2]; 2] {
        let scaled = self.left * std::f64::consts::FRAC_1_SQRT_2;
        [
            outer(scaled.perp(), self.right),
            outer(scaled, self.right.perp()),
        ]
    }
}

/// The matrix a bᵀ by its rows.
fn outer(a: DVec2, b: DVec2) -> [DVec2; 2] {
    [b * a.x, b * a.y]
}

/// A direction among matrices as one among the corners' images: through J = Σ image gradientᵀ.
fn by_corners(matrix: [DVec2; 2], gradients: [DVec2; 3]) -> [f64; 6] {
    let mut entries = [0.0; 6];
    for (pair, gradient) in entries.chunks_exact_mut(2).zip(gradients) {
        pair[0] = matrix[0].dot(gradient);
        pair[1] = matrix[1].dot(gradient);
    }
    entries
}

/// Eigenvalues and unit eigenvectors of the symmetric matrix with entries xx, xy, yy.
fn eigenpairs([xx, xy, yy]: [f64; 3]) -> [(f64, [f64; 2]); 2] {
    if xy == 0.0 {
        return [(xx, [1.0, 0.0]), (yy, [0.0, 1.0])];
    }
    let half = 0.5 * (xx - yy);
    let radius = half.hypot(xy);
    let middle = 0.5 * (xx + yy);
    let angle = 0.5 * libm::atan2(xy, half);
    let [c, s] = [libm::cos(angle), libm::sin(angle)];
    [(middle + radius, [c, s]), (middle - radius, [-s, c])]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENERGIES: [DistortionEnergy; 2] =
        [DistortionEnergy::SymmetricDirichlet, DistortionEnergy::Mips];

    fn cases() -> Vec<(SourceTriangle, [DVec2; 3])> {
        let images = [
            [(0.0, 0.0), (1.3, 0.2), (0.1, 0.9)],
            [(0.3, -0.2), (2.0, 1.0), (-0.4, 2.5)],
            [(0.0, 0.0), (0.3, 0.02), (0.28, 0.06)],
            [(1.0, 1.0), (-1.0, 1.1), (0.0, -3.0)],
        ];
        let lengths = [[1.0, 1.1, 0.9], [2.0, 1.2, 1.0], [1.0, 1.0, 0.1]];
        let sources = lengths.map(|sides| SourceTriangle::from_lengths(sides).unwrap());
        let places = images.map(|image| image.map(|(x, y)| DVec2::new(x, y)));
        let of_source = |source| places.map(move |image| (source, image));
        sources.into_iter().flat_map(of_source).collect()
    }

    fn moved(images: [DVec2; 3], entry: usize, by: f64) -> [DVec2; 3] {
        let mut images = images;
        images[entry / 2][entry % 2] += by;
        images
    }

    #[test]
    fn gradients_are_those_of_differences() {
        let step = 1e-6;
        for energy in ENERGIES {
            for (source, images) in cases() {
                let gradient = expand(energy, &source, images, 0.0).gradient;
                let size = gradient.iter().fold(1.0, |m: f64, g| m.max(g.abs()));
                for (entry, derivative) in gradient.into_iter().enumerate() {
                    let at = |by| value(energy, &source, moved(images, entry, by));
                    let difference = (at(step) - at(-step)) / (2.0 * step);
                    assert!(
                        (difference - derivative).abs() < 1e-5 * size,
                        "{energy:?} {entry}: {difference} {derivative}"
                    );
                }
            }
        }
    }

    #[test]
    fn hessians_are_those_of_differences_and_positive_ones_are_above() {
        let step = 1e-5;
        for energy in ENERGIES {
            for (source, images) in cases() {
                let [exact, positive] =
                    [1.0, 0.0].map(|kept| expand(energy, &source, images, kept).hessian);
                let size = exact.iter().fold(1.0, |m: f64, g| m.max(g.abs()));
                for row in 0..6 {
                    let at = |by| expand(energy, &source, moved(images, row, by), 0.0).gradient;
                    let [above, below] = [at(step), at(-step)];
                    for column in 0..=row {
                        let difference = (above[column] - below[column]) / (2.0 * step);
                        let entry = row * (row + 1) / 2 + column;
                        let error = (exact[entry] - difference).abs();
                        assert!(error < 1e-4 * size, "{energy:?} {row} {column}: {error}");
                        assert!(row != column || positive[entry] > difference - 1e-4 * size);
                    }
                }
            }
        }
    }

    #[test]
    fn an_isometry_has_the_least_energy_and_a_flip_an_infinite_one() {
        let source = SourceTriangle::from_lengths([1.0, 1.2, 0.7]).unwrap();
        let corners = source.corners();
        for energy in ENERGIES {
            assert!((value(energy, &source, corners) - energy.least()).abs() < 1e-12);
            let mirrored = corners.map(|p| DVec2::new(-p.x, p.y));
            assert!(value(energy, &source, mirrored).is_infinite());
            assert!(value(energy, &source, [DVec2::ZERO; 3]).is_infinite());
        }
    }
}
