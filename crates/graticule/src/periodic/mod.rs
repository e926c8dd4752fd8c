//! Maps of whole surfaces whose coordinates are the same on both sides of an edge up to quarter
//! turns and whole shifts, so that the lines with whole coordinates form a net without seams.

mod error;
mod grid_map;
mod integer;
mod transition;

pub use error::GridMapError;
pub use grid_map::{GRID_EXTENT, GRID_STEPS, GridMap};
pub use integer::{
    GridDensity, IntegerGridError, IntegerGridMap, IntegerGridOptions, IntegerGridReport, NetPlan,
    integer_grid_map, poisson_net,
};
pub use transition::{QuarterTurn, Transition};
