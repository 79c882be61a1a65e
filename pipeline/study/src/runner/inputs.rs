//! Inputs: what a record would be made from right now, as hashes and values, and whether what lies there still fits.
//!
//! Stands on: store, manifest, verdict. Never knows: how a record is made.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::Runner;
use super::graph::Job;
use super::hashes::Hashes;
use super::manifest::{MadeFrom, Manifest};
use super::store::{Found, Store};
use super::verdict::differences;
use crate::fault::{Fault, Outcome};
use crate::needs::Id;
use crate::stage::RawFile;

/// Whether a record is as it should be.
pub enum State {
    /// It is.
    Kept(Box<Manifest>),
    /// It is not, for these reasons.
    Stale(Vec<String>),
    /// Its bytes are not those that were written.
    Damaged(String),
}

/// The ingredients of a job, with the content of each record that it reads.
///
/// # Errors
/// A [`Fault`] when the ingredients cannot be said or a recording is missing.
pub fn made_from(runner: &Runner, job: &Job, contents: &BTreeMap<Id, String>, hashes: &Hashes) -> Outcome<MadeFrom> {
    let ingredients = job.ingredients.as_ref().map_err(|fault| fault.clone().of(&job.id))?;
    let mut raw = BTreeMap::new();
    for file in &ingredients.raw {
        raw.insert(file.place.clone(), hash(runner, file, hashes).map_err(|fault| fault.of(&job.id))?);
    }
    let content = |id: &Id| (id.to_string(), contents.get(id).cloned().unwrap_or_default());
    Ok(MadeFrom {
        edition: job.entry.edition,
        raw,
        card: ingredients.card.clone(),
        settings: ingredients.settings.clone(),
        records: ingredients.records.iter().map(content).collect(),
    })
}

/// Compares what lies on disk with what a job would be made from now.
pub fn state(runner: &Runner, job: &Job, now: &MadeFrom, hashes: &Hashes) -> State {
    judged(Store::new(&runner.folders).look_by(&job.id, hashes), now)
}

/// Compares what was found with what a job would be made from now.
pub fn judged(found: Found, now: &MadeFrom) -> State {
    match found {
        Found::Nothing => State::Stale(vec!["it was never made".into()]),
        Found::Damaged(damage) => State::Damaged(damage),
        Found::Whole(manifest) if manifest.key == now.key() => State::Kept(manifest),
        Found::Whole(manifest) => State::Stale(differences(&manifest.made_from, now)),
    }
}

fn hash(runner: &Runner, file: &RawFile, hashes: &Hashes) -> Outcome<String> {
    let path = runner.folders.raw_file(&file.place);
    let read = if path.is_dir() { hash_folder(&path, hashes) } else { hashes.of(&path) };
    match read {
        Ok(hash) => Ok(hash),
        Err(e) if file.optional && e.kind() == std::io::ErrorKind::NotFound => Ok("absent".into()),
        Err(e) => Err(Fault::new(
            format!("the {} {} cannot be read", file.word, runner.folders.tell(&path)),
            format!("the card of `{}` names it, and the system says: {e}", job_specimen(&file.place)),
            "put the file there, or correct its name on the card",
        )),
    }
}

/// Of a folder of pictures: names and contents of its files, in the order of their names.
fn hash_folder(path: &Path, hashes: &Hashes) -> std::io::Result<String> {
    let entries = std::fs::read_dir(path)?.map(|entry| entry.map(|e| e.path()));
    let mut files = entries.collect::<std::io::Result<Vec<PathBuf>>>()?;
    files.sort();
    let mut whole = blake3::Hasher::new();
    for file in files.iter().filter(|file| file.is_file()) {
        whole.update(file.file_name().unwrap_or_default().as_encoded_bytes()).update(hashes.of(file)?.as_bytes());
    }
    Ok(whole.finalize().to_hex().to_string())
}

fn job_specimen(place: &str) -> &str {
    place.split('/').next().unwrap_or(place)
}
