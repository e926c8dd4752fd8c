//! Phases from coarse to fine.

use glam::DVec2;

use super::minimize::CoarseToFineOptions;
use crate::field::hierarchy::Hierarchy;
use crate::field::phase_graph::PhaseGraph;
use crate::watch::{Stopped, Watch};

/// Nodes in the coarsest level at most, if the couplings carry that far.
const COARSEST: usize = 32;

/// Sweeps on the coarsest level.
const COARSEST_SWEEPS: usize = 50;

/// By how much there are fewer sweeps on the finest level.
const FINEST_SHARE: usize = 3;

/// Unit vectors of low energy: the form is coarsened as long as nodes hang together, solved on the
/// coarsest level, and relaxed on each finer one. Cost: linear.
pub(super) fn phases_from_coarse(
    graph: &PhaseGraph,
    options: CoarseToFineOptions,
    watch: &Watch,
) -> Result<Vec<DVec2>, Stopped> {
    let hierarchy = Hierarchy::new(graph, COARSEST, watch)?;
    let coarsest = hierarchy.coarsest();
    let mut values = coarsest.starts_from.clone();
    relax(coarsest, &mut values, COARSEST_SWEEPS);
    hierarchy.carried_down(values, watch, |finer, values| {
        // The finest level costs more than all others, and has the least left to do.
        let share = if std::ptr::eq(finer, graph) {
            FINEST_SHARE
        } else {
            1
        };
        relax(finer, values, options.sweeps.div_ceil(share));
        Ok(())
    })
}

fn relax(graph: &PhaseGraph, values: &mut [DVec2], sweeps: usize) {
    for _ in 0..sweeps {
        graph.relax_units(values);
    }
}
