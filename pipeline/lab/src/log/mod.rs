//! Logs as instruments write them: columns of numbers with or without titles, on a clock that need not be even.
//!
//! The separator is `,`, `;`, a tab or a run of blanks; where it is no comma, a comma is the decimal sign. Lines that open with `#` are remarks;
//! `head` has what else may stand above the numbers, [`encoding`] in what letters. Columns may stand in any order and others may stand beside
//! them; `[[log.columns]]` of the card names those with other titles or units. A number at the full scale of an amplifier and a lone jump of a
//! force are no force (`spikes`). An uneven log is resampled onto an even clock; a gap and a time that does not rise are refused with their line.

mod clock_wrap;
mod columns;
mod dialect;
pub mod encoding;
mod even;
mod evenness;
mod grouping;
mod head;
mod parabola;
mod sampling;
mod spikes;
pub mod table;
mod time;
mod units;

use std::path::Path;

use si::Second;

use crate::card::{Log, LogKind};
use columns::FirstLine;
use diagnostics::{Diagnostic, input};
use dialect::Dialect;
use head::{Head, is_content, numbered_lines};
use sampling::Stamps;
pub use sampling::{InterpolationBound, Method, RateChange, Sampling, StampFault, StampFaultKind};
pub use spikes::Spike;
pub(crate) use spikes::Spikes;
pub use time::are_spreadsheet_days;
pub(crate) use time::iso8601;

/// The columns of one kind of log; the first one is time in s.
pub(crate) struct LogFormat {
    /// What the log is called in messages.
    pub kind: &'static str,
    /// What writes it.
    pub instrument: LogKind,
    /// The columns.
    pub columns: Vec<ColumnFormat>,
    /// What of its second column is no reading.
    pub spikes: Spikes,
}

/// One column of a kind of log.
#[derive(Debug, Clone)]
pub(crate) struct ColumnFormat {
    /// Its title.
    pub title: String,
    /// The lowest and the highest number in it, and the unit, in the units of `data/raw/README.md`.
    pub range: (f64, f64, &'static str),
    /// Whether it is a command, which is taken from the nearest sample; others are interpolated linearly.
    pub held: bool,
}

impl ColumnFormat {
    /// The log's clock: plausible times, s, include those since 1970.
    pub fn time() -> Self {
        Self::measured("time_s", (-1e10, 1e10, "s"))
    }

    /// A measured quantity.
    pub fn measured(title: &str, range: (f64, f64, &'static str)) -> Self {
        Self { title: title.to_owned(), range, held: false }
    }

    /// A command.
    pub fn command(title: &str, range: (f64, f64, &'static str)) -> Self {
        Self { held: true, ..Self::measured(title, range) }
    }
}

impl LogFormat {
    /// The titles of its columns.
    pub(crate) fn column_titles(&self) -> Vec<&str> {
        self.columns.iter().map(|column| column.title.as_str()).collect()
    }
}

/// A log, and how it was sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct Logged<T> {
    /// The log on an even clock.
    pub log: T,
    /// How the samples lay in time.
    pub sampling: Sampling,
}

/// What the stamps of a log show, whether or not it can be read.
#[derive(Debug, Clone, PartialEq)]
pub struct StampReport {
    /// How the samples lie in time; none where a time does not rise.
    pub sampling: Option<Sampling>,
    /// Gaps, repeated and backward times.
    pub faults: Vec<StampFault>,
    /// A change of the clock's rate.
    pub rate_change: Option<RateChange>,
}

/// Lines before the last that show with how many decimals the log is written.
const COMPARED: usize = 10;

/// The text of the log in the file `path`.
///
/// # Errors
/// [`Diagnostic`] when the file cannot be read or is no text.
pub(crate) fn read_text(path: &Path, absent: &str) -> Result<String, Diagnostic> {
    let bytes = input::read(path, input::LOG).map_err(|e| Diagnostic::io(path, e, absent))?;
    decoded(bytes, path)
}

/// The text of a log of these bytes; `path` appears only in diagnostics.
///
/// # Errors
/// [`Diagnostic`] when they are no text.
pub fn decoded(bytes: Vec<u8>, path: &Path) -> Result<String, Diagnostic> {
    encoding::decode_text(bytes).ok_or_else(|| {
        let reason = "a log is text in UTF-8, UTF-16 or Windows-1252";
        Diagnostic::file(path, "the file is no text", reason, "export it again as CSV in UTF-8")
    })
}

/// A text of which the first line is known.
pub(crate) struct LogText<'a> {
    text: &'a str,
    first: FirstLine<'a>,
    first_line: usize,
    /// Where the numbers begin.
    begin: usize,
}

impl<'a> LogText<'a> {
    /// Finds separator and titles; `path` appears only in diagnostics.
    pub(crate) fn new(text: &'a str, path: &'a Path) -> Self {
        let text = text.trim_start_matches('\u{feff}');
        let Head { dialect, titles, units, begin, width } = Head::new(text);
        let first = titles.or_else(|| numbered_lines(text).nth(begin - 1)).unwrap_or((begin, ""));
        let fields = dialect.split_titles(first.1, width);
        let first_line = first.0;
        let units = units.map(|(_, line)| dialect.split_titles(line, width)).unwrap_or_default();
        let first = FirstLine { path, dialect, titled: titles.is_some(), fields, units, width };
        Self { text, first, first_line, begin }
    }

