//! The store: records on disk, written whole or not at all, and verified when read.
//!
//! A record is written under another name, synced and renamed. A kill at any instant leaves the old record, or the new
//! one, or none; never half a file under a record's name. A reader compares the bytes that it has read with their hashes, and reads again
//! where another process has replaced the record meanwhile.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;
use std::time::Duration;

use super::atomic::write_synced;
use super::folders::Folders;
use super::hashes::Hashes;
use super::lock::Lock;
use super::manifest::{FILE, Manifest, Sealed, parse};
use super::usage::{Measured, Usage};
use crate::needs::{RecordId, RecordReader};
use crate::record::RecordFiles;
use diagnostics::{Diagnostic, Result, input};

/// Number and interval of readings of a record that another process is replacing: two renames on a busy file server.
const TRIES: usize = 40;
const PAUSE: Duration = Duration::from_millis(50);

/// The records of one profile.
pub struct Store<'a> {
    folders: &'a Folders,
}

/// A record's manifest and files.
type Whole<'a> = (&'a Manifest, &'a RecordFiles);

/// The state of a record on disk.
pub enum Found<M = Manifest> {
    /// Nothing.
    Nothing,
    /// A record whose bytes are those that were written.
    Whole(Box<M>),
    /// A damaged record, and why.
    Damaged(String),
}

impl<M> Found<M> {
    /// The manifest of a whole record.
    pub fn manifest(&self) -> Option<&M> {
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
    pub(crate) fn find_with<M: Sealed>(&self, id: &RecordId, hashes: &Hashes) -> Found<M> {
        let folder = self.folders.record(id);
        let manifest = match read_manifest(&folder) {
            Ok(Some(manifest)) => manifest,
            Ok(None) => return Found::Nothing,
            Err(damage) => return Found::Damaged(damage),
        };
        match first_damage(&folder, &manifest, hashes) {
            Some(damage) => Found::Damaged(damage),
            None => Found::Whole(Box::new(manifest)),
        }
    }

    /// What a record's making used; none where there is no record. Its files are not read.
    pub(crate) fn measured(&self, id: &RecordId) -> Option<Measured> {
        let manifest: Manifest = read_manifest(&self.folders.record(id)).ok()??;
        let (Usage { cpu_seconds, peak_memory, .. }, seconds) = (manifest.usage, manifest.seconds);
        Some(Measured { seconds, cpu_seconds, peak_memory })
    }

    /// Writes a record in one step, unless its lock was lost.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it cannot be written; the former record then remains in place.
    pub(crate) fn write(&self, id: &RecordId, (manifest, files): Whole<'_>, lock: &Lock<'_>) -> Result<()> {
        self.write_whole(id, (manifest, files), lock).map_err(|e| {
            Diagnostic::new(
                format!("record `{id}` cannot be written to {}", self.folders.display(&self.folders.record(id))),
                e,
                "free some disk space or correct the folder's permissions, then run again; finished records are kept",
            )
        })
    }

    fn write_whole(&self, id: &RecordId, (manifest, files): Whole<'_>, lock: &Lock<'_>) -> io::Result<()> {
        let unfinished = self.folders.unfinished(id);
        remove_folder(&unfinished)?;
        fs::create_dir_all(&unfinished)?;
        for (name, bytes) in files.contents().chain(files.durations_files()) {
            write_synced(&unfinished.join(name), bytes)?;
        }
        let text = manifest.to_text().map_err(io::Error::other)?;
        write_synced(&unfinished.join(FILE), text.as_bytes())?;
        if !lock.is_held() {
            return Err(io::Error::other("this process gave no sign of life for so long that another took its place"));
        }
        let (record, outdated) = (self.folders.record(id), self.folders.outdated(id));
        remove_folder(&outdated)?;
        if record.exists() {
            fs::rename(&record, &outdated)?;
        }
        fs::rename(&unfinished, &record)?;
        remove_folder(&outdated)
    }
}

impl Store<'_> {
    /// A record's content and files.
    fn read_record(&self, id: &RecordId) -> Result<(String, RecordFiles)> {
        let locked = || self.folders.record_lock(id).exists();
        let mut reason = String::new();
        for _ in 0..TRIES {
            let was_locked = locked();
            match self.read_once(id) {
                Ok(read) => return Ok(read),
                Err(e) => reason = e,
            }
            if !was_locked && !locked() {
                break;
            }
            std::thread::sleep(PAUSE);
        }
        Err(unusable_record(id, &reason))
    }

    fn read_once(&self, id: &RecordId) -> Result<(String, RecordFiles), String> {
        let folder = self.folders.record(id);
        let manifest: Manifest = read_manifest(&folder)?.ok_or("there is no such record")?;
        let read = |files: RecordFiles, (name, hash): (&String, &String)| {
            let bytes = input::read(&folder.join(name), input::MESH);
            let bytes = bytes.map_err(|e| format!("its {name} cannot be read ({e})"))?;
            let intact = *blake3::hash(&bytes).to_hex() == **hash;
            intact.then(|| files.file(name, bytes)).ok_or_else(|| other_bytes(name))
        };
        let files = manifest.files.iter().try_fold(RecordFiles::default(), read)?;
        Ok((manifest.content, files))
    }
}

impl RecordReader for Store<'_> {
    fn files(&self, id: &RecordId) -> Result<RecordFiles> {
        Ok(self.read_record(id)?.1)
    }
}

/// The records that a record is keyed by: of each, the content that the key holds and no other.
pub(crate) struct KeyedReader<'a> {
    /// Where they lie.
    pub store: &'a Store<'a>,
    /// The content of each.
    pub contents: &'a BTreeMap<RecordId, String>,
}

impl RecordReader for KeyedReader<'_> {
    fn files(&self, id: &RecordId) -> Result<RecordFiles> {
        let (content, files) = self.store.read_record(id)?;
        let same = self.contents.get(id).is_some_and(|expected| *expected == content);
        same.then_some(files).ok_or_else(|| {
            let problem = format!("record `{id}` was replaced while its reader was being made");
            Diagnostic::new(problem, "another run made it again to another content", "run again")
        })
    }
}

/// The manifest in a record's folder; none where there is no record, or an empty folder: a workflow engine makes that before its job.
fn read_manifest<M: Sealed>(folder: &Path) -> Result<Option<M>, String> {
    let empty = || fs::read_dir(folder).map_or(!folder.exists(), |mut entries| entries.next().is_none());
    match input::read_text(&folder.join(FILE), input::LOG) {
        Ok(text) => parse(&text).map(Some),
        Err(e) if e.kind() == io::ErrorKind::NotFound && empty() => Ok(None),
        Err(e) => Err(format!("its {FILE} cannot be read ({e})")),
    }
}

fn first_damage(folder: &Path, manifest: &impl Sealed, hashes: &Hashes) -> Option<String> {
    manifest.files().iter().find_map(|(name, hash)| match hashes.of(&folder.join(name)) {
        Ok(now) if now == *hash => None,
        Ok(_) => Some(other_bytes(name)),
        Err(e) => Some(format!("its {name} cannot be read ({e})")),
    })
}

fn other_bytes(name: &str) -> String {
    format!("the bytes of its {name} are not those that were written")
}

fn remove_folder(folder: &Path) -> io::Result<()> {
    match fs::remove_dir_all(folder) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

fn unusable_record(id: &RecordId, reason: &str) -> Diagnostic {
    Diagnostic::new(format!("record `{id}` cannot be used"), reason, format!("study run {}", id.stage))
}
