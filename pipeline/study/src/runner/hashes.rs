//! Hashes: the BLAKE3 of each file, and what a run remembers of them so that a plan need not read every film again.
//!
//! A run reads every byte that it relies on, whatever a file's date says, and writes down what it saw. A plan believes that a
//! file of the same length and date as then has the same bytes; it decides nothing but what it prints.
//!
//! Stands on: blake3. Never knows: what a file is for.

use std::collections::{BTreeMap, HashMap};
use std::fs::{self, File, Metadata};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};

use super::store::write_at_once;

/// What was seen of a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Seen {
    length: u64,
    /// ns since 1970.
    date: u64,
    hash: String,
}

impl Seen {
    /// Whether length and date are those of `now`.
    fn fits(&self, now: &Self) -> bool {
        (self.length, self.date) == (now.length, now.date)
    }
}

/// The hashes of files.
#[derive(Debug, Default)]
pub struct Hashes {
    seen: Mutex<BTreeMap<PathBuf, Seen>>,
    /// By path; believed.
    remembered: HashMap<String, Seen>,
}

impl Hashes {
    /// Those that a run wrote at `place`, believed where length and date fit; none where there are none.
    pub fn remembered(place: &Path) -> Self {
        Self { remembered: written(place), ..Self::default() }
    }

    /// The hash of a file's bytes, as hexadecimal digits.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn of(&self, path: &Path) -> io::Result<String> {
        let now = seen(&fs::metadata(path)?);
        if let Some(hash) = self.known(path, &now) {
            return Ok(hash);
        }
        let mut hasher = blake3::Hasher::new();
        let hash = hasher.update_reader(File::open(path)?)?.finalize().to_hex().to_string();
        self.lock().insert(path.to_path_buf(), Seen { hash: hash.clone(), ..now });
        Ok(hash)
    }

    /// Writes what was seen, for plans to come, beside what was written there of other files that are as they were: a run of a part
    /// forgets nothing of the rest.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn write(&self, place: &Path) -> io::Result<()> {
        let mut all: BTreeMap<PathBuf, Seen> =
            written(place).into_iter().map(|(path, then)| (PathBuf::from(path), then)).collect();
        all.retain(|path, then| fs::metadata(path).is_ok_and(|now| then.fits(&seen(&now))));
        all.append(&mut self.lock().clone());
        let text = serde_json::to_vec(&all).map_err(io::Error::other)?;
        write_at_once(place, &text)
    }

    fn known(&self, path: &Path, now: &Seen) -> Option<String> {
        let then = self.remembered.get(path.to_str()?)?;
        then.fits(now).then(|| then.hash.clone())
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<PathBuf, Seen>> {
        self.seen.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// What a run wrote at `place`; nothing where that cannot be read.
fn written(place: &Path) -> HashMap<String, Seen> {
    fs::read(place).ok().and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default()
}

fn seen(of: &Metadata) -> Seen {
    let date = of.modified().ok().and_then(|date| date.duration_since(UNIX_EPOCH).ok());
    Seen { length: of.len(), date: date.map_or(0, |d| d.as_nanos() as u64), hash: String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_of_a_part_forgets_nothing_of_the_rest_but_what_has_changed() {
        let folder = std::env::temp_dir().join(format!("hashes_{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let [place, first, second, third] = ["hashes.json", "first", "second", "third"].map(|name| folder.join(name));
        for file in [&first, &second, &third] {
            fs::write(file, "as it was").unwrap();
        }
        let whole = Hashes::default();
        let hash = [&first, &second, &third].map(|file| whole.of(file).unwrap())[0].clone();
        whole.write(&place).unwrap();
        fs::write(&third, "longer than it was").unwrap();
        let part = Hashes::default();
        part.of(&first).unwrap();
        part.write(&place).unwrap();
        let remembered = Hashes::remembered(&place);
        let known = |file: &Path| remembered.known(file, &seen(&fs::metadata(file).unwrap()));
        assert_eq!([&first, &second, &third].map(|file| known(file)), [Some(hash.clone()), Some(hash), None]);
        assert_eq!(remembered.remembered.len(), 2, "what has changed is not kept");
        fs::remove_dir_all(&folder).unwrap();
    }
}
