use serde::Serialize;

use crate::watch::Watch;

/// Figures of an integer grid map.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct IntegerGridReport {
    /// Singular triangles of the field.
    pub field_singularities: usize,
    /// Singular vertices of the map inside the surface: the irregular ones of its quads.
    pub singular_vertices: usize,
    /// Chains of the cut across which coordinates jump.
    pub chains: usize,
    /// Whole numbers that were free to be chosen.
    pub whole_parameters: usize,
    /// Edges that lines run along.
    pub aligned_edges: usize,
    /// Edges that lines were to run along and do not, for want of room at a corner.
    pub dropped_edges: usize,
    /// Distance of lines that the energy wished for, in the unit of the positions, where the
    /// sizing is 1.
    pub edge_length: f64,
    /// The area of the map, in cells of the net.
    pub cells: f64,
    /// Mean over the area of the difference between the gradients of the coordinates and those
    /// wished for, relative to the latter.
    pub gradient_error: f64,
    /// Triangles without positive orientation after rounding.
    pub flips_before: usize,
    /// The same in the end.
    pub flips: usize,
    /// Vertices on lines to be followed that were let go of them, where nothing else made triangles
    /// positive.
    pub released_vertices: usize,
    /// Times that lines were drawn closer together round flipped triangles: the most of any
    /// component.
    pub denser_rounds: usize,
    /// Densities that were tried for the number of quads.
    pub densities: usize,
}

impl IntegerGridReport {
    /// Counts another component in. What is one for all is left as it is.
    pub(super) fn add(&mut self, other: &Self) {
        self.field_singularities += other.field_singularities;
        self.singular_vertices += other.singular_vertices;
        self.chains += other.chains;
        self.whole_parameters += other.whole_parameters;
        self.aligned_edges += other.aligned_edges;
        self.dropped_edges += other.dropped_edges;
        self.cells += other.cells;
        self.flips += other.flips;
        self.released_vertices += other.released_vertices;
        self.denser_rounds = self.denser_rounds.max(other.denser_rounds);
    }

    /// Tells what the map does not keep of what was asked for.
    pub fn warn(&self, watch: &Watch) {
        for (code, count, what) in [
            (
                "dropped-edges",
                self.dropped_edges,
                "edges without a line along them, for a corner there has no room in the net",
            ),
            (
                "released-vertices",
                self.released_vertices,
                "vertices let go of the lines along them, to keep triangles positive",
            ),
            (
                "denser-lines",
                self.denser_rounds,
                "times that lines were drawn closer together, on parts thinner than a cell",
            ),
            ("flips", self.flips, "flipped triangles of the map"),
        ] {
            if count > 0 {
                watch.warn(code, format!("{what}: {count}"));
            }
        }
    }
}
