//! The equations of maps with a given boundary: which weights each neighbour has, and the system
//! that they make.

use crate::geometry::{
    DirectedWeights, EdgeWeights, intrinsic_weights, mean_value_weights, uniform_weights,
};
use crate::mesh::{Element, VertexId};
use crate::solve::{
    DirichletLu, DirichletSystem, Exchange, Placement, Solution, SolveError, SparseMatrix,
    SymmetricMatrix,
};
use crate::watch::Watch;

use super::domain::Domain;
use super::{FlattenError, Method};

/// A mix `λ E_A + μ E_χ` of the two intrinsic energies ([DMA02] §3.4), up to a common factor.
///
/// The conformal energy has the coefficients `cot α + cot β` of Eq. 4, the authalic one those of
/// Eq. 6 times the mean square of the edge lengths ([`intrinsic_weights`]): both are numbers, and
/// λ : μ means the same in every unit of length.
///
/// [DMA02]: crate::papers::DMA02
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    lambda: f64,
    mu: f64,
}

impl Mix {
    /// The conformal energy alone.
    pub const CONFORMAL: Self = Self {
        lambda: 1.0,
        mu: 0.0,
    };
    /// The authalic energy alone.
    pub const AUTHALIC: Self = Self {
        lambda: 0.0,
        mu: 1.0,
    };

    /// The mix with these factors of the conformal and of the authalic energy. They may be
    /// negative, as the paper allows; then there is mostly nothing that the map minimises.
    ///
    /// # Errors
    /// [`FlattenError::BadMix`] if one is not finite or both are zero.
    pub fn new(lambda: f64, mu: f64) -> Result<Self, FlattenError> {
        let largest = lambda.abs().max(mu.abs());
        if !(lambda.is_finite() && mu.is_finite() && largest > 0.0) {
            return Err(FlattenError::BadMix { lambda, mu });
        }
        // Only the ratio matters; at this size nothing overflows.
        Ok(Self {
            lambda: lambda / largest,
            mu: mu / largest,
        })
    }

    /// λ, over the larger of |λ| and |μ|.
    #[must_use]
    pub fn lambda(self) -> f64 {
        self.lambda
    }

    /// μ, over the larger of |λ| and |μ|.
    #[must_use]
    pub fn mu(self) -> f64 {
        self.mu
    }
}

/// How much each neighbour counts in the mean that a vertex is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Weights {
    /// The discrete conformal map ([DMA02] Eq. 4), on the patch's own triangles. Weights opposite
    /// to obtuse angles may be negative; then triangles may flip.
    ///
    /// [DMA02]: crate::papers::DMA02
    #[default]
    Cotangent,
    /// The discrete conformal map on the intrinsic Delaunay triangulation of the same surface. No
    /// weight inside is negative: on a circle none of *its* triangles flips, except that what lies
    /// between two of its edges with the same ends (the tip of a thin spike) collapses onto them.
    /// Triangles of the patch that it does not share may flip, and on the straight side of a
    /// rectangle some of its own may collapse.
    DelaunayCotangent,
    /// A mix of the conformal and the authalic energy ([DMA02] §3.4); [`Mix::AUTHALIC`] is the
    /// discrete authalic map of Eq. 6. Weights may be negative; then triangles may flip.
    ///
    /// [DMA02]: crate::papers::DMA02
    Intrinsic(Mix),
    /// Mean value weights (M. Floater, *Mean value coordinates*, 2003): all positive, and a flat
    /// patch is its own map.
    MeanValue,
    /// The same weight for all neighbours (W. T. Tutte, *How to draw a graph*, 1963): knows nothing
    /// of shapes.
    Uniform,
}

impl Weights {
    pub(super) fn method(self) -> Method {
        match self {
            Self::Cotangent => Method::FixedConformal,
            Self::DelaunayCotangent => Method::FixedConformalDelaunay,
            Self::Intrinsic(mix) if mix.mu == 0.0 => Method::FixedConformal,
            Self::Intrinsic(mix) if mix.lambda == 0.0 => Method::FixedAuthalic,
            Self::Intrinsic(_) => Method::FixedMix,
            Self::MeanValue => Method::FixedMeanValue,
            Self::Uniform => Method::FixedUniform,
        }
    }
}

/// For each vertex: the sum over its neighbours of weights times differences is zero.
pub(super) enum Equations {
    Symmetric(EdgeWeights),
    Directed(DirectedWeights),
}

impl Equations {
    pub(super) fn new(
        domain: &mut Domain,
        weights: Weights,
        watch: &Watch,
    ) -> Result<Self, FlattenError> {
        let _stage = watch.stage("weights");
        match weights {
            Weights::Uniform => return Ok(Self::Symmetric(uniform_weights(&domain.mesh))),
            Weights::DelaunayCotangent => domain.make_delaunay(watch)?,
            Weights::Cotangent | Weights::Intrinsic(_) | Weights::MeanValue => {
                domain.mollify(watch);
            }
        }
        Ok(match weights {
            Weights::MeanValue => Self::Directed(mean_value_weights(&domain.triangulation())?),
            Weights::Intrinsic(mix) if mix.mu != 0.0 => {
                let triangulation = domain.triangulation();
                Self::Directed(intrinsic_weights(&triangulation, mix.lambda, mix.mu)?)
            }
            _ => Self::Symmetric(domain.cotangent_weights()?),
        })
    }

