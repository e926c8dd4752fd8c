//! The linear system of a Newton step, two unknowns for each vertex: one symbolic factorisation
//! for all steps.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::energy::Expansion;
use crate::solve::{Cholesky, Placement, SolveError, Symbolic, SymmetricMatrix};
use crate::tolerance::NEWTON_DAMPING;

/// Entries of the lower triangle of a triangle's 6 × 6 matrix.
const ENTRIES: usize = 21;

/// Gradient and Hessian by the places of vertices, where triangles couple their corners.
#[derive(Debug)]
pub(super) struct NewtonSystem<'a> {
    triangles: &'a [[u32; 3]],
    /// Pairs of vertices that are coupled beside those of triangles.
    coupled: Vec<[u32; 2]>,
    /// Where each triangle's entries stand among the matrix's values.
    slots: Vec<[u32; ENTRIES]>,
    diagonal: Vec<u32>,
    matrix: SymmetricMatrix,
    symbolic: Arc<Symbolic>,
    fixed: Vec<bool>,
    pub(super) gradient: Vec<DVec2>,
    pub(super) hessian: Vec<f64>,
    /// What turns the direction beside the gradient: no part of the energy's slope.
    pull: Vec<DVec2>,
}

/// A common move of a boundary vertex and the ends of an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mode {
    pub(super) vertices: [u32; 3],
    pub(super) moves: [DVec2; 3],
}

impl Mode {
    /// The same moves turned by a quarter.
    pub(super) fn across(&self) -> Self {
        Self {
            vertices: self.vertices,
            moves: self.moves.map(DVec2::perp),
        }
    }
}

/// A direction in which to move all vertices.
pub(super) struct Direction {
    pub(super) step: Vec<DVec2>,
    /// The slope of the energy along it, below 0 unless at a critical point.
    pub(super) slope: f64,
    /// Relative residual of the linear system.
    pub(super) residual: f64,
}

impl<'a> NewtonSystem<'a> {
    /// Plans the system of these triangles over `points.len()` vertices; `points` say where the
    /// vertices lie in space. `fixed` vertices do not move.
    pub(super) fn new(
        triangles: &'a [[u32; 3]],
        points: &[DVec3],
        fixed: Vec<bool>,
    ) -> Result<Self, SolveError> {
        Self::planned(triangles, Vec::new(), points, fixed)
    }

    /// Plans it anew with more pairs of vertices coupled than those of triangles, which lie near
    /// each other in the plane.
    pub(super) fn plan(&mut self, pairs: &[[u32; 2]], places: &[DVec2]) -> Result<(), SolveError> {
        let points: Vec<DVec3> = places.iter().map(|place| place.extend(0.0)).collect();
        let fixed = std::mem::take(&mut self.fixed);
        *self = Self::planned(self.triangles, pairs.to_vec(), &points, fixed)?;
        Ok(())
    }

    fn planned(
        triangles: &'a [[u32; 3]],
        coupled: Vec<[u32; 2]>,
        points: &[DVec3],
        fixed: Vec<bool>,
    ) -> Result<Self, SolveError> {
        let unknowns = 2 * points.len();
        let entries = pattern(triangles, &coupled, points.len());
        let matrix = SymmetricMatrix::from_triplets(unknowns, entries)?;
        let places = matrix.lower().pattern();
        let ordering = Placement::at(points).with_block(2).ordering(places)?;
        let symbolic = Symbolic::new(&matrix, &ordering)?;
        let slot = |row: usize, column: usize| {
            let place = places.find(row.max(column), row.min(column));
            place.map_or(0, |place| place as u32)
        };
        let slots = triangles.iter().map(|triangle| {
            let unknown = |entry: usize| 2 * triangle[entry / 2] as usize + entry % 2;
            let mut entries = lower_entries();
            std::array::from_fn(|_| {
                let [row, column] = entries.next().unwrap_or_default();
                slot(unknown(row), unknown(column))
            })
        });
        Ok(Self {
            slots: slots.collect(),
            diagonal: (0..unknowns)
                .map(|unknown| slot(unknown, unknown))
                .collect(),
            hessian: vec![0.0; places.entries()],
            gradient: vec![DVec2::ZERO; points.len()],
            pull: vec![DVec2::ZERO; points.len()],
            triangles,
            coupled,
            symbolic,
            fixed,
            matrix,
        })
    }

