//! Diffusion and normalisation of a field over the vertices that are not fixed.

use std::f64::consts::TAU;

use faer::c64;
use glam::{DVec2, DVec3};

use super::connection::ConnectionLaplacian;
use super::{FieldError, Guidance, Symmetry};
use crate::geometry::{IntrinsicTriangulation, vertex_areas};
use crate::mesh::{Element, PerVertex, VertexId};
use crate::solve::{HermitianCholesky, HermitianMatrix, Placement, SymmetricMatrix};
use crate::tolerance::{
    DIFFUSION_STEP, FAINT_GUIDANCE, FIELD_AT_REST, FREE_FIELD_AT_REST, NO_DIRECTION,
};
use crate::watch::Watch;

/// Stands for no place among the free vertices.
const FIXED: usize = usize::MAX;

/// The quadratic form: smoothness, guidance and diffusion, and what is fixed.
pub(super) struct System {
    pub(super) connection: ConnectionLaplacian,
    pub(super) smoothing: f64,
    /// Area of each vertex over the mean.
    pub(super) masses: PerVertex<f64>,
    /// Sums of weights × targets and of weights, both with ρ and the areas in.
    pub(super) pulls: PerVertex<DVec2>,
    pub(super) weights: PerVertex<f64>,
    fixed: PerVertex<Option<DVec2>>,
    /// The vertices that are not fixed, and for each vertex its place among them or [`FIXED`].
    pub(super) free: Vec<VertexId>,
    places: PerVertex<usize>,
}

impl System {
    pub(super) fn new(
        triangulation: &IntrinsicTriangulation,
        guidance: &Guidance,
        smoothing: f64,
    ) -> Result<Self, FieldError> {
        let areas = vertex_areas(triangulation);
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        // A vertex of area 0 must not drop out of the matrix.
        let masses = areas.map(|area| (area / mean).max(f64::EPSILON));
        let fitting = |vertex: VertexId| (1.0 - smoothing) * masses[vertex];
        let count = guidance.vertex_count();
        let is_free = |vertex: &VertexId| guidance.fixed(*vertex).is_none();
        let free: Vec<_> = triangulation.vertices().filter(is_free).collect();
        let mut places = PerVertex::filled(count, FIXED);
        for (place, &vertex) in free.iter().enumerate() {
            places[vertex] = place;
        }
        Ok(Self {
            connection: ConnectionLaplacian::new(triangulation, guidance.symmetry())?,
            smoothing,
            pulls: PerVertex::from_fn(count, |v| guidance.pull(v) * fitting(v)),
            weights: PerVertex::from_fn(count, |v| guidance.weight(v) * fitting(v)),
            fixed: PerVertex::from_fn(count, |v| guidance.fixed(v)),
            masses,
            free,
            places,
        })
    }

    /// The matrix of the form over the free vertices, complex and Hermitian.
    fn matrix(&self) -> Result<HermitianMatrix, FieldError> {
        let own = |&vertex: &VertexId| self.weights[vertex] + DIFFUSION_STEP * self.masses[vertex];
        let mut diagonal: Vec<f64> = self.free.iter().map(own).collect();
        let [mut real, mut imaginary] = [Vec::new(), Vec::new()];
        for edge in &self.connection.edges {
            let weight = self.smoothing * edge.weight;
            let [i, j] = edge.ends.map(|vertex| self.places[vertex]);
            for place in [i, j].into_iter().filter(|&place| place != FIXED) {
                diagonal[place] += weight;
            }
            if i != FIXED && j != FIXED {
                real.push((j, i, -weight * edge.rotation.x));
                imaginary.push((j, i, -weight * edge.rotation.y));
            }
        }
        let diagonal = diagonal.iter().enumerate();
        let diagonal = diagonal.map(|(place, &value)| (place, place, value));
        let real =
            SymmetricMatrix::from_triplets(self.free.len(), real.into_iter().chain(diagonal))?;
        Ok(HermitianMatrix::new(&real, imaginary)?)
    }

    /// The part of the right-hand side that does not change: guidance, and what fixed neighbours
    /// bring.
    fn constant_side(&self) -> Vec<DVec2> {
        let mut side: Vec<DVec2> = self.free.iter().map(|&v| self.pulls[v]).collect();
        for edge in &self.connection.edges {
            let [i, j] = edge.ends;
            let weight = self.smoothing * edge.weight;
            match (self.fixed[i], self.fixed[j]) {
                (Some(at_i), None) => side[self.places[j]] += edge.rotation.rotate(at_i) * weight,
                (None, Some(at_j)) => {
                    side[self.places[i]] += edge.conjugate().rotate(at_j) * weight;
                }
                _ => {}
            }
        }
        side
    }

    /// The place of a vertex among the free ones.
    pub(super) fn place(&self, vertex: VertexId) -> Option<usize> {
        Some(self.places[vertex]).filter(|&place| place != FIXED)
    }

    /// The unit vectors of all vertices, from those of the free ones.
    pub(super) fn with_fixed(&self, free: &[DVec2]) -> PerVertex<DVec2> {
        PerVertex::from_fn(self.fixed.len(), |vertex: VertexId| {
            self.fixed[vertex].unwrap_or_else(|| free[self.places[vertex]])
        })
    }

    /// Whether so little guides the field that diffusion alone decides where it is singular.
    pub(super) fn is_unguided(&self) -> bool {
        let wished: f64 = self.weights.iter().sum();
        let total: f64 = self.masses.iter().sum();
        self.fixed.iter().all(Option::is_none)
            && wished <= FAINT_GUIDANCE * (1.0 - self.smoothing) * total
    }

