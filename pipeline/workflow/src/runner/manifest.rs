//! The manifest of a record: its inputs, and the hashes of its files.
//!
//! A record is up to date when its inputs are unchanged; no clock and no file date is used.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::usage::Usage;
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
    /// When it was made, and what that used. Like the duration it differs from run to run and is no part of the content.
    #[serde(default)]
    pub usage: Usage,
    /// BLAKE3 of the manifest's own text with this field empty.
    pub seal: String,
}

/// The part of a manifest that tells whether a record is up to date: a plan of thirty thousand records holds no more of them.
#[derive(Debug, Deserialize)]
pub struct Outline {
    /// BLAKE3 of the inputs.
    pub key: String,
    /// BLAKE3 of all files but the durations.
    pub content: String,
    files: BTreeMap<String, String>,
    seal: String,
}

/// What is read from a manifest's text.
pub(crate) trait Sealed: DeserializeOwned {
    /// BLAKE3 of the text with the seal empty.
    fn seal(&self) -> &str;

    /// BLAKE3 of each file.
    fn files(&self) -> &BTreeMap<String, String>;
}

impl Sealed for Manifest {
    fn seal(&self) -> &str {
        &self.seal
    }

    fn files(&self) -> &BTreeMap<String, String> {
        &self.files
    }
}

impl Sealed for Outline {
    fn seal(&self) -> &str {
        &self.seal
    }

    fn files(&self) -> &BTreeMap<String, String> {
        &self.files
    }
}

/// The field of the seal in a manifest's text, before it is sealed.
const OPEN: &str = "\"seal\": \"\"";

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

/// The present inputs of a record: a [`MadeFrom`] that borrows, with the same key.
#[derive(Debug, Serialize)]
pub(crate) struct Present<'a> {
    pub version: u32,
    pub raw: BTreeMap<&'a str, String>,
    pub card: &'a Value,
    pub settings: &'a Value,
    pub records: BTreeMap<String, &'a str>,
}

impl MadeFrom {
    /// The record's key.
    pub fn key(&self) -> String {
        inputs_key(self)
    }
}

impl Present<'_> {
    /// The record's key.
    pub(crate) fn key(&self) -> String {
        inputs_key(self)
    }

    /// The same by itself.
    pub(crate) fn made_from(self) -> MadeFrom {
        MadeFrom {
            version: self.version,
            raw: self.raw.into_iter().map(|(path, hash)| (path.to_owned(), hash)).collect(),
            card: self.card.clone(),
            settings: self.settings.clone(),
            records: self.records.into_iter().map(|(id, content)| (id, content.to_owned())).collect(),
        }
    }
}

fn inputs_key(inputs: &impl Serialize) -> String {
    let text = serde_json::to_vec(inputs).unwrap_or_default();
    blake3::hash(&text).to_hex().to_string()
}

impl Manifest {
    /// The manifest of a record that was just made, and its files.
    pub(crate) fn of(made_from: MadeFrom, product: Product, seconds: f64, usage: Usage) -> (Self, RecordFiles) {
        let Product { files, metrics, summary } = product;
        let hash = |(name, bytes): (&str, &[u8])| (name.to_string(), blake3::hash(bytes).to_hex().to_string());
        let contents: BTreeMap<_, _> = files.contents().chain(files.untimed()).map(hash).collect();
        let content = contents.iter().fold(blake3::Hasher::new(), |mut hasher, (name, file)| {
            hasher.update(name.as_bytes()).update(file.as_bytes());
            hasher
        });
        let hashes = files.contents().chain(files.durations_files()).map(hash).collect();
        let content = content.finalize().to_hex().to_string();
        let (key, seal) = (made_from.key(), String::new());
        (Self { key, content, made_from, files: hashes, metrics, summary, seconds, usage, seal }, files)
    }

    /// The text of the manifest with its seal, so that an altered metric or duration is found like an altered file.
    ///
    /// The seal is no part of `content`: durations differ from run to run and must not make later records stale. It is taken of the
    /// text, since a number may lose its last digit when it is read and written again.
    ///
    /// # Errors
    /// When a value has no form in JSON.
    pub(crate) fn to_text(&self) -> Result<String, serde_json::Error> {
        let open = serde_json::to_string_pretty(&Self { seal: String::new(), ..self.clone() })?;
        let seal = blake3::hash(open.as_bytes()).to_hex();
        // The last occurrence: a part of the card may have a key of the same name.
        let (prefix, suffix) = open.rsplit_once(OPEN).unwrap_or((&open, ""));
        Ok(format!("{prefix}\"seal\": \"{seal}\"{suffix}"))
    }
}

