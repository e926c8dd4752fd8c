use graticule::Hint;

/// Largest width and height of a picture in pixels.
pub const MAX_SIDE: u32 = 16_384;

/// Why a picture could not be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DrawError {
    /// There is not one value for each element.
    #[error("{given} {what} were given for {expected}")]
    ValueCount {
        /// What was given.
        what: &'static str,
        /// The number needed.
        expected: usize,
        /// The number given.
        given: usize,
    },
    /// No triangle has finite coordinates at its three corners.
    #[error("none of the {faces} triangles has finite texture coordinates")]
    NoCoordinates {
        /// Triangles of the surface.
        faces: usize,
    },
    /// All texture coordinates coincide.
    #[error("the layout has zero extent: all texture coordinates are ({}, {})", .at[0], .at[1])]
    ZeroExtent {
        /// The one place where all lie.
        at: [f64; 2],
    },
    /// Texture coordinates so far apart that their differences overflow.
    #[error("the extent of the layout overflows: a coordinate is {coordinate:e}")]
    ExtentOverflow {
        /// The largest coordinate in magnitude.
        coordinate: f64,
    },
    /// The side of a checker square is not a positive number.
    #[error("the checker has squares of side {side}")]
    CheckerSide {
        /// The side asked for.
        side: f64,
    },
    /// The direction of a view is zero or not finite.
    #[error("the view has the direction ({}, {}, {})", .direction[0], .direction[1], .direction[2])]
    Direction {
        /// The direction asked for.
        direction: [f64; 3],
    },
    /// The picture would be empty or too large.
    #[error("a picture of {width} x {height} pixels is not between 16 and {MAX_SIDE} each way")]
    PictureSize {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
    },
}

impl Hint for DrawError {
    fn hint(&self) -> Option<String> {
        let text = match self {
            Self::ValueCount { .. } => "give one value for each element of the surface drawn",
            Self::NoCoordinates { .. } | Self::ZeroExtent { .. } | Self::ExtentOverflow { .. } => {
                "flatten the surface first, or draw it without its layout"
            }
            Self::CheckerSide { .. } => "give a positive side, or none for a fitting one",
            Self::Direction { .. } => "give a direction other than zero, or the automatic view",
            Self::PictureSize { .. } => "choose another size of the picture",
        };
        Some(text.into())
    }
}

/// Fails unless `given` equals `expected`.
pub(crate) fn check_count(
    what: &'static str,
    expected: usize,
    given: usize,
) -> Result<(), DrawError> {
    if expected == given {
        return Ok(());
    }
    Err(DrawError::ValueCount {
        what,
        expected,
        given,
    })
}
