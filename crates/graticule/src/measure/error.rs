use crate::watch::Stopped;

/// Why a map could not be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// There is not one coordinate pair for each corner.
    #[error("{uvs} texture coordinates were given for {corners} corners")]
    CornerCount {
        /// Coordinate pairs given.
        uvs: usize,
        /// Corners of the mesh.
        corners: usize,
    },
    /// Squares of lengths would overflow or vanish.
    #[error("the extent of the {what} is {extent:e}; it can be measured from 1e-140 to 1e140")]
    ExtentOutOfRange {
        /// `"surface"` or `"map"`.
        what: &'static str,
        /// The larger side of the box around it.
        extent: f64,
    },
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl crate::Hint for MeasureError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::CornerCount { .. } => Some("give one pair for each corner of each face".into()),
            Self::ExtentOutOfRange { .. } => Some("scale the coordinates to ordinary sizes".into()),
            Self::Stopped(stopped) => stopped.hint(),
        }
    }
}
