//! `metrics.json`: every number that leaves the house, beside what was published and what is expected.
//!
//! Assembled from the manifests of the records at hand, in the order of their names; a number that several specimens share
//! (a quantity of the bench) is the worst of them.
//!
//! Stands on: store, `paper/expected.toml`. Never knows: how a number was computed.

use std::collections::BTreeMap;
use std::{fs, io};

use serde::{Deserialize, Serialize};

use super::Runner;
use super::graph::Job;
use super::report::Report;
use super::store::{Found, Store, write_at_once};
use crate::expected::Expected;
use crate::fault::{Fault, Outcome};
use crate::metric::Metric;

/// One number with all that is known of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// The number itself.
    #[serde(flatten)]
    pub metric: Metric,
    /// What was published.
    pub published: Option<f64>,
    /// What is expected of this profile.
    pub expected: Option<f64>,
    /// How far it may lie from `expected`, in the unit of the metric.
    pub tolerance: Option<f64>,
    /// "as expected", "drifted" or "not compared".
    pub status: String,
}

/// Gathers and writes all numbers; leaves the file alone when nothing changed.
pub fn write(runner: &Runner, jobs: &[Job], report: &Report) -> io::Result<()> {
    let expected = match Expected::read(&runner.folders.expected(), runner.profile) {
        Ok(expected) => expected,
        Err(fault) => {
            report.warn(&fault.what);
            Expected::default()
        }
    };
    let entries: Vec<Entry> = gather(runner, jobs).into_values().map(|metric| expected.judge(metric)).collect();
    let text = serde_json::to_string_pretty(&entries).map_err(io::Error::other)? + "\n";
    let place = runner.folders.metrics();
    if fs::read(&place).is_ok_and(|old| old == text.as_bytes()) {
        return Ok(());
    }
    write_at_once(&place, text.as_bytes())
}

/// Reads the numbers of the last run.
///
/// # Errors
/// A [`Fault`] when there has been none.
pub fn read(runner: &Runner) -> Outcome<Vec<Entry>> {
    let place = runner.folders.metrics();
    let told = runner.folders.tell(&place);
    let text = fs::read(&place).map_err(|e| Fault::new(format!("{told} cannot be read"), e, "study run"))?;
    serde_json::from_slice(&text).map_err(|e| Fault::new(format!("{told} is not understood"), e, "study run"))
}

fn gather(runner: &Runner, jobs: &[Job]) -> BTreeMap<String, Metric> {
    let store = Store::new(&runner.folders);
    let mut all: BTreeMap<String, Metric> = BTreeMap::new();
    for job in jobs {
        if let Found::Whole(manifest) = store.look(&job.id) {
            for metric in manifest.metrics {
                let known = all.entry(metric.id.clone()).or_insert_with(|| metric.clone());
                known.value = known.value.max(metric.value);
            }
        }
    }
    all
}
