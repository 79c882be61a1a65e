//! Checkpoints: the parts of an unfinished recording that are complete, so that an interrupted recording can be resumed and its parts made
//! by different processes.
//!
//! A checkpoint is written after a part's last file and holds what the rest of the recording needs of it: of a trial its ground truth.
//! All are removed when the recording is finished; a recording of some trials keeps them.

use std::path::Path;

use diagnostics::{Result, input};

use crate::folder;
use crate::trial::TrialTruth;

/// Their folder.
const FOLDER: &str = "checkpoints";

/// The ground truth of trial `id`, if it is complete in `folder`.
pub(crate) fn load_trial(folder: &Path, id: &str) -> Option<TrialTruth> {
    toml::from_str(&String::from_utf8(load_bytes(folder, &of_trial(id))?).ok()?).ok()
}

/// Writes the checkpoint of trial `id`.
///
/// # Errors
/// When the file cannot be written.
pub(crate) fn save_trial(folder: &Path, id: &str, truth: &TrialTruth) -> Result<()> {
    let text = toml::to_string(truth).expect("ground truth has only tables, numbers and strings");
    save_bytes(folder, &of_trial(id), text.as_bytes())
}

fn of_trial(id: &str) -> String {
    format!("{id}.toml")
}

/// What the checkpoint of `part` holds, if it is complete in `folder`.
pub(crate) fn load_bytes(folder: &Path, part: &str) -> Option<Vec<u8>> {
    input::read(&folder.join(FOLDER).join(part), input::MESH).ok()
}

/// Writes the checkpoint of `part`.
///
/// # Errors
/// When the file cannot be written.
pub(crate) fn save_bytes(folder: &Path, part: &str, bytes: &[u8]) -> Result<()> {
    // written under another name first: an interruption leaves no half-written checkpoint
    let unfinished = format!("{FOLDER}/{part}.unfinished");
    folder::write_file(folder, &unfinished, bytes)?;
    let path = folder.join(FOLDER).join(part);
    std::fs::rename(folder.join(FOLDER).join(format!("{part}.unfinished")), &path)
        .map_err(|e| folder::unusable_path(&path, e))
}

/// Makes the folder of the checkpoints where there is none yet.
///
/// # Errors
/// When it cannot be made.
pub(crate) fn begin(folder: &Path) -> Result<()> {
    let checkpoints = folder.join(FOLDER);
    std::fs::create_dir_all(&checkpoints).map_err(|e| folder::unusable_path(&checkpoints, e))
}

/// Whether a folder has checkpoints: those of an unfinished recording, or of one of some trials.
pub(crate) fn exist_in(folder: &Path) -> bool {
    folder.join(FOLDER).is_dir()
}

/// Removes all checkpoints.
///
/// # Errors
/// When the folder cannot be removed.
pub(crate) fn clear_all(folder: &Path) -> Result<()> {
    folder::remove_folder(&folder.join(FOLDER))
}
