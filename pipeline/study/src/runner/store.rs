//! The store: records on disk, written whole or not at all, and verified when read.
//!
//! A record is written under another name, synced and renamed. A kill at any instant leaves the old record, or the new
//! one, or none; never half a file under a record's name.
//!
//! Stands on: folders, manifest. Never knows: what a record says.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use super::folders::Folders;
use super::hashes::Hashes;
use super::manifest::{FILE, Manifest};
use crate::fault::{Fault, Outcome};
use crate::needs::{Id, Shelf};
use crate::record::Parcel;

/// The records of one profile.
pub struct Store<'a> {
    folders: &'a Folders,
}

/// What lies where a record should be.
pub enum Found {
    /// Nothing.
    Nothing,
    /// A record whose bytes are those that were written.
    Whole(Box<Manifest>),
    /// A record that cannot be trusted, and why.
    Damaged(String),
}

impl Found {
    /// What stands beside a record that can be trusted.
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

    /// Looks at a record and checks each of its files against its hash.
    pub fn look(&self, id: &Id) -> Found {
        self.look_by(id, &Hashes::default())
    }

    /// Looks at a record and checks each of its files against its hash, as `hashes` have it.
    pub fn look_by(&self, id: &Id, hashes: &Hashes) -> Found {
        let folder = self.folders.record(id);
        let text = match fs::read(folder.join(FILE)) {
            Ok(text) => text,
            Err(e) if e.kind() == io::ErrorKind::NotFound && !folder.exists() => return Found::Nothing,
            Err(e) => return Found::Damaged(format!("its {FILE} cannot be read ({e})")),
        };
        let manifest: Manifest = match serde_json::from_slice(&text) {
            Ok(manifest) => manifest,
            Err(e) => return Found::Damaged(format!("its {FILE} is not understood ({e})")),
        };
        match first_damage(&folder, &manifest, hashes) {
            Some(damage) => Found::Damaged(damage),
            None => Found::Whole(Box::new(manifest)),
        }
    }

    /// Writes a record in one step.
    ///
    /// # Errors
    /// A [`Fault`] when the disk refuses, with the record that was there before left in place.
    pub fn write(&self, id: &Id, manifest: &Manifest, parcel: &Parcel) -> Outcome<()> {
        self.write_whole(id, manifest, parcel).map_err(|e| {
            Fault::new(
                format!("record `{id}` cannot be written to {}", self.folders.tell(&self.folders.record(id))),
                e,
                "free some disk space or mend the folder's permissions, then run again; finished records are kept",
            )
        })
    }

    fn write_whole(&self, id: &Id, manifest: &Manifest, parcel: &Parcel) -> io::Result<()> {
        let unfinished = self.folders.unfinished(id);
        remove(&unfinished)?;
        fs::create_dir_all(&unfinished)?;
        for (name, bytes) in parcel.files().chain(parcel.clocks()) {
            write_synced(&unfinished.join(name), bytes)?;
        }
        let text = serde_json::to_string_pretty(manifest).map_err(io::Error::other)?;
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

impl Shelf for Store<'_> {
    fn parcel(&self, id: &Id) -> Outcome<Parcel> {
        let folder = self.folders.record(id);
        match self.look(id) {
            Found::Whole(manifest) => manifest.files.keys().try_fold(Parcel::default(), |parcel, name| {
                let bytes = fs::read(folder.join(name)).map_err(|e| gone(id, &e.to_string()))?;
                Ok(parcel.file(name, bytes))
            }),
            Found::Nothing => Err(gone(id, "there is no such record")),
            Found::Damaged(damage) => Err(gone(id, &damage)),
        }
    }
}

/// Writes a file's bytes and waits until the disk has them.
pub fn write_synced(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = fs::File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// Lays a file under its name in one step, for readers outside the house.
pub fn write_at_once(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".unfinished");
    let unfinished = path.with_file_name(name);
    write_synced(&unfinished, bytes)?;
    fs::rename(&unfinished, path)
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

fn gone(id: &Id, why: &str) -> Fault {
    Fault::new(format!("record `{id}` cannot be used"), why, format!("study run {}", id.stage))
}
