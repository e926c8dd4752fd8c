use super::energy::EnergyKind;
use super::{Minimizer, PeriodicError};
use crate::mesh::EdgeId;

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
    /// Whether inverted triangles away from singular ones are turned over again.
    pub untangle: bool,
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
            untangle: true,
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
    /// The same size on a surface scaled by two to this power.
    pub(super) fn at_exponent(self, exponent: i32) -> Self {
        match self {
            Self::Length(length) => Self::Length(libm::ldexp(length, exponent)),
            other => other,
        }
    }

    /// The size as a length, for a surface with this mean edge and area.
    pub(super) fn length(self, mean_edge: f64, area: f64) -> Result<f64, PeriodicError> {
        let (name, value) = match self {
            Self::MeanEdges(count) => ("chart size", count),
            Self::Length(length) => ("chart size", length),
            Self::Count(count) => ("chart count", count),
        };
        let length = match self {
            Self::MeanEdges(count) => count * mean_edge,
            Self::Length(length) => length,
            Self::Count(count) => (area / count).sqrt(),
        };
        let is_good = value.is_finite() && value > 0.0 && length.is_finite() && length > 0.0;
        is_good.then_some(length).ok_or(PeriodicError::Option {
            name,
            value,
            range: "above 0, finite",
        })
    }
}
