//! Staleness: the present inputs of a record, as hashes and values, compared with its manifest.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::Runner;
use super::differences::differences;
use super::graph::Job;
use super::hashes::Hashes;
use super::manifest::{MadeFrom, Manifest, Present};
use super::store::{Found, Store};
use crate::needs::RecordId;
use crate::stage::RawFile;
use crate::subject::Universe;
use diagnostics::{Diagnostic, Result};

/// Whether a record is up to date.
pub enum State {
    /// Up to date.
    Kept(Box<Manifest>),
    /// Stale, for these reasons.
    Stale(Vec<String>),
    /// Its bytes are not those that were written.
    Damaged(String),
}

/// The inputs of a job, with the content of each record that it reads.
///
/// # Errors
/// A [`Diagnostic`] when the inputs cannot be determined or a recording is missing.
pub fn made_from<U: Universe>(
    runner: &Runner<U>,
    job: &Job<U>,
    contents: &BTreeMap<RecordId, String>,
    hashes: &Hashes,
) -> Result<MadeFrom> {
    present_inputs(runner, job, contents, hashes).map(Present::made_from)
}

/// The same, borrowed.
pub(super) fn present_inputs<'a, U: Universe>(
    runner: &Runner<U>,
    job: &'a Job<U>,
    contents: &'a BTreeMap<RecordId, String>,
    hashes: &Hashes,
) -> Result<Present<'a>> {
    let inputs = job.inputs.as_ref().map_err(|diagnostic| diagnostic.clone().of(&job.id))?;
    let mut raw = BTreeMap::new();
    for file in &inputs.raw {
        raw.insert(&*file.path, hash_recording(runner, file, hashes).map_err(|diagnostic| diagnostic.of(&job.id))?);
    }
    let content = |id: &RecordId| (id.to_string(), contents.get(id).map_or("", String::as_str));
    Ok(Present {
        version: job.entry.version,
        raw,
        card: &inputs.card,
        settings: &inputs.settings,
        records: inputs.records.iter().map(content).collect(),
    })
}

/// Compares what lies on disk with what a job would be made from now.
pub(crate) fn record_state<U: Universe>(runner: &Runner<U>, job: &Job<U>, now: &MadeFrom, hashes: &Hashes) -> State {
    compared_state(Store::new(&runner.folders).find_with(&job.id, hashes), now)
}

/// Compares what was found with what a job would be made from now.
pub(crate) fn compared_state(stored: Found, now: &MadeFrom) -> State {
    match stored {
        Found::Nothing => State::Stale(vec!["it was never made".into()]),
        Found::Damaged(damage) => State::Damaged(damage),
        Found::Whole(manifest) if manifest.key == now.key() => State::Kept(manifest),
        Found::Whole(manifest) => State::Stale(differences(&manifest.made_from, now)),
    }
}

fn hash_recording<U: Universe>(runner: &Runner<U>, file: &RawFile, hashes: &Hashes) -> Result<String> {
    let path = runner.folders.raw_file(&file.path);
    let read = match hashes.of(&path) {
        Err(_) if path.is_dir() => hash_folder(&path, hashes),
        read => read,
    };
    match read {
        Ok(hash) => Ok(hash),
        Err(e) if file.optional && e.kind() == std::io::ErrorKind::NotFound => Ok("absent".into()),
        Err(e) => Err(Diagnostic::new(
            format!("the {} {} cannot be read", file.name, runner.folders.display(&path)),
            format!("the card of `{}` names it, and reading it failed: {e}", group_of(&file.path)),
            "put the file there, or correct its name on the card",
        )),
    }
}

/// Of a folder of pictures: names and contents of its files, in the order of their names.
fn hash_folder(path: &Path, hashes: &Hashes) -> std::io::Result<String> {
    let entries = std::fs::read_dir(path)?.map(|entry| entry.map(|e| e.path()));
    let mut files = entries.collect::<std::io::Result<Vec<PathBuf>>>()?;
    files.sort();
    let mut hasher = blake3::Hasher::new();
    for file in files.iter().filter(|file| file.is_file()) {
        hasher.update(file.file_name().unwrap_or_default().as_encoded_bytes()).update(hashes.of(file)?.as_bytes());
    }
    Ok(hasher.finalize().to_hex().to_string())
}

fn group_of(path: &str) -> &str {
    path.split('/').next().unwrap_or(path)
}
