//! Checkpoints: the trials of an unfinished recording that are complete, so that an interrupted recording can be resumed.
//!
//! A checkpoint is written after a trial's last file and holds the trial's ground truth. All are removed when the recording is finished.

use std::path::{Path, PathBuf};

use diagnostics::Result;

use crate::folder;
use crate::trial::TrialTruth;

/// Their folder.
const FOLDER: &str = "checkpoints";

/// The ground truth of trial `id`, if it is complete in `folder`.
pub(crate) fn load(folder: &Path, id: &str) -> Option<TrialTruth> {
    let text = std::fs::read_to_string(path(folder, id)).ok()?;
    toml::from_str(&text).ok()
}

/// Writes the checkpoint of trial `id`.
///
/// # Errors
/// When the file cannot be written.
pub(crate) fn save(folder: &Path, id: &str, truth: &TrialTruth) -> Result<()> {
    let text = toml::to_string(truth).expect("ground truth has only tables, numbers and strings");
    // written under another name first: an interruption leaves no half-written checkpoint
    let unfinished = format!("{FOLDER}/{id}.part");
    folder::write(folder, &unfinished, text.as_bytes())?;
    let to = path(folder, id);
    std::fs::rename(folder.join(FOLDER).join(format!("{id}.part")), &to).map_err(|e| folder::unusable(&to, e))
}

/// Removes all checkpoints.
///
/// # Errors
/// When the folder cannot be removed.
pub(crate) fn clear(folder: &Path) -> Result<()> {
    folder::remove(&folder.join(FOLDER))
}

fn path(folder: &Path, id: &str) -> PathBuf {
    folder.join(FOLDER).join(format!("{id}.toml"))
}
