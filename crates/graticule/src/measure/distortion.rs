use rayon::prelude::*;
use serde::Serialize;

use super::face::FaceDistortion;
use super::statistics::{self, Sample, extremes, weighted_quantiles};
use super::uv_map::UvMap;
use crate::mesh::{Element, FaceId};

/// How far a map is from keeping angles, areas and lengths.
///
/// Over the triangles whose state is [`FaceState::Measured`](super::FaceState::Measured), flipped
/// ones included by the absolute value of their area, each weighted with its area in space unless
/// said otherwise. σ₁ ≥ σ₂ are the singular values of the map from the surface to texture
/// coordinates. One scale holds for the whole map, so that islands of different density count as
/// distortion. No figure depends on the units of the surface or of the map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Distortion {
    /// σ₁/σ₂, the quasi-conformal error; conformal: 1. Source: [`SSGH01`] and [`HG00`] use the
    /// same ratio.
    ///
    /// [`SSGH01`]: crate::papers::SSGH01
    /// [`HG00`]: crate::papers::HG00
    pub quasi_conformal_error: QuasiConformalError,
    /// Mean of σ₁/σ₂ + σ₂/σ₁; conformal: 2. Source: [`HG00`].
    ///
    /// [`HG00`]: crate::papers::HG00
    pub mips_mean: f64,
    /// Mean |change of angle| over the three corners, in degrees; conformal: 0.
    pub angle_change_mean: f64,
    /// σ₁σ₂, the scale of areas.
    pub area_scale: AreaScale,
    /// Root of the mean of (σ₁⁻² + σ₂⁻²) / 2, times that of the area in the map over the area in
    /// space; isometric: 1, and never below. Source: [`SSGH01`] §3.
    ///
    /// [`SSGH01`]: crate::papers::SSGH01
    pub l2_stretch: f64,
    /// Largest σ₂⁻¹, times the root of the area in the map over the area in space; isometric: 1.
    /// Source: [`SSGH01`] §3.
    ///
    /// [`SSGH01`]: crate::papers::SSGH01
    pub linf_stretch: f64,
    /// Mean |cos| of the angle between the gradients of u and v; orthogonal: 0. Source: Table I of
    /// [`PGP06`], as it fits the printed figures.
    ///
    /// [`PGP06`]: crate::papers::PGP06
    pub shear_mean: f64,
    /// Mean of σ₁² + σ₂² + σ₁⁻² + σ₂⁻² at the scale of the whole map that makes it least;
    /// isometric: 4. Without flipped triangles, for which the energy is infinite; `None` if no
    /// other is there. Source: [`SS15`].
    ///
    /// [`SS15`]: crate::papers::SS15
    pub symmetric_dirichlet: Option<f64>,
    /// Dirichlet energy, half the integral of σ₁² + σ₂², over the area in the map; conformal: 1.
    pub dirichlet_energy: f64,
    /// Mean over the triangles' sides, each with the same weight, of (l'²/l² − 1)², l the length in
    /// space and l' in the map, at the scale of the map that makes it least; isometric: 0. Source:
    /// [`DMA02`] §5.1, there as a sum and without the scale.
    ///
    /// [`DMA02`]: crate::papers::DMA02
    pub edge_length_error: f64,
}

/// The distribution of σ₁/σ₂ over the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct QuasiConformalError {
    /// Mean.
    pub mean: f64,
    /// The value that half the area does not exceed.
    pub median: f64,
    /// The value that 95 % of the area do not exceed.
    pub p95: f64,
    /// The value that 99 % of the area do not exceed.
    pub p99: f64,
    /// The largest value.
    pub max: f64,
}

/// The distribution of the scale of areas over the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AreaScale {
    /// Mean |log(scale / median scale)|, with the natural logarithm; the median by area is the
    /// global scale that makes this mean least. Equiareal: 0.
    pub log_mean: f64,
    /// The value of |log(scale / median scale)| that 95 % of the area do not exceed.
    pub log_p95: f64,
    /// The largest |log(scale / median scale)|.
    pub log_max: f64,
    /// The least scale, once the whole map is scaled to the area of the surface.
    pub min: f64,
    /// The greatest scale, once the whole map is scaled to the area of the surface.
    pub max: f64,
}

/// Sums over triangles.
#[derive(Clone, Copy, Default)]
struct Sums {
    area: f64,
    uv_area: f64,
    ratio: f64,
    inverse_ratio: f64,
    angle_change: f64,
    inverse_squares: f64,
    squares: f64,
    shear: f64,
    unflipped_area: f64,
    unflipped_squares: f64,
    unflipped_inverse_squares: f64,
    least_value: f64,
}

impl Sums {
    fn start() -> Self {
        Self {
            least_value: f64::INFINITY,
            ..Self::default()
        }
    }

    fn with(mut self, face: &FaceDistortion) -> Self {
        let [larger, smaller] = face.singular_values;
        let area = face.area;
        let squares = area * (larger * larger + smaller * smaller);
        let inverse_squares = area * (larger.powi(-2) + smaller.powi(-2));
        self.area += area;
        self.uv_area += area * larger * smaller;
        self.ratio += area * (larger / smaller);
        self.inverse_ratio += area * (smaller / larger);
        self.angle_change += area * face.angle_change;
        self.inverse_squares += inverse_squares;
        self.squares += squares;
        self.shear += area * face.shear;
        if !face.flipped {
            self.unflipped_area += area;
            self.unflipped_squares += squares;
            self.unflipped_inverse_squares += inverse_squares;
        }
        self.least_value = self.least_value.min(smaller);
        self
    }