    /// The pairs that are coupled beside those of triangles.
    pub(super) fn coupled(&self) -> &[[u32; 2]] {
        &self.coupled
    }

    /// Whether the vertices of all these pairs are coupled.
    pub(super) fn couples(&self, pairs: &[[u32; 2]]) -> bool {
        let pattern = self.matrix.lower().pattern();
        pairs.iter().all(|&[a, b]| {
            let place = pattern.find(2 * a.max(b) as usize, 2 * a.min(b) as usize);
            place.is_some()
        })
    }

    /// Empties gradient and Hessian.
    pub(super) fn clear(&mut self) {
        self.gradient.fill(DVec2::ZERO);
        self.pull.fill(DVec2::ZERO);
        self.hessian.fill(0.0);
    }

    /// Adds `weight` times the expansion of the triangle number `index` of those given at first.
    pub(super) fn add_triangle(
        &mut self,
        index: usize,
        corners: [u32; 3],
        weight: f64,
        expansion: &Expansion,
    ) {
        for (corner, pair) in corners.iter().zip(expansion.gradient.chunks_exact(2)) {
            self.gradient[*corner as usize] += weight * DVec2::new(pair[0], pair[1]);
        }
        for (&slot, entry) in self.slots[index].iter().zip(expansion.hessian) {
            self.hessian[slot as usize] += weight * entry;
        }
    }

    /// Adds `slope` times a mode to the gradient.
    pub(super) fn add_force(&mut self, mode: &Mode, slope: f64) {
        for (&vertex, &along) in mode.vertices.iter().zip(&mode.moves) {
            self.gradient[vertex as usize] += slope * along;
        }
    }

    /// Adds `curvature` times mode modeᵀ to the Hessian; its vertices must be coupled.
    pub(super) fn add_stiffness(&mut self, mode: &Mode, curvature: f64) {
        let unknown = |entry: usize| 2 * mode.vertices[entry / 2] as usize + entry % 2;
        let along = |entry: usize| mode.moves[entry / 2][entry % 2];
        let pattern = Arc::clone(self.matrix.lower().pattern());
        for [row, column] in lower_entries() {
            let (high, low) = (
                unknown(row).max(unknown(column)),
                unknown(row).min(unknown(column)),
            );
            let slot = pattern.find(high, low);
            debug_assert!(slot.is_some(), "vertices {high} and {low} are not coupled");
            if let Some(slot) = slot {
                self.hessian[slot] += curvature * along(row) * along(column);
            }
        }
    }

    /// Asks the direction to go `share` along a mode, the more so the stiffer: adds
    /// stiffness / 2 · (mode · step − share)² to the model of the energy.
    pub(super) fn add_aim(&mut self, mode: &Mode, share: f64, stiffness: f64) {
        self.add_stiffness(mode, stiffness);
        for (&vertex, &along) in mode.vertices.iter().zip(&mode.moves) {
            self.pull[vertex as usize] += share * stiffness * along;
        }
    }

    /// The trace of the Hessian's block of a vertex.
    pub(super) fn stiffness(&self, vertex: u32) -> f64 {
        let first = 2 * vertex as usize;
        let own = &self.diagonal[first..first + 2];
        own.iter().map(|&slot| self.hessian[slot as usize]).sum()
    }

