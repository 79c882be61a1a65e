//! Reading a pressure log: every refusal names the file, the line, what was expected and the next move.
//!
//! Stands on: the log's columns and ranges, the form of logs. Never knows: which trial it belongs to.

use std::path::Path;

use super::{COLUMNS, PressureLog, RANGE};
use crate::Refusal;
use crate::log::{self, Form, TIMES};
use si::MILLIBAR;

const MBAR: (f64, f64, &str) = (RANGE[0] / MILLIBAR, RANGE[1] / MILLIBAR, "mbar");

const FORM: Form<6> = Form {
    kind: "pressure log",
    columns: COLUMNS,
    ranges: [TIMES, MBAR, MBAR, MBAR, MBAR, (0.0, 1.0, "(off to on)")],
    absent: "put the trial's log there, or correct `pressure` of the trial in specimen.toml",
};

/// The log in the file `path`, checked.
///
/// # Errors
/// [`Refusal`] when the file cannot be read, lacks a column, holds a NaN, a decimal comma, a number out of range, or
/// time that does not rise evenly.
pub fn read(path: &Path) -> Result<PressureLog, Refusal> {
    log::read(&FORM, path).map(gathered)
}

/// The log in `text`; `path` is only quoted in refusals.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<PressureLog, Refusal> {
    log::parse(&FORM, text, path).map(gathered)
}

fn gathered(rows: Vec<[f64; 6]>) -> PressureLog {
    let mut log = PressureLog::default();
    rows.into_iter().for_each(|row| log.push(row));
    log
}
