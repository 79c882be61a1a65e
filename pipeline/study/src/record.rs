//! Records: what one stage hands to the next, as typed values with a stable form in bytes.
//!
//! A record is written as a parcel of named files (Parquet tables, JSON scalars, VTU meshes, SVG pictures). Its content
//! hash is the BLAKE3 of those files, so that a stage run again to the same result leaves everything behind it fresh.
//!
//! Stands on: columns. Never knows: a path, a disk, the stage that reads it.

use std::collections::BTreeMap;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::columns::{Columns, ColumnsError};
use crate::metric::Metric;
use crate::subject::Scope;

/// The contract of a record.
pub trait Record: Sized + Send + Sync {
    /// What the record is one of: a study, a specimen or a trial.
    type Of: Scope;
    /// The stage that makes it.
    const STAGE: &'static str;

    /// The record as files.
    ///
    /// # Errors
    /// [`RecordError`] when a table cannot be written.
    fn pack(&self) -> Result<Parcel, RecordError>;

    /// The record from its files.
    ///
    /// # Errors
    /// [`RecordError`] when a file is absent or is not what [`Record::pack`] writes.
    fn unpack(parcel: &Parcel) -> Result<Self, RecordError>;

    /// Whether there is such a record of this subject at all (a validation exists of validation trials only).
    fn is_made_for(of: &Self::Of) -> bool {
        let _ = of;
        true
    }

    /// The numbers that leave the house with this record.
    fn metrics(&self, of: &Self::Of) -> Vec<Metric> {
        let _ = of;
        Vec::new()
    }

    /// The one telling number that the runner prints when the record is made.
    fn telling(&self) -> String {
        String::new()
    }
}

/// Why a record's files are not the record.
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
        /// What the parser says.
        cause: String,
    },
}

/// A record's files by name, in alphabetical order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parcel {
    files: BTreeMap<String, Vec<u8>>,
    clocks: BTreeMap<String, Vec<u8>>,
}

impl Parcel {
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
        let text = serde_json::to_string_pretty(value).map_err(|e| unreadable(name, &e))?;
        Ok(self.file(name, (text + "\n").into_bytes()))
    }

    /// Adds durations as JSON: kept with the record, but no part of what it says.
    ///
    /// # Errors
    /// [`RecordError::Scalars`] when a value has no form in JSON.
    pub fn durations(mut self, name: &str, value: &impl Serialize) -> Result<Self, RecordError> {
        let text = serde_json::to_string_pretty(value).map_err(|e| unreadable(name, &e))?;
        self.clocks.insert(name.into(), (text + "\n").into_bytes());
        Ok(self)
    }

    /// A file's bytes.
    ///
    /// # Errors
    /// [`RecordError::Absent`] when there is none of that name.
    pub fn bytes(&self, name: &str) -> Result<&[u8], RecordError> {
        let found = self.files.get(name).or_else(|| self.clocks.get(name));
        found.map(Vec::as_slice).ok_or_else(|| RecordError::Absent(name.into()))
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
        serde_json::from_slice(self.bytes(name)?).map_err(|e| unreadable(name, &e))
    }

    /// The files that say what the record says, by name.
    pub fn files(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
    }

    /// The files that only say how long it took, by name.
    pub fn clocks(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.clocks.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
    }
}

fn unreadable(file: &str, cause: &serde_json::Error) -> RecordError {
    RecordError::Scalars { file: file.into(), cause: cause.to_string() }
}
