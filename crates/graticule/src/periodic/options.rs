use super::energy::EnergyKind;
use super::{Minimizer, PeriodicError};
use crate::geometry::{EdgeLengths, face_areas, face_shapes, normalized};
use crate::mesh::{EdgeId, Surface};

/// How [`parameterize`](super::parameterize()) covers a surface with coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterizeOptions {
    /// The side of a chart, which is a period of the coordinates.
    pub chart_size: ChartSize,
    /// The functional.
    pub energy: EnergyKind,
    /// Which triangles the functional is summed over.
    pub triangles: EnergyTriangles,
    /// How the functional is minimised.
    pub minimizer: Minimizer,
    /// Edges that lines should run along, where the field does.
    pub features: Vec<EdgeId>,
    /// Whether lines should run along the boundary, where the field does.
    pub follow_boundary: bool,
    /// Whether the coordinates are solved for once more as real numbers, with the integers kept.
    pub refine: bool,
    /// How often the final solve is repeated with the field turned towards the map: less shear and
    /// stretch for lines that follow the field less exactly.
    pub relaxations: usize,
    /// Whether inverted triangles away from singular ones are turned over again.
    pub untangle: bool,
    /// How often, at most, charts are halved about triangles that stay inverted, as where a limb is
    /// thinner than half a chart. Each time everything is computed anew.
    pub halvings: usize,
}

impl Default for ParameterizeOptions {
    fn default() -> Self {
        Self {
            chart_size: ChartSize::default(),
            energy: EnergyKind::default(),
            triangles: EnergyTriangles::default(),
            minimizer: Minimizer::default(),
            features: Vec::new(),
            follow_boundary: true,
            refine: true,
            relaxations: 4,
            untangle: true,
            halvings: 4,
        }
    }
}

/// The triangles that the functional is summed over; the coordinates are unrolled on the surface's own
/// in any case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EnergyTriangles {
    /// The intrinsic Delaunay triangulation, where no weight inside is negative.
    #[default]
    Delaunay,
    /// The surface's own, with negative weights as 0.
    Own,
}

/// The side of a chart where the field has the scale 1: h, with `ω = 2π / h` ([PGP06] §2.2,
/// erratum 1).
///
/// [PGP06]: crate::papers::PGP06
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ChartSize {
    /// In mean edge lengths.
    MeanEdges(f64),
    /// In the unit of the positions.
    Length(f64),
    /// So that this many squares have the area of the surface.
    Count(f64),
}

impl Default for ChartSize {
    fn default() -> Self {
        Self::MeanEdges(10.0)
    }
}

impl ChartSize {
    /// The size on a surface, as a length in the unit of its positions.
    ///
    /// # Errors
    /// [`PeriodicError::Option`] unless it is positive and finite.
    pub fn on(self, surface: &Surface) -> Result<f64, PeriodicError> {
        let (unit_surface, similarity) = normalized(surface);
        let wanted = self.at_exponent(similarity.exponent());
        Ok(similarity.invert_length(wanted.length(&unit_surface)?))
    }

    /// The same size on a surface scaled by two to this power.
    pub(super) fn at_exponent(self, exponent: i32) -> Self {
        match self {
            Self::Length(length) => Self::Length(libm::ldexp(length, exponent)),
            other => other,
        }
    }

    /// The size as a length.
    pub(super) fn length(self, surface: &Surface) -> Result<f64, PeriodicError> {
        let (name, value) = match self {
            Self::MeanEdges(count) => ("chart size", count),
            Self::Length(length) => ("chart size", length),
            Self::Count(count) => ("chart count", count),
        };
        let length = match self {
            Self::MeanEdges(count) => count * EdgeLengths::of(surface).mean(),
            Self::Length(length) => length,
            Self::Count(count) => {
                let area: f64 = face_areas(&face_shapes(surface)).iter().sum();
                (area / count).sqrt()
            }
        };
        let is_good = value.is_finite() && value > 0.0 && length.is_finite() && length > 0.0;
        is_good.then_some(length).ok_or(PeriodicError::Option {
            name,
            value,
            range: "above 0, finite",
        })
    }
}
