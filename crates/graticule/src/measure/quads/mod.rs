//! Measures of polygon meshes: what a reader of a quad mesh wants to know before relying on it.
//!
//! [`measure_quads`] takes any soup, sound or not, whoever made it; [`compare_to_reference`]
//! holds it against the surface that it stands for.

mod carrying;
mod connections;
mod polygons;
mod quality;
mod reference;
mod samples;
mod strips;

#[cfg(test)]
mod tests;

use serde::Serialize;

pub use carrying::LineCarrying;
pub use connections::{Connections, IrregularVertex, Valences};
pub use polygons::PolygonCounts;
pub(crate) use quality::vector_area;
pub use quality::{
    AngleDeviation, Aspect, EdgeLengthSpread, Planarity, QuadQuality, ScaledJacobian,
    scaled_jacobian,
};
pub use reference::{Deviation, NormalDeviation, ReferenceMeasure, compare_to_reference};
pub use strips::Strips;

use self::polygons::Measured;
use super::MeasureError;
use crate::mesh::{Defects, PolygonSoup};
use crate::watch::Watch;

/// What can be said of a polygon mesh. Made by [`measure_quads`].
///
/// Serialized without [`elements`](Self::elements); keys are the names of the fields.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QuadMeasure {
    /// Polygons by their number of corners.
    pub polygons: PolygonCounts,
    /// How the polygons hang together.
    pub connections: Connections,
    /// Edges at the vertices.
    pub valences: Valences,
    /// Shape of the quads; `None` without quads.
    pub quality: Option<QuadQuality>,
    /// Lengths of all edges; `None` without polygons.
    pub edge_length: Option<EdgeLengthSpread>,
    /// Corners of any polygon wider than 170°: a vertex in the middle of a side.
    pub straight_corners: usize,
    /// Edges whose two polygons face more than 120° apart.
    pub folds: usize,
    /// Rows of quads.
    pub strips: Strips,
    /// What holds for single elements, for drawing.
    #[serde(skip)]
    pub elements: QuadElements,
}

/// What holds for single elements of a measured polygon mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuadElements {
    /// For each polygon of the soup its scaled Jacobian; NaN for all but quads.
    pub scaled_jacobians: Vec<f64>,
    /// The vertices counted in [`Valences::irregular`].
    pub irregular_vertices: Vec<IrregularVertex>,
}

/// Measures a polygon mesh.
///
/// Polygons that span no face (less than three different corners, a corner without vertex or with a
/// position that is not finite) are counted and left out. Vertices are not welded. Counts are
/// exact; figures of shape do not depend on units.
///
/// Cost: O(n log n).
///
/// # Errors
/// [`MeasureError`]: an extent beyond 1e±140, or stopped.
pub fn measure_quads(soup: &PolygonSoup, watch: &Watch) -> Result<QuadMeasure, MeasureError> {
    let _stage = watch.stage("measure quads");
    let measured = Measured::new(soup)?;
    watch.check()?;
    let defects = Defects::find(soup);
    watch.check()?;
    let (valences, irregular_vertices) = connections::valences(&measured.mesh);
    let scaled_jacobians = quality::scaled_jacobians(&measured);
    Ok(QuadMeasure {
        polygons: polygons::count(soup, &measured),
        connections: connections::connections(&measured.mesh, &defects, &valences),
        valences,
        quality: quality::measure(&measured, &scaled_jacobians),
        edge_length: quality::edge_lengths(&measured),
        straight_corners: quality::straight_corners(&measured),
        folds: quality::folds(&measured),
        strips: strips::count(&measured.mesh),
        elements: QuadElements {
            scaled_jacobians: by_source(soup, &measured, &scaled_jacobians),
            irregular_vertices,
        },
    })
}

fn by_source(soup: &PolygonSoup, measured: &Measured, figures: &[f64]) -> Vec<f64> {
    let mut by_source = vec![f64::NAN; soup.polygons.len()];
    for (polygon, &figure) in figures.iter().enumerate() {
        by_source[measured.mesh.source(polygon)] = figure;
    }
    by_source
}
