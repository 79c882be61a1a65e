//! A stage of the workflow: it receives the subject's part of the card, its settings and records, and makes one record.
//!
//! A stage opens no file, prints nothing and reads no clock: raw files, progress and elapsed time come from its [`StageContext`].
//! It does not receive its subject, only the part [`Stage::Card`] of it, so that its inputs and the key of its record cannot differ.

use std::path::PathBuf;

use diagnostics::Result;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::needs::Needs;
use crate::record::Record;
use crate::subject::Part;

/// One stage of the workflow.
pub trait Stage {
    /// Its section of the settings.
    type Settings: Serialize + DeserializeOwned;
    /// The part of the card that it reads; its serialised form is part of the record's key.
    type Card: Part<<Self::Makes as Record>::Of>;
    /// The records that it reads.
    type Needs: Needs<<Self::Makes as Record>::Of>;
    /// The record that it makes.
    type Makes: Record;
    /// One phrase that describes the stage.
    const DESCRIPTION: &'static str;
    /// Increased when the same inputs give another record.
    const VERSION: u32;

    /// Its section in the settings: its own, or that of a stage whose settings it shares.
    const SECTION: &'static str = Self::Makes::STAGE;

    /// The raw files that it reads.
    fn raw(subject: &<Self::Makes as Record>::Of) -> Vec<RawFile> {
        let _ = subject;
        Vec::new()
    }

    /// Makes the record.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] with what, why and the next action.
    fn run(
        card: &Self::Card,
        settings: &Self::Settings,
        needs: Self::Needs,
        context: &dyn StageContext,
    ) -> Result<Self::Makes>;
}

/// A raw file, by the stage's own name for it and its path below the folder of raw files.
#[derive(Debug, Clone, PartialEq)]
pub struct RawFile {
    /// The stage's own name: "body", "video".
    pub name: String,
    /// Relative to the folder of raw files, with `/` between folders.
    pub path: String,
    /// Whether the stage can do without it.
    pub optional: bool,
}

impl RawFile {
    /// A file that must exist.
    pub fn new(name: &str, folder: &str, file: &str) -> Self {
        Self { name: name.into(), path: format!("{folder}/{file}"), optional: false }
    }
}

/// The interface of a running stage to the runner.
pub trait StageContext: Sync {
    /// A raw file's bytes.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when it is missing or cannot be read.
    fn bytes(&self, name: &str) -> Result<Vec<u8>>;

    /// The path of a raw file, for a decoder that opens it itself.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when the stage did not declare it.
    fn path(&self, name: &str) -> Result<PathBuf>;

    /// A raw file's path as a user would type it, for messages.
    fn display_path(&self, name: &str) -> String;

    /// Seconds since the stage began.
    fn seconds(&self) -> f64;

    /// Processor time of this thread, s, whatever else the machine does: for what runs on one core.
    fn thread_seconds(&self) -> f64;

    /// Reports progress: a fraction from 0 to 1, and the current step.
    fn progress(&self, fraction: f64, step: &str);
}
