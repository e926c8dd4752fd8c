use serde::Serialize;

use super::{Cancellation, CurlReport, Singularities, SmoothingReport, Symmetry};

/// Figures of a field.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldReport {
    /// The symmetry of the field.
    pub symmetry: Symmetry,
    /// Vertices with a fixed direction.
    pub fixed_vertices: usize,
    /// Edges that the field was asked to run along, those of the boundary apart.
    pub feature_edges: usize,
    /// Singular triangles.
    pub singularities: usize,
    /// The same by index.
    pub singularities_by_index: Vec<IndexCount>,
    /// The sum of all indices, those of the boundary loops included.
    pub index_sum: f64,
    /// What it has to be.
    pub euler_characteristic: i64,
    /// Mean angle between the field and the directions of curvature in degrees, by area ×
    /// confidence; `None` without curvature, or where it is trusted nowhere.
    pub mean_deviation: Option<f64>,
    /// Mean confidence in the directions of curvature, by area.
    pub mean_confidence: Option<f64>,
    /// Figures of the smoothing.
    pub smoothing: SmoothingReport,
    /// What cancelling did.
    pub cancellation: Option<Cancellation>,
    /// Figures of the curl correction.
    pub curl: Option<CurlReport>,
}

/// How many singular triangles have an index.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct IndexCount {
    /// The index.
    pub index: f64,
    /// How many.
    pub count: usize,
}

/// The numbers of singular triangles by index, smallest index first.
pub(super) fn counts_by_index(singular: &Singularities) -> Vec<IndexCount> {
    let mut steps: Vec<i32> = singular.faces.iter().map(|face| face.steps).collect();
    steps.sort_unstable();
    let order = f64::from(singular.symmetry.order());
    let equal = steps.chunk_by(|a, b| a == b);
    let counts = equal.map(|run| IndexCount {
        index: f64::from(run[0]) / order,
        count: run.len(),
    });
    counts.collect()
}