    /// How far unit vectors are from the guidance.
    pub(super) fn guidance_energy(&self, powers: &PerVertex<DVec2>) -> f64 {
        // Σ w |u - t|² = Σ w (2 - 2 u·t) for unit vectors.
        let terms = powers
            .enumerate()
            .map(|(vertex, power)| 2.0 * (self.weights[vertex] - power.dot(self.pulls[vertex])));
        terms.sum::<f64>().max(0.0)
    }
}

/// The iteration, with its factorisation; vectors are those of the free vertices.
pub(super) struct Diffusion<'a> {
    system: &'a System,
    solver: Option<(HermitianMatrix, HermitianCholesky)>,
    constant: Vec<DVec2>,
    /// Relative residual of the first solve; all have the same matrix.
    pub(super) residual: f64,
    /// Steps taken so far.
    pub(super) steps: usize,
    /// Mean change in the last of them.
    pub(super) last_change: f64,
}

impl<'a> Diffusion<'a> {
    pub(super) fn new(
        system: &'a System,
        positions: &PerVertex<DVec3>,
        watch: &Watch,
    ) -> Result<Self, FieldError> {
        Ok(Self {
            solver: factored(system, positions, watch)?,
            constant: system.constant_side(),
            system,
            residual: 0.0,
            steps: 0,
            last_change: 0.0,
        })
    }

    /// Guidance carried into the places without; seeded phases where none arrives.
    pub(super) fn start(&mut self, seed: u64) -> Result<Vec<DVec2>, FieldError> {
        let carried = self.diffuse(&vec![DVec2::ZERO; self.system.free.len()], true)?;
        let vertices = self.system.free.iter();
        let powers = vertices.zip(carried).map(|(&vertex, power)| {
            if power.length() > NO_DIRECTION {
                power.normalize()
            } else {
                phase(vertex, seed)
            }
        });
        Ok(powers.collect())
    }

    /// One solve. To check it costs nearly as much again.
    fn diffuse(&mut self, powers: &[DVec2], is_checked: bool) -> Result<Vec<DVec2>, FieldError> {
        let Some((matrix, factor)) = &self.solver else {
            return Ok(Vec::new());
        };
        let parts = self.system.free.iter().zip(&self.constant).zip(powers);
        let side = parts.map(|((&vertex, &constant), &power)| {
            let value = constant + power * (DIFFUSION_STEP * self.system.masses[vertex]);
            c64::new(value.x, value.y)
        });
        let side: Vec<c64> = side.collect();
        let solution = factor.solve(&side)?;
        if is_checked {
            self.residual = relative_residual(matrix, &solution, &side);
        }
        let vectors = solution.iter().map(|value| DVec2::new(value.re, value.im));
        Ok(vectors.collect())
    }

    /// Diffuses and normalises until the field is at rest, at most so many times.
    pub(super) fn descend(
        &mut self,
        start: Vec<DVec2>,
        steps: usize,
        watch: &Watch,
    ) -> Result<Vec<DVec2>, FieldError> {
        let mut powers = start;
        let at_rest = if self.system.is_unguided() {
            FREE_FIELD_AT_REST
        } else {
            FIELD_AT_REST
        };
        while self.steps < steps && !powers.is_empty() {
            watch.check()?;
            let diffused = self.diffuse(&powers, self.steps == 0)?;
            let mut moved = 0.0;
            for (power, next) in powers.iter_mut().zip(&diffused) {
                // A vector that vanishes says nothing: keep the one before.
                let next = next.try_normalize().unwrap_or(*power);
                moved += power.distance(next);
                *power = next;
            }
            self.last_change = moved / powers.len() as f64;
            self.steps += 1;
            watch.progress(self.steps as f64 / steps as f64);
            if self.last_change < at_rest {
                break;
            }
        }
        Ok(powers)
    }
}

fn factored(
    system: &System,
    positions: &PerVertex<DVec3>,
    watch: &Watch,
) -> Result<Option<(HermitianMatrix, HermitianCholesky)>, FieldError> {
    if system.free.is_empty() {
        return Ok(None);
    }
    let _stage = watch.stage("factorisation");
    let matrix = system.matrix()?;
    let positions: Vec<DVec3> = system.free.iter().map(|&v| positions[v]).collect();
    let ordering = Placement::at(&positions).ordering(matrix.pattern())?;
    watch.check()?;
    let factor = HermitianCholesky::new(&matrix, &ordering)?;
    Ok(Some((matrix, factor)))
}

/// `|Ax - b| / (|A| |x| + |b|)` in largest entries and row sums.
fn relative_residual(matrix: &HermitianMatrix, solution: &[c64], side: &[c64]) -> f64 {
    let largest = |values: &mut dyn Iterator<Item = c64>| values.map(c64::norm).fold(0.0, f64::max);
    let product = matrix.multiply(solution);
    let rest = largest(&mut product.iter().zip(side).map(|(a, b)| a - b));
    let size = matrix.row_sum_norm() * largest(&mut solution.iter().copied())
        + largest(&mut side.iter().copied());
    if size > 0.0 { rest / size } else { 0.0 }
}

/// Phases that neighbours do not share, the same on every machine: a hash of vertex and seed
/// (S. Vigna's `SplitMix64`).
pub(crate) fn phase(vertex: VertexId, seed: u64) -> DVec2 {
    let number = (vertex.index() as u64).wrapping_add(seed.rotate_left(32));
    let mut bits = number.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^= bits >> 31;
    Symmetry::Vector.power(TAU * (bits >> 11) as f64 / (1_u64 << 53) as f64)
}
