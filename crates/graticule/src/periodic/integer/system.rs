//! The normal equations of a net with real and whole unknowns, factored once for all densities.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use glam::DVec3;

use super::energy::{NormalEquations, SideEnergy};
use super::form::Form;
use super::unknowns::{Slot, Unknowns, turned};
use crate::mesh::{HalfedgeId, PerVertex, TriangleMesh};
use crate::solve::{Cholesky, Graph, Ordering, SolveError};

/// The energy of a net as a function of all its unknowns, the real ones before the whole ones.
pub(super) struct NetSystem {
    reals: usize,
    factor: Cholesky,
    /// The right-hand side for a density of one line per unit of length.
    loads: Vec<f64>,
    /// The energy's matrix over the whole unknowns once the real ones are at their best.
    complement: Vec<f64>,
    /// All unknowns where the energy is least, at that density, whole or not.
    relaxed: Vec<f64>,
}

/// The energy over the free parameters of the whole unknowns.
pub(super) struct WholeEnergy {
    /// Its matrix, symmetric.
    pub(super) matrix: Mat<f64>,
    /// Its right-hand side, at a density of one line per unit of length.
    pub(super) loads: Vec<f64>,
}

impl NetSystem {
    /// Assembles and factors. The whole unknowns are eliminated last, so that their part of the
    /// energy stands in the factor.
    pub(super) fn new(
        mesh: &TriangleMesh,
        positions: &PerVertex<DVec3>,
        unknowns: &Unknowns,
        energy: &SideEnergy,
    ) -> Result<Self, SolveError> {
        let (matrix, loads) = assemble(mesh, unknowns, energy)?;
        let reals = unknowns.reals;
        let ordering = ordering(mesh, positions, unknowns, matrix.lower().pattern());
        let factor = Cholesky::new(&matrix, &ordering)?;
        let wholes: Vec<u32> = (reals as u32..loads.len() as u32).collect();
        let complement = factor.last_complement(&wholes)?;
        let relaxed = factor.solve(&loads)?.values;
        Ok(Self {
            reals,
            factor,
            loads,
            complement,
            relaxed,
        })
    }

    /// The energy over parameters of which `rows` gives the whole unknowns.
    pub(super) fn over_parameters(&self, rows: &[Form], parameters: usize) -> WholeEnergy {
        let wholes = rows.len();
        let mut basis = Mat::<f64>::zeros(wholes, parameters);
        for (row, form) in rows.iter().enumerate() {
            for &(column, value) in form.terms() {
                basis[(row, column as usize)] = value as f64;
            }
        }
        let complement = MatRef::from_row_major_slice(&self.complement, wholes, wholes);
        let product = |left: MatRef<'_, f64>, right: MatRef<'_, f64>| {
            let mut result = Mat::<f64>::zeros(left.nrows(), right.ncols());
            matmul(result.as_mut(), Accum::Replace, left, right, 1.0, Par::Seq);
            result
        };
        let half = product(complement, basis.as_ref());
        let matrix = product(basis.transpose(), half.as_ref());
        let relaxed = &self.relaxed[self.reals..];
        let load = |column: usize| {
            (0..wholes)
                .map(|row| half[(row, column)] * relaxed[row])
                .sum()
        };
        let loads = (0..parameters).map(load).collect();
        WholeEnergy { matrix, loads }
    }

    /// The best real unknowns for given whole ones, at a density.
    pub(super) fn reals(&self, density: f64, wholes: &[i64]) -> Result<Vec<f64>, SolveError> {
        let mut loads: Vec<f64> = self.loads.iter().map(|load| density * load).collect();
        let relaxed = &self.relaxed[self.reals..];
        let off = wholes.iter().zip(relaxed);
        let off: Vec<f64> = off
            .map(|(&whole, &value)| whole as f64 - density * value)
            .collect();
        // The load on the whole unknowns that moves their solution to the given values.
        let rows = self.complement.chunks_exact(wholes.len().max(1));
        for (load, row) in loads[self.reals..].iter_mut().zip(rows) {
            *load += row
                .iter()
                .zip(&off)
                .map(|(entry, off)| entry * off)
                .sum::<f64>();
        }
        let mut values = self.factor.solve(&loads)?.values;
        values.truncate(self.reals);
        Ok(values)
    }
}

fn assemble(
    mesh: &TriangleMesh,
    unknowns: &Unknowns,
    energy: &SideEnergy,
) -> Result<(crate::solve::SymmetricMatrix, Vec<f64>), SolveError> {
    let mut equations = NormalEquations::new(unknowns.reals + unknowns.wholes);
    let mut terms = Vec::new();
    for halfedge in mesh.halfedges() {
        for coordinate in 0..2 {
            terms.clear();
            push_terms(mesh, unknowns, halfedge.next(), coordinate, 1, &mut terms);
            push_terms(mesh, unknowns, halfedge, coordinate, -1, &mut terms);
            let wish = energy.wishes[halfedge][coordinate];
            equations.add(energy.weights[halfedge], terms.iter().copied(), wish);
        }
    }
    equations.finish()
}

/// A coordinate of a corner, times a sign, as terms of the unknowns.
fn push_terms(
    mesh: &TriangleMesh,
    unknowns: &Unknowns,
    corner: HalfedgeId,
    coordinate: usize,
    factor: i64,
    terms: &mut Vec<(u32, f64)>,
) {
    let reals = unknowns.reals as u32;
    let jump = &unknowns.jumps[corner];
    let (which, sign) = turned(jump.turn, coordinate);
    let sign = sign * factor;
    match unknowns.slots[mesh.origin(corner)][which] {
        Slot::Real(column) => terms.push((column, sign as f64)),
        Slot::Whole(sum) => {
            let sum = unknowns.sums[sum as usize].terms().iter();
            terms.extend(sum.map(|&(column, more)| (reals + column, (sign * more) as f64)));
        }
    }
    for shift in &jump.shifts {
        let (which, sign) = turned(shift.turn, coordinate);
        terms.push((
            reals + 2 * shift.chain + which as u32,
            (sign * factor) as f64,
        ));
    }
}

/// Real unknowns as a mesh wants it, then the whole ones.
fn ordering(
    mesh: &TriangleMesh,
    positions: &PerVertex<DVec3>,
    unknowns: &Unknowns,
    pattern: &crate::solve::Pattern,
) -> Ordering {
    let reals = unknowns.reals as u32;
    let entries = (0..reals).flat_map(|column| {
        let rows = pattern.column(column as usize).iter();
        rows.map(move |&row| [row, column])
    });
    let graph = Graph::from_edges(reals as usize, entries.filter(|[row, _]| *row < reals));
    let mut points = Vec::with_capacity(reals as usize);
    for vertex in mesh.vertices() {
        for slot in unknowns.slots[vertex] {
            if let Slot::Real(_) = slot {
                points.push(positions[vertex]);
            }
        }
    }
    let order = Ordering::for_mesh(&graph, &points);
    let all = order.order().iter().copied();
    let all = all.chain(reals..reals + unknowns.wholes as u32).collect();
    Ordering::from_order(all).unwrap_or_else(|| Ordering::natural(pattern.columns()))
}
