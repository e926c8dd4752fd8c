use crate::Hint;
use crate::geometry::GeometryError;
use crate::mesh::VertexId;
use crate::solve::SolveError;
use crate::watch::Stopped;

/// Why there are no periodic coordinates.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PeriodicError {
    /// An option is outside its range.
    #[error("{name} is {value}, outside {range}")]
    Option {
        /// Name of the option.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// The field or its scale is for another number of vertices.
    #[error("{what} has {given} values, but there are {vertices} vertices")]
    VertexCount {
        /// "the field" or "the scale".
        what: &'static str,
        /// Its length.
        given: usize,
        /// The number of vertices.
        vertices: usize,
    },
    /// A feature edge that the surface does not have.
    #[error("feature edge {edge} does not exist: there are {count} edges")]
    NoSuchEdge {
        /// The edge.
        edge: u32,
        /// How many there are.
        count: usize,
    },
    /// The field's scale is not a positive number.
    #[error("the scale of the field at {vertex} is {value}")]
    Scale {
        /// The vertex.
        vertex: VertexId,
        /// The scale there.
        value: f64,
    },
    /// Charts so small that an edge crosses more of them than coordinates can count.
    #[error("an edge is {charts:e} charts long, more than coordinates can count ({limit:e})")]
    ChartsTooSmall {
        /// The longest edge in charts.
        charts: f64,
        /// The most allowed.
        limit: f64,
    },
    /// A geometric quantity could not be had.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A linear system could not be solved.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl Hint for PeriodicError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::Option { name, range, .. } => Some(format!("give {name} a value in {range}")),
            Self::VertexCount { .. } => Some("compute the field on this very surface".into()),
            Self::NoSuchEdge { count, .. } => Some(format!(
                "edges are numbered from 0 to {}",
                count.saturating_sub(1)
            )),
            Self::Scale { .. } => Some("give every vertex a scale above 0".into()),
            Self::ChartsTooSmall { .. } => Some("choose larger charts".into()),
            Self::Geometry(error) => error.hint(),
            Self::Solve(error) => error.hint(),
            Self::Stopped(stopped) => stopped.hint(),
        }
    }
}
