//! Pictures of results.

use std::path::Path;

use crate::failure::Failure;
use crate::output::extension;

/// How a picture is encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    Png,
    Svg,
}

impl PictureFormat {
    /// The format that the ending of the file's name asks for.
    pub(crate) fn of(path: &Path) -> Result<Self, Failure> {
        match extension(path).as_str() {
            "png" => Ok(Self::Png),
            "svg" => Ok(Self::Svg),
            other => Err(Failure::usage(
                format!("a picture cannot be written as '{other}' ({})", path.display()),
                "end its name in .png or .svg",
            )),
        }
    }
}
