//! `metrics.json` of real recordings: one file for all bodies of a folder, each of which replaces its own entries.

use std::path::Path;

use diagnostics::{Diagnostic, Result, input};
use serde_json::{Value, json};

/// A metric of a body, not compared with an expected or a published value; none where the prediction does not exist.
pub(crate) fn entry(id: &str, value: Option<f64>, unit: &str) -> Value {
    json!({
        "id": id,
        "value": value,
        "unit": unit,
        "published": null,
        "expected": null,
        "tolerance": null,
        "status": if value.is_some() { "not compared" } else { "not predicted" },
    })
}

/// Replaces the entries of the body `name` in `folder`/metrics.json and keeps those of other bodies.
///
/// # Errors
/// A [`Diagnostic`] when the file cannot be written.
pub(crate) fn replace(folder: &Path, name: &str, entries: Vec<Value>) -> Result<()> {
    let path = folder.join("metrics.json");
    let own = format!("real.{name}.");
    // A file that is not there, or not a list, holds nothing that could be kept.
    let text = input::read_text(&path, input::PAGE).unwrap_or_default();
    let mut all: Vec<Value> = serde_json::from_str(&text).unwrap_or_default();
    all.retain(|entry| !entry["id"].as_str().is_some_and(|id| id.starts_with(&own)));
    all.extend(entries);
    let text = Value::Array(all).to_string() + "\n";
    std::fs::write(&path, text).map_err(|e| Diagnostic::io(&path, e, "name another folder with --out"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_replaces_its_own_metrics_and_keeps_those_of_others() {
        let folder = std::env::temp_dir().join(format!("metrics-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        for (name, value) in [("bar", Some(1.0)), ("arm", Some(2.0)), ("bar", None)] {
            replace(&folder, name, vec![entry(&format!("real.{name}.error"), value, "%")]).unwrap();
        }
        let text = std::fs::read_to_string(folder.join("metrics.json")).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        let all: Vec<Value> = serde_json::from_str(&text).unwrap();
        assert_eq!((all.len(), &all[0]["value"], &all[1]["value"]), (2, &json!(2.0), &Value::Null));
    }
}
