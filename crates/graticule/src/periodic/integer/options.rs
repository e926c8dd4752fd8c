use crate::mesh::{EdgeId, PerVertex};

use super::IntegerGridError;

/// How dense a net is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridDensity {
    /// The distance of lines, in the unit of the positions, where the sizing is 1.
    EdgeLength(f64),
    /// The area of the map in cells, which is the number of quads.
    Quads(usize),
}

impl GridDensity {
    pub(super) fn check(self) -> Result<(), IntegerGridError> {
        match self {
            Self::EdgeLength(length) if !(length > 0.0 && length.is_finite()) => {
                Err(out_of_range("edge length", length, "above 0, finite"))
            }
            Self::Quads(0) => Err(out_of_range("number of quads", 0.0, "1 and above")),
            _ => Ok(()),
        }
    }
}

/// How far the cells of a net are from squares at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// The direction in which cells are longer, as an angle in the tangent plane of the vertex, up to
    /// a half turn.
    pub direction: f64,
    /// The distance of lines that follow each other in that direction over that of those across, 1
    /// and above. The area of cells does not depend on it.
    pub ratio: f64,
}

fn out_of_range(name: &'static str, value: f64, range: &'static str) -> IntegerGridError {
    IntegerGridError::Option { name, value, range }
}

/// How [`integer_grid_map`](super::integer_grid_map) makes a map.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegerGridOptions {
    /// How dense the net is.
    pub density: GridDensity,
    /// Whether lines run along the boundary.
    pub align_boundary: bool,
    /// Edges that lines run along.
    pub features: Vec<EdgeId>,
    /// Lines per unit of length at each vertex, relative to the density; `None` for the same
    /// everywhere.
    pub sizing: Option<PerVertex<f64>>,
    /// How far cells are from squares at each vertex; `None` for squares. Where the field runs at an
    /// angle `a` to the direction, the ratio counts with the power `cos 2a`.
    pub stretch: Option<PerVertex<Stretch>>,
    /// Rounds of making flipped triangles positive again; 0 for none.
    pub untangling_rounds: usize,
    /// Rounds of lowering distortion round triangles that the map squeezes; 0 for none.
    pub relaxation_rounds: usize,
}

impl Default for IntegerGridOptions {
    fn default() -> Self {
        Self {
            density: GridDensity::Quads(5000),
            align_boundary: true,
            features: Vec::new(),
            sizing: None,
            stretch: None,
            untangling_rounds: 5,
            relaxation_rounds: 0,
        }
    }
}

impl IntegerGridOptions {
    pub(super) fn check(&self, vertices: usize, edges: usize) -> Result<(), IntegerGridError> {
        self.density.check()?;
        if let Some(edge) = self.features.iter().find(|edge| edge.0 as usize >= edges) {
            return Err(IntegerGridError::NoSuchEdge { edge: *edge, edges });
        }
        if let Some(sizing) = &self.sizing {
            check_sizes(sizing, vertices)?;
        }
        if let Some(stretch) = &self.stretch {
            check_count(stretch, vertices)?;
            // Where there is no direction, no ratio is good.
            let mut ratios = stretch
                .iter()
                .map(|stretch| stretch.ratio + 0.0 * stretch.direction);
            if let Some(value) = ratios.find(|ratio| !(1.0..=f64::MAX).contains(ratio)) {
                return Err(out_of_range("ratio of a stretch", value, "1 and above"));
            }
        }
        Ok(())
    }
}

/// Refuses sizes that are not positive, and too few or too many.
pub(crate) fn check_sizes(sizes: &PerVertex<f64>, vertices: usize) -> Result<(), IntegerGridError> {
    check_count(sizes, vertices)?;
    let is_good = |value: f64| value > 0.0 && value.is_finite() && value.recip().is_finite();
    match sizes.iter().find(|value| !is_good(**value)) {
        Some(&value) => Err(out_of_range("sizing", value, "above 0, finite")),
        None => Ok(()),
    }
}

fn check_count<T>(values: &PerVertex<T>, needed: usize) -> Result<(), IntegerGridError> {
    let given = values.len();
    if given == needed {
        return Ok(());
    }
    Err(IntegerGridError::SizingCount { given, needed })
}
