//! Files that a command writes: checked before the work, whole or not at all.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::failure::Failure;

/// Checks that a file could be written at `path`, without writing it.
pub(crate) fn check_writable(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        return Err(Failure::usage(
            format!("{} is a folder", path.display()),
            "name a file in it",
        ));
    }
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(Failure::usage(
            format!("the folder {} does not exist", folder.display()),
            "create it first, or name another place",
        ));
    }
    if is_special(path) {
        return Ok(());
    }
    match tempfile::tempfile_in(&folder) {
        Ok(_) => Ok(()),
        Err(error) => Err(Failure::usage(
            format!("the folder {} cannot be written: {error}", folder.display()),
            "allow writing there, or name another place",
        )),
    }
}

/// Checks that no file is to be written twice.
pub(crate) fn check_distinct(paths: &[&Path]) -> Result<(), Failure> {
    for (index, path) in paths.iter().enumerate() {
        if paths[..index].contains(path) && !is_special(path) {
            return Err(Failure::usage(
                format!("{} is named for two outputs", path.display()),
                "give each output a file of its own",
            ));
        }
    }
    Ok(())
}

/// The ending of a file's name in lower case, without the dot; empty where there is none.
pub(crate) fn extension(path: &Path) -> String {
    let extension = path.extension().unwrap_or_default();
    extension.to_string_lossy().to_lowercase()
}

/// Writes a file so that it appears whole, under its name, or not at all.
pub(crate) fn write_whole(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    let written = if is_special(path) {
        fs::File::options()
            .write(true)
            .open(path)
            .and_then(|file| fill(file, content).map(drop))
    } else {
        replace(path, content)
    };
    written.map_err(|error| {
        Failure::new(
            format!("{} could not be written: {error}", path.display()),
            "check the space left on the disk and the rights to the folder",
        )
    })
}

/// Writes beside the file, then moves the new file over it.
fn replace(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    // Through a link the file it names is replaced, not the link.
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let file = temporary_file(&path)?;
    fill(file, content)?.persist(&path)?;
    Ok(())
}

fn fill<W: Write>(
    file: W,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<W> {
    let mut writer = BufWriter::new(file);
    content(&mut writer)?;
    writer.into_inner().map_err(io::IntoInnerError::into_error)
}

/// A file beside `path` with the rights that the file of that name has, or an ordinary new file
/// would get.
fn temporary_file(path: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".graticule-");
    match fs::metadata(path) {
        Ok(existing) => builder.permissions(existing.permissions()),
        Err(_) => ordinary_rights(&mut builder),
    };
    builder.tempfile_in(folder_of(path))
}

#[cfg(unix)]
fn ordinary_rights<'a, 'b>(
    builder: &'a mut tempfile::Builder<'b, 'b>,
) -> &'a mut tempfile::Builder<'b, 'b> {
    use std::os::unix::fs::PermissionsExt;
    // The process's mask takes away from these, as for any new file.
    builder.permissions(fs::Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn ordinary_rights<'a, 'b>(
    builder: &'a mut tempfile::Builder<'b, 'b>,
) -> &'a mut tempfile::Builder<'b, 'b> {
    builder
}

/// Whether the path names a device or a pipe, which must not be replaced by a file.
fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_whose_content_fails_leaves_the_old_one_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let result = write_whole(&path, |out| {
            out.write_all(b"half")?;
            Err(io::Error::other("broken"))
        });
        assert!(result.is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn links_and_rights_survive() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_whole(&link, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), "new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        let mode = fs::metadata(&file).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_written_into() {
        write_whole(Path::new("/dev/null"), |out| out.write_all(b"x")).unwrap();
        assert!(is_special(Path::new("/dev/null")));
    }
}
