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
}

impl Default for IntegerGridOptions {
    fn default() -> Self {
        Self {
            density: GridDensity::Quads(5000),
            align_boundary: true,
            features: Vec::new(),
            sizing: None,
            untangling_rounds: 5,
        }
    }
}

impl IntegerGridOptions {
    pub(super) fn check(&self, vertices: usize, edges: usize) -> Result<(), IntegerGridError> {
        let range = |name, value, range| Err(IntegerGridError::Option { name, value, range });
        match self.density {
            GridDensity::EdgeLength(length) if !(length > 0.0 && length.is_finite()) => {
                return range("edge length", length, "above 0, finite");
            }
            GridDensity::Quads(0) => return range("number of quads", 0.0, "1 and above"),
            _ => {}
        }
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
                return range("sizing", value, "above 0, finite");
            }
        }
        Ok(())
    }
}
