//! `ro-crate-metadata.json`: the study as a Research Object Crate 1.1, for archives and reuse.
//!
//! Each record is a dataset; its creation is an action with the stage and its version as instrument, recordings and records
//! as objects, the settings, and the duration. Hashes are those of the manifests.

use diagnostics::{Diagnostic, Result};
use std::fs;
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

use workflow::runner::Manifest;
use workflow::runner::Runner;
use workflow::runner::{Found, Store, write_atomically};
use workflow::runner::{Goal, Job};
use workflow::subject::Universe;

const CONTEXT: &str = "https://w3id.org/ro/crate/1.1/context";
const LICENCE: &str = "https://spdx.org/licenses/MIT";

/// Writes the crate's description; leaves it alone when only its date would change.
///
/// # Errors
/// A [`Diagnostic`] when it cannot be written.
pub fn write<U: Universe>(runner: &Runner<U>) -> Result<()> {
    let jobs = &runner.jobs_of(&Goal::default())?;
    let parts = parts(runner, jobs);
    let place = runner.folders.crate_file();
    let old: Option<Value> = fs::read(&place).ok().and_then(|text| serde_json::from_slice(&text).ok());
    if old.is_some_and(|old| same_but_for_the_date(&old, &described(&parts, ""))) {
        return Ok(());
    }
    let text = serde_json::to_string_pretty(&described(&parts, &today()))?;
    write_atomically(&place, (text + "\n").as_bytes()).map_err(|e| {
        let what = format!("{} cannot be written", runner.folders.display(&place));
        Diagnostic::new(what, &e, "free some disk space and run again").caused_by(e)
    })
}

fn described(parts: &[Value], date: &str) -> Value {
    let named = |part: &&Value| part["@type"] == "Dataset";
    let has: Vec<Value> = parts.iter().filter(named).map(|part| json!({ "@id": part["@id"] })).collect();
    let mut graph = vec![
        json!({
            "@id": "ro-crate-metadata.json", "@type": "CreativeWork", "about": { "@id": "./" },
            "conformsTo": { "@id": "https://w3id.org/ro/crate/1.1" },
        }),
        json!({
            "@id": "./", "@type": "Dataset", "name": "Records of a study", "hasPart": has,
            "description": "Computed records of each specimen with their inputs.",
            "datePublished": date, "license": { "@id": LICENCE },
        }),
    ];
    graph.extend_from_slice(parts);
    json!({ "@context": CONTEXT, "@graph": graph })
}

fn same_but_for_the_date(a: &Value, b: &Value) -> bool {
    let undated = |value: &Value| {
        let mut value = value.clone();
        value["@graph"][1]["datePublished"] = Value::Null;
        value
    };
    undated(a) == undated(b)
}

/// A dataset and an action for each whole record, and an instrument for each stage.
fn parts<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>]) -> Vec<Value> {
    let store = Store::new(&runner.folders);
    let mut parts = Vec::new();
    for list in runner.lists {
        parts.extend(list.iter().map(|entry| {
            json!({
                "@id": format!("#{}", entry.name), "@type": "SoftwareApplication", "name": entry.name,
                "description": entry.description, "softwareVersion": version(entry.version),
            })
        }));
    }
    for job in jobs {
        if let Found::Whole(manifest) = store.find(&job.id) {
            parts.extend(record(runner, job, &manifest));
        }
    }
    parts
}

fn version(version: u32) -> String {
    format!("{} of the pipeline, version {version}", env!("CARGO_PKG_VERSION"))
}

fn record<U: Universe>(runner: &Runner<U>, job: &Job<U>, manifest: &Manifest) -> [Value; 2] {
    let from = &manifest.made_from;
    let place = |id: &str| format!("#record/{id}");
    let raw = from.raw.iter().map(|(at, hash)| json!({ "@id": format!("#recording/{at}"), "identifier": hash }));
    let read = from.records.iter().map(|(id, hash)| json!({ "@id": place(id), "identifier": hash }));
    let id = place(&job.id.to_string());
    let dataset = json!({
        "@id": id, "@type": "Dataset", "name": job.id.to_string(), "identifier": manifest.content,
        "description": manifest.summary, "url": runner.folders.display(&runner.folders.record(&job.id)),
    });
    let action = json!({
        "@id": format!("#made/{}", job.id), "@type": "CreateAction",
        "instrument": { "@id": format!("#{}", job.entry.name) }, "softwareVersion": version(from.version),
        "object": raw.chain(read).collect::<Vec<_>>(), "result": { "@id": id },
        "additionalProperty": { "settings": from.settings, "card": from.card, "seconds": manifest.seconds },
    });
    [dataset, action]
}

/// The date of today, as in 2022-09-27.
fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    date((seconds / 86_400) as i64)
}

/// The date so many days after 1970-01-01, in the Gregorian calendar: eras of 400 years that begin in March.
fn date(days: i64) -> String {
    let days = days + 719_468;
    let (era, day) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let of_month = day - (153 * month + 2) / 5 + 1;
    let (month, later) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{:04}-{month:02}-{of_month:02}", year + 400 * era + later)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_become_dates_over_leap_years_and_turns_of_the_century() {
        let known = [
            (0, "1970-01-01"),
            (59, "1970-03-01"),
            (11_016, "2000-02-29"),
            (11_017, "2000-03-01"),
            (19_358, "2023-01-01"),
        ];
        assert!(
            known.iter().all(|(days, expected)| date(*days) == *expected),
            "{:?}",
            known.map(|(days, _)| date(days))
        );
    }

    #[test]
    fn a_crate_that_differs_by_its_date_alone_is_the_same() {
        let part = [json!({ "@id": "#record/mesh/nemo", "@type": "Dataset" })];
        let (a, b) = (described(&part, "2022-01-01"), described(&part, "2023-01-01"));
        assert!(a != b && same_but_for_the_date(&a, &b) && !same_but_for_the_date(&a, &described(&[], "2022-01-01")));
        assert_eq!(a["@graph"][1]["hasPart"][0]["@id"], "#record/mesh/nemo");
    }
}
