//! Hashes: the BLAKE3 of each file, and a cache of them written by runs so that a plan need not read every film again.
//!
//! A run hashes every byte that it reads, whatever the date of a file, and records the hashes. A plan takes a file of unchanged length
//! and date as unchanged: a wrong date would change only what it prints, while a run decides what is published and may not depend on
//! dates, which copies and version control rewrite.

use std::collections::{BTreeMap, HashMap};
use std::fs::{self, File, Metadata};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::UNIX_EPOCH;

use diagnostics::input;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::atomic::write_atomically;

/// Length, date and hash of a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Fingerprint {
    length: u64,
    /// ns since 1970.
    date: u64,
    hash: String,
}

impl Fingerprint {
    /// Whether length and date are those of `now`.
    fn is_unchanged(&self, now: &Self) -> bool {
        (self.length, self.date) == (now.length, now.date)
    }
}

/// The hashes of files.
#[derive(Debug, Default)]
pub struct Hashes {
    fingerprints: Mutex<BTreeMap<PathBuf, Fingerprint>>,
    /// Of an earlier run, by path.
    cached: HashMap<String, Fingerprint>,
}

impl Hashes {
    /// Those that a run wrote at `path` and those of single records at the `further` paths, used where length and date are equal; none where
    /// a file does not exist.
    pub(crate) fn from_caches(path: &Path, further: impl ParallelIterator<Item = PathBuf>) -> Self {
        let of_records = || further.map(|path| read_fingerprints(&path)).collect::<Vec<_>>();
        let (mut cached, of_records) = rayon::join(|| read_fingerprints(path), of_records);
        cached.extend(of_records.into_iter().flatten());
        Self { cached, ..Self::default() }
    }

    /// The hash of a file's bytes, as hexadecimal digits.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn of(&self, path: &Path) -> io::Result<String> {
        let metadata = fs::metadata(path)?;
        // A FIFO would never end.
        input::regular_file(&metadata)?;
        let now = fingerprint_of(&metadata);
        if let Some(hash) = self.cached_hash(path, &now) {
            return Ok(hash);
        }
        let mut hasher = blake3::Hasher::new();
        let hash = hasher.update_reader(File::open(path)?)?.finalize().to_hex().to_string();
        self.lock_fingerprints().insert(path.to_path_buf(), Fingerprint { hash: hash.clone(), ..now });
        Ok(hash)
    }

    /// Writes the hashes for later plans and keeps those of other unchanged files: a run of a part of the project does not remove the
    /// others.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        let mut fingerprints: BTreeMap<PathBuf, Fingerprint> =
            read_fingerprints(path).into_iter().map(|(path, then)| (PathBuf::from(path), then)).collect();
        fingerprints.retain(|path, then| fs::metadata(path).is_ok_and(|now| then.is_unchanged(&fingerprint_of(&now))));
        fingerprints.append(&mut self.lock_fingerprints().clone());
        let text = serde_json::to_vec(&fingerprints).map_err(io::Error::other)?;
        write_atomically(path, &text)
    }

    /// Writes the hashes of these files alone. A process that is killed meanwhile leaves a part, which is read as nothing.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub(crate) fn write_of(&self, files: &[PathBuf], path: &Path) -> io::Result<()> {
        let fingerprints = self.lock_fingerprints();
        let selected: BTreeMap<_, _> = files.iter().filter_map(|file| fingerprints.get_key_value(file)).collect();
        fs::write(path, serde_json::to_vec(&selected).map_err(io::Error::other)?)
    }

    fn cached_hash(&self, path: &Path, now: &Fingerprint) -> Option<String> {
        let then = self.cached.get(path.to_str()?)?;
        then.is_unchanged(now).then(|| then.hash.clone())
    }

    fn lock_fingerprints(&self) -> std::sync::MutexGuard<'_, BTreeMap<PathBuf, Fingerprint>> {
        self.fingerprints.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// The hashes that a run wrote at `path`; empty where they cannot be read.
fn read_fingerprints(path: &Path) -> HashMap<String, Fingerprint> {
    input::read(path, input::LOG).ok().and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default()
}

fn fingerprint_of(metadata: &Metadata) -> Fingerprint {
    let date = metadata.modified().ok().and_then(|date| date.duration_since(UNIX_EPOCH).ok());
    Fingerprint { length: metadata.len(), date: date.map_or(0, |d| d.as_nanos() as u64), hash: String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_of_a_part_forgets_nothing_of_the_rest_but_what_has_changed() {
        let folder = std::env::temp_dir().join(format!("hashes_{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let [path, first, second, third] = ["hashes.json", "first", "second", "third"].map(|name| folder.join(name));
        for file in [&first, &second, &third] {
            fs::write(file, "as it was").unwrap();
        }
        let hashes = Hashes::default();
        let hash = [&first, &second, &third].map(|file| hashes.of(file).unwrap())[0].clone();
        hashes.write(&path).unwrap();
        fs::write(&third, "longer than it was").unwrap();
        let part = Hashes::default();
        part.of(&first).unwrap();
        part.write(&path).unwrap();
        let cached = Hashes::from_caches(&path, rayon::iter::empty());
        let hash_of = |file: &Path| cached.cached_hash(file, &fingerprint_of(&fs::metadata(file).unwrap()));
        assert_eq!([&first, &second, &third].map(|file| hash_of(file)), [Some(hash.clone()), Some(hash), None]);
        assert_eq!(cached.cached.len(), 2, "changed files are not kept");
        fs::remove_dir_all(&folder).unwrap();
    }
}