/// The manifest in a text, or a part of it.
///
/// # Errors
/// What is wrong with the text: it is no manifest, or not the one that was written.
pub(crate) fn parse<M: Sealed>(text: &str) -> Result<M, String> {
    let manifest: M = serde_json::from_str(text).map_err(|e| format!("its {FILE} is not understood ({e})"))?;
    let (prefix, suffix) = text.rsplit_once(&format!("\"seal\": \"{}\"", manifest.seal())).unwrap_or((text, ""));
    let mut open = blake3::Hasher::new();
    open.update(prefix.as_bytes()).update(OPEN.as_bytes()).update(suffix.as_bytes());
    let seal = open.finalize().to_hex();
    let intact = *manifest.seal() == *seal;
    intact.then_some(manifest).ok_or_else(|| format!("the contents of its {FILE} are not those that were written"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest() -> Manifest {
        of_files(RecordFiles::default().file("a.bin", vec![1, 2]))
    }

    fn of_files(files: RecordFiles) -> Manifest {
        let made_from = MadeFrom {
            version: 1,
            raw: BTreeMap::new(),
            card: serde_json::json!({ "seal": "", "length": 0.1 }),
            settings: Value::Null,
            records: BTreeMap::new(),
        };
        let product =
            Product { files, metrics: vec![Metric::new("a.b", 0.123_456_789_012_345_68, "m")], summary: "made".into() };
        Manifest::of(made_from, product, 1.5, Usage::default()).0
    }

    #[test]
    fn an_altered_metric_is_found_and_an_untouched_manifest_is_read() {
        let manifest = manifest();
        let text = manifest.to_text().unwrap();
        assert_eq!(parse::<Manifest>(&text).unwrap().content, manifest.content);
        let outline = parse::<Outline>(&text).unwrap();
        assert_eq!((outline.key, outline.content, outline.files), (manifest.key, manifest.content, manifest.files));
        for altered in [text.replace("0.1234", "1.1234"), text.replace("1.5", "2.5"), text.replace("made\"", "mad\"")] {
            assert_ne!(altered, text);
            assert!(parse::<Manifest>(&altered).unwrap_err().contains("not those that were written"));
            assert!(parse::<Outline>(&altered).is_err());
        }
        assert!(parse::<Manifest>("{}").unwrap_err().contains("not understood"));
    }

    #[test]
    fn the_content_of_a_file_that_prints_durations_is_the_rest_of_it() {
        let printed = |text: &str, untimed: &str| {
            of_files(RecordFiles::default().timed_file("a.csv", text.into(), untimed.into()))
        };
        let (fast, slow, changed) =
            (printed("adam,3 s", "adam"), printed("adam,4 s", "adam"), printed("grid,4 s", "grid"));
        assert!(fast.content == slow.content && slow.content != changed.content);
        assert_ne!(fast.files, slow.files);
    }

    #[test]
    fn present_inputs_have_the_key_of_their_manifest() {
        let card = serde_json::json!({ "length": 0.1 });
        let records = BTreeMap::from([("mesh/a".to_owned(), "01")]);
        let raw = BTreeMap::from([("a/log.csv", "ab".to_owned())]);
        let present = Present { version: 2, raw, card: &card, settings: &Value::Null, records };
        assert_eq!(present.key(), present.made_from().key());
    }

    #[test]
    fn a_manifest_that_is_altered_or_cut_at_any_byte_is_refused() {
        let text = manifest().to_text().unwrap();
        for index in 0..text.len() {
            let mut bytes = text.clone().into_bytes();
            bytes[index] ^= 1;
            let altered = String::from_utf8(bytes).unwrap();
            assert!(
                parse::<Outline>(&altered).is_err() && parse::<Manifest>(&altered).is_err(),
                "byte {index} is `{}`",
                &altered[index..=index]
            );
            assert!(
                parse::<Outline>(&text[..index]).is_err() && parse::<Manifest>(&text[..index]).is_err(),
                "cut at {index}"
            );
        }
    }
}
