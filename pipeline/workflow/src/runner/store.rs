//! The store: records on disk, written whole or not at all, and verified when read.
//!
//! A record is written under another name, synced and renamed. A kill at any instant leaves the old record, or the new
//! one, or none; never half a file under a record's name.

use std::fs;
use std::io;
use std::path::Path;

use super::atomic::write_synced;
use super::folders::Folders;
use super::hashes::Hashes;
use super::manifest::{FILE, Manifest};
use crate::needs::{RecordId, RecordReader};
use crate::record::RecordFiles;
use diagnostics::{Diagnostic, Result};

/// The records of one profile.
pub struct Store<'a> {
    folders: &'a Folders,
}

/// The state of a record on disk.
pub enum Found {
    /// Nothing.
    Nothing,
    /// A record whose bytes are those that were written.
    Whole(Box<Manifest>),
    /// A damaged record, and why.
    Damaged(String),
}

impl Found {
    /// The manifest of a whole record.
    pub fn manifest(&self) -> Option<&Manifest> {
        match self {
            Self::Whole(manifest) => Some(manifest),
            Self::Nothing | Self::Damaged(_) => None,
        }
    }
}

impl<'a> Store<'a> {
    /// The store in these folders.
    pub fn new(folders: &'a Folders) -> Self {
        Self { folders }
    }

    /// Finds a record and checks each of its files against its hash.
    pub fn find(&self, id: &RecordId) -> Found {
        self.find_with(id, &Hashes::default())
    }

    /// Finds a record and checks each of its files against its hash, as `hashes` have it.
    pub(crate) fn find_with(&self, id: &RecordId, hashes: &Hashes) -> Found {
        let folder = self.folders.record(id);
        let text = match fs::read_to_string(folder.join(FILE)) {
            Ok(text) => text,
            Err(e) if e.kind() == io::ErrorKind::NotFound && !folder.exists() => return Found::Nothing,
            Err(e) => return Found::Damaged(format!("its {FILE} cannot be read ({e})")),
        };
        let manifest = match Manifest::parse(&text) {
            Ok(manifest) => manifest,
            Err(damage) => return Found::Damaged(damage),
        };
        match first_damage(&folder, &manifest, hashes) {
            Some(damage) => Found::Damaged(damage),
            None => Found::Whole(Box::new(manifest)),
        }
    }

    /// Writes a record in one step.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it cannot be written; the former record then remains in place.
    pub fn write(&self, id: &RecordId, manifest: &Manifest, files: &RecordFiles) -> Result<()> {
        self.write_whole(id, manifest, files).map_err(|e| {
            Diagnostic::new(
                format!("record `{id}` cannot be written to {}", self.folders.display(&self.folders.record(id))),
                e,
                "free some disk space or correct the folder's permissions, then run again; finished records are kept",
            )
        })
    }

    fn write_whole(&self, id: &RecordId, manifest: &Manifest, files: &RecordFiles) -> io::Result<()> {
        let unfinished = self.folders.unfinished(id);
        remove(&unfinished)?;
        fs::create_dir_all(&unfinished)?;
        for (name, bytes) in files.contents().chain(files.durations_files()) {
            write_synced(&unfinished.join(name), bytes)?;
        }
        let text = manifest.to_text().map_err(io::Error::other)?;
        write_synced(&unfinished.join(FILE), text.as_bytes())?;
        let (record, outdated) = (self.folders.record(id), self.folders.outdated(id));
        remove(&outdated)?;
        if record.exists() {
            fs::rename(&record, &outdated)?;
        }
        fs::rename(&unfinished, &record)?;
        remove(&outdated)
    }
}

impl RecordReader for Store<'_> {
    fn files(&self, id: &RecordId) -> Result<RecordFiles> {
        let folder = self.folders.record(id);
        match self.find(id) {
            Found::Whole(manifest) => manifest.files.keys().try_fold(RecordFiles::default(), |files, name| {
                let bytes = fs::read(folder.join(name)).map_err(|e| gone(id, &e.to_string()))?;
                Ok(files.file(name, bytes))
            }),
            Found::Nothing => Err(gone(id, "there is no such record")),
            Found::Damaged(damage) => Err(gone(id, &damage)),
        }
    }
}

fn first_damage(folder: &Path, manifest: &Manifest, hashes: &Hashes) -> Option<String> {
    manifest.files.iter().find_map(|(name, hash)| match hashes.of(&folder.join(name)) {
        Ok(now) if now == *hash => None,
        Ok(_) => Some(format!("the bytes of its {name} are not those that were written")),
        Err(e) => Some(format!("its {name} cannot be read ({e})")),
    })
}

fn remove(folder: &Path) -> io::Result<()> {
    match fs::remove_dir_all(folder) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

fn gone(id: &RecordId, why: &str) -> Diagnostic {
    Diagnostic::new(format!("record `{id}` cannot be used"), why, format!("study run {}", id.stage))
}
