use crate::Hint;
use crate::geometry::GeometryError;
use crate::mesh::FaceId;
use crate::solve::SolveError;
use crate::watch::Stopped;

/// Why there is no field.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FieldError {
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
    /// There is not one size for each vertex.
    #[error("there are {given} sizes for {needed} vertices")]
    SizeCount {
        /// How many there are.
        given: usize,
        /// How many there should be.
        needed: usize,
    },
    /// A guide is for an element that the surface does not have.
    #[error("guide {guide} is for {kind} {number}, but there are {count}")]
    NoSuchElement {
        /// The guide, counted from 0.
        guide: usize,
        /// "vertex", "face" or "edge".
        kind: &'static str,
        /// The element.
        number: u32,
        /// How many there are.
        count: usize,
    },
    /// A guide's direction is zero, not finite, or at a right angle to the surface; or its weight is
    /// no positive number.
    #[error("guide {guide} has {what}: {value}")]
    Guide {
        /// The guide, counted from 0.
        guide: usize,
        /// What is wrong with it.
        what: &'static str,
        /// The direction or the weight.
        value: String,
    },
    /// The indices of the singularities do not sum to the Euler characteristic: a triangle is too
    /// degenerate for its angles.
    #[error(
        "the indices of the field sum to {sum}, the Euler characteristic is {euler_characteristic}"
    )]
    IndexSum {
        /// The sum.
        sum: f64,
        /// What it should be.
        euler_characteristic: i64,
    },
    /// A stroke makes no sense.
    #[error("stroke {number} {what}")]
    Stroke {
        /// The stroke, counted from 0.
        number: usize,
        /// What is wrong with it.
        what: &'static str,
    },
    /// A singularity is wanted in a triangle that there is not.
    #[error("a singularity is for triangle {}, but there are {count}", face.0)]
    NoSuchFace {
        /// The triangle.
        face: FaceId,
        /// How many there are.
        count: usize,
    },
    /// A singularity is to be moved from where there is none.
    #[error("the field is not singular in triangle {}", face.0)]
    NotSingular {
        /// The triangle.
        face: FaceId,
    },
    /// Prescribed singularities do not sum to what the topology of their component asks for.
    #[error("the indices wanted in component {component} sum to {sum}, but must sum to {needed}")]
    SingularitySum {
        /// The component, counted from 0.
        component: usize,
        /// Their sum.
        sum: f64,
        /// What it should be.
        needed: f64,
    },
    /// Directions that are kept exactly enclose a triangle, and with it its singularity.
    #[error("edges that the field is held to enclose triangle {}: its index cannot change", face.0)]
    Enclosed {
        /// The triangle.
        face: FaceId,
    },
    /// A field with the prescribed singularities would have to turn too fast along an edge.
    #[error("the field has index {found} in triangle {}, not {wanted}", face.0)]
    NotReached {
        /// The triangle.
        face: FaceId,
        /// The index that was prescribed.
        wanted: f64,
        /// The index that the field has.
        found: f64,
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

impl Hint for FieldError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::Option { name, range, .. } => Some(format!("give {name} a value in {range}")),
            Self::SizeCount { .. } => Some("give one size for each vertex".into()),
            Self::NoSuchElement { count, .. } | Self::NoSuchFace { count, .. } => Some(format!(
                "they are numbered from 0 to {}",
                count.saturating_sub(1)
            )),
            Self::Guide { .. } => Some(
                "give a direction along the surface, of any length but zero, and a weight above 0"
                    .into(),
            ),
            Self::IndexSum { .. } => Some(
                "repair the mesh first: 'graticule repair' removes triangles without area".into(),
            ),
            Self::Stroke { .. } => {
                Some("draw it on the surface, in the coordinates of the mesh".into())
            }
            Self::NotSingular { .. } => {
                Some("move a singularity from a triangle that the report lists".into())
            }
            Self::SingularitySum { sum, needed, .. } => Some(format!(
                "add singularities whose indices sum to {}",
                needed - sum
            )),
            Self::Enclosed { .. } => Some(
                "keep fewer edges (a larger feature angle), or give their faces the indices that \
                 their corners ask for"
                    .into(),
            ),
            Self::NotReached { .. } => Some(
                "put singularities of one step into triangles of good shape, apart from each other \
                 and from directions that are kept exactly"
                    .into(),
            ),
            Self::Geometry(error) => error.hint(),
            Self::Solve(error) => error.hint(),
            Self::Stopped(stopped) => stopped.hint(),
        }
    }
}
