//! The normal equations of a net with real and whole unknowns, factored once for all densities.

use std::convert::Infallible;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use glam::DVec2;

use super::IntegerGridError;
use super::energy::{NormalEquations, merge_terms};
use super::form::Form;
use super::solver::Parts;
use super::unknowns::{Slot, turned};
use crate::mesh::{Element, HalfedgeId, PerCorner};
use crate::solve::{Cholesky, Ordering, Pattern, SolveError, SymmetricMatrix};

/// The most entries off the diagonal: 1.6 GB. Six million triangles have so many.
const MOST_ENTRIES: usize = 1 << 26;

/// The energy of a net as a function of all its unknowns, the real ones before the whole ones.
pub(super) struct NetSystem {
    reals: usize,
    factor: Cholesky,
    /// The right-hand side for a density of one line per unit of length.
    loads: Vec<f64>,
    /// A lower triangle, by rows, that times its transpose is the energy's matrix over the whole
    /// unknowns once the real ones are at their best.
    last_block: Vec<f64>,
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
    pub(super) fn new(parts: Parts<'_>) -> Result<Self, IntegerGridError> {
        let reals = parts.unknowns.reals;
        let (matrix, loads) = normal_equations(parts, reals + parts.unknowns.wholes)?.finish()?;
        let ordering = ordering(parts, matrix.lower().pattern());
        let factor = Cholesky::new(&matrix, &ordering)?;
        Self::factored(factor, loads, reals)
    }

    /// Takes over other weights, of which none was or becomes 0.
    pub(super) fn reweigh(&mut self, parts: Parts<'_>) -> Result<(), IntegerGridError> {
        let matrix = reweighed(self.factor.matrix(), parts)?;
        let loads = right_side(parts, self.loads.len());
        let factor = Cholesky::factor(self.factor.symbolic(), &matrix)?;
        *self = Self::factored(factor, loads, self.reals)?;
        Ok(())
    }

    fn factored(factor: Cholesky, loads: Vec<f64>, reals: usize) -> Result<Self, IntegerGridError> {
        let wholes: Vec<u32> = (reals as u32..loads.len() as u32).collect();
        let last_block = factor.last_block(&wholes)?;
        let relaxed = factor.solve(&loads)?.values;
        Ok(Self {
            reals,
            factor,
            loads,
            last_block,
            relaxed,
        })
    }

    /// The energy over parameters of which `rows` gives the whole unknowns.
    pub(super) fn over_parameters(&self, rows: &[Form], parameters: usize) -> WholeEnergy {
        let wholes = rows.len();
        // The transposed block times the parameters' coefficients: half of the matrix, so to speak.
        let mut half = Mat::<f64>::zeros(wholes, parameters);
        for (row, (form, block)) in rows.iter().zip(self.block_rows()).enumerate() {
            for &(column, value) in form.terms() {
                let entries = &mut half.col_as_slice_mut(column as usize)[..=row];
                for (entry, own) in entries.iter_mut().zip(block) {
                    *entry += value as f64 * own;
                }
            }
        }
        let mut matrix = Mat::<f64>::zeros(parameters, parameters);
        let (left, right) = (half.transpose(), half.as_ref());
        matmul(matrix.as_mut(), Accum::Replace, left, right, 1.0, Par::Seq);
        let loads = self.parameter_loads(rows, parameters);
        WholeEnergy { matrix, loads }
    }

    /// The right-hand side over the parameters.
    pub(super) fn parameter_loads(&self, rows: &[Form], parameters: usize) -> Vec<f64> {
        let mut loads = vec![0.0; parameters];
        let on_wholes = self.complement_times(&self.relaxed[self.reals..]);
        for (form, load) in rows.iter().zip(on_wholes) {
            for &(column, value) in form.terms() {
                loads[column as usize] += value as f64 * load;
            }
        }
        loads
    }

    /// Takes over other wishes; the matrix stays.
    pub(super) fn wish(&mut self, parts: Parts<'_>) -> Result<(), SolveError> {
        self.loads = right_side(parts, self.loads.len());
        self.relaxed = self.factor.solve(&self.loads)?.values;
        Ok(())
    }

