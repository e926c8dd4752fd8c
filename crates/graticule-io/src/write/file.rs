use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use tempfile::Builder;

use super::WriteError;

/// Lets `write` fill a file that takes its place at `path` only when it is complete.
pub(super) fn write_whole<T>(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<T, WriteError>,
) -> Result<T, WriteError> {
    // A link is followed, so that it goes on pointing to the file.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if fs::metadata(&target).is_ok_and(|there| !there.is_file() && !there.is_dir()) {
        return write(&mut File::options().write(true).open(&target)?);
    }
    let folder = target
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let mut builder = Builder::new();
    builder.prefix(".graticule-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // What a new file has; the system takes away what the user's mask forbids.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder.unwrap_or(Path::new(".")))?;
    let result = write(file.as_file_mut())?;
    if let Ok(before) = fs::metadata(&target) {
        fs::set_permissions(file.path(), before.permissions())?;
    }
    file.persist(&target).map_err(|error| error.error)?;
    Ok(result)
}