    fn join(self, other: Self) -> Self {
        Self {
            area: self.area + other.area,
            uv_area: self.uv_area + other.uv_area,
            ratio: self.ratio + other.ratio,
            inverse_ratio: self.inverse_ratio + other.inverse_ratio,
            angle_change: self.angle_change + other.angle_change,
            inverse_squares: self.inverse_squares + other.inverse_squares,
            squares: self.squares + other.squares,
            shear: self.shear + other.shear,
            unflipped_area: self.unflipped_area + other.unflipped_area,
            unflipped_squares: self.unflipped_squares + other.unflipped_squares,
            unflipped_inverse_squares: self.unflipped_inverse_squares
                + other.unflipped_inverse_squares,
            least_value: self.least_value.min(other.least_value),
        }
    }
}

/// The distortion of a map by that of its triangles; `None` where none is measured.
pub(super) fn summarize(map: &UvMap<'_>, faces: &[FaceDistortion]) -> Option<Distortion> {
    if !faces.iter().any(FaceDistortion::measured) {
        return None;
    }
    let parts = statistics::by_chunks(faces, |chunk| {
        let measured = chunk.iter().filter(|face| face.measured());
        measured.fold(Sums::start(), Sums::with)
    });
    let sums = parts.into_iter().fold(Sums::start(), Sums::join);
    let mean = |sum: f64| sum / sums.area;
    let area_scale = sums.uv_area / sums.area;
    let symmetric_dirichlet = 2.0
        * (sums.unflipped_squares / sums.unflipped_area).sqrt()
        * (sums.unflipped_inverse_squares / sums.unflipped_area).sqrt();
    Some(Distortion {
        quasi_conformal_error: quasi_conformal_error(faces, mean(sums.ratio)),
        mips_mean: mean(sums.ratio) + mean(sums.inverse_ratio),
        angle_change_mean: mean(sums.angle_change).to_degrees(),
        area_scale: area_scales(faces, area_scale),
        l2_stretch: (0.5 * mean(sums.inverse_squares) * area_scale).sqrt(),
        linf_stretch: area_scale.sqrt() / sums.least_value,
        shear_mean: mean(sums.shear),
        symmetric_dirichlet: (sums.unflipped_area > 0.0).then_some(symmetric_dirichlet),
        dirichlet_energy: 0.5 * sums.squares / sums.uv_area,
        edge_length_error: edge_length_error(map, faces),
    })
}

fn quasi_conformal_error(faces: &[FaceDistortion], mean: f64) -> QuasiConformalError {
    let ratio = |face: &FaceDistortion| face.singular_values[0] / face.singular_values[1];
    let mut samples = samples(faces, ratio);
    let [median, p95, p99] = weighted_quantiles(&mut samples, [0.5, 0.95, 0.99]);
    QuasiConformalError {
        mean,
        median,
        p95,
        p99,
        max: extremes(&samples)[1],
    }
}

fn area_scales(faces: &[FaceDistortion], whole: f64) -> AreaScale {
    let scale = |face: &FaceDistortion| face.singular_values[0] * face.singular_values[1];
    let mut scales = samples(faces, scale);
    let [median] = weighted_quantiles(&mut scales, [0.5]);
    let [least, greatest] = extremes(&scales);
    for sample in &mut scales {
        sample.value = libm::log(sample.value / median).abs();
    }
    let [log_p95] = weighted_quantiles(&mut scales, [0.95]);
    let area = statistics::sum(&scales, |sample| sample.weight);
    AreaScale {
        log_mean: statistics::sum(&scales, |sample| sample.value * sample.weight) / area,
        log_p95,
        log_max: extremes(&scales)[1],
        min: least / whole,
        max: greatest / whole,
    }
}

fn samples(faces: &[FaceDistortion], value: impl Fn(&FaceDistortion) -> f64) -> Vec<Sample> {
    let sample = |face: &FaceDistortion| Sample {
        value: value(face),
        weight: face.area,
    };
    let measured = faces.iter().filter(|face| face.measured());
    measured.map(sample).collect()
}

fn edge_length_error(map: &UvMap<'_>, faces: &[FaceDistortion]) -> f64 {
    let indices = (0..faces.len()).filter(|&face| faces[face].measured());
    let indices: Vec<usize> = indices.collect();
    // Squared length in the map over that in space, for the three sides of a triangle.
    let ratios = |&face: &usize| {
        let face = FaceId::from_index(face);
        let positions = map.positions(face);
        let images = map.images(face);
        [0, 1, 2].map(|side: usize| {
            let next = (side + 1) % 3;
            images[side].distance_squared(images[next])
                / positions[side].distance_squared(positions[next])
        })
    };
    let all: Vec<[f64; 3]> = indices.par_iter().map(ratios).collect();
    let sum = |term: &(dyn Fn(f64) -> f64 + Sync)| {
        statistics::sum(&all, |ratios| ratios.map(term).iter().sum::<f64>())
    };
    let best = sum(&|ratio| ratio) / sum(&|ratio| ratio * ratio);
    sum(&|ratio| (best * ratio - 1.0).powi(2)) / (3 * all.len()) as f64
}
