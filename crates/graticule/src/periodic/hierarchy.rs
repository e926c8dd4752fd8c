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
    let values = lowest(coarsest);
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

/// How many starts are tried on the coarsest level, where they cost next to nothing: where phases
/// may go round a handle any number of times, each leads to a minimum of its own.
const STARTS: u32 = 16;

/// Most nodes for which more than one start is tried.
const MOST_FOR_STARTS: usize = 16 * COARSEST;

/// Share by which an energy must be lower to count: rounding must not choose between equal minima.
const LOWER: f64 = 1e-6;

/// Unit vectors relaxed from each start, those of lowest energy. The starts are powers of the given
/// unit vectors: that keeps them conjugate where these are.
fn lowest(graph: &PhaseGraph) -> Vec<DVec2> {
    let mut start = graph.starts_from.clone();
    let mut best = (f64::INFINITY, Vec::new());
    // Where coarsening stalled early, one start costs enough.
    let starts = if graph.count() <= MOST_FOR_STARTS {
        STARTS
    } else {
        1
    };
    for _ in 0..starts {
        let mut values = start.clone();
        relax(graph, &mut values, COARSEST_SWEEPS);
        let energy = graph.energy(&values);
        if best.1.is_empty() || energy < best.0 * (1.0 - LOWER) {
            best = (energy, values);
        }
        for (power, unit) in start.iter_mut().zip(&graph.starts_from) {
            *power = power.rotate(*unit).normalize_or(DVec2::X);
        }
    }
    best.1
}

fn relax(graph: &PhaseGraph, values: &mut [DVec2], sweeps: usize) {
    for _ in 0..sweeps {
        graph.relax_units(values);
    }
}
