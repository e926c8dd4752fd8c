//! The conformal map without pins: the smallest eigenvector of the conformal energy.
//!
//! P. Mullen, Y. Tong, P. Alliez, M. Desbrun, *Spectral Conformal Parameterization*, 2008: among
//! all maps whose boundary has a given moment of inertia about its centre of mass, the one of least
//! conformal energy. Every boundary vertex counts, two pins do not. Departure from the
//! paper: a boundary vertex weighs half the lengths of its two boundary edges rather than 1, so
//! that the result does not depend on how densely the boundary is sampled.

use faer::c64;

use crate::mesh::{Element, VertexId};
use crate::solve::SolveError;
use crate::tolerance::{EIGENVECTOR, ROUNDING, THIN_AREA};
use crate::watch::Watch;

use super::conformal::{PinnedForm, PinnedSolution, Triangulation, largest};
use super::domain::Domain;
use super::energy::complex;
use super::flat_map::MapDraft;
use super::lanczos::{Krylov, Operator};
use super::natural::{farthest_pins, pinned_map};
use super::{FlatMap, FlattenError, Method, Patch};

/// The spectral conformal map of a patch: free boundary, no pins, holes free too.
///
/// It is rotated so that the patch's [default pins](super::Pins::Farthest) lie as they would in
/// [`natural_map`](super::natural_map), the first at the origin, the second on the positive u axis,
/// and scaled to the area of the patch. Flips are not excluded by theory; the result counts them.
///
/// Cost: one sparse complex factorisation as for the natural map, and some ten to thirty solves.
///
/// A patch so thin that the form has lost the digits of its eigenvectors is laid down with the two
/// pins, which a warning (`pins-for-thin-patch`) tells: the farther its ends are apart, the less
/// the maps differ.
///
/// # Errors
/// [`FlattenError::Solve`] where the factorisation fails or the iteration does not converge.
pub fn spectral_map(
    patch: &Patch,
    triangulation: Triangulation,
    watch: &Watch,
) -> Result<FlatMap, FlattenError> {
    let _stage = watch.stage("spectral conformal map");
    let pins = farthest_pins(patch, watch)?;
    let domain = Domain::conformal(patch, triangulation, watch)?;
    let solved = least_map(patch, &domain, pins.map(|(vertex, _)| vertex), watch);
    let PinnedSolution {
        positions,
        residual,
    } = match solved.map_err(|error| thin_patch_told(error, patch)) {
        Err(FlattenError::TooThin { area }) => {
            let message = format!(
                "the patch is too thin for the eigenvector, its area {area:.1e} of its squared \
                 extent: laid down with two pins instead"
            );
            watch.warn("pins-for-thin-patch", message);
            let places = pins.map(|(vertex, place)| (vertex, complex(place)));
            pinned_map(patch, &domain, places, watch)?
        }
        solved => solved?,
    };
    let intrinsic_flips = domain.intrinsic_flips(&positions);
    let draft = MapDraft {
        positions,
        method: Method::SpectralConformal,
        residual,
        flip_free_in_theory: false,
        intrinsic_flips,
    };
    draft.scaled_to_patch(patch)?.finish(patch, watch)
}

/// The eigenvector, turned so that the pins lie as those of the natural map.
fn least_map(
    patch: &Patch,
    domain: &Domain,
    pins: [VertexId; 2],
    watch: &Watch,
) -> Result<PinnedSolution, FlattenError> {
    let inverse = InverseForm::new(patch, domain, pins, watch)?;
    let eigenvector = {
        let _stage = watch.stage("eigenvector");
        Krylov::from(inverse.start()).largest_eigenvector(&inverse, EIGENVECTOR)?
    };
    let (mut positions, residual) = inverse.refined(&eigenvector)?;
    turn_upright(&mut positions, pins);
    Ok(PinnedSolution {
        positions,
        residual,
    })
}

/// Names thinness as the reason where it is.
pub(super) fn thin_patch_told(error: FlattenError, patch: &Patch) -> FlattenError {
    let area = patch.unit_area();
    let lost = matches!(
        error,
        FlattenError::Undetermined { .. }
            | FlattenError::Solve(SolveError::NotPositiveDefinite { .. })
    );
    if lost && area < THIN_AREA {
        FlattenError::TooThin { area }
    } else {
        error
    }
}

/// Takes the first pin to the origin and the second to the positive real axis.
fn turn_upright(positions: &mut [c64], pins: [VertexId; 2]) {
    let [from, to] = pins.map(|pin| positions[pin.index()]);
    let across = to - from;
    let length = across.norm();
    let turn = if length > 0.0 {
        across.conj() / length
    } else {
        c64::ONE
    };
    for position in positions {
        *position = (*position - from) * turn;
    }
}

