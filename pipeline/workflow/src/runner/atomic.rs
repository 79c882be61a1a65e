//! Atomic writes: a file appears under its name with all of its bytes or not at all.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

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
    // With the number of the process: two may write the same file, each with all of its bytes.
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.unfinished", std::process::id()));
    let unfinished = path.with_file_name(name);
    // Without the sync a power cut after the rename could leave an empty file under the final name.
    write_synced(&unfinished, bytes)?;
    fs::rename(&unfinished, path)
}
