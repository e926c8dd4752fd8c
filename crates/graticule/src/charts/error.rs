use super::ChartId;
use crate::Hint;
use crate::field::FieldError;
use crate::flatten::{BoundaryError, FlattenError};
use crate::mesh::{FaceId, MeshError, VertexId};
use crate::periodic::{GridMapError, IntegerGridError, PeriodicError};
use crate::quads::QuadsError;
use crate::watch::Stopped;

/// Why there is no layout of charts.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LayoutError {
    /// An array has another size than the mesh.
    #[error("{what}: {given} values were given, {needed} are needed")]
    Count {
        /// Which array.
        what: &'static str,
        /// Its size.
        given: usize,
        /// The size needed.
        needed: usize,
    },
    /// An arc ends inside a chart.
    #[error("an arc ends inside a chart, at vertex {}", vertex.0)]
    DanglingArc {
        /// Where it ends, in the refined surface.
        vertex: VertexId,
    },
    /// A chart is no disk.
    #[error("{chart}, which holds triangle {}, is no disk: {rule}", face.0)]
    NoDisk {
        /// The chart.
        chart: ChartId,
        /// One of its triangles, in the refined surface.
        face: FaceId,
        /// Which rule is broken.
        rule: &'static str,
    },
    /// Nodes less arcs plus charts is not what it is for the surface.
    #[error("nodes - arcs + charts is {found}, for the surface it is {expected}")]
    EulerCharacteristic {
        /// For the layout.
        found: i64,
        /// For the surface.
        expected: i64,
    },
    /// The map is for another mesh.
    #[error("the map has coordinates for {given} corners, the mesh has {needed}")]
    OtherMesh {
        /// Corners of the map.
        given: usize,
        /// Corners of the mesh.
        needed: usize,
    },
    /// The refined surface does not cover the input once.
    #[error("refined triangles miss the area of the input by a share of {share:e}")]
    Area {
        /// The differences in all triangles of the input, as a share of its area.
        share: f64,
    },
    /// There is no field.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// There are no periodic coordinates.
    #[error(transparent)]
    Periodic(#[from] PeriodicError),
    /// There is no integer grid map.
    #[error(transparent)]
    Integer(#[from] IntegerGridError),
    /// The coordinates are no map.
    #[error(transparent)]
    Map(#[from] GridMapError),
    /// The lines could not be traced.
    #[error(transparent)]
    Lines(#[from] QuadsError),
    /// The refined triangles are no surface.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl LayoutError {
    /// Whether another map would do no better: the computation was stopped, or an option is wrong.
    pub(super) fn is_final(&self) -> bool {
        match self {
            Self::Stopped(_) | Self::Lines(QuadsError::Stopped(_) | QuadsError::TooFine { .. }) => {
                true
            }
            Self::Periodic(error) => {
                !matches!(error, PeriodicError::Geometry(_) | PeriodicError::Solve(_))
            }
            Self::Integer(error) => matches!(
                error,
                IntegerGridError::Stopped(_)
                    | IntegerGridError::Option { .. }
                    | IntegerGridError::NoSuchEdge { .. }
                    | IntegerGridError::Field { .. }
            ),
            _ => false,
        }
    }
}

impl Hint for LayoutError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::NoDisk { .. } | Self::DanglingArc { .. } => {
                Some("ask for smaller charts, or repair the mesh first".into())
            }
            Self::Field(error) => error.hint(),
            Self::Periodic(error) => error.hint(),
            Self::Integer(error) => error.hint(),
            Self::Map(error) => error.hint(),
            Self::Lines(error) => error.hint(),
            Self::Mesh(error) => error.hint(),
            Self::Stopped(stopped) => stopped.hint(),
            Self::Count { .. }
            | Self::EulerCharacteristic { .. }
            | Self::Area { .. }
            | Self::OtherMesh { .. } => None,
        }
    }
}

/// Why charts could not be laid down.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ChartMapError {
    /// The layout was made from another surface.
    #[error("the layout was not made from this surface: its triangles do not lie on it")]
    OtherInput,
    /// The arcs round a chart are not its border.
    #[error("the arcs of {chart} are not its border")]
    Border {
        /// The chart.
        chart: ChartId,
    },
    /// The border of a chart was not laid down as a polygon.
    #[error("{chart}: {reason}")]
    Polygon {
        /// The chart.
        chart: ChartId,
        /// What is wrong with it.
        reason: BoundaryError,
    },
    /// A chart could not be laid onto its polygon.
    #[error("{chart}: {reason}")]
    Chart {
        /// The chart.
        chart: ChartId,
        /// What is in the way.
        reason: FlattenError,
    },
    /// The squares put together are no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl ChartMapError {
    pub(super) fn of_chart(chart: ChartId, reason: FlattenError) -> Self {
        match reason {
            FlattenError::Stopped(stopped) => Self::Stopped(stopped),
            reason => Self::Chart { chart, reason },
        }
    }
}

impl Hint for ChartMapError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::OtherInput => Some("give the surface that the layout was made from".into()),
            Self::Border { .. } | Self::Polygon { .. } | Self::Mesh(_) => None,
            Self::Chart { reason, .. } => reason.hint(),
            Self::Stopped(stopped) => stopped.hint(),
        }
    }
}

/// Why squares could not be packed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ChartAtlasError {
    /// The padding leaves no texel for the squares.
    #[error("a square of {texels:.1} texels has no room for a padding of {padding}")]
    Padding {
        /// Texels along a side of the smallest squares.
        texels: f64,
        /// Texels between squares.
        padding: u32,
    },
    /// A number of texels, of tiles or a density that is none.
    #[error("{what} is {value}; it must be above 0 and finite")]
    BadNumber {
        /// What it is.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl Hint for ChartAtlasError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::Padding { .. } => {
                Some("ask for a larger resolution, more tiles, or less padding".into())
            }
            Self::BadNumber { .. } => None,
            Self::Stopped(stopped) => stopped.hint(),
        }
    }
}
