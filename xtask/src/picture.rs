//! Makes the picture of the README from `graticule demo`.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::Trouble;
use crate::shrink::shrink;

/// Where the README finds its picture.
const PICTURE: &str = "docs/demo.png";
/// A README should open at once.
const LARGEST: u64 = 600 * 1024;

/// Runs the demo and takes its picture over.
pub(crate) fn run(root: &Path) -> Result<String, Trouble> {
    let program = crate::build_release(root)?;
    let folder = tempfile::tempdir().map_err(|error| Trouble(error.to_string()))?;
    let status = Command::new(&program)
        .args(["demo", "--quiet", "--output-folder"])
        .arg(folder.path())
        .status()
        .map_err(|error| Trouble::reading(&program, &error))?;
    if !status.success() {
        return Err(Trouble(format!("the demo ended with {status}")));
    }
    let made = folder.path().join("small.png");
    shrink(&folder.path().join("charts.png"), &made)?;
    let bytes = fs::metadata(&made)
        .map_err(|error| Trouble::reading(&made, &error))?
        .len();
    if bytes > LARGEST {
        return Err(Trouble(format!(
            "the picture has {bytes} bytes, above {LARGEST}"
        )));
    }
    let place = root.join(PICTURE);
    fs::copy(&made, &place).map_err(|error| Trouble::reading(&place, &error))?;
    Ok(format!("{PICTURE}: {bytes} bytes"))
}
