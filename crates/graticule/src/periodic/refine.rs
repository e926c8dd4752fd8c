use crate::geometry::IntrinsicTriangulation;
use crate::mesh::{Element, PerEdge, PerVertex};
use crate::solve::{
    ConjugateGradientOptions, IncompleteCholesky, ParallelMatrix, SymmetricMatrix,
    conjugate_gradients,
};
use crate::watch::Watch;

use super::energy::partner;
use super::unroll::VertexFrames;
use super::{EdgeSteps, PeriodicError};

/// Residual of the correction, relative to what is to be corrected: coordinates off by a tenth of a
/// period come to 1e-5 of one.
const TOLERANCE: f64 = 1e-4;

/// Keeps coordinates of a component without singularity and without line to follow where they are.
const SLACK: f64 = 1e-8;

/// Stands for a coordinate that is not solved for.
const FIXED: u32 = u32::MAX;

/// Solves for the coordinates as real numbers, with the integers of all edges and the whole
/// coordinates kept: the minimum of `Σ w |R^-r pⱼ + n − pᵢ − δ|²`, of which the sines and cosines are
/// an approximation. Returns the iterations of the solver.
pub(super) fn refine(
    triangulation: &IntrinsicTriangulation,
    steps: &EdgeSteps,
    weights: &PerEdge<f64>,
    whole: &PerVertex<[bool; 2]>,
    frames: &mut VertexFrames,
    watch: &Watch,
) -> Result<usize, PeriodicError> {
    let _stage = watch.stage("refinement");
    let mut places = vec![FIXED; 2 * whole.len()];
    let mut count = 0;
    for (place, _) in places
        .iter_mut()
        .zip(whole.iter().flatten())
        .filter(|(_, is_whole)| !**is_whole)
    {
        *place = count;
        count += 1;
    }
    let mut diagonal = vec![0.0; count as usize];
    let mut entries = Vec::with_capacity(2 * weights.len() + count as usize);
    let mut load = vec![0.0; count as usize];
    for (edge, &weight) in weights.enumerate() {
        let [i, j] = triangulation.ends(triangulation.edge_halfedge(edge));
        let (step, jump) = (steps.of_edge(edge), frames.jumps[edge]);
        let at_j = jump.apply(frames.coordinates[j]);
        let miss = at_j - frames.coordinates[i] - step.delta;
        for coordinate in 0..2 {
            let (there, is_mirrored) = partner(step.turn, coordinate);
            let sign = if is_mirrored { -1.0 } else { 1.0 };
            let a = places[2 * i.index() + coordinate];
            let b = places[2 * j.index() + there];
            let pull = weight * miss[coordinate];
            for (place, pull) in [(a, pull), (b, -sign * pull)] {
                if place != FIXED {
                    diagonal[place as usize] += weight;
                    load[place as usize] += pull;
                }
            }
            if a != FIXED && b != FIXED {
                entries.push((b as usize, a as usize, -sign * weight));
            }
        }
    }
    let mean = diagonal.iter().sum::<f64>() / diagonal.len().max(1) as f64;
    let own = diagonal.iter().enumerate();
    entries.extend(own.map(|(place, &value)| (place, place, value + SLACK * mean)));
    let matrix = SymmetricMatrix::from_triplets(count as usize, entries)?;
    let options = ConjugateGradientOptions {
        tolerance: TOLERANCE,
        ..ConjugateGradientOptions::default()
    };
    let preconditioner = IncompleteCholesky::new(&matrix)?;
    let operator = ParallelMatrix::new(&matrix);
    let solution = conjugate_gradients(&operator, &preconditioner, &load, options, watch)?;
    for (vertex, own) in places.chunks_exact(2).enumerate() {
        let vertex = crate::mesh::VertexId::from_index(vertex);
        for (coordinate, &place) in own.iter().enumerate() {
            if place != FIXED {
                frames.coordinates[vertex][coordinate] += solution.values[place as usize];
            }
        }
    }
    Ok(solution.iterations)
}