    /// Whether a quantity stands in it.
    pub(crate) fn has_quantity(&self, format: &LogFormat, card: &Log, quantity: &str) -> bool {
        self.first.has_quantity(format, card, quantity)
    }

    /// Its numbers, unchecked in time.
    fn parse_rows(&self, format: &LogFormat, card: &Log) -> Result<Rows, Diagnostic> {
        let layout = self.first.column_layout(format, card).map_err(|r| r.at_line(self.first_line))?;
        let (path, dialect) = (self.first.path, self.first.dialect);
        let mut rows = Rows::default();
        for (line, text) in numbered_lines(self.text).skip(self.begin - 1).filter(is_content) {
            rows.rows.push(layout.row_values(text).map_err(|r| r.at_line(line))?);
            rows.lines.push(line);
        }
        layout.check_grouping(|| numbered_lines(self.text).skip(self.begin - 1).filter(is_content))?;
        check_whole(self.text, dialect, path)?;
        if rows.rows.len() < 2 {
            let defect = format!("the log has {} samples", rows.rows.len());
            return Err(Diagnostic::file(path, defect, "at least two are needed", "record the trial again"));
        }
        rows.spikes = format.spikes.leave_out(&mut rows.rows, &rows.lines, layout.unit_factor(1));
        rows.unwrap_clock();
        layout.check_clock(&rows.row_times()).map_err(|diagnostic| diagnostic.at_line(rows.lines[0]))?;
        let mut numbered_rows = rows.rows.iter().zip(&rows.lines);
        numbered_rows
            .try_for_each(|(row, line)| layout.check_ranges(row).map_err(|diagnostic| diagnostic.at_line(*line)))?;
        spikes::check_saturation(format.spikes, &rows, (path, layout.unit_factor(1)))?;
        Ok(rows)
    }

    /// Its numbers on an even clock, in the order of the format's columns.
    ///
    /// # Errors
    /// [`Diagnostic`] when a column is missing, a field is no number or out of range, there is a gap, or time does not rise.
    pub(crate) fn parse(&self, format: &LogFormat, card: &Log) -> Result<Logged<Vec<Vec<f64>>>, Diagnostic> {
        let rows = self.parse_rows(format, card)?;
        let times = rows.row_times();
        let stamps = Stamps { times: &times, lines: &rows.lines };
        let longest_gap = stamps.longest_gap(card.longest_gap);
        if let Some(diagnostic) = first_fault(&stamps.faults(longest_gap), longest_gap) {
            return Err(diagnostic
                .in_file(self.first.path)
                .at_line(stamps.faults(longest_gap).first().map(|f| f.line)));
        }
        let mut sampling = Sampling { spikes: rows.spikes, ..stamps.sampling(longest_gap) };
        let log = even::onto_even_clock(rows.rows, (format, &stamps), &mut sampling);
        Ok(Logged { log, sampling })
    }

