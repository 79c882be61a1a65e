//! Records: the results of stages, as typed values with a stable form in bytes.
//!
//! A record is a set of named files (Parquet tables, JSON scalars, VTU meshes, SVG pictures). Its content hash is the BLAKE3
//! of those files, so that a stage run again with the same result leaves all later records up to date.

use std::collections::BTreeMap;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::columns::{Columns, ColumnsError};
use crate::metric::Metric;
use crate::subject::Subject;

/// A record.
pub trait Record: Sized + Send + Sync {
    /// The type of its subject: a study, a specimen or a trial.
    type Of: Subject;
    /// The stage that makes it.
    const STAGE: &'static str;

    /// The record as files.
    ///
    /// # Errors
    /// [`RecordError`] when a table cannot be written.
    fn to_files(&self) -> Result<RecordFiles, RecordError>;

    /// The record from its files.
    ///
    /// # Errors
    /// [`RecordError`] when a file is absent or is not what [`Record::to_files`] writes.
    fn from_files(files: &RecordFiles) -> Result<Self, RecordError>;

    /// Whether there is such a record of this subject at all (a validation exists of validation trials only).
    fn is_made_for(subject: &Self::Of) -> bool {
        let _ = subject;
        true
    }

    /// The numbers that are published with this record, under the name of its subject. They depend on nothing else: they are computed
    /// with the record and kept with it.
    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let _ = subject;
        Vec::new()
    }

    /// The summary that the runner prints when the record is made.
    fn summary(&self) -> String {
        String::new()
    }
}

/// An error of a record's files.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordError {
    /// A file that should be in the record is not.
    #[error("the record has no file `{0}`")]
    Absent(String),
    /// A table is not as expected.
    #[error(transparent)]
    Table(#[from] ColumnsError),
    /// A JSON file is not as expected.
    #[error("`{file}` is not what this version writes: {cause}")]
    Scalars {
        /// Which file.
        file: String,
        /// The parser's message.
        cause: String,
    },
}

/// A record's files by name, in alphabetical order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RecordFiles {
    files: BTreeMap<String, Vec<u8>>,
    durations: BTreeMap<String, Vec<u8>>,
    untimed: BTreeMap<String, Vec<u8>>,
}

impl RecordFiles {
    /// Adds a file.
    pub fn file(mut self, name: &str, bytes: Vec<u8>) -> Self {
        self.files.insert(name.into(), bytes);
        self
    }

    /// Adds a table as Parquet.
    ///
    /// # Errors
    /// [`RecordError::Table`] when its columns differ in length.
    pub fn table(self, name: &str, columns: &Columns) -> Result<Self, RecordError> {
        let bytes = columns.to_parquet()?;
        Ok(self.file(name, bytes))
    }

    /// Adds scalars as JSON.
    ///
    /// # Errors
    /// [`RecordError::Scalars`] when a value has no form in JSON.
    pub fn scalars(self, name: &str, value: &impl Serialize) -> Result<Self, RecordError> {
        let text = serde_json::to_string_pretty(value).map_err(|e| json_error(name, &e))?;
        Ok(self.file(name, (text + "\n").into_bytes()))
    }

    /// Adds durations as JSON: stored with the record, but not part of its content.
    ///
    /// # Errors
    /// [`RecordError::Scalars`] when a value has no form in JSON.
    pub fn durations(mut self, name: &str, value: &impl Serialize) -> Result<Self, RecordError> {
        let text = serde_json::to_string_pretty(value).map_err(|e| json_error(name, &e))?;
        self.durations.insert(name.into(), (text + "\n").into_bytes());
        Ok(self)
    }

    /// Adds a file that prints durations among other things: it is stored as it is, and the content has `untimed` in its place.
    pub(crate) fn timed_file(mut self, name: &str, bytes: Vec<u8>, untimed: Vec<u8>) -> Self {
        self.durations.insert(name.into(), bytes);
        self.untimed.insert(name.into(), untimed);
        self
    }

    /// A file's bytes.
    ///
    /// # Errors
    /// [`RecordError::Absent`] when there is none of that name.
    pub fn bytes(&self, name: &str) -> Result<&[u8], RecordError> {
        let bytes = self.files.get(name).or_else(|| self.durations.get(name));
        bytes.map(Vec::as_slice).ok_or_else(|| RecordError::Absent(name.into()))
    }

    /// A table.
    ///
    /// # Errors
    /// [`RecordError`] when it is absent or not Parquet.
    pub fn read_table(&self, name: &str) -> Result<Columns, RecordError> {
        Ok(Columns::from_parquet(self.bytes(name)?)?)
    }

    /// Scalars.
    ///
    /// # Errors
    /// [`RecordError`] when they are absent or of another form.
    pub fn read_scalars<T: DeserializeOwned>(&self, name: &str) -> Result<T, RecordError> {
        serde_json::from_slice(self.bytes(name)?).map_err(|e| json_error(name, &e))
    }

    /// The files of the content, by name.
    pub fn contents(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
    }

    /// What the content has in the place of files that print durations, by name.
    pub(crate) fn untimed(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.untimed.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
    }

    /// The files of durations, by name.
    pub(crate) fn durations_files(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.durations.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
    }
}

fn json_error(file: &str, cause: &serde_json::Error) -> RecordError {
    RecordError::Scalars { file: file.into(), cause: cause.to_string() }
}
