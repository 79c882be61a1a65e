//! The manifest of a record: from what it was made, and the hashes that prove its bytes.
//!
//! A record is fresh when its ingredients are what they were; no clock and no file date takes part.
//!
//! Stands on: blake3, entry. Never knows: a path.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::metric::Metric;
use crate::record::Parcel;

/// The name of the manifest inside a record's folder.
pub const FILE: &str = "record.json";

/// What stands beside a record's files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// BLAKE3 of `made_from`.
    pub key: String,
    /// BLAKE3 of all files but the durations.
    pub content: String,
    /// The ingredients.
    pub made_from: MadeFrom,
    /// BLAKE3 of each file, durations included.
    pub files: BTreeMap<String, String>,
    /// The numbers that leave the house with it.
    pub metrics: Vec<Metric>,
    /// Its telling number.
    pub telling: String,
    /// How long it took, s.
    pub seconds: f64,
}

/// Everything that decides what a record is, as hashes and values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MadeFrom {
    /// The stage's edition.
    pub edition: u32,
    /// Place of each recording → BLAKE3 of its bytes.
    pub raw: BTreeMap<String, String>,
    /// The part of the card.
    pub card: Value,
    /// The settings.
    pub settings: Value,
    /// Name of each record read → its content.
    pub records: BTreeMap<String, String>,
}

impl MadeFrom {
    /// The record's key.
    pub fn key(&self) -> String {
        let text = serde_json::to_vec(self).unwrap_or_default();
        blake3::hash(&text).to_hex().to_string()
    }
}

impl Manifest {
    /// The manifest of a parcel that was just made.
    pub fn of(made_from: MadeFrom, parcel: &Parcel, metrics: Vec<Metric>, telling: String, seconds: f64) -> Self {
        let hash = |(name, bytes): (&str, &[u8])| (name.to_string(), blake3::hash(bytes).to_hex().to_string());
        let said: BTreeMap<_, _> = parcel.files().map(hash).collect();
        let content = said.iter().fold(blake3::Hasher::new(), |mut hasher, (name, file)| {
            hasher.update(name.as_bytes()).update(file.as_bytes());
            hasher
        });
        let files = said.into_iter().chain(parcel.clocks().map(hash)).collect();
        let content = content.finalize().to_hex().to_string();
        Self { key: made_from.key(), content, made_from, files, metrics, telling, seconds }
    }
}
