//! The folder of a recording while it is made: files are written into a partial folder, which replaces the old one at once.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::Duration;

use diagnostics::{Diagnostic, Result};

/// A partial folder beside `into/name`, with `stamp` in its file `mark`. The remains of an interrupted recording with the same stamp are
/// kept; anything else is removed.
///
/// # Errors
/// When the folder cannot be made.
pub(crate) fn begin(into: &Path, name: &str, mark: &str, stamp: &str) -> Result<PathBuf> {
    let partial = into.join(format!(".{name}.partial"));
    remove(&outdated(&into.join(name)))?;
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

/// The lock of a folder of recordings; the operating system releases it when the process ends.
const LOCK: &str = ".lock";

/// Number and interval of the attempts to take it.
const TRIES: usize = 50;
const PAUSE: Duration = Duration::from_millis(20);

/// Locks `into` until the returned file is dropped, so that two processes never write the same recording.
///
/// # Errors
/// When another process holds the lock, or its file cannot be made.
pub(crate) fn lock(into: &Path) -> Result<File> {
    let path = into.join(LOCK);
    std::fs::create_dir_all(into).map_err(|e| unusable(into, e))?;
    let file = File::options().create(true).append(true).open(&path).map_err(|e| unusable(&path, e))?;
    let mut asked = file.try_lock();
    // A process that was killed holds its lock until the system has freed its memory.
    for _ in 0..TRIES {
        if !matches!(asked, Err(TryLockError::WouldBlock)) {
            break;
        }
        std::thread::sleep(PAUSE);
        asked = file.try_lock();
    }
    match asked {
        Ok(()) => Ok(file),
        Err(TryLockError::Error(e)) => Err(Diagnostic::io(&path, e, "use a local disk")),
        Err(TryLockError::WouldBlock) => Err(Diagnostic::file(
            into,
            "another recording is in progress in this folder",
            format!("it holds {LOCK}"),
            "wait until it has ended, or end it; its finished trials are kept",
        )),
    }
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
    fn two_recordings_into_one_folder_are_refused_until_the_first_has_ended() {
        let into = std::env::temp_dir().join(format!("rig-lock-{}", std::process::id()));
        let first = lock(&into).unwrap();
        let refused = lock(&into).unwrap_err().to_string();
        assert!(refused.contains("another recording is in progress") && refused.contains("do:"), "{refused}");
        drop(first);
        assert!(lock(&into).is_ok());
        remove(&into).unwrap();
    }

    #[test]
    fn a_replacement_that_was_interrupted_leaves_nothing_of_the_old_recording() {
        let into = std::env::temp_dir().join(format!("rig-replace-{}", std::process::id()));
        let at = into.join("tail");
        write(&into.join(".tail.outdated"), "film.mp4", b"old").unwrap();
        let partial = begin(&into, "tail", "stamp", "new").unwrap();
        assert!(!into.join(".tail.outdated").exists());
        write(&at, "film.mp4", b"old").unwrap();
        finish(&partial, &at).unwrap();
        assert_eq!(std::fs::read_to_string(at.join("stamp")).unwrap(), "new");
        assert_eq!(std::fs::read_dir(&into).unwrap().count(), 1);
        remove(&into).unwrap();
    }
}
