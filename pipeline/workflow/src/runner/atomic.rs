//! Atomic writes: a file appears under its name with all of its bytes or not at all.

use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::sync::OnceLock;

use super::process::Process;

/// The end of a name under which a file is written.
const UNFINISHED: &str = ".unfinished";

/// Writes a file's bytes and waits until they are on the disk.
///
/// # Errors
/// When the file cannot be created or written.
pub(crate) fn write_synced(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = fs::File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// Writes a file under another name and renames it, so that a reader finds the old bytes or the new ones.
///
/// # Errors
/// When the folder, the file or the name cannot be written.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    // With the process: two may write the same file, each with all of its bytes, and a leftover is known by a process that has ended.
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}{UNFINISHED}", this_process().token));
    let unfinished = path.with_file_name(name);
    // Without the sync a power cut after the rename could leave an empty file under the final name.
    let written = write_synced(&unfinished, bytes).and_then(|()| fs::rename(&unfinished, path));
    if written.is_err() {
        // On a full disk the part that was written takes what little room there is.
        let _ = fs::remove_file(&unfinished);
    }
    written
}

/// Removes what processes of this machine that were killed left half-written in a folder.
pub(super) fn sweep(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let token =
            name.to_str().and_then(|name| name.strip_suffix(UNFINISHED)).and_then(|name| name.rsplit('.').next());
        if token.is_some_and(|token| this_process().has_ended_here(token)) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// This process, asked for once: its name is part of every file that is written.
fn this_process() -> &'static Process {
    static THIS: OnceLock<Process> = OnceLock::new();
    THIS.get_or_init(Process::this)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_an_ended_process_left_is_swept_and_what_a_running_one_writes_is_not() {
        let folder = std::env::temp_dir().join(format!("atomic-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let token = &this_process().token;
        let ended = token.replacen(&format!("-{}-", std::process::id()), "-0-", 1);
        let names =
            [format!("a.json.{ended}{UNFINISHED}"), format!("a.json.{token}{UNFINISHED}"), "b.unfinished".into()];
        names.iter().for_each(|name| fs::write(folder.join(name), "").unwrap());
        sweep(&folder);
        assert_eq!(names.map(|name| folder.join(name).exists()), [false, true, true]);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_file_that_cannot_be_put_in_place_leaves_nothing() {
        let folder = std::env::temp_dir().join(format!("atomic-refused-{}", std::process::id()));
        fs::create_dir_all(folder.join("taken/by")).unwrap();
        assert!(write_atomically(&folder.join("taken"), b"bytes").is_err());
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }
}
