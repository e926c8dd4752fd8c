use crate::Hint;
use crate::geometry::GeometryError;
use crate::mesh::{EdgeId, VertexId};
use crate::periodic::GridMapError;
use crate::solve::SolveError;
use crate::watch::Stopped;

/// Why there is no integer grid map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IntegerGridError {
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
    /// A feature is not an edge of the surface.
    #[error("{edge} is to be aligned, but there are {edges} edges")]
    NoSuchEdge {
        /// The edge.
        edge: EdgeId,
        /// How many there are.
        edges: usize,
    },
    /// The sizing or the stretch is for another number of vertices.
    #[error("{given} sizes were given for {needed} vertices")]
    SizingCount {
        /// Sizes given.
        given: usize,
        /// Vertices.
        needed: usize,
    },
    /// The field is not a cross field on this surface.
    #[error(
        "a cross field with {needed} angles is needed, not one of symmetry {order} with {given}"
    )]
    Field {
        /// Directions at each point.
        order: u32,
        /// Its number of angles.
        given: usize,
        /// Vertices of the surface.
        needed: usize,
    },
    /// The turns round a vertex are not those of its index: the triangles there are too degenerate
    /// for their angles.
    #[error("the axes turn by {found} quarters round {vertex}, its index asks for {expected}")]
    Turns {
        /// The vertex.
        vertex: VertexId,
        /// Quarters found, modulo 4.
        found: u8,
        /// Quarters expected, modulo 4.
        expected: u8,
    },
    /// Whole numbers of the net are not determined by its energy.
    #[error("the energy of the net does not determine its {parameters} whole parameters")]
    Undetermined {
        /// Number of parameters.
        parameters: usize,
    },
    /// The whole numbers of the net depend on each other so much that the equations of its energy
    /// would not fit into memory.
    #[error("the equations of the net have more than {limit} entries")]
    TooEntangled {
        /// The most entries allowed.
        limit: usize,
    },
    /// The coordinates do not make a map.
    #[error(transparent)]
    Map(#[from] GridMapError),
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

impl Hint for IntegerGridError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::Option { name, range, .. } => Some(format!("give {name} a value in {range}")),
            Self::NoSuchEdge { edges, .. } => Some(format!(
                "edges are numbered from 0 to {}",
                edges.saturating_sub(1)
            )),
            Self::SizingCount { .. } => Some("give one size for each vertex".into()),
            Self::Field { .. } => Some("make the field for this surface, with symmetry 4".into()),
            Self::Turns { .. } | Self::Undetermined { .. } => Some(
                "repair the mesh first: 'graticule repair' removes triangles without area".into(),
            ),
            Self::TooEntangled { .. } => Some(
                "let lines follow fewer edges, let more singularities cancel, or simplify the mesh"
                    .into(),
            ),
            Self::Map(error) => error.hint(),
            Self::Geometry(error) => error.hint(),
            Self::Solve(error) => error.hint(),
            Self::Stopped(stopped) => stopped.hint(),
        }
    }
}
