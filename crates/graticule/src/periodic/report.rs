use serde::Serialize;

use super::unroll::{FaceKind, VertexFrames};
use super::{EnergyKind, MinimizationReport};
use crate::measure::SourceTriangle;
use crate::mesh::{PerFace, Surface};

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
    /// Iterations of the final solve in real coordinates.
    pub refinement_iterations: usize,
    /// Distortion over regular triangles.
    pub distortion: RegularDistortion,
}

/// Distortion over the regular triangles, as in Table I of [PGP06].
///
/// [PGP06]: crate::papers::PGP06
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RegularDistortion {
    /// L² stretch, at the scale where an isometry has 1.
    pub stretch: f64,
    /// Mean |cos| of the angle between the gradients of both coordinates.
    pub shear: f64,
    /// Share of the area that is left out: that of triangles that are not regular.
    pub left_out_area: f64,
}

impl RegularDistortion {
    /// Measures the regular triangles.
    pub(super) fn of(surface: &Surface, frames: &VertexFrames, kinds: &PerFace<FaceKind>) -> Self {
        let [mut measured, mut total, mut image, mut stretch, mut shear] = [0.0; 5];
        for (face, kind) in kinds.enumerate() {
            let Some(source) = SourceTriangle::from_positions(surface.corner_positions(face))
            else {
                continue;
            };
            let area = source.area();
            total += area;
            if *kind != FaceKind::Regular {
                continue;
            }
            let jacobian = source.jacobian(frames.corners(surface.mesh(), face));
            let square = jacobian.squared_stretch();
            if square.is_finite() {
                measured += area;
                image += area * jacobian.determinant();
                stretch += area * square;
                shear += area * jacobian.shear();
            }
        }
        let share = |sum: f64| if measured > 0.0 { sum / measured } else { 0.0 };
        Self {
            stretch: (share(stretch) * share(image)).sqrt(),
            shear: share(shear),
            left_out_area: if total > 0.0 {
                1.0 - measured / total
            } else {
                0.0
            },
        }
    }
}
