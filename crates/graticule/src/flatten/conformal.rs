//! The conformal energy as a Hermitian form, factored with two vertices pinned.

use faer::c64;

use crate::geometry::EdgeWeights;
use crate::mesh::{Element, HalfedgeId, VertexId};
use crate::solve::{HermitianCholesky, HermitianMatrix, Placement};
use crate::tolerance::{DETERMINED, REFINED, REFINEMENT_GAIN};
use crate::watch::Watch;

use super::FlattenError;
use super::domain::Domain;

/// Corrections after which refinement has nothing more to gain.
const MOST_REFINEMENTS: usize = 4;

/// Planar positions as complex numbers `z`: the conformal energy is `½ zᴴ H z` with `H = L + iS`,
/// `L` the cotangent Laplacian and `-½ zᴴ (iS) z` the area of the map, which depends on the boundary
/// alone. `H z = 0` is [DMA02] Eq. 7, row by row.
///
/// [DMA02]: crate::papers::DMA02
pub(super) struct ConformalForm {
    weights: EdgeWeights,
    /// Boundary edges, directed with the surface to their left.
    boundary: Vec<[VertexId; 2]>,
}

impl ConformalForm {
    pub(super) fn of(domain: &Domain) -> Result<Self, FlattenError> {
        let mesh = &domain.mesh;
        let is_boundary = |&halfedge: &HalfedgeId| mesh.twin(halfedge).is_none();
        let boundary = mesh.halfedges().filter(is_boundary);
        Ok(Self {
            weights: domain.cotangent_weights()?,
            boundary: boundary.map(|halfedge| mesh.ends(halfedge)).collect(),
        })
    }

    fn matrix(&self) -> Result<HermitianMatrix, FlattenError> {
        let pairs = self.weights.ends.iter().zip(&self.weights.weights);
        let edges = pairs.map(|(ends, &weight)| (ends.map(Element::index), weight));
        let edges: Vec<_> = edges.collect();
        let couplings = self.boundary.iter();
        let couplings = couplings.map(|[a, b]| (a.index(), b.index(), 0.5));
        let order = self.weights.vertex_count();
        Ok(HermitianMatrix::laplacian(order, &edges, couplings)?)
    }

    /// Largest violation of the equations of all vertices but the pins, relative to the norm of the
    /// matrix times the size of the map.
    pub(super) fn residual(&self, z: &[c64], pins: [VertexId; 2]) -> Result<f64, FlattenError> {
        let mut violations = self.apply(z);
        for pin in pins {
            violations[pin.index()] = c64::ZERO;
        }
        Ok(largest(&violations) / (self.matrix()?.row_sum_norm() * largest(z)))
    }

    /// `H z`, from differences of positions: a rounding error is relative to the length of the
    /// edges and not to the size of the map, so that refinement gains digits.
    pub(super) fn apply(&self, z: &[c64]) -> Vec<c64> {
        let mut result = vec![c64::new(0.0, 0.0); z.len()];
        for (ends, &weight) in self.weights.ends.iter().zip(&self.weights.weights) {
            let [a, b] = ends.map(Element::index);
            let flow = (z[a] - z[b]) * weight;
            result[a] += flow;
            result[b] -= flow;
        }
        for ends in &self.boundary {
            let [a, b] = ends.map(Element::index);
            // Each vertex has a boundary edge before and one after it: what is taken off z cancels.
            let quarter_turned = (z[b] - z[a]) * c64::new(0.0, 0.5);
            result[a] += quarter_turned;
            result[b] += quarter_turned;
        }
        result
    }
}

/// The conformal form with two vertices pinned, factored: positive definite, unless a conformal
/// map takes both pins to one point.
pub(super) struct PinnedForm {
    form: ConformalForm,
    norm: f64,
    factor: HermitianCholesky,
    pins: [usize; 2],
}

/// Whether edges may be replaced by other shortest lines before weights are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Triangulation {
    /// The triangles of the patch, as in the paper.
    #[default]
    Given,
    /// The intrinsic Delaunay triangulation of the same surface
    /// ([`intrinsic_delaunay`](crate::geometry::intrinsic_delaunay)): less sensitive to thin
    /// triangles. The map then is linear on its triangles; between the same vertices the triangles
    /// of the patch are laid down straight.
    IntrinsicDelaunay,
}