/// The inverse of the conformal form, on boundary values with their centre of mass at the origin.
///
/// With the pins `p` and `q` eliminated and `w` the natural map that takes them to 0 and 1, the
/// solution of `H x = b` that vanishes in `p` is `x = t + w (wᴴ b) / s`, where `t` vanishes in `q`
/// too and `s = wᴴ H w`. On a surface that can be flattened without distortion `s` is 0, and up to
/// scale `w` is the answer: `s` is kept just above 0, and inverse iteration finds `w`.
struct InverseForm<'a> {
    system: PinnedForm,
    natural: Vec<c64>,
    energy: f64,
    boundary: Vec<(usize, f64)>,
    watch: &'a Watch,
}

impl<'a> InverseForm<'a> {
    fn new(
        patch: &Patch,
        domain: &Domain,
        pins: [VertexId; 2],
        watch: &'a Watch,
    ) -> Result<Self, FlattenError> {
        let system = PinnedForm::new(domain, pins, watch)?;
        let nothing = vec![c64::ZERO; patch.mesh().vertex_count()];
        let natural = system
            .solve(&nothing, [c64::ZERO, c64::ONE], watch)?
            .positions;
        // A sum of squares keeps its digits where the form would lose them.
        let energy = 2.0 * domain.energy(&natural).conformal;
        Ok(Self {
            energy: energy.max(ROUNDING * ROUNDING * system.norm()),
            boundary: boundary_masses(patch),
            system,
            natural,
            watch,
        })
    }

    /// The natural map's boundary: nearly the answer already.
    fn start(&self) -> Vec<c64> {
        self.restricted(&self.natural)
    }

    /// The values on the boundary, the centre of mass taken off.
    fn restricted(&self, values: &[c64]) -> Vec<c64> {
        let on_boundary = self.boundary.iter();
        let mut values: Vec<_> = on_boundary.map(|&(vertex, _)| values[vertex]).collect();
        let mut moment = c64::ZERO;
        let mut total = 0.0;
        for (value, (_, mass)) in values.iter().zip(&self.boundary) {
            moment += value * mass;
            total += mass;
        }
        for value in &mut values {
            *value -= moment / total;
        }
        values
    }

    /// What stands on the right for these boundary values: masses times values.
    fn right_side(&self, boundary_values: &[c64]) -> Vec<c64> {
        let mut right_side = vec![c64::ZERO; self.natural.len()];
        for (value, &(vertex, mass)) in boundary_values.iter().zip(&self.boundary) {
            right_side[vertex] = value * mass;
        }
        right_side
    }

    /// The solution that vanishes in the first pin, from the one that vanishes in both.
    fn completed(&self, mut pinned: Vec<c64>, right_side: &[c64]) -> Vec<c64> {
        let share = inner(&self.natural, right_side) / self.energy;
        for (value, natural) in pinned.iter_mut().zip(&self.natural) {
            *value += natural * share;
        }
        pinned
    }

    /// The whole map that belongs to an eigenvector, of about unit size, and the relative residual
    /// of `H z = λ M z`.
    fn refined(&self, boundary_values: &[c64]) -> Result<(Vec<c64>, f64), FlattenError> {
        let right_side = self.right_side(boundary_values);
        let pinned = self.system.solve(&right_side, [c64::ZERO; 2], self.watch)?;
        let mut map = self.completed(pinned.positions, &right_side);
        let size = largest(&map);
        for value in &mut map {
            *value /= size;
        }
        let centred = self.restricted(&map);
        let mut residual = self.system.form().apply(&map);
        let eigenvalue = inner(&map, &residual).re / self.inner(&centred, &centred).re;
        for (value, &(vertex, mass)) in centred.iter().zip(&self.boundary) {
            residual[vertex] -= value * (mass * eigenvalue);
        }
        Ok((map, largest(&residual) / self.system.norm()))
    }
}

impl Operator for InverseForm<'_> {
    type Error = FlattenError;

    fn apply(&self, values: &[c64]) -> Result<Vec<c64>, FlattenError> {
        self.watch.check()?;
        let right_side = self.right_side(values);
        let pinned = self.system.solve_once(&right_side)?;
        Ok(self.restricted(&self.completed(pinned, &right_side)))
    }

    fn inner(&self, a: &[c64], b: &[c64]) -> c64 {
        let terms = a.iter().zip(b).zip(&self.boundary);
        terms.map(|((a, b), (_, mass))| a.conj() * b * mass).sum()
    }

    fn not_converged(&self, iterations: usize, residual: f64) -> FlattenError {
        FlattenError::Solve(SolveError::NotConverged {
            iterations,
            residual,
            tolerance: EIGENVECTOR,
        })
    }
}

/// Each boundary vertex with half the lengths of its boundary edges.
fn boundary_masses(patch: &Patch) -> Vec<(usize, f64)> {
    let mut masses = Vec::new();
    for boundary_loop in patch.mesh().boundary_loops() {
        let steps: Vec<f64> = patch.unit_steps(boundary_loop).collect();
        for (place, vertex) in patch.loop_vertices(boundary_loop).enumerate() {
            let before = steps[(place + steps.len() - 1) % steps.len()];
            masses.push((vertex.index(), f64::midpoint(before, steps[place])));
        }
    }
    masses
}

fn inner(a: &[c64], b: &[c64]) -> c64 {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}
