//! The folder of a recording while it is made: files are written into a partial folder, which replaces the old one at once.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result, input};

/// The partial folder of the recording `into/name`.
pub(crate) fn partial_folder(into: &Path, name: &str) -> PathBuf {
    into.join(format!(".{name}.partial"))
}

/// Makes the partial folder of a recording that will be `folder`, with a stamp in its file: `(file, stamp)`. The remains of an
/// interrupted recording with the same stamp are kept, and so is what `folder` shows with that stamp where it is `taken_up`; anything else is removed.
///
/// # Errors
/// When the folder cannot be made.
pub(crate) fn begin_recording(
    folder: &Path,
    partial: &Path,
    (file, stamp): (&str, &str),
    taken_up: bool,
) -> Result<()> {
    remove_folder(&outdated_folder(folder))?;
    let has_stamp =
        |folder: &Path| input::read_text(&folder.join(file), input::PAGE).is_ok_and(|former| former == stamp);
    if has_stamp(partial) {
        return Ok(());
    }
    remove_folder(partial)?;
    if taken_up && has_stamp(folder) {
        return std::fs::rename(folder, partial).map_err(|e| unusable_path(folder, e));
    }
    std::fs::create_dir_all(partial).map_err(|e| unusable_path(partial, e))?;
    write_file(partial, file, stamp.as_bytes())
}

/// Replaces `folder` by a finished one. The caller has checked that `folder` was made by the bench.
///
/// # Errors
/// When the old folder cannot be removed or the new one not renamed.
pub(crate) fn finish_recording(partial: &Path, folder: &Path) -> Result<()> {
    let outdated = outdated_folder(folder);
    if folder.exists() {
        // A removal that is interrupted would leave a folder without its stamp, which is refused as a laboratory's.
        std::fs::rename(folder, &outdated).map_err(|e| unusable_path(folder, e))?;
    }
    std::fs::rename(partial, folder).map_err(|e| unusable_path(folder, e))?;
    remove_folder(&outdated)
}

/// The name of a recording that is being replaced.
fn outdated_folder(folder: &Path) -> PathBuf {
    folder.with_file_name(format!(".{}.outdated", folder.file_name().unwrap_or_default().to_string_lossy()))
}

/// The path of `file` (parts separated by `/`) in `folder`; its parent folder is created.
///
/// # Errors
/// When the parent folder cannot be created.
pub(crate) fn prepared_path(folder: &Path, file: &str) -> Result<PathBuf> {
    let path = file.split('/').fold(folder.to_owned(), |path, part| path.join(part));
    let parent = path.parent().unwrap_or(folder);
    std::fs::create_dir_all(parent).map_err(|e| unusable_path(parent, e))?;
    Ok(path)
}

/// Writes `file` in `folder`.
///
/// # Errors
/// When the file cannot be written.
pub(crate) fn write_file(folder: &Path, file: &str, bytes: &[u8]) -> Result<()> {
    let path = prepared_path(folder, file)?;
    std::fs::write(&path, bytes).map_err(|e| unusable_path(&path, e))
}

/// Removes `folder` if it exists.
///
/// # Errors
/// When it exists and cannot be removed.
pub(crate) fn remove_folder(folder: &Path) -> Result<()> {
    match std::fs::remove_dir_all(folder) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(unusable_path(folder, e)),
        _ => Ok(()),
    }
}

/// A file or folder that cannot be used.
pub(crate) fn unusable_path(path: &Path, error: std::io::Error) -> Diagnostic {
    Diagnostic::io(path, error, "check the permissions and the free space of its folder")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_begun_is_taken_up_with_the_same_stamp_alone() {
        let into = std::env::temp_dir().join(format!("rig-begin-{}", std::process::id()));
        let (at, partial) = (into.join("tail"), partial_folder(&into, "tail"));
        let begun = |stamp| {
            begin_recording(&at, &partial, ("stamp", stamp), false).unwrap();
            partial.join("film.mp4").exists()
        };
        assert!(!begun("old"));
        write_file(&partial, "film.mp4", b"half").unwrap();
        assert!(begun("old"));
        assert!(!begun("new"));
        assert_eq!(std::fs::read_to_string(partial.join("stamp")).unwrap(), "new");
        remove_folder(&into).unwrap();
    }

    #[test]
    fn trials_that_are_shown_are_taken_up_again_with_the_same_stamp_alone() {
        let into = std::env::temp_dir().join(format!("rig-shown-{}", std::process::id()));
        let (folder, partial) = (into.join("tail"), partial_folder(&into, "tail"));
        for (former, is_kept) in [("stamp", true), ("another", false)] {
            write_file(&folder, "stamp", former.as_bytes()).unwrap();
            write_file(&folder, "film.mp4", b"whole").unwrap();
            begin_recording(&folder, &partial, ("stamp", "stamp"), true).unwrap();
            assert_eq!((partial.join("film.mp4").exists(), folder.exists()), (is_kept, !is_kept));
            remove_folder(&into).unwrap();
        }
    }

    #[test]
    fn a_replacement_that_was_interrupted_leaves_nothing_of_the_old_recording() {
        let into = std::env::temp_dir().join(format!("rig-replace-{}", std::process::id()));
        let at = into.join("tail");
        write_file(&into.join(".tail.outdated"), "film.mp4", b"old").unwrap();
        let partial = partial_folder(&into, "tail");
        begin_recording(&at, &partial, ("stamp", "new"), false).unwrap();
        assert!(!into.join(".tail.outdated").exists());
        write_file(&at, "film.mp4", b"old").unwrap();
        finish_recording(&partial, &at).unwrap();
        assert_eq!(std::fs::read_to_string(at.join("stamp")).unwrap(), "new");
        assert_eq!(std::fs::read_dir(&into).unwrap().count(), 1);
        remove_folder(&into).unwrap();
    }
}