/// Positions that fulfil the equations of all vertices but the pins.
pub(super) struct PinnedSolution {
    pub(super) positions: Vec<c64>,
    /// Largest violation relative to the norm of the matrix times the size of the map, plus that
    /// of the right-hand side.
    pub(super) residual: f64,
}

impl PinnedForm {
    pub(super) fn new(
        domain: &Domain,
        pins: [VertexId; 2],
        watch: &Watch,
    ) -> Result<Self, FlattenError> {
        let pins = pins.map(Element::index);
        let stage = watch.stage("assemble");
        let form = ConformalForm::of(domain)?;
        let matrix = form.matrix()?.decoupled(&pins);
        drop(stage);
        watch.check()?;
        let stage = watch.stage("order");
        let placement = Placement::at(&domain.coordinates);
        let ordering = placement.ordering(matrix.pattern())?;
        drop(stage);
        watch.check()?;
        let _stage = watch.stage("factor");
        Ok(Self {
            norm: matrix.row_sum_norm(),
            factor: HermitianCholesky::new(&matrix, &ordering)?,
            form,
            pins,
        })
    }

    pub(super) fn form(&self) -> &ConformalForm {
        &self.form
    }

    /// Largest row sum of the matrix.
    pub(super) fn norm(&self) -> f64 {
        self.norm
    }

    /// Solves `H z = right_side` except at the pins, which get the places given.
    ///
    /// Every round computes what is missing and solves for the correction; the first round is the
    /// solution, the others refine it.
    pub(super) fn solve(
        &self,
        right_side: &[c64],
        places: [c64; 2],
        watch: &Watch,
    ) -> Result<PinnedSolution, FlattenError> {
        let _stage = watch.stage("solve");
        let mut positions = vec![c64::new(0.0, 0.0); right_side.len()];
        for (&pin, place) in self.pins.iter().zip(places) {
            positions[pin] = place;
        }
        refined(&mut positions, watch, |positions| {
            Ok(self.factor.solve(&self.missing(right_side, positions))?)
        })?;
        let scale = self.norm * largest(&positions) + largest(right_side);
        let residual = largest(&self.missing(right_side, &positions)) / scale;
        Ok(PinnedSolution {
            positions,
            residual: if scale > 0.0 { residual } else { 0.0 },
        })
    }

    /// Solves `H z = right_side` with the pins at 0, without refinement.
    pub(super) fn solve_once(&self, right_side: &[c64]) -> Result<Vec<c64>, FlattenError> {
        let mut right_side = right_side.to_vec();
        for pin in self.pins {
            right_side[pin] = c64::ZERO;
        }
        Ok(self.factor.solve(&right_side)?)
    }

    /// `right_side - H z`, zero at the pins.
    fn missing(&self, right_side: &[c64], positions: &[c64]) -> Vec<c64> {
        let mut missing = self.form.apply(positions);
        for (missing, right_side) in missing.iter_mut().zip(right_side) {
            *missing = right_side - *missing;
        }
        for pin in self.pins {
            missing[pin] = c64::new(0.0, 0.0);
        }
        missing
    }
}

/// Adds to the positions the corrections that they ask for until the next one would no longer matter,
/// or they no longer shrink.
pub(super) fn refined(
    positions: &mut [c64],
    watch: &Watch,
    correction: impl Fn(&[c64]) -> Result<Vec<c64>, FlattenError>,
) -> Result<(), FlattenError> {
    let mut change = 1.0;
    for _ in 0..MOST_REFINEMENTS {
        watch.check()?;
        let correction = correction(positions)?;
        for (position, correction) in positions.iter_mut().zip(&correction) {
            *position += correction;
        }
        let last = change;
        change = largest(&correction) / largest(positions);
        // Corrections shrink at a steady rate.
        let next = change * change / last;
        if next <= REFINED || change.is_nan() || change > REFINEMENT_GAIN * last && last < 1.0 {
            break;
        }
    }
    if change <= DETERMINED {
        return Ok(());
    }
    Err(FlattenError::Undetermined {
        change: if change.is_nan() { 1.0 } else { change },
    })
}

/// The largest magnitude.
pub(super) fn largest(numbers: &[c64]) -> f64 {
    numbers
        .iter()
        .map(|number| number.norm())
        .fold(0.0, f64::max)
}
