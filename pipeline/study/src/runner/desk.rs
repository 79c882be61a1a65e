//! The desk laid out for one running stage: its recordings, its stopwatch, its progress line.
//!
//! Stands on: folders, report. Never knows: what the stage does.

use std::fs;
use std::time::Instant;

use track::video::Film;

use super::folders::Folders;
use super::report::Line;
use crate::fault::{Fault, Outcome};
use crate::stage::{Desk, RawFile};

/// A stage's view of the world while it runs.
pub struct Laid<'a> {
    folders: &'a Folders,
    raw: &'a [RawFile],
    began: Instant,
    line: Line,
}

impl<'a> Laid<'a> {
    /// A desk with these recordings on it; the stopwatch starts.
    pub fn new(folders: &'a Folders, raw: &'a [RawFile], line: Line) -> Self {
        Self { folders, raw, began: Instant::now(), line }
    }

    fn file(&self, word: &str) -> Outcome<&RawFile> {
        self.raw.iter().find(|file| file.word == word).ok_or_else(|| {
            Fault::new(format!("no recording is called `{word}` here"), "the stage did not name it", "report it")
        })
    }
}

impl Desk for Laid<'_> {
    fn bytes(&self, word: &str) -> Outcome<Vec<u8>> {
        let path = self.folders.raw_file(&self.file(word)?.place);
        fs::read(&path).map_err(|e| {
            let what = format!("{} cannot be read", self.folders.tell(&path));
            Fault::new(what, e, "put the file there, or correct its name on the card")
        })
    }

    fn film(&self, word: &str) -> Outcome<Film> {
        Film::open(&self.folders.raw_file(&self.file(word)?.place)).map_err(Fault::from_tool)
    }

    fn place(&self, word: &str) -> String {
        self.file(word).map_or_else(|_| word.into(), |f| self.folders.tell(&self.folders.raw_file(&f.place)))
    }

    fn seconds(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    fn progress(&self, part: f64, at: &str) {
        self.line.progress(part, at);
    }
}
