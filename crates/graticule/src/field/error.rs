use crate::Hint;
use crate::geometry::GeometryError;
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
            Self::NoSuchElement { count, .. } => Some(format!(
                "elements are numbered from 0 to {}",
                count.saturating_sub(1)
            )),
            Self::Guide { .. } => Some(
                "give a direction along the surface, of any length but zero, and a weight above 0"
                    .into(),
            ),
            Self::IndexSum { .. } => Some(
                "repair the mesh first: 'graticule repair' removes triangles without area".into(),
            ),
            Self::Geometry(error) => error.hint(),
            Self::Solve(error) => error.hint(),
            Self::Stopped(stopped) => stopped.hint(),
        }
    }
}
