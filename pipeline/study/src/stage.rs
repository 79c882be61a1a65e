//! A stage: it receives records, makes one record, and hands it on.
//!
//! The contract of `stages/`. A stage opens no file, prints nothing and keeps no time: raw recordings, progress and the
//! stopwatch come over its [`Desk`], which the runner lays out.
//!
//! Stands on: record, needs, subject, settings. Never knows: a path, another stage's code.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::fault::Outcome;
use crate::needs::Needs;
use crate::record::Record;

/// One stage of the pipeline.
pub trait Stage {
    /// What stands in its section of `study.toml`.
    type Settings: Serialize + DeserializeOwned;
    /// The records that it reads.
    type Needs: Needs<<Self::Makes as Record>::Of>;
    /// The record that it makes.
    type Makes: Record;
    /// One sentence: what becomes what.
    const STORY: &'static str;
    /// Counted up when the same inputs give another record than before.
    const EDITION: u32;

    /// Its section in `study.toml`: its own, or that of a stage whose settings it shares.
    const SECTION: &'static str = Self::Makes::STAGE;

    /// The raw recordings that it reads.
    fn raw(of: &<Self::Makes as Record>::Of) -> Vec<RawFile> {
        let _ = of;
        Vec::new()
    }

    /// The part of the card that it reads: a change elsewhere on the card leaves its record fresh.
    fn card(of: &<Self::Makes as Record>::Of) -> serde_json::Value {
        let _ = of;
        serde_json::Value::Null
    }

    /// Makes the record.
    ///
    /// # Errors
    /// A [`crate::fault::Fault`] that says what, why, and what to do.
    fn run(
        of: &<Self::Makes as Record>::Of,
        settings: &Self::Settings,
        needs: Self::Needs,
        desk: &dyn Desk,
    ) -> Outcome<Self::Makes>;
}

/// A raw recording, by the word that the stage uses for it and its place in `data/raw`.
#[derive(Debug, Clone, PartialEq)]
pub struct RawFile {
    /// The stage's own word: "body", "video".
    pub word: String,
    /// Relative to `data/raw`, with `/` between folders.
    pub place: String,
    /// Whether the stage can do without it.
    pub optional: bool,
}

impl RawFile {
    /// A recording that must be there.
    pub fn new(word: &str, folder: &str, name: &str) -> Self {
        Self { word: word.into(), place: format!("{folder}/{name}"), optional: false }
    }
}

/// What the runner lays out for a running stage.
pub trait Desk: Sync {
    /// A raw recording's bytes.
    ///
    /// # Errors
    /// A [`crate::fault::Fault`] when it is not there or cannot be read.
    fn bytes(&self, word: &str) -> Outcome<Vec<u8>>;

    /// A raw film, ready to be read frame by frame.
    ///
    /// # Errors
    /// A [`crate::fault::Fault`] when it is not there or is no film.
    fn film(&self, word: &str) -> Outcome<track::video::Film>;

    /// A raw recording's place as a person would write it, for messages.
    fn place(&self, word: &str) -> String;

    /// Seconds since the stage began.
    fn seconds(&self) -> f64;

    /// Says how far the stage is: from 0 to 1, and at what.
    fn progress(&self, part: f64, at: &str);
}
