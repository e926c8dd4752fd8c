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
            Self::Geometry(error) => error.hint(),
            Self::Solve(error) => error.hint(),
            Self::Stopped(stopped) => stopped.hint(),
        }
    }
}
