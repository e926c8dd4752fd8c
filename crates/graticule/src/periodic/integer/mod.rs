//! Maps of whole surfaces, no triangle left out, whose net of whole lines has its irregular points
//! at the singularities of a cross field: integer grid maps, from which pure quads come
//! (F. Kälberer, M. Nieser, K. Polthier, *Surface Parameterization using Branched Coverings*, 2007; D. Bommes, H. Zimmer, L. Kobbelt,
//! *Mixed-Integer Quadrangulation*, 2009).
//!
//! The steps for each component, a file each: axes per triangle with singular vertices, a cut along which coordinates
//! jump, lines to be followed, the unknowns with their whole equations, the energy, weights for
//! squeezed triangles, rounding, and the removal of flips.

mod alignment;
mod batches;
mod components;
mod cut;
mod descent;
mod energy;
mod error;
mod form;
mod frames;
mod guard;
mod lattice;
mod net;
mod options;
mod poisson;
mod report;
mod rounding;
mod separation;
mod sizing;
mod solver;
mod stage;
mod stiffening;
mod system;
mod unknowns;
mod untangle;

pub use error::IntegerGridError;
pub(crate) use options::check_sizes;
pub use options::{GridDensity, IntegerGridOptions, Stretch};
pub use poisson::{NetPlan, poisson_net};
pub use report::IntegerGridReport;
pub use stage::{IntegerGrid, IntegerGridMap, integer_grid_map};

#[cfg(test)]
mod tests;
