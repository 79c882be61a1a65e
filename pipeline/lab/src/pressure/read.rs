//! Reading a pressure log: every refusal names the file, the line, what was expected and the next move.
//!
//! Stands on: the log's columns and ranges, `csv`. Never knows: which trial it belongs to.

use std::path::Path;

use super::{COLUMNS, PressureLog, RANGE};
use crate::Refusal;
use crate::nearest::nearest;
use si::MILLIBAR;

/// The log in the file `path`, checked.
///
/// # Errors
/// [`Refusal`] when the file cannot be read, lacks a column, holds a NaN, a decimal comma, a number out of range, or
/// time that does not rise evenly.
pub fn read(path: &Path) -> Result<PressureLog, Refusal> {
    let bytes = std::fs::read(path).map_err(|e| {
        Refusal::io(path, &e, "put the trial's log there, or correct `pressure` of the trial in specimen.toml")
    })?;
    let text = String::from_utf8(bytes).map_err(|_| {
        Refusal::file(path, "the file is no text", "a log is UTF-8 text", "export it again as CSV in UTF-8")
    })?;
    parse(&text, path)
}

/// The log in `text`; `path` is only quoted in refusals.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<PressureLog, Refusal> {
    let text = text.trim_start_matches('\u{feff}');
    let mut reader =
        csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).flexible(true).from_reader(text.as_bytes());
    let header = reader.headers().cloned().map_err(|e| broken(path, &e))?;
    let header_line = 1 + text.lines().take_while(|l| l.starts_with('#') || l.trim().is_empty()).count();
    let places = columns(path, &header).map_err(|r| r.at_line(header_line))?;
    let mut log = PressureLog::default();
    for record in reader.records() {
        let record = record.map_err(|e| broken(path, &e))?;
        let line = record.position().map(|p| p.line() as usize);
        let row = row(path, &header, &record, &places).map_err(|r| r.at_line(line))?;
        later(path, &log, row[0]).map_err(|r| r.at_line(line))?;
        log.push(row);
    }
    even(path, &log)?;
    Ok(log)
}

fn broken(path: &Path, error: &csv::Error) -> Refusal {
    let line = error.position().map(|p| p.line() as usize);
    Refusal::file(path, "the line is no CSV", error.to_string().to_lowercase(), "export the log again").at_line(line)
}

/// Where each of [`COLUMNS`] stands.
fn columns(path: &Path, header: &csv::StringRecord) -> Result<[usize; 6], Refusal> {
    let mut places = [0; 6];
    for (place, name) in places.iter_mut().zip(COLUMNS) {
        *place = header.iter().position(|h| h == name).ok_or_else(|| missing(path, header, name))?;
    }
    Ok(places)
}

fn missing(path: &Path, header: &csv::StringRecord, name: &str) -> Refusal {
    let present: Vec<&str> = header.iter().filter(|h| !COLUMNS.contains(h)).collect();
    let act = match nearest(name, &present) {
        Some(near) => format!("rename the column `{near}` to `{name}`"),
        None if header.len() == 1 && header[0].contains(';') => "export with commas between columns".to_owned(),
        None => format!("add the column `{name}`"),
    };
    let why = format!("a pressure log has the columns {}", COLUMNS.join(", "));
    Refusal::file(path, format!("the column `{name}` is missing"), why, act)
}

fn row(
    path: &Path,
    header: &csv::StringRecord,
    record: &csv::StringRecord,
    places: &[usize; 6],
) -> Result<[f64; 6], Refusal> {
    if record.len() != header.len() {
        let what = format!("the line has {} fields", record.len());
        let why = format!("the header names {}; a decimal comma also looks like this", header.len());
        return Err(Refusal::file(path, what, why, "write decimal points, and as many fields as columns"));
    }
    let mut row = [0.0; 6];
    for (k, place) in places.iter().enumerate() {
        row[k] = number(path, COLUMNS[k], &record[*place])?;
        range(path, k, row[k])?;
    }
    Ok(row)
}

fn number(path: &Path, column: &str, text: &str) -> Result<f64, Refusal> {
    let refused = |why: &str, act: &str| Refusal::file(path, format!("{column} is `{text}`"), why, act);
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(refused("every sample must be a finite number", "cut the log there, or record the trial again")),
        Err(_) if text.contains(',') => Err(refused("the decimal sign is a point", "export with decimal points")),
        Err(_) => Err(refused("a number was expected", "correct the field, or cut the line out")),
    }
}

fn range(path: &Path, column: usize, value: f64) -> Result<(), Refusal> {
    let (low, high, unit) = match column {
        0 => (-1e6, 1e6, "s"),
        5 => (0.0, 1.0, "(off to on)"),
        _ => (RANGE[0] / MILLIBAR, RANGE[1] / MILLIBAR, "mbar"),
    };
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let what = format!("{} = {value} is out of range", COLUMNS[column]);
    Err(Refusal::file(path, what, format!("the range is {low} to {high} {unit}"), "check the unit of the column"))
}

fn later(path: &Path, log: &PressureLog, time: f64) -> Result<(), Refusal> {
    match log.time.last() {
        Some(before) if time <= *before => {
            let what = format!("time_s goes from {before} to {time}");
            Err(Refusal::file(path, what, "time must rise from line to line", "take the repeated or swapped lines out"))
        }
        _ => Ok(()),
    }
}

/// At least two samples, and no step a fifth off the mean one.
fn even(path: &Path, log: &PressureLog) -> Result<(), Refusal> {
    if log.time.len() < 2 {
        let what = format!("the log has {} samples", log.time.len());
        return Err(Refusal::file(path, what, "at least two are needed", "record the trial again"));
    }
    let step = 1.0 / log.rate();
    let uneven = log.time.windows(2).position(|t| (t[1] - t[0] - step).abs() > 0.2 * step);
    match uneven {
        None => Ok(()),
        Some(i) => {
            let what = format!(
                "after time_s = {} the next sample comes {:.4} s later",
                log.time[i],
                log.time[i + 1] - log.time[i]
            );
            let why = format!("samples come every {step:.4} s, and a step may be a fifth off that");
            Err(Refusal::file(path, what, why, "fill the gap from the logger, or cut the log there"))
        }
    }
}
