use crate::geometry::IntrinsicTriangulation;
use crate::mesh::{EdgeId, Element, PerEdge, PerVertex, VertexId};
use crate::solve::{
    ConjugateGradientOptions, IncompleteCholesky, ParallelMatrix, SolveError, SymmetricMatrix,
    conjugate_gradients,
};
use crate::watch::Watch;

use super::energy::partner;
use super::phase_graph::FIXED;
use super::unroll::VertexFrames;
use super::{EdgeSteps, PeriodicError};

/// Residual of the correction, relative to what is to be corrected: coordinates off by a tenth of a
/// period come to 1e-5 of one.
const TOLERANCE: f64 = 1e-4;

/// Keeps coordinates of a component without singularity and without line to follow where they are.
const SLACK: f64 = 1e-8;

/// Solves for the coordinates as real numbers, with the integers of all edges and the whole
/// coordinates kept: the minimum of `Σ w |R^-r pⱼ + n − pᵢ − δ|²`, of which the sines and cosines are
/// an approximation. Returns the iterations of the solver.
///
/// The system has one unknown for each coordinate, which along an edge is coupled to one coordinate
/// of the neighbour, with a sign. `weights` must not be negative.
pub(super) fn refine(
    triangulation: &IntrinsicTriangulation,
    steps: &EdgeSteps,
    weights: &PerEdge<f64>,
    whole: &PerVertex<[bool; 2]>,
    frames: &mut VertexFrames,
    watch: &Watch,
) -> Result<usize, PeriodicError> {
    let _stage = watch.stage("refinement");
    let mut system = System::new(whole);
    for (edge, &weight) in weights.enumerate() {
        system.add_edge(edge, weight, triangulation, steps, frames);
    }
    let matrix = system.matrix()?;
    let options = ConjugateGradientOptions {
        tolerance: TOLERANCE,
        ..ConjugateGradientOptions::default()
    };
    let preconditioner = IncompleteCholesky::new(&matrix)?;
    let operator = ParallelMatrix::new(&matrix);
    let solution = conjugate_gradients(&operator, &preconditioner, &system.load, options, watch)?;
    for (vertex, places) in system.places.chunks_exact(2).enumerate() {
        for (coordinate, &place) in places.iter().enumerate() {
            if place != FIXED {
                let vertex = VertexId::from_index(vertex);
                frames.coordinates[vertex][coordinate] += solution.values[place as usize];
            }
        }
    }
    Ok(solution.iterations)
}

/// The linear system for the corrections of all coordinates that are not whole.
struct System {
    /// The unknown of each coordinate, or [`FIXED`].
    places: Vec<u32>,
    diagonal: Vec<f64>,
    /// Entries off the diagonal, each once.
    entries: Vec<(usize, usize, f64)>,
    load: Vec<f64>,
}

impl System {
    fn new(whole: &PerVertex<[bool; 2]>) -> Self {
        let mut count = 0;
        let places = whole.iter().flatten().map(|&is_whole| {
            if is_whole {
                return FIXED;
            }
            count += 1;
            count - 1
        });
        let places = places.collect();
        Self {
            places,
            diagonal: vec![0.0; count as usize],
            entries: Vec::new(),
            load: vec![0.0; count as usize],
        }
    }

    fn add_edge(
        &mut self,
        edge: EdgeId,
        weight: f64,
        triangulation: &IntrinsicTriangulation,
        steps: &EdgeSteps,
        frames: &VertexFrames,
    ) {
        let [i, j] = triangulation.ends(triangulation.edge_halfedge(edge));
        let step = steps.of_edge(edge);
        let at_j = frames.jumps[edge].apply(frames.coordinates[j]);
        let miss = at_j - frames.coordinates[i] - step.delta;
        for coordinate in 0..2 {
            let (there, is_mirrored) = partner(step.turn, coordinate);
            let sign = if is_mirrored { -1.0 } else { 1.0 };
            let a = self.places[2 * i.index() + coordinate];
            let b = self.places[2 * j.index() + there];
            let pull = weight * miss[coordinate];
            for (place, pull) in [(a, pull), (b, -sign * pull)] {
                if place != FIXED {
                    self.diagonal[place as usize] += weight;
                    self.load[place as usize] += pull;
                }
            }
            if a != FIXED && b != FIXED {
                // An edge from a vertex to itself may couple a coordinate to itself: both halves.
                let both = if a == b { 2.0 } else { 1.0 };
                let entry = -sign * weight * both;
                self.entries.push((b as usize, a as usize, entry));
            }
        }
    }

    fn matrix(&self) -> Result<SymmetricMatrix, SolveError> {
        let mean = self.diagonal.iter().sum::<f64>() / self.diagonal.len().max(1) as f64;
        // Where no edge has any weight, every number would do.
        let slack = if mean > 0.0 { SLACK * mean } else { 1.0 };
        let own = self.diagonal.iter().enumerate();
        let own = own.map(|(place, &value)| (place, place, value + slack));
        let entries = self.entries.iter().copied().chain(own);
        SymmetricMatrix::from_triplets(self.diagonal.len(), entries)
    }
}