    /// What its stamps show.
    ///
    /// # Errors
    /// [`Diagnostic`] when a column is missing, or a field is no number or out of range.
    pub(crate) fn stamp_report(&self, format: &LogFormat, card: &Log) -> Result<StampReport, Diagnostic> {
        let rows = self.parse_rows(format, card)?;
        let times = rows.row_times();
        let stamps = Stamps { times: &times, lines: &rows.lines };
        let longest_gap = stamps.longest_gap(card.longest_gap);
        let faults = stamps.faults(longest_gap);
        let rising = faults.iter().all(|fault| fault.kind == StampFaultKind::Gap);
        let sampling = rising.then(|| {
            let mut sampling = Sampling { spikes: rows.spikes.clone(), ..stamps.sampling(longest_gap) };
            let _ = even::onto_even_clock(rows.rows.clone(), (format, &stamps), &mut sampling);
            sampling
        });
        // A gap bends the line of the stamps as a change of rate does.
        let rate_change = faults.is_empty().then(|| stamps.rate_change()).flatten();
        Ok(StampReport { sampling, faults, rate_change })
    }
}

/// Rows of a log and their lines.
#[derive(Default)]
struct Rows {
    rows: Vec<Vec<f64>>,
    lines: Vec<usize>,
    spikes: Vec<Spike>,
}

impl Rows {
    fn row_times(&self) -> Vec<Second> {
        self.rows.iter().map(|row| row[0]).collect()
    }

    fn unwrap_clock(&mut self) {
        let mut times = self.row_times();
        clock_wrap::unwrap_times(&mut times);
        // length: a time for each row
        self.rows.iter_mut().zip(times).for_each(|(row, time)| row[0] = time);
    }
}

/// The first of the faults as a diagnostic, with the lines of the others like it.
fn first_fault(faults: &[StampFault], longest_gap: Second) -> Option<Diagnostic> {
    let fault = faults.first()?;
    let similar_lines: Vec<String> =
        faults[1..].iter().filter(|f| f.kind == fault.kind).take(5).map(|f| f.line.to_string()).collect();
    let more = if similar_lines.is_empty() {
        String::new()
    } else {
        format!("; so it is on line {}", similar_lines.join(", "))
    };
    Some(fault.as_diagnostic(longest_gap, &more))
}

impl StampFault {
    /// It as a diagnostic without its place.
    fn as_diagnostic(&self, longest_gap: Second, more: &str) -> Diagnostic {
        let (before, time) = (self.before, self.time);
        match self.kind {
            StampFaultKind::Gap => Diagnostic::new(
                format!("after time_s = {before} the next sample comes {:.4} s later", time - before),
                format!(
                    "samples may be {longest_gap:.4} s apart (specimen.toml, [log] longest_gap, or three steps){more}"
                ),
                "fill the gap from the logger, cut the log there, or raise longest_gap where nothing happens in it",
            ),
            StampFaultKind::Repeated => Diagnostic::new(
                format!("time_s = {time} is repeated"),
                format!("time must rise from line to line{more}"),
                "take the repeated lines out, or log time with more digits",
            ),
            StampFaultKind::Backward => Diagnostic::new(
                format!("time_s goes from {before} to {time}"),
                format!("time must rise from line to line{more}"),
                "take the swapped lines out, or cut the log where its clock was set back",
            ),
        }
    }

    /// It as a diagnostic about the file `path`.
    pub fn in_file(&self, path: &Path, longest_gap: Second) -> Diagnostic {
        self.as_diagnostic(longest_gap, "").in_file(path).at_line(self.line)
    }
}

/// The last line is as long as the others: a file that was cut in the middle of a number ends without a line end and with fewer decimals
/// than every other line, and would be read as another number.
fn check_whole(text: &str, dialect: Dialect, path: &Path) -> Result<(), Diagnostic> {
    let decimal_count =
        |field: &str| dialect.decimal_text(field.trim()).split_once('.').map_or(0, |(_, digits)| digits.len());
    let decimals =
        |line: &str| -> Vec<usize> { line.split(char::from(dialect.separator)).map(decimal_count).collect() };
    let mut lines = text.lines().rev();
    let (Some(last), false) = (lines.next(), text.ends_with('\n')) else { return Ok(()) };
    let previous_decimals: Vec<Vec<usize>> =
        lines.take(COMPARED).take_while(|line| !line.starts_with('#')).map(decimals).collect();
    let last_decimals = decimals(last);
    let uniform =
        previous_decimals.len() == COMPARED && previous_decimals.iter().all(|line| *line == previous_decimals[0]);
    if !uniform || previous_decimals[0] == last_decimals {
        return Ok(());
    }
    let reason = "it has no line end and other decimals than the lines before it, as a file that was cut";
    let diagnostic =
        Diagnostic::file(path, format!("the last line is `{last}`"), reason, "copy the log again, or cut the line out");
    Err(diagnostic.at_line(text.lines().count()))
}
