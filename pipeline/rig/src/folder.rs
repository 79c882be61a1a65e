//! The folder of a recording while it is made: files are written into a partial folder, which replaces the old one at once.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result, input};

/// The partial folder of the recording `into/name`.
pub(crate) fn partial(into: &Path, name: &str) -> PathBuf {
    into.join(format!(".{name}.partial"))
}

/// Makes the partial folder of a recording that will lie `at` its place, with a stamp in its file: `(file, stamp)`. The remains of an
/// interrupted recording with the same stamp are kept; anything else is removed.
///
/// # Errors
/// When the folder cannot be made.
pub(crate) fn begin(at: &Path, partial: &Path, (file, stamp): (&str, &str)) -> Result<()> {
    remove(&outdated(at))?;
    if input::read_text(&partial.join(file), input::PAGE).is_ok_and(|found| found == stamp) {
        return Ok(());
    }
    remove(partial)?;
    std::fs::create_dir_all(partial).map_err(|e| unusable(partial, e))?;
    write(partial, file, stamp.as_bytes())
}

/// Replaces the folder `at` by a finished one. The caller has checked that `at` was made by the bench.
///
/// # Errors
/// When the old folder cannot be removed or the new one not renamed.
pub(crate) fn finish(partial: &Path, at: &Path) -> Result<()> {
    let outdated = outdated(at);
    if at.exists() {
        // A removal that is interrupted would leave a folder without its stamp, which is refused as a laboratory's.
        std::fs::rename(at, &outdated).map_err(|e| unusable(at, e))?;
    }
    std::fs::rename(partial, at).map_err(|e| unusable(at, e))?;
    remove(&outdated)
}

/// The name of a recording that is being replaced.
fn outdated(at: &Path) -> PathBuf {
    at.with_file_name(format!(".{}.outdated", at.file_name().unwrap_or_default().to_string_lossy()))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_begun_is_taken_up_with_the_same_stamp_alone() {
        let into = std::env::temp_dir().join(format!("rig-begin-{}", std::process::id()));
        let (at, partial) = (into.join("tail"), partial(&into, "tail"));
        let begun = |stamp| {
            begin(&at, &partial, ("stamp", stamp)).unwrap();
            partial.join("film.mp4").exists()
        };
        assert!(!begun("old"));
        write(&partial, "film.mp4", b"half").unwrap();
        assert!(begun("old"));
        assert!(!begun("new"));
        assert_eq!(std::fs::read_to_string(partial.join("stamp")).unwrap(), "new");
        remove(&into).unwrap();
    }

    #[test]
    fn a_replacement_that_was_interrupted_leaves_nothing_of_the_old_recording() {
        let into = std::env::temp_dir().join(format!("rig-replace-{}", std::process::id()));
        let at = into.join("tail");
        write(&into.join(".tail.outdated"), "film.mp4", b"old").unwrap();
        let partial = partial(&into, "tail");
        begin(&at, &partial, ("stamp", "new")).unwrap();
        assert!(!into.join(".tail.outdated").exists());
        write(&at, "film.mp4", b"old").unwrap();
        finish(&partial, &at).unwrap();
        assert_eq!(std::fs::read_to_string(at.join("stamp")).unwrap(), "new");
        assert_eq!(std::fs::read_dir(&into).unwrap().count(), 1);
        remove(&into).unwrap();
    }
}
