//! Phases from coarse to fine.

use glam::DVec2;

use super::minimize::CoarseToFineOptions;
use super::phase_graph::PhaseGraph;
use crate::field::hierarchy::Hierarchy;
use crate::field::phase;
use crate::mesh::{Element, VertexId};
use crate::watch::{Stopped, Watch};

/// Nodes in the coarsest level at most, if the couplings carry that far.
const COARSEST: usize = 32;

/// Sweeps on the coarsest level, and on each other.
const COARSEST_SWEEPS: usize = 50;

/// Unit vectors of low energy: the form is coarsened as long as nodes hang together, solved on the
/// coarsest level from seeded phases, and relaxed on each finer one. Cost: linear.
pub(super) fn phases_from_coarse(
    graph: &PhaseGraph,
    options: CoarseToFineOptions,
    watch: &Watch,
) -> Result<Vec<DVec2>, Stopped> {
    let hierarchy = Hierarchy::new(graph, COARSEST, watch)?;
    let coarsest = hierarchy.coarsest();
    let mut values = seeded_phases(coarsest.count(), options.seed);
    relax(coarsest, &mut values, COARSEST_SWEEPS);
    hierarchy.carried_down(values, watch, |finer, values| {
        relax(finer, values, options.sweeps);
        Ok(())
    })
}

fn relax(graph: &PhaseGraph, values: &mut [DVec2], sweeps: usize) {
    for _ in 0..sweeps {
        graph.relax_units(values);
    }
}

/// A unit vector for each node, from nowhere but its number and the seed.
pub(super) fn seeded_phases(count: usize, seed: u64) -> Vec<DVec2> {
    let nodes = (0..count).map(VertexId::from_index);
    nodes.map(|node| phase(node, seed)).collect()
}
