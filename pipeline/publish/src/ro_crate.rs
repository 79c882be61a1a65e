//! `ro-crate-metadata.json`: the study as a Process Run Crate 0.5, a profile of Workflow Run RO-Crate, for archives and reuse.
//!
//! Each record is a dataset; its creation is an action with the stage and its version as instrument, with recordings, records, settings
//! and the part of the card as objects, and with the times of its start and end. Hashes are those of the manifests; times are no part of
//! any of them.

use std::collections::BTreeMap;
use std::time::SystemTime;

use chrono::{DateTime, SecondsFormat, Utc};
use diagnostics::{Diagnostic, Result, input};
use serde_json::{Value, json};

use workflow::entry::Entry;
use workflow::runner::{Folders, Found, Goal, Job, Manifest, Runner, Store, write_atomically};
use workflow::subject::Universe;

const CONTEXT: &str = "https://w3id.org/ro/crate/1.1/context";
const PROFILE: &str = "https://w3id.org/ro/wfrun/process/0.5";
const LICENCE: &str = "https://spdx.org/licenses/MIT";

/// Writes the crate's description; leaves it alone when only its date would change.
///
/// # Errors
/// A [`Diagnostic`] when it cannot be written.
pub fn write<U: Universe>(runner: &Runner<U>) -> Result<()> {
    let jobs = &runner.jobs_of(&Goal::default())?;
    let parts = crate_parts(runner, jobs);
    let path = runner.folders.crate_file();
    let former: Option<Value> =
        input::read(&path, input::MESH).ok().and_then(|text| serde_json::from_slice(&text).ok());
    if former.is_some_and(|former| equal_but_for_date(&former, &crate_document(&parts, ""))) {
        return Ok(());
    }
    let text = serde_json::to_string_pretty(&crate_document(&parts, &iso_time(DateTime::from(SystemTime::now()))))?;
    write_atomically(&path, (text + "\n").as_bytes()).map_err(|e| {
        let defect = format!("{} cannot be written", runner.folders.display(&path));
        Diagnostic::new(defect, &e, "free some disk space and run again").caused_by(e)
    })
}

fn crate_document(parts: &[Value], date: &str) -> Value {
    let of_type = |name: &str| -> Vec<Value> {
        parts.iter().filter(|part| part["@type"] == name).map(|part| json!({ "@id": part["@id"] })).collect()
    };
    let mut graph = vec![
        json!({
            "@id": "ro-crate-metadata.json", "@type": "CreativeWork", "about": { "@id": "./" },
            "conformsTo": { "@id": "https://w3id.org/ro/crate/1.1" },
        }),
        json!({
            "@id": "./", "@type": "Dataset", "name": "Records of a study",
            "description": "Computed records of each specimen with their inputs.",
            "conformsTo": { "@id": PROFILE }, "hasPart": of_type("Dataset"), "mentions": of_type("CreateAction"),
            "datePublished": date, "license": { "@id": LICENCE },
        }),
        json!({ "@id": PROFILE, "@type": "CreativeWork", "name": "Process Run Crate", "version": "0.5" }),
        json!({ "@id": LICENCE, "@type": "CreativeWork", "name": "MIT License", "description": "SPDX: MIT" }),
    ];
    graph.extend_from_slice(parts);
    json!({ "@context": CONTEXT, "@graph": graph })
}

fn equal_but_for_date(a: &Value, b: &Value) -> bool {
    let without_date = |value: &Value| {
        let mut value = value.clone();
        value["@graph"][1]["datePublished"] = Value::Null;
        value
    };
    without_date(a) == without_date(b)
}

/// A dataset and an action for each whole record, and once each the instruments and what lies outside of the crate.
fn crate_parts<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>]) -> Vec<Value> {
    let store = Store::new(&runner.folders);
    let mut parts = Parts { folders: &runner.folders, own: Vec::new(), shared: BTreeMap::new() };
    for job in jobs {
        if let Found::Whole(manifest) = store.find(&job.id) {
            parts.add_instrument(job.entry);
            parts.add_record(job, &manifest);
        }
    }
    parts.shared.into_values().chain(parts.own).collect()
}

/// The entities of a crate.
struct Parts<'a> {
    folders: &'a Folders,
    /// Of the records, in their order.
    own: Vec<Value>,
    /// Those that several records name, by identifier.
    shared: BTreeMap<String, Value>,
}