    fn block_rows(&self) -> impl Iterator<Item = &[f64]> {
        let wholes = self.relaxed.len() - self.reals;
        self.last_block.chunks_exact(wholes.max(1))
    }

    /// The energy's matrix over the whole unknowns times a vector.
    fn complement_times(&self, values: &[f64]) -> Vec<f64> {
        let mut half = vec![0.0; values.len()];
        for (row, (entries, value)) in self.block_rows().zip(values).enumerate() {
            for (sum, entry) in half[..=row].iter_mut().zip(entries) {
                *sum += entry * value;
            }
        }
        let product = |(row, entries): (usize, &[f64])| {
            let terms = entries[..=row].iter().zip(&half);
            terms.map(|(entry, value)| entry * value).sum()
        };
        self.block_rows().enumerate().map(product).collect()
    }

    /// The best real unknowns for given whole ones, at a density.
    pub(super) fn reals(&self, density: f64, wholes: &[f64]) -> Result<Vec<f64>, SolveError> {
        let mut loads: Vec<f64> = self.loads.iter().map(|load| density * load).collect();
        let relaxed = &self.relaxed[self.reals..];
        let off = wholes.iter().zip(relaxed);
        let off: Vec<f64> = off
            .map(|(&whole, &value)| whole - density * value)
            .collect();
        // The load on the whole unknowns that moves their solution to the given values.
        let moving = self.complement_times(&off);
        for (load, more) in loads[self.reals..].iter_mut().zip(moving) {
            *load += more;
        }
        let mut values = self.factor.solve(&loads)?.values;
        values.truncate(self.reals);
        Ok(values)
    }
}

/// The normal equations over `count` unknowns: the real ones, after them the whole ones, and more.
pub(super) fn normal_equations(
    parts: Parts<'_>,
    count: usize,
) -> Result<NormalEquations, IntegerGridError> {
    let mut equations = NormalEquations::new(count);
    for_each_square(parts, |weight, terms, wish| {
        equations.add(weight, terms.iter().copied(), wish);
        equations.check_size(MOST_ENTRIES)
    })?;
    Ok(equations)
}

/// The matrix of the same squares with other weights.
fn reweighed(
    matrix: &SymmetricMatrix,
    parts: Parts<'_>,
) -> Result<SymmetricMatrix, IntegerGridError> {
    // A column of it begins with the entry on the diagonal.
    let pattern = matrix.lower().pattern();
    let mut values = vec![0.0; pattern.entries()];
    let mut merged = Vec::new();
    for_each_square(parts, |weight, terms, _| {
        merge_terms(terms.iter().copied(), &mut merged);
        for (place, &(column, factor)) in merged.iter().enumerate() {
            let weighted = weight * factor;
            values[pattern.range(column as usize).start] += weighted * factor;
            for &(other, more) in &merged[..place] {
                let [row, column] = [column.max(other), column.min(other)];
                if let Some(entry) = pattern.find(row as usize, column as usize) {
                    values[entry] += weighted * more;
                }
            }
        }
        Ok::<(), Infallible>(())
    })
    .unwrap_or_else(|never| match never {});
    Ok(matrix.with_values(values)?)
}

/// The differences of coordinates along each halfedge, in its own triangle, for values of the real
/// unknowns and of the whole ones after them.
pub(super) fn differences(parts: Parts<'_>, values: &[f64]) -> PerCorner<DVec2> {
    let mut found = Vec::with_capacity(2 * parts.mesh.halfedge_count());
    let added = for_each_square(parts, |_, terms, _| {
        let sum = terms
            .iter()
            .map(|&(column, factor)| factor * values[column as usize]);
        found.push(sum.sum::<f64>());
        Ok::<(), Infallible>(())
    });
    match added {
        Ok(()) => PerCorner::from_fn(found.len() / 2, |h: HalfedgeId| {
            DVec2::new(found[2 * h.index()], found[2 * h.index() + 1])
        }),
    }
}

