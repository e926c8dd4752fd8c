use serde::Serialize;

use super::unroll::VertexFrames;
use super::{EnergyKind, MinimizationReport};
use crate::measure::SourceTriangle;
use crate::mesh::{PerFace, PerVertex, Surface};

/// Figures of a [`Parameterization`](super::Parameterization).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterizationReport {
    /// The side of a chart, in the unit of the positions.
    pub chart_size: f64,
    /// The side of a chart over the mean edge.
    pub chart_edges: f64,
    /// Area of the surface over that of a chart, by the scale of the field.
    pub charts: f64,
    /// The functional.
    pub energy: EnergyKind,
    /// Figures of the minimisation.
    pub minimization: MinimizationReport,
    /// Coordinates that are whole because a line runs along a boundary or feature edge.
    pub whole_coordinates: usize,
    /// Boundary and feature edges that the field does not follow, so that no line does.
    pub unaligned_edges: usize,
    /// Coordinates that were to be whole and are not: lines there run closer together than the charts
    /// are wide, so that triangles between them had no room.
    pub released_coordinates: usize,
    /// Triangles with a singularity of the field.
    pub field_singular_faces: usize,
    /// Triangles where a line ends.
    pub phase_singular_faces: usize,
    /// Triangles that do not turn counter-clockwise.
    pub inverted_faces: usize,
    /// Inverted triangles before they were untangled.
    pub inverted_before: usize,
    /// Edges of triangles that do not close.
    pub singular_edges: usize,
    /// Vertices whose neighbourhood does not close once.
    pub singular_vertices: usize,
    /// Singular triangles of all kinds over all triangles.
    pub singular_share: f64,
    /// Mean angle between the lines and the field in degrees, by area, after the final solve in real
    /// coordinates, if there was one.
    pub field_deviation: Option<f64>,
    /// How often charts were halved about inverted triangles.
    pub halvings: usize,
    /// Distortion over regular triangles.
    pub distortion: RegularDistortion,
    /// The same without two rings of triangles about those that are not regular.
    pub distortion_apart: RegularDistortion,
}

/// Distortion over some triangles, as in Table I of [PGP06].
///
/// [PGP06]: crate::papers::PGP06
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RegularDistortion {
    /// L² stretch of the whole (Sander et al. 2001), at the scale where an isometry has 1.
    pub stretch: f64,
    /// The same with lengths measured in charts of the size wanted at each place: 1 for a conformal
    /// map that has the density of a curl correction or a sizing.
    pub stretch_at_scale: f64,
    /// Mean |cos| of the angle between the gradients of both coordinates.
    pub shear: f64,
    /// Share of the area that is left out.
    pub left_out_area: f64,
}

impl RegularDistortion {
    /// Measures the triangles that count. `density` is the number of periods wanted per unit length.
    pub(super) fn of(
        surface: &Surface,
        frames: &VertexFrames,
        counts: &PerFace<bool>,
        density: &PerVertex<f64>,
    ) -> Self {
        let mesh = surface.mesh();
        let [mut measured, mut total, mut shear] = [0.0; 3];
        let mut plain = StretchSums::default();
        let mut scaled = StretchSums::default();
        for (face, counts) in counts.enumerate() {
            let Some(source) = SourceTriangle::from_positions(surface.corner_positions(face))
            else {
                continue;
            };
            let area = source.area();
            total += area;
            let jacobian = source.jacobian(frames.corners(mesh, face));
            let square = jacobian.squared_stretch();
            if !counts || !square.is_finite() {
                continue;
            }
            measured += area;
            shear += area * jacobian.shear();
            let image = area * jacobian.determinant();
            let wanted = mesh.triangle(face).map(|v| density[v]).iter().sum::<f64>() / 3.0;
            let growth = wanted * wanted;
            plain.add(area, image, square);
            scaled.add(area * growth, image, square * growth);
        }
        let share = |sum: f64| if total > 0.0 { sum / total } else { 0.0 };
        Self {
            stretch: plain.stretch(),
            stretch_at_scale: scaled.stretch(),
            shear: if measured > 0.0 {
                shear / measured
            } else {
                0.0
            },
            left_out_area: share(total - measured),
        }
    }
}

/// Sums over triangles of which an L² stretch is made.
#[derive(Default)]
struct StretchSums {
    area: f64,
    image: f64,
    squares: f64,
}

impl StretchSums {
    fn add(&mut self, area: f64, image: f64, squared_stretch: f64) {
        self.area += area;
        self.image += image;
        self.squares += area * squared_stretch;
    }

    fn stretch(&self) -> f64 {
        if self.area > 0.0 {
            (self.squares / self.area * (self.image / self.area)).sqrt()
        } else {
            0.0
        }
    }
}
