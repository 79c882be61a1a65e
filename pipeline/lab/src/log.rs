//! Logs as CSV: named columns of numbers, evenly sampled; every diagnostic has the file, the line, the column and the action.
//!
//! Lines that open with `#` are remarks. Columns may stand in any order and others may stand beside them. A byte-order
//! mark and CRLF are tolerated; the decimal sign is a point.

use std::path::Path;

use crate::table::nearest;
use diagnostics::{Diagnostic, input};

/// The columns of one kind of log; the first one is time in s.
pub(crate) struct LogFormat<const N: usize> {
    /// What the log is called in messages.
    pub kind: &'static str,
    /// The columns.
    pub columns: [&'static str; N],
    /// The lowest and the highest number in each of them, and the unit, in the units of the file.
    pub ranges: [(f64, f64, &'static str); N],
    /// What to do when there is no such file.
    pub absent: &'static str,
}

/// Lines before the last that show with how many decimals the log is written.
const COMPARED: usize = 10;

/// Plausible times of a log, s.
pub(crate) const TIMES: (f64, f64, &str) = (-1e6, 1e6, "s");

/// Rows of the log in the file `path`, in the order of the form's columns.
///
/// # Errors
/// [`Diagnostic`] when the file cannot be read, lacks a column, holds a NaN, a decimal comma, a number out of range, or
/// time that does not rise evenly.
pub(crate) fn read<const N: usize>(form: &LogFormat<N>, path: &Path) -> Result<Vec<[f64; N]>, Diagnostic> {
    let bytes = input::read(path, input::LOG).map_err(|e| Diagnostic::io(path, e, form.absent))?;
    let text = String::from_utf8(bytes).map_err(|_| {
        Diagnostic::file(path, "the file is no text", "a log is UTF-8 text", "export it again as CSV in UTF-8")
    })?;
    parse(form, &text, path)
}

/// Rows of the log in `text`; `path` appears only in diagnostics.
///
/// # Errors
/// As [`read`].
pub(crate) fn parse<const N: usize>(form: &LogFormat<N>, text: &str, path: &Path) -> Result<Vec<[f64; N]>, Diagnostic> {
    let text = text.trim_start_matches('\u{feff}');
    let mut reader =
        csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).flexible(true).from_reader(text.as_bytes());
    let header = reader.headers().cloned().map_err(|e| csv_error(path, &e))?;
    let header_line = 1 + text.lines().take_while(|l| l.starts_with('#') || l.trim().is_empty()).count();
    let places = columns(form, path, &header).map_err(|r| r.at_line(header_line))?;
    let layout = Layout { form, path, width: header.len(), places };
    let mut rows: Vec<[f64; N]> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| csv_error(path, &e))?;
        let line = record.position().map(|p| p.line() as usize);
        let row = layout.row(&record).map_err(|r| r.at_line(line))?;
        check_increasing(path, rows.last().map(|before| before[0]), row[0]).map_err(|r| r.at_line(line))?;
        rows.push(row);
    }
    check_whole(text, path)?;
    check_even(path, &rows.iter().map(|row| row[0]).collect::<Vec<_>>())?;
    Ok(rows)
}

fn csv_error(path: &Path, error: &csv::Error) -> Diagnostic {
    let line = error.position().map(|p| p.line() as usize);
    Diagnostic::file(path, "the line is no CSV", error.to_string().to_lowercase(), "export the log again").at_line(line)
}

/// The index of each column of the format in the file.
fn columns<const N: usize>(
    form: &LogFormat<N>,
    path: &Path,
    header: &csv::StringRecord,
) -> Result<[usize; N], Diagnostic> {
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(form.columns) {
        *place = header.iter().position(|h| h == name).ok_or_else(|| missing(form, path, header, name))?;
    }
    Ok(places)
}

fn missing<const N: usize>(form: &LogFormat<N>, path: &Path, header: &csv::StringRecord, name: &str) -> Diagnostic {
    let present: Vec<&str> = header.iter().filter(|h| !form.columns.contains(h)).collect();
    let action = match nearest(name, &present) {
        Some(near) => format!("rename the column `{near}` to `{name}`"),
        None if header.len() == 1 && header[0].contains(';') => "export with commas between columns".to_owned(),
        None => format!("add the column `{name}`"),
    };
    let why = format!("a {} has the columns {}", form.kind, form.columns.join(", "));
    Diagnostic::file(path, format!("the column `{name}` is missing"), why, action)
}