/// Their right-hand side alone.
pub(super) fn right_side(parts: Parts<'_>, count: usize) -> Vec<f64> {
    let mut loads = vec![0.0; count];
    let added = for_each_square(parts, |weight, terms, wish| {
        for &(column, factor) in terms {
            loads[column as usize] += weight * factor * wish;
        }
        Ok::<(), Infallible>(())
    });
    match added {
        Ok(()) => loads,
    }
}

/// Calls with weight, terms and wish of each square `weight (Σ factor unknown - wish)²` of the
/// energy.
fn for_each_square<E>(
    parts: Parts<'_>,
    mut call: impl FnMut(f64, &[(u32, f64)], f64) -> Result<(), E>,
) -> Result<(), E> {
    let Parts {
        mesh,
        unknowns,
        energy,
        ..
    } = parts;
    let first_whole = unknowns.reals as u32;
    let mut terms = Vec::new();
    for halfedge in mesh.halfedges() {
        for coordinate in 0..2 {
            terms.clear();
            for (corner, factor) in [(halfedge.next(), 1), (halfedge, -1)] {
                let (slot, sign) = unknowns.slot(mesh, corner, coordinate);
                match slot {
                    Slot::Real(column) => terms.push((column, (sign * factor) as f64)),
                    Slot::Whole(sum) => {
                        let whole = unknowns.sums[sum as usize].terms().iter();
                        terms.extend(whole.map(|&(column, more)| {
                            (first_whole + column, (sign * factor * more) as f64)
                        }));
                    }
                }
                for shift in &unknowns.jumps[corner].shifts {
                    let (which, sign) = turned(shift.turn, coordinate);
                    let column = first_whole + 2 * shift.chain + which as u32;
                    terms.push((column, (sign * factor) as f64));
                }
            }
            let wish = energy.wishes[halfedge][coordinate];
            call(energy.weights[halfedge], &terms, wish)?;
        }
    }
    Ok(())
}

/// Real unknowns as a mesh wants it, then the whole ones.
fn ordering(parts: Parts<'_>, pattern: &Pattern) -> Ordering {
    let unknowns = parts.unknowns;
    let (points, point_of) = unknowns.points(parts.positions);
    let order = Ordering::of_groups(pattern, &point_of, &points);
    let all = order.order().iter().copied();
    let wholes = unknowns.reals as u32..pattern.columns() as u32;
    Ordering::from_order(all.chain(wholes).collect())
        .unwrap_or_else(|| Ordering::natural(pattern.columns()))
}

#[cfg(test)]
mod tests {
    use graticule_fixtures::icosphere;

    use super::super::net::Draft;
    use super::super::{GridDensity, IntegerGridOptions};
    use super::*;
    use crate::field::{FieldOptions, cross_field};
    use crate::mesh::Surface;
    use crate::watch::Watch;

    #[test]
    fn a_reweighed_system_is_the_one_made_with_these_weights() {
        let sphere = icosphere(3);
        let sphere = Surface::from_triangles(sphere.positions, &sphere.triangles).unwrap();
        let field = cross_field(&sphere, &FieldOptions::default(), &Watch::new());
        let options = IntegerGridOptions {
            density: GridDensity::Quads(200),
            ..IntegerGridOptions::default()
        };
        let draft = Draft::of(sphere, &field.unwrap().field, &options, &Watch::new()).unwrap();
        let parts = draft.parts();
        let mut other = parts.energy.clone();
        for (number, weight) in other.weights.as_mut_slice().iter_mut().enumerate() {
            *weight *= 1.0 + (number % 5) as f64;
        }
        let changed = Parts {
            energy: &other,
            ..parts
        };
        let expected = NetSystem::new(changed).unwrap();
        let mut found = NetSystem::new(parts).unwrap();
        let off = |found: &NetSystem| {
            let [found, expected] = [found, &expected].map(|system| {
                let matrix = system.factor.matrix().lower().values();
                matrix.iter().chain(&system.loads)
            });
            let differences = found.zip(expected).map(|(a, b)| (a - b).abs());
            differences.fold(0.0, f64::max)
        };
        assert!(off(&found) > 0.1);
        found.reweigh(changed).unwrap();
        assert!(off(&found) < 1e-12, "{}", off(&found));
    }
}
