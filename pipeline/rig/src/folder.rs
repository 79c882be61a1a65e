//! The folder of a recording while it is made: files appear inside it, and the whole takes its place at once.
//!
//! Stands on: the disk. Never knows: what the files hold.

use std::path::{Path, PathBuf};

use crate::fault::Fault;

/// A folder beside where `name` will stand in `into`, with `stamp` in its file `mark`. What an interrupted recording with the
/// same stamp left there is kept, anything else removed.
///
/// # Errors
/// [`Fault`] when the disk refuses.
pub fn begin(into: &Path, name: &str, mark: &str, stamp: &str) -> Result<PathBuf, Fault> {
    let partial = into.join(format!(".{name}.partial"));
    if std::fs::read_to_string(partial.join(mark)).is_ok_and(|found| found == stamp) {
        return Ok(partial);
    }
    remove(&partial)?;
    std::fs::create_dir_all(&partial).map_err(|e| Fault::io(&partial, &e))?;
    write(&partial, mark, stamp.as_bytes())?;
    Ok(partial)
}

/// Puts a finished folder in the place of `at`, whose owner has been looked at before.
///
/// # Errors
/// [`Fault`] when the disk refuses.
pub fn finish(partial: &Path, at: &Path) -> Result<(), Fault> {
    remove(at)?;
    std::fs::rename(partial, at).map_err(|e| Fault::io(at, &e))
}

/// The path of `file` (parts parted by `/`) in `folder`, its own folder made.
///
/// # Errors
/// [`Fault`] when the disk refuses.
pub fn prepared(folder: &Path, file: &str) -> Result<PathBuf, Fault> {
    let path = file.split('/').fold(folder.to_owned(), |path, part| path.join(part));
    let parent = path.parent().unwrap_or(folder);
    std::fs::create_dir_all(parent).map_err(|e| Fault::io(parent, &e))?;
    Ok(path)
}

/// Writes `file` in `folder`.
///
/// # Errors
/// [`Fault`] when the disk refuses.
pub fn write(folder: &Path, file: &str, bytes: &[u8]) -> Result<(), Fault> {
    let path = prepared(folder, file)?;
    std::fs::write(&path, bytes).map_err(|e| Fault::io(&path, &e))
}

fn remove(folder: &Path) -> Result<(), Fault> {
    match std::fs::remove_dir_all(folder) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Fault::io(folder, &e)),
        _ => Ok(()),
    }
}
