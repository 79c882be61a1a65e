//! A fault of the bench: what a tool or the disk refused, with the specimen and the part of the recording.
//!
//! Stands on: the tools' own messages. Never knows: how it is shown.

use std::path::Path;

/// Why a recording failed. Its text has three parts: what and where, why, and the next move.
#[derive(Debug)]
pub struct Fault {
    place: String,
    said: String,
}

impl Fault {
    /// What `said` about `place` (a specimen, or a specimen and its trial); `said` has its own why and next move.
    pub fn at(place: impl Into<String>, said: impl std::fmt::Display) -> Self {
        Self { place: place.into(), said: said.to_string() }
    }

    /// A fault of the bench itself, in three parts.
    pub fn new(place: impl Into<String>, what: &str, why: &str, act: &str) -> Self {
        Self::at(place, format!("{what}\n  why: {why}\n  do:  {act}"))
    }

    /// A file that could not be written or read.
    pub fn io(file: &Path, error: &std::io::Error) -> Self {
        let why = error.to_string().to_lowercase();
        let place = file.display().to_string();
        Self::new(place, "the file cannot be used", &why, "check the permissions and the free space of its folder")
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.place, self.said)
    }
}

impl std::error::Error for Fault {}
