//! The manifest of a record: its inputs, and the hashes of its files.
//!
//! A record is up to date when its inputs are unchanged; no clock and no file date is used.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::entry::Product;
use crate::metric::Metric;
use crate::record::RecordFiles;

/// The name of the manifest inside a record's folder.
pub const FILE: &str = "record.json";

/// The manifest beside a record's files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// BLAKE3 of `made_from`.
    pub key: String,
    /// BLAKE3 of all files but the durations.
    pub content: String,
    /// The inputs.
    pub made_from: MadeFrom,
    /// BLAKE3 of each file, durations included.
    pub files: BTreeMap<String, String>,
    /// Its metrics.
    pub metrics: Vec<Metric>,
    /// Its summary.
    pub summary: String,
    /// How long it took, s.
    pub seconds: f64,
}

/// Everything that decides what a record is, as hashes and values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MadeFrom {
    /// The stage's version.
    pub version: u32,
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
    /// The manifest of a record that was just made, and its files.
    pub fn of(made_from: MadeFrom, product: Product, seconds: f64) -> (Self, RecordFiles) {
        let Product { files, metrics, summary } = product;
        let hash = |(name, bytes): (&str, &[u8])| (name.to_string(), blake3::hash(bytes).to_hex().to_string());
        let contents: BTreeMap<_, _> = files.contents().map(hash).collect();
        let content = contents.iter().fold(blake3::Hasher::new(), |mut hasher, (name, file)| {
            hasher.update(name.as_bytes()).update(file.as_bytes());
            hasher
        });
        let hashes = contents.into_iter().chain(files.durations_files().map(hash)).collect();
        let content = content.finalize().to_hex().to_string();
        (Self { key: made_from.key(), content, made_from, files: hashes, metrics, summary, seconds }, files)
    }
}
