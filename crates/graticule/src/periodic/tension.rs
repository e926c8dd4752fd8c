//! Where the phases want to be singular, vertex by vertex.

use serde::Serialize;

use super::minimize::Minimum;
use super::phase_graph::{FIXED, PhaseGraph};
use crate::mesh::PerVertex;

/// What the minimisation leaves at each vertex ([PGP06] Fig. 5): around what is singular the norm is
/// small and the energy high.
///
/// [PGP06]: crate::papers::PGP06
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhaseTension {
    /// The smaller norm of the two periodic variables, from 0 to about 1: with Newton's method as it
    /// comes out, else of the mean of what the neighbours want. 1 where both coordinates are whole.
    pub norms: PerVertex<f64>,
    /// The vertex's part of the energy F* of the unit vectors, over its share of the mean area of a
    /// vertex.
    pub energies: PerVertex<f64>,
}

impl PhaseTension {
    /// Of a minimum over the nodes of a graph, two for each vertex.
    pub(super) fn of(graph: &PhaseGraph, found: &Minimum) -> Self {
        let free =
            |node: usize| (graph.places[node] != FIXED).then_some(graph.places[node] as usize);
        let count = graph.places.len() / 2;
        let both = |vertex: usize| [2 * vertex, 2 * vertex + 1].into_iter().filter_map(free);
        let norm = |vertex| {
            both(vertex)
                .map(|node| found.moduli[node])
                .fold(1.0, f64::min)
        };
        let energy = |vertex| -> f64 {
            let parts = both(vertex)
                .map(|node| graph.energy_at(node, &found.values).max(0.0) / graph.masses[node]);
            parts.sum()
        };
        Self {
            norms: PerVertex::new((0..count).map(norm).collect()),
            energies: PerVertex::new((0..count).map(energy).collect()),
        }
    }
}
