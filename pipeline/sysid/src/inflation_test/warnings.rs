//! Warnings of an inflation test: a fit that is none, since no material of its family moves the tip as the recording has it.
//!
//! None of them is an error: other rows and recordings are as they should be. A row whose fit is none has no modulus in text, table and
//! metrics, so that no number is taken for a result.

use super::Report;
use super::fits::Row;

/// The parameters of a fit, in the order of its points.
const PARAMETERS: [&str; 3] = ["the modulus", "C20/C10", "the missing pressure in kPa"];

/// Why the fit of a row is none; nothing where it is one, or nothing was fitted.
pub(super) fn no_fit(report: &Report, row: &Row) -> Option<String> {
    row.used.iter().find_map(|&k| recording_contradiction(report, row, k))
}

/// How a row contradicts the recording `k` to which it was fitted.
fn recording_contradiction(report: &Report, row: &Row, k: usize) -> Option<String> {
    let recording = &report.page.recording[k];
    let recording_label = format!("`{}` ({})", recording.name, recording.files.join(", "));
    let Some(features) = row.predictions[k].features else {
        return Some(format!("the wall balloons without bound at {recording_label}: correct its `pressure`"));
    };
    let (predicted, measured) = (1e3 * features.early, 1e3 * report.recorded[k].features.early);
    if !predicted.is_finite() || !features.late.is_finite() {
        return Some(format!("the tip has no place at {recording_label}"));
    }
    (predicted * measured <= 0.0).then(|| {
        format!(
            "the tip moves by {predicted:+.2} mm at {recording_label}, and by {measured:+.2} mm in the recording, which no modulus turns round: \
             correct `along`, its `pressure` or its markers"
        )
    })
}

/// How the search of a row ended where it did not end at an optimum inside of its ranges.
fn search_warnings(row: &Row) -> Vec<String> {
    let Some(end) = row.end else { return Vec::new() };
    let name = &row.name;
    let on_bounds = end.on_bounds().map(|(p, [low, high])| {
        let parameter = PARAMETERS[p];
        format!("{parameter} of `{name}` lies on an end of its range, {low} to {high}: it is not identified")
    });
    let step = end.next_step;
    let unfinished =
        (!end.converged()).then(|| format!("`{name}` did not converge: a further step would change it by {step:.2}"));
    on_bounds.chain(unfinished).collect()
}

/// All warnings of a report.
pub(super) fn warnings(report: &Report) -> Vec<String> {
    let of_row = |row: &Row| match no_fit(report, row) {
        Some(reason) => vec![format!("`{}` is no fit: {reason}", row.name)],
        None => search_warnings(row),
    };
    report.rows.iter().flat_map(of_row).collect()
}
