//! The folder of a recording while it is made: files are written into a partial folder, which replaces the old one at once.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};

/// A partial folder beside `into/name`, with `stamp` in its file `mark`. The remains of an interrupted recording with the same stamp are
/// kept; anything else is removed.
///
/// # Errors
/// When the folder cannot be made.
pub(crate) fn begin(into: &Path, name: &str, mark: &str, stamp: &str) -> Result<PathBuf> {
    let partial = into.join(format!(".{name}.partial"));
    if std::fs::read_to_string(partial.join(mark)).is_ok_and(|found| found == stamp) {
        return Ok(partial);
    }
    remove(&partial)?;
    std::fs::create_dir_all(&partial).map_err(|e| unusable(&partial, e))?;
    write(&partial, mark, stamp.as_bytes())?;
    Ok(partial)
}

/// Replaces the folder `at` by a finished one. The caller has checked that `at` was made by the bench.
///
/// # Errors
/// When the old folder cannot be removed or the new one not renamed.
pub(crate) fn finish(partial: &Path, at: &Path) -> Result<()> {
    remove(at)?;
    std::fs::rename(partial, at).map_err(|e| unusable(at, e))
}

/// The path of `file` (parts separated by `/`) in `folder`; its parent folder is created.
///
/// # Errors
/// When the parent folder cannot be created.
pub(crate) fn prepared(folder: &Path, file: &str) -> Result<PathBuf> {
    let path = file.split('/').fold(folder.to_owned(), |path, part| path.join(part));
    let parent = path.parent().unwrap_or(folder);
    std::fs::create_dir_all(parent).map_err(|e| unusable(parent, e))?;
    Ok(path)
}

/// Writes `file` in `folder`.
///
/// # Errors
/// When the file cannot be written.
pub(crate) fn write(folder: &Path, file: &str, bytes: &[u8]) -> Result<()> {
    let path = prepared(folder, file)?;
    std::fs::write(&path, bytes).map_err(|e| unusable(&path, e))
}

/// Removes `folder` if it exists.
///
/// # Errors
/// When it exists and cannot be removed.
pub(crate) fn remove(folder: &Path) -> Result<()> {
    match std::fs::remove_dir_all(folder) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(unusable(folder, e)),
        _ => Ok(()),
    }
}

/// A file or folder that cannot be used.
pub(crate) fn unusable(path: &Path, error: std::io::Error) -> Diagnostic {
    Diagnostic::io(path, error, "check the permissions and the free space of its folder")
}
