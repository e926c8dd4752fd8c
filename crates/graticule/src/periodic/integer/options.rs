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
            if sizing.len() != vertices {
                let (given, needed) = (sizing.len(), vertices);
                return Err(IntegerGridError::SizingCount { given, needed });
            }
            let bad = sizing
                .iter()
                .find(|value| !(**value > 0.0 && value.is_finite()));
            if let Some(&value) = bad {
                return Err(out_of_range("sizing", value, "above 0, finite"));
            }
        }
        Ok(())
    }
}
