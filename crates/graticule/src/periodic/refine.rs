use glam::{DVec2, DVec3};

use crate::geometry::IntrinsicTriangulation;
use crate::mesh::{EdgeId, Element, PerEdge, PerVertex, VertexId};
use crate::solve::{Cholesky, Placement, SolveError, Symbolic, SymmetricMatrix};

use super::EdgeSteps;
use super::energy::{partner, rotor};
use super::unroll::VertexFrames;

/// Keeps coordinates of a component without singularity and without line to follow where they are.
const SLACK: f64 = 1e-8;

/// Solves for coordinates as real numbers, with the integers of all edges and the whole coordinates
/// kept: the minimum of `Σ w |R^-r pⱼ + n − pᵢ − δ|²`, of which the sines and cosines are an
/// approximation.
///
/// Two unknowns for each vertex, which an edge couples to one of the neighbour's each, with a sign.
/// Factored once: each solution after the first costs a fraction of it.
pub(super) struct Refinement<'a> {
    triangulation: &'a IntrinsicTriangulation,
    steps: &'a EdgeSteps,
    weights: PerEdge<f64>,
    whole: &'a PerVertex<[bool; 2]>,
    factor: Cholesky,
}

impl<'a> Refinement<'a> {
    /// `weights` must not be negative.
    pub(super) fn new(
        triangulation: &'a IntrinsicTriangulation,
        steps: &'a EdgeSteps,
        weights: PerEdge<f64>,
        whole: &'a PerVertex<[bool; 2]>,
        positions: &[DVec3],
    ) -> Result<Self, SolveError> {
        let matrix = matrix(triangulation, steps, &weights, whole)?;
        let ordering = Placement::at(positions).with_block(2);
        let ordering = ordering.ordering(matrix.lower().pattern())?;
        let symbolic = Symbolic::new(&matrix, &ordering)?;
        Ok(Self {
            triangulation,
            steps,
            weights,
            whole,
            factor: Cholesky::factor(&symbolic, &matrix)?,
        })
    }

    /// Moves the coordinates to the minimum, for steps turned by the mean of the angles of both
    /// ends, in whole turns.
    pub(super) fn solve(
        &self,
        turns: &PerVertex<f64>,
        frames: &mut VertexFrames,
    ) -> Result<(), SolveError> {
        let mut load = vec![0.0; 2 * turns.len()];
        for (edge, &weight) in self.weights.enumerate() {
            let [i, j] = self.ends(edge);
            let step = self.steps.of_edge(edge);
            let wanted = rotor(0.5 * (turns[i] + turns[j])).rotate(step.delta);
            let miss = self.difference(edge, frames) - wanted;
            for coordinate in 0..2 {
                let (there, is_mirrored) = partner(step.turn, coordinate);
                let pull = weight * miss[coordinate];
                load[2 * i.index() + coordinate] += pull;
                load[2 * j.index() + there] += if is_mirrored { pull } else { -pull };
            }
        }
        for (load, is_whole) in load.iter_mut().zip(self.whole.iter().flatten()) {
            if *is_whole {
                *load = 0.0;
            }
        }
        let solution = self.factor.solve(&load)?;
        let places = frames.coordinates.as_mut_slice().iter_mut();
        for (place, correction) in places.zip(solution.values.chunks_exact(2)) {
            *place += DVec2::from_slice(correction);
        }
        Ok(())
    }

    /// By how much the differences of the coordinates round each vertex are turned against the
    /// steps: the best rotation in the sense of least squares.
    pub(super) fn turns(&self, frames: &VertexFrames) -> PerVertex<f64> {
        let mut products = PerVertex::filled(frames.coordinates.len(), DVec2::ZERO);
        for (edge, &weight) in self.weights.enumerate() {
            // The same in the frames of both ends.
            let delta = self.steps.of_edge(edge).delta * weight;
            let difference = self.difference(edge, frames);
            let product = DVec2::new(delta.dot(difference), delta.perp_dot(difference));
            for end in self.ends(edge) {
                products[end] += product;
            }
        }
        products.map(|product| libm::atan2(product.y, product.x) / std::f64::consts::TAU)
    }

    fn ends(&self, edge: EdgeId) -> [VertexId; 2] {
        let triangulation = self.triangulation;
        triangulation.ends(triangulation.edge_halfedge(edge))
    }

    /// The difference of coordinates along an edge, in the frame of its origin.
    fn difference(&self, edge: EdgeId, frames: &VertexFrames) -> DVec2 {
        let [i, j] = self.ends(edge).map(|end| frames.coordinates[end]);
        frames.jumps[edge].apply(j) - i
    }
}

/// The matrix of the corrections; coordinates that are whole are coupled to nothing.
fn matrix(
    triangulation: &IntrinsicTriangulation,
    steps: &EdgeSteps,
    weights: &PerEdge<f64>,
    whole: &PerVertex<[bool; 2]>,
) -> Result<SymmetricMatrix, SolveError> {
    let is_whole: Vec<bool> = whole.iter().flatten().copied().collect();
    let mut diagonal = vec![0.0; is_whole.len()];
    let mut entries = Vec::with_capacity(2 * weights.len() + diagonal.len());
    for (edge, &weight) in weights.enumerate() {
        let [i, j] = triangulation.ends(triangulation.edge_halfedge(edge));
        for coordinate in 0..2 {
            let (there, is_mirrored) = partner(steps.of_edge(edge).turn, coordinate);
            let (a, b) = (2 * i.index() + coordinate, 2 * j.index() + there);
            diagonal[a] += weight;
            diagonal[b] += weight;
            if !is_whole[a] && !is_whole[b] {
                // An edge from a vertex to itself may couple a coordinate to itself: both halves.
                let both = if a == b { 2.0 } else { 1.0 };
                let entry = both * if is_mirrored { weight } else { -weight };
                entries.push((b, a, entry));
            }
        }
    }
    let mean = diagonal.iter().sum::<f64>() / diagonal.len().max(1) as f64;
    // Where no edge has any weight, every number would do.
    let slack = if mean > 0.0 { SLACK * mean } else { 1.0 };
    let own = diagonal.iter().enumerate();
    entries.extend(own.map(|(place, &value)| (place, place, value + slack)));
    SymmetricMatrix::from_triplets(diagonal.len(), entries)
}