/// The columns of one file.
struct Layout<'a, const N: usize> {
    form: &'a LogFormat<N>,
    path: &'a Path,
    /// Number of columns in the file.
    width: usize,
    /// Index of each column of the format in the file.
    places: [usize; N],
}

impl<const N: usize> Layout<'_, N> {
    fn row(&self, record: &csv::StringRecord) -> Result<[f64; N], Diagnostic> {
        if record.len() != self.width {
            let what = format!("the line has {} fields", record.len());
            let why = format!("the header has {}; a decimal comma also looks like this", self.width);
            return Err(Diagnostic::file(self.path, what, why, "write decimal points, and as many fields as columns"));
        }
        let mut row = [0.0; N];
        for (k, place) in self.places.iter().enumerate() {
            row[k] = number(self.path, self.form.columns[k], &record[*place])?;
            range(self.path, self.form.columns[k], self.form.ranges[k], row[k])?;
        }
        Ok(row)
    }
}

fn number(path: &Path, column: &str, text: &str) -> Result<f64, Diagnostic> {
    let refused = |why: &str, action: &str| Diagnostic::file(path, format!("{column} is `{text}`"), why, action);
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(refused("every sample must be a finite number", "cut the log there, or record the trial again")),
        Err(_) if text.contains(',') => Err(refused("the decimal sign is a point", "export with decimal points")),
        Err(_) => Err(refused("a number was expected", "correct the field, or cut the line out")),
    }
}

fn range(path: &Path, column: &str, (low, high, unit): (f64, f64, &str), value: f64) -> Result<(), Diagnostic> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let what = format!("{column} = {value} is out of range");
    Err(Diagnostic::file(path, what, format!("the range is {low} to {high} {unit}"), "check the unit of the column"))
}

fn check_increasing(path: &Path, before: Option<f64>, time: f64) -> Result<(), Diagnostic> {
    match before {
        Some(before) if time <= before => {
            let what = format!("time_s goes from {before} to {time}");
            Err(Diagnostic::file(
                path,
                what,
                "time must rise from line to line",
                "take the repeated or swapped lines out",
            ))
        }
        _ => Ok(()),
    }
}

/// The last line is as long as the others: a file that was cut in the middle of a number ends without a line end and with fewer decimals
/// than every other line, and would be read as another number.
fn check_whole(text: &str, path: &Path) -> Result<(), Diagnostic> {
    let decimals = |line: &str| -> Vec<usize> {
        line.split(',').map(|field| field.trim().split_once('.').map_or(0, |(_, digits)| digits.len())).collect()
    };
    let mut lines = text.lines().rev();
    let (Some(last), false) = (lines.next(), text.ends_with('\n')) else { return Ok(()) };
    let before: Vec<Vec<usize>> =
        lines.take(COMPARED).take_while(|line| !line.starts_with('#')).map(decimals).collect();
    let found = decimals(last);
    let uniform = before.len() == COMPARED && before.iter().all(|line| *line == before[0]);
    if !uniform || before[0] == found {
        return Ok(());
    }
    let why = "it has no line end and other decimals than the lines before it, as a file that was cut";
    let refused =
        Diagnostic::file(path, format!("the last line is `{last}`"), why, "copy the log again, or cut the line out");
    Err(refused.at_line(text.lines().count()))
}

/// At least two samples, and every step within a fifth of the mean one.
fn check_even(path: &Path, time: &[f64]) -> Result<(), Diagnostic> {
    if time.len() < 2 {
        let what = format!("the log has {} samples", time.len());
        return Err(Diagnostic::file(path, what, "at least two are needed", "record the trial again"));
    }
    let step = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
    match time.windows(2).position(|t| (t[1] - t[0] - step).abs() > 0.2 * step) {
        None => Ok(()),
        Some(i) => {
            let late = time[i + 1] - time[i];
            let what = format!("after time_s = {} the next sample comes {late:.4} s later", time[i]);
            let why = format!("samples come every {step:.4} s, and a step may be a fifth off that");
            Err(Diagnostic::file(path, what, why, "fill the gap from the logger, or cut the log there"))
        }
    }
}