    /// The Newton direction of what was added since [`clear`](Self::clear), if the Hessian is
    /// positive.
    pub(super) fn exact_direction(&mut self) -> Result<Option<Direction>, SolveError> {
        self.hold_still();
        match self.damped_direction(0.0) {
            Ok(direction) => Ok(Some(direction)),
            Err(SolveError::NotPositiveDefinite { .. } | SolveError::Inaccurate { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The same for a Hessian that is positive but for rounding, which may leave the matrix
    /// indefinite: then its diagonal is raised until it is not.
    pub(super) fn direction(&mut self) -> Result<Direction, SolveError> {
        self.hold_still();
        let mut damping = 0.0;
        loop {
            match self.damped_direction(damping) {
                Ok(direction) => return Ok(direction),
                Err(SolveError::NotPositiveDefinite { .. } | SolveError::Inaccurate { .. })
                    if damping < 1.0 =>
                {
                    damping = (damping * 1e3).max(NEWTON_DAMPING);
                }
                Err(error) => return Err(error),
            }
        }
    }

    fn damped_direction(&self, damping: f64) -> Result<Direction, SolveError> {
        let mut values = self.hessian.clone();
        for &slot in &self.diagonal {
            values[slot as usize] *= 1.0 + damping;
        }
        let factor = Cholesky::factor(&self.symbolic, &self.matrix.with_values(values)?)?;
        let pulled = self.gradient.iter().zip(&self.pull);
        let forces: Vec<f64> = pulled
            .map(|(&gradient, &pull)| pull - gradient)
            .flat_map(<[f64; 2]>::from)
            .collect();
        let solution = factor.solve(&forces)?;
        let pairs = solution.values.chunks_exact(2);
        let step: Vec<DVec2> = pairs.map(DVec2::from_slice).collect();
        let slope = self
            .gradient
            .iter()
            .zip(&step)
            .map(|(g, s)| g.dot(*s))
            .sum();
        Ok(Direction {
            step,
            slope,
            residual: solution.residual,
        })
    }

    /// Takes fixed vertices out of the equations. Where there are none, the first vertex is held:
    /// forces inside a surface sum to zero, so that this changes the step by a translation only.
    fn hold_still(&mut self) {
        if !self.fixed.contains(&true) {
            for &slot in self.diagonal.iter().take(2) {
                self.hessian[slot as usize] *= 2.0;
            }
            return;
        }
        let pattern = self.matrix.lower().pattern();
        let mut slot = 0;
        for column in 0..pattern.columns() {
            for &row in pattern.column(column) {
                if self.fixed[column / 2] || self.fixed[row as usize / 2] {
                    self.hessian[slot] = f64::from(row as usize == column);
                }
                slot += 1;
            }
        }
        for (vertex, _) in self.fixed.iter().enumerate().filter(|(_, fixed)| **fixed) {
            self.gradient[vertex] = DVec2::ZERO;
            self.pull[vertex] = DVec2::ZERO;
        }
    }

    /// The longest force on a vertex.
    pub(super) fn largest_force(&self) -> f64 {
        let longest = |longest: f64, gradient: &DVec2| longest.max(gradient.length());
        self.gradient.iter().fold(0.0, longest)
    }
}

/// Rows and columns of the lower triangle of a 6 × 6 matrix, row by row.
fn lower_entries() -> impl Iterator<Item = [usize; 2]> {
    (0..6).flat_map(|row| (0..=row).map(move |column| [row, column]))
}

/// A zero at every place that vertices, edges of the triangles and other pairs couple.
fn pattern(
    triangles: &[[u32; 3]],
    pairs: &[[u32; 2]],
    vertices: usize,
) -> impl Iterator<Item = (usize, usize, f64)> {
    let sides = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut edges: Vec<[u32; 2]> = sides
        .chain(pairs.iter().copied())
        .map(|[a, b]| [a.max(b), a.min(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let own = (0..2 * vertices).map(|unknown| (unknown, unknown, 0.0));
    let cross = (0..vertices).map(|vertex| (2 * vertex + 1, 2 * vertex, 0.0));
    let coupled = edges.into_iter().flat_map(|[high, low]| {
        [[0, 0], [0, 1], [1, 0], [1, 1]]
            .map(|[i, j]| (2 * high as usize + i, 2 * low as usize + j, 0.0))
    });
    own.chain(cross).chain(coupled)
}
