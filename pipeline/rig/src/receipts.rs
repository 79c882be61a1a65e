//! Receipts: which trials of an unfinished recording are whole, so that an interrupted one goes on where it was.
//!
//! A receipt is left after a trial's last file, and holds what was hidden in it. Receipts go when the recording is finished.
//!
//! Stands on: the folder, `toml`. Never knows: how a trial is made.

use std::path::{Path, PathBuf};

use crate::fault::Fault;
use crate::folder;
use crate::trial::Hidden;

/// Their folder.
const FOLDER: &str = "receipts";

/// What was hidden in trial `id`, when it is whole in `folder`.
pub fn find(folder: &Path, id: &str) -> Option<Hidden> {
    let text = std::fs::read_to_string(place(folder, id)).ok()?;
    toml::from_str(&text).ok()
}

/// Leaves a receipt for trial `id`.
///
/// # Errors
/// [`Fault`] when the disk refuses.
pub fn leave(folder: &Path, id: &str, hidden: &Hidden) -> Result<(), Fault> {
    let text = toml::to_string(hidden).expect("what is hidden has only tables, numbers and words");
    let unfinished = format!("{FOLDER}/{id}.part");
    folder::write(folder, &unfinished, text.as_bytes())?;
    let at = place(folder, id);
    std::fs::rename(folder.join(FOLDER).join(format!("{id}.part")), &at).map_err(|e| Fault::io(&at, &e))
}

/// Takes all receipts away.
///
/// # Errors
/// [`Fault`] when the disk refuses.
pub fn clear(folder: &Path) -> Result<(), Fault> {
    let at = folder.join(FOLDER);
    match std::fs::remove_dir_all(&at) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Fault::io(&at, &e)),
        _ => Ok(()),
    }
}

fn place(folder: &Path, id: &str) -> PathBuf {
    folder.join(FOLDER).join(format!("{id}.toml"))
}
