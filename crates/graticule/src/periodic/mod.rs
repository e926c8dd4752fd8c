//! Maps of whole surfaces whose coordinates are the same on both sides of an edge up to quarter
//! turns and whole shifts, so that the lines with whole coordinates form a net without seams.

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
mod phase_graph;
mod refine;
mod report;
mod singular;
mod steps;
mod transition;
mod unroll;
mod untangle;

pub use energy::{EnergyKind, Phases, edge_energy, energy_weights, total_energy, turned_phases};
pub use error::GridMapError;
pub use grid_map::{GRID_EXTENT, GRID_STEPS, GridMap};
pub use integer::{
    GridDensity, IntegerGridError, IntegerGridMap, IntegerGridOptions, IntegerGridReport, NetPlan,
    integer_grid_map, poisson_net,
};
pub use minimize::{
    CoarseToFineOptions, DiffusionOptions, MinimizationReport, Minimizer, NewtonOptions,
};
pub use options::{ChartSize, ParameterizeOptions};
pub use parameterization::{Parameterization, parameterize};
pub use periodic_error::PeriodicError;
pub use report::{ParameterizationReport, RegularDistortion};
pub use singular::SingularElements;
pub use steps::{EdgeStep, EdgeSteps, edge_steps};
pub use transition::{QuarterTurn, Transition};
pub use unroll::{FaceKind, Layout, VertexFrames, angles_of_phases, edge_jump, face_kinds, layout};

#[cfg(test)]
mod tests;