    /// Whether every weight in the equation of a free vertex is above 0.
    pub(super) fn are_positive(&self, fixed: &[VertexId]) -> bool {
        let is_fixed = |vertex: &VertexId| fixed.binary_search(vertex).is_ok();
        match self {
            Self::Symmetric(edges) => {
                let mut pairs = edges.ends.iter().zip(&edges.weights);
                pairs.all(|(ends, &weight)| weight > 0.0 || ends.iter().all(is_fixed))
            }
            Self::Directed(rows) => {
                let mut vertices = (0..rows.vertex_count()).map(VertexId::from_index);
                vertices.all(|v| is_fixed(&v) || rows.weights(v).iter().all(|&w| w > 0.0))
            }
        }
    }

    pub(super) fn factor(&self, fixed: &[VertexId], domain: &Domain) -> Result<Factor, SolveError> {
        let placement = Placement::at(&domain.coordinates);
        let fixed: Vec<usize> = fixed.iter().map(|vertex| vertex.index()).collect();
        let order = domain.mesh.vertex_count();
        match self {
            Self::Symmetric(edges) => {
                let matrix = SymmetricMatrix::laplacian(order, index_pairs(edges))?;
                let system = DirichletSystem::new(&matrix, &fixed, placement)?;
                Ok(Factor::Symmetric(Box::new(system)))
            }
            Self::Directed(rows) => {
                let matrix = SparseMatrix::from_triplets(order, order, laplacian(rows))?;
                let system = DirichletLu::new(&matrix, &fixed, placement)?;
                Ok(Factor::General(Box::new(system)))
            }
        }
    }

    /// The entries of the matrix `L` with `(L u)ᵢ = Σⱼ wᵢⱼ (uᵢ - uⱼ)`, some of them in several
    /// terms.
    pub(super) fn entries(&self) -> Vec<(usize, usize, f64)> {
        match self {
            Self::Symmetric(edges) => {
                let entries = index_pairs(edges).flat_map(|([i, j], weight)| {
                    [
                        (i, i, weight),
                        (j, j, weight),
                        (i, j, -weight),
                        (j, i, -weight),
                    ]
                });
                entries.collect()
            }
            Self::Directed(rows) => laplacian(rows).collect(),
        }
    }

    pub(super) fn is_symmetric(&self) -> bool {
        matches!(self, Self::Symmetric(_))
    }
}

/// The weight of each edge with the indices of its ends.
pub(super) fn index_pairs(edges: &EdgeWeights) -> impl Iterator<Item = ([usize; 2], f64)> + '_ {
    let pairs = edges.ends.iter().zip(&edges.weights);
    pairs.map(|(ends, &weight)| (ends.map(Element::index), weight))
}

/// The entries of the matrix `L` with `(L u)ᵢ = Σⱼ wᵢⱼ (uᵢ - uⱼ)`.
fn laplacian(rows: &DirectedWeights) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
    let vertices = (0..rows.vertex_count()).map(VertexId::from_index);
    vertices.flat_map(move |i| {
        let row = rows.neighbors(i).iter().zip(rows.weights(i));
        row.flat_map(move |(j, &weight)| {
            [
                (i.index(), i.index(), weight),
                (i.index(), j.index(), -weight),
            ]
        })
    })
}

/// The factored equations of the vertices that are not fixed.
#[derive(Debug)]
pub(super) enum Factor {
    Symmetric(Box<DirichletSystem>),
    General(Box<DirichletLu>),
}

impl Factor {
    pub(super) fn warn_of_exchange(&self, watch: &Watch) {
        if let Self::General(system) = self
            && system.factor().exchange() == Exchange::Unrestricted
        {
            let message = "the equations have no good pivots near the diagonal: factored with \
                           exchanges over the whole matrix, which takes more time and memory";
            watch.warn("unrestricted-pivoting", message);
        }
    }

    /// The values of all vertices for one or several columns of values of the fixed ones.
    pub(super) fn solve(&self, fixed_values: &[f64]) -> Result<Solution, SolveError> {
        match self {
            Self::Symmetric(system) => system.solve(fixed_values),
            Self::General(system) => system.solve(fixed_values),
        }
    }

    /// Gradients by the values of the fixed vertices, from those by the values of all.
    pub(super) fn pull_back(&self, gradients: &[f64]) -> Result<Solution, SolveError> {
        match self {
            Self::Symmetric(system) => system.pull_back(gradients),
            Self::General(system) => system.pull_back(gradients),
        }
    }
}
