use serde::Serialize;

/// The quality of the quads of a mesh, by their scaled Jacobians
/// ([`scaled_jacobian`](crate::measure::scaled_jacobian)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ShapeQuality {
    /// The least one; 0 without quads.
    pub least: f64,
    /// Their mean; 0 without quads.
    pub mean: f64,
    /// The number that are not positive.
    pub non_positive: usize,
}

impl ShapeQuality {
    pub(super) fn of(scaled_jacobians: &[f64]) -> Self {
        let count = scaled_jacobians.len();
        if count == 0 {
            return Self::default();
        }
        let least = scaled_jacobians
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        Self {
            least,
            mean: scaled_jacobians.iter().sum::<f64>() / count as f64,
            non_positive: scaled_jacobians
                .iter()
                .filter(|&&value| value <= 0.0)
                .count(),
        }
    }
}

/// What [`shape()`](super::shape()) did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ShapeReport {
    /// The quads as they were given.
    pub before: ShapeQuality,
    /// The quads as they are.
    pub after: ShapeQuality,
    /// Vertices that moved.
    pub moved_vertices: usize,
    /// The longest way of a vertex, in percent of the diagonal of the surface's box.
    pub longest_way: f64,
    /// How often all vertices were visited.
    pub sweeps: usize,
}
