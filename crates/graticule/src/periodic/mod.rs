//! Periodic global parameterization ([`PGP06`] §§2, 3.1, 3.2): coordinates of whole surfaces that are
//! the same on both sides of an edge up to quarter turns and whole shifts, so that the lines with
//! whole coordinates form a net without seams.
//!
//! [`parameterize()`] does it all, in the paper's order:
//!
//! 1. [`edge_steps`]: what a cross field asks of the coordinates along each edge;
//! 2. [`energy_weights`], [`total_energy`]: how far sines and cosines are from that;
//! 3. [`Minimizer`]: the least energy;
//! 4. [`VertexFrames`]: the whole numbers along each edge, and with them real coordinates, solved for
//!    once more and untangled;
//! 5. [`SingularElements`]: where the triangles do not fit together;
//! 6. [`GridMap`]: the coordinates as exact numbers, for what follows.
//!
//! [`PGP06`]: crate::papers::PGP06
//!
//! ```
//! use graticule::field::{FieldOptions, cross_field};
//! use graticule::mesh::Surface;
//! use graticule::periodic::{ParameterizeOptions, parameterize};
//! use graticule::watch::Watch;
//!
//! let sphere = graticule_fixtures::icosphere(3);
//! let surface = Surface::from_triangles(sphere.positions, &sphere.triangles)?;
//! let watch = Watch::new();
//! let field = cross_field(&surface, &FieldOptions::default(), &watch)?;
//! let options = ParameterizeOptions::default();
//! let map = parameterize(&surface, &field.field, None, &options, &watch)?;
//! assert_eq!(map.singular.field_faces.len(), field.singularities.count());
//! let grid = map.grid_map(surface.mesh())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod alignment;
mod diffusion;
mod energy;
mod error;
mod grid_map;
mod ground;
mod hierarchy;
mod integer;
mod minimize;
mod newton;
mod options;
mod parameterization;
mod periodic_error;
mod refine;
mod report;
mod singular;
mod sizing;
mod steps;
mod tension;
mod transition;
mod unroll;
mod untangle;

use crate::field::phase_graph;

pub use energy::{EnergyKind, Phases, edge_energy, energy_weights, total_energy, turned_phases};
pub use error::GridMapError;
pub use grid_map::{GRID_EXTENT, GRID_STEPS, GridMap};
pub(crate) use integer::check_sizes;
pub use integer::{
    GridDensity, IntegerGrid, IntegerGridError, IntegerGridMap, IntegerGridOptions,
    IntegerGridReport, NetPlan, Stretch, integer_grid_map, poisson_net,
};
pub use minimize::{
    CoarseToFineOptions, DiffusionOptions, MinimizationReport, Minimizer, NewtonOptions,
};
pub use options::{ChartSize, EnergyTriangles, ParameterizeOptions};
pub use parameterization::{Parameterization, parameterize};
pub use periodic_error::PeriodicError;
pub use report::{ParameterizationReport, RegularDistortion};
pub use singular::SingularElements;
pub use sizing::{CurvatureSizing, curvature_density};
pub use steps::{EdgeStep, EdgeSteps, edge_steps};
pub use tension::PhaseTension;
pub use transition::{QuarterTurn, Transition};
pub use unroll::{FaceKind, Layout, VertexFrames, angles_of_phases, edge_jump, face_kinds, layout};

#[cfg(test)]
mod tests;
