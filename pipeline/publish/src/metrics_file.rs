//! `metrics.json`: every metric with its expected value and the value published elsewhere.
//!
//! Assembled from the manifests of the records at hand, in the order of their names; a number that several subjects share is the
//! largest of theirs.

use std::fs;

use diagnostics::{Diagnostic, Result};
use workflow::runner::{Runner, write_atomically};
use workflow::subject::Universe;

use crate::expected::{Expected, MetricEntry};

/// Gathers and writes all numbers; leaves the file alone when nothing changed.
///
/// # Errors
/// A [`Diagnostic`] when the expectations cannot be read or the file cannot be written.
pub fn write<U: Universe>(runner: &Runner<U>) -> Result<()> {
    let path = runner.folders.expected();
    // A project may have no expectations yet; its numbers are published all the same.
    let expected = if path.exists() { Expected::read(&path, runner.profile)? } else { Expected::default() };
    let entries: Vec<MetricEntry> = runner.metrics()?.into_values().map(|metric| expected.judge(metric)).collect();
    let text = serde_json::to_string_pretty(&entries)? + "\n";
    let path = runner.folders.metrics();
    if fs::read(&path).is_ok_and(|old| old == text.as_bytes()) {
        return Ok(());
    }
    write_atomically(&path, text.as_bytes()).map_err(|e| {
        let what = format!("the numbers cannot be written to {}", runner.folders.display(&path));
        Diagnostic::new(what, &e, "free some disk space and run again").caused_by(e)
    })
}

/// Reads the numbers of the last run.
///
/// # Errors
/// A [`Diagnostic`] when there has been none.
pub fn read<U: Universe>(runner: &Runner<U>) -> Result<Vec<MetricEntry>> {
    let path = runner.folders.metrics();
    let shown = runner.folders.display(&path);
    let text = fs::read(&path)
        .map_err(|e| Diagnostic::new(format!("{shown} cannot be read"), &e, "study run").caused_by(e))?;
    serde_json::from_slice(&text)
        .map_err(|e| Diagnostic::new(format!("{shown} is not understood"), &e, "study run").caused_by(e))
}