impl Parts<'_> {
    fn share_entity(&mut self, entity: Value) -> Value {
        let id = entity["@id"].clone();
        self.shared.insert(id.as_str().unwrap_or_default().into(), entity);
        json!({ "@id": id })
    }

    fn add_instrument<U>(&mut self, entry: &Entry<U>) {
        self.share_entity(json!({
            "@id": format!("#{}", entry.name), "@type": "SoftwareApplication", "name": entry.name,
            "description": entry.description,
            "softwareVersion": format!("{} of the pipeline, version {}", env!("CARGO_PKG_VERSION"), entry.version),
        }));
    }

    fn add_record<U>(&mut self, job: &Job<U>, manifest: &Manifest) {
        let id = json!({ "@id": self.record_path(&job.id.to_string()) });
        self.own.push(json!({
            "@id": id["@id"], "@type": "Dataset", "name": job.id.to_string(), "identifier": manifest.content,
            "description": manifest.summary,
        }));
        let mut action = json!({
            "@id": format!("#made/{}", job.id), "@type": "CreateAction", "name": format!("making of {}", job.id),
            "description": job.entry.description, "instrument": { "@id": format!("#{}", job.entry.name) },
            "object": self.input_objects(job, manifest), "result": id,
        });
        if let Some([start, end]) = action_times(manifest) {
            (action["startTime"], action["endTime"]) = (start.into(), end.into());
        }
        self.own.push(action);
    }

    /// What a record was made from.
    fn input_objects<U>(&mut self, job: &Job<U>, manifest: &Manifest) -> Vec<Value> {
        let inputs = &manifest.made_from;
        let recording = |(path, hash): (&String, &String)| {
            let id = format!("#recording/{path}");
            json!({ "@id": id, "@type": "CreativeWork", "name": path, "identifier": hash })
        };
        let parameter = |(what, value): (&str, &Value)| {
            let id = format!("#{what}/{}", job.id);
            json!({ "@id": id, "@type": "PropertyValue", "name": what, "value": value.to_string() })
        };
        let parameters =
            [("settings", &inputs.settings), ("card", &inputs.card)].into_iter().filter(|(_, v)| !v.is_null());
        let shared_entities: Vec<Value> = inputs.raw.iter().map(recording).chain(parameters.map(parameter)).collect();
        let shared_entities: Vec<Value> = shared_entities.into_iter().map(|entity| self.share_entity(entity)).collect();
        let records = inputs.records.keys().map(|id| json!({ "@id": self.record_path(id) }));
        shared_entities.into_iter().chain(records).collect()
    }

    /// A record's folder, from that of the crate.
    fn record_path(&self, id: &str) -> String {
        format!("{id}/{}/", self.folders.record_folder_name())
    }
}

/// When a record's making began and ended; none of a record of an earlier version of the program.
fn action_times(manifest: &Manifest) -> Option<[String; 2]> {
    let start = manifest.usage.begun?;
    let timestamp = |seconds: f64| DateTime::from_timestamp_millis((seconds * 1e3) as i64).map(iso_time);
    Some([timestamp(start)?, timestamp(start + manifest.seconds)?])
}

/// As in 2022-09-27T10:00:00.000+00:00: the form that profiles of RO-Crate ask for.
fn iso_time(time: DateTime<Utc>) -> String {
    time.to_rfc3339_opts(SecondsFormat::Millis, false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_those_of_iso_8601() {
        assert_eq!(
            iso_time(DateTime::from_timestamp_millis(951_782_400_250).unwrap()),
            "2000-02-29T00:00:00.250+00:00"
        );
    }

    #[test]
    fn a_crate_that_differs_by_its_date_alone_is_the_same() {
        let part = [json!({ "@id": "mesh/fish/record/", "@type": "Dataset" })];
        let (a, b) = (crate_document(&part, "2022-01-01"), crate_document(&part, "2023-01-01"));
        assert!(a != b && equal_but_for_date(&a, &b) && !equal_but_for_date(&a, &crate_document(&[], "2022-01-01")));
        assert_eq!(a["@graph"][1]["hasPart"][0]["@id"], "mesh/fish/record/");
    }
}
