//! `metrics.json`: every metric with its expected value and the value published elsewhere.
//!
//! Assembled from the manifests of the records that are up to date, in the order of their names; a number that several subjects share is the
//! largest of theirs.

use std::path::Path;

use diagnostics::{Diagnostic, Result, input};
use workflow::runner::{Runner, write_atomically};
use workflow::subject::Universe;

use crate::expected::{Expected, MetricEntry};

/// Gathers and writes all numbers; leaves the file alone when nothing changed.
///
/// # Errors
/// A [`Diagnostic`] when the expectations cannot be read or the file cannot be written.
pub fn write<U: Universe>(runner: &Runner<U>) -> Result<()> {
    let (path, text) = (runner.folders.metrics(), metrics_text(runner)?);
    if file_holds(&path, &text) {
        return Ok(());
    }
    write_atomically(&path, text.as_bytes()).map_err(|e| {
        let defect = format!("the numbers cannot be written to {}", runner.folders.display(&path));
        Diagnostic::new(defect, &e, "free some disk space and run again").caused_by(e)
    })
}

/// Whether the file holds the numbers of the records that are up to date; where nothing was made there need be none.
///
/// # Errors
/// A [`Diagnostic`] when the expectations cannot be read.
pub fn is_current<U: Universe>(runner: &Runner<U>) -> Result<bool> {
    let (path, text) = (runner.folders.metrics(), metrics_text(runner)?);
    Ok(file_holds(&path, &text) || !path.exists() && text == NONE)
}

/// Reads the numbers of the last run.
///
/// # Errors
/// A [`Diagnostic`] when there has been none.
pub fn read<U: Universe>(runner: &Runner<U>) -> Result<Vec<MetricEntry>> {
    let path = runner.folders.metrics();
    let shown = runner.folders.display(&path);
    let text = input::read(&path, input::MESH)
        .map_err(|e| Diagnostic::new(format!("{shown} cannot be read"), &e, "study run").caused_by(e))?;
    serde_json::from_slice(&text)
        .map_err(|e| Diagnostic::new(format!("{shown} is not understood"), &e, "study run").caused_by(e))
}

/// The same, none where there has been no run.
///
/// # Errors
/// A [`Diagnostic`] when the file is not understood.
pub fn read_or_none<U: Universe>(runner: &Runner<U>) -> Result<Vec<MetricEntry>> {
    if runner.folders.metrics().exists() { read(runner) } else { Ok(Vec::new()) }
}

/// The file's text where there is no number.
const NONE: &str = "[]\n";

/// The numbers of the records that are up to date.
fn metrics_text<U: Universe>(runner: &Runner<U>) -> Result<String> {
    let path = runner.folders.expected();
    // A project may have no expectations yet; its numbers are published all the same.
    let expected = if path.exists() { Expected::read(&path, runner.profile)? } else { Expected::default() };
    let entries: Vec<MetricEntry> = runner.metrics()?.into_values().map(|metric| expected.judge(metric)).collect();
    Ok(serde_json::to_string_pretty(&entries)? + "\n")
}

fn file_holds(path: &Path, text: &str) -> bool {
    input::read(path, input::MESH).is_ok_and(|former| former == text.as_bytes())
}
