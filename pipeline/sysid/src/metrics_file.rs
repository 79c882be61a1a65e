//! `metrics.json` of real recordings: one file for all bodies of a folder, each of which replaces its own entries.

use std::io::ErrorKind;
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
/// A [`Diagnostic`] when the file cannot be written, or is there and holds no list: entries of other bodies would be lost.
pub(crate) fn replace(folder: &Path, name: &str, entries: Vec<Value>) -> Result<()> {
    let path = folder.join("metrics.json");
    let prefix = format!("real.{name}.");
    let mut metrics = entries_of(&path)?;
    metrics.retain(|entry| !entry["id"].as_str().is_some_and(|id| id.starts_with(&prefix)));
    metrics.extend(entries);
    let text = Value::Array(metrics).to_string() + "\n";
    std::fs::write(&path, text).map_err(|e| Diagnostic::io(&path, e, "name another folder with --out"))
}

/// The entries of a file; none where there is no file.
fn entries_of(path: &Path) -> Result<Vec<Value>> {
    let text = match input::read_text(path, input::PAGE) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        text => text.map_err(|e| Diagnostic::io(path, e, "name another folder with --out"))?,
    };
    let action = "restore it or remove it: the metrics of other bodies would be lost";
    let list = serde_json::from_str::<Vec<Value>>(&text);
    let list = list.map_err(|e| Diagnostic::file(path, "it holds no list of metrics", &e, action).caused_by(e))?;
    match list.iter().position(|entry| !entry["id"].is_string()) {
        Some(number) => {
            Err(Diagnostic::file(path, format!("entry {number} has no `id`"), "each metric has one", action))
        }
        None => Ok(list),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_holds_no_metrics_is_refused_and_stays() {
        let folder = std::env::temp_dir().join(format!("metrics-damaged-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("metrics.json");
        for (text, words) in [
            ("[{\"id\": \"real.arm.error\"", "no list"),
            ("{}", "no list"),
            ("[{\"value\": 1}]", "entry 0 has no `id`"),
        ] {
            std::fs::write(&path, text).unwrap();
            let error = replace(&folder, "bar", vec![entry("real.bar.error", Some(1.0), "%")]).unwrap_err().to_string();
            assert!(error.contains("metrics.json") && error.contains(words), "{error}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }

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
