//! Pressure logs (`pressure.csv`): commanded and measured pressure of every channel, and the lamp, on the log's own clock.
//!
//! ```text
//! # virtual bench
//! time_s,left_command_mbar,right_command_mbar,left_mbar,right_mbar,led
//! 0.0000,0.00,0.00,0.31,-0.22,0
//! ```
//! A channel is one valve with its sensor; the card names them, and its names begin the titles of their columns. Lines that open with
//! `#` are remarks. Columns may stand in any order and others may stand beside them. A byte-order mark, CRLF, tabs and semicolons, and
//! decimal commas are tolerated; `[[log.columns]]` of the card names other titles and units.

use std::fmt::Write;
use std::path::Path;

use si::{Hertz, MILLIBAR, Pascal, Second, Series};

use crate::card::{Log, LogKind};
use crate::log::{self, ColumnFormat, LogFormat, LogText, Logged, Spikes, StampReport};
use diagnostics::Diagnostic;

/// Plausible pressures of a soft actuator, Pa.
pub(crate) const RANGE: [Pascal; 2] = [-20_000.0, 500_000.0];

/// The column of the lamp.
const LAMP: &str = "led";

const ABSENT: &str = "put the trial's log there, or correct `pressure` of the trial in specimen.toml";

/// One channel of a log: `samples` each.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Channel {
    /// Its name on the card.
    pub name: String,
    /// Command of the valve, Pa over ambient.
    pub command: Vec<Pascal>,
    /// Reading of the sensor, Pa over ambient.
    pub measured: Vec<Pascal>,
}

/// A pressure log, every list `samples` long.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PressureLog {
    /// Time on the log's clock, s, strictly increasing and even.
    pub time: Vec<Second>,
    /// The channels, in the order in which they were requested.
    pub channels: Vec<Channel>,
    /// Drive of the lamp, 0 to 1; empty where it is not read.
    pub led: Vec<f64>,
}

/// How a log is written: the names of its channels, and what the card says of the instrument.
#[derive(Debug, Clone, Copy)]
pub struct Layout<'a> {
    /// The names of the channels.
    pub channels: &'a [String],
    /// Whether it has the lamp's column: a film is synchronised by it.
    pub lamp: bool,
    /// `[log]` of the card.
    pub log: &'a Log,
}

impl PressureLog {
    /// A log of these channels without a sample.
    pub fn of(channels: &[String]) -> Self {
        let channel = |name: &String| Channel { name: name.clone(), ..Channel::default() };
        Self { channels: channels.iter().map(channel).collect(), ..Self::default() }
    }

    /// A channel by its name; none where the log has no such channel.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Mean sampling rate, Hz.
    pub fn rate(&self) -> Hertz {
        let last = self.time.len() - 1;
        last as f64 / (self.time[last] - self.time[0])
    }

    /// Any list of the log (`log.led`, `channel.measured`, …) as a series on the log's clock.
    pub fn series(&self, values: &[f64]) -> Series {
        Series::new(self.time[0], self.rate(), values.to_vec())
            .expect("a log is read with finite samples and rising time")
    }
}

/// The title of a channel's command.
pub fn command_title(channel: &str) -> String {
    format!("{channel}_command_mbar")
}

/// The title of a channel's measured pressure.
pub fn measured_title(channel: &str) -> String {
    format!("{channel}_mbar")
}

/// The titles of a log with these channels, in the order in which they are written.
pub fn titles(channels: &[String]) -> Vec<String> {
    let commands = channels.iter().map(|name| command_title(name));
    let measured = channels.iter().map(|name| measured_title(name));
    std::iter::once("time_s".to_owned()).chain(commands).chain(measured).chain([LAMP.to_owned()]).collect()
}

const MBAR: (f64, f64, &str) = (RANGE[0] / MILLIBAR, RANGE[1] / MILLIBAR, "mbar");

fn lamp_column() -> ColumnFormat {
    ColumnFormat::measured(LAMP, (0.0, 1.0, "(off to on)"))
}

/// Time, and the measured pressure of each channel.
fn measured_format(channels: &[String]) -> LogFormat {
    let pressures = channels.iter().map(|name| ColumnFormat::measured(&measured_title(name), MBAR));
    let columns = std::iter::once(ColumnFormat::time()).chain(pressures).collect();
    LogFormat { kind: "pressure log", instrument: LogKind::Pressure, columns, spikes: Spikes::None }
}

/// The columns of [`titles`], without a lamp where the log needs none.
fn log_format(layout: Layout<'_>) -> LogFormat {
    let mut format = measured_format(layout.channels);
    let commands = layout.channels.iter().map(|name| ColumnFormat::command(&command_title(name), MBAR));
    format.columns.splice(1..1, commands);
    format.columns.extend(layout.lamp.then(lamp_column));
    format
}

/// The log in the file `path`, checked, of columns as `data/raw/README.md` has them.
///
/// # Errors
/// [`Diagnostic`] when the file cannot be read, lacks a column, holds a NaN, a number out of range, a gap, or time that does not rise.
pub fn read(path: &Path, channels: &[String]) -> Result<PressureLog, Diagnostic> {
    parse(&log::read_text(path, ABSENT)?, path, channels)
}

/// The log in `text`; `path` appears only in diagnostics.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path, channels: &[String]) -> Result<PressureLog, Diagnostic> {
    parse_as(text, path, Layout { channels, lamp: true, log: &Log::default() }).map(|logged| logged.log)
}

/// The log in `text`, of columns as the card has them, on an even clock; `path` appears only in diagnostics.
///
/// # Errors
/// As [`read`].
pub fn parse_as(text: &str, path: &Path, layout: Layout<'_>) -> Result<Logged<PressureLog>, Diagnostic> {
    let Logged { log: rows, sampling } = LogText::new(text, path).parse(&log_format(layout), layout.log)?;
    let count = layout.channels.len();
    let mut log = PressureLog::of(layout.channels);
    log.time = column_values(&rows, 0);
    for (k, channel) in log.channels.iter_mut().enumerate() {
        channel.command = pressure_values(&rows, 1 + k);
        channel.measured = pressure_values(&rows, 1 + count + k);
    }
    if layout.lamp {
        log.led = column_values(&rows, 1 + 2 * count);
    }
    Ok(Logged { log, sampling })
}

/// The measured pressures of the log in `text`, which needs neither commands nor lamp; those lists are empty where it has none.
///
/// # Errors
/// As [`read`].
pub fn parse_measured(text: &str, path: &Path, layout: Layout<'_>) -> Result<Logged<PressureLog>, Diagnostic> {
    let text = LogText::new(text, path);
    let mut format = measured_format(layout.channels);
    format.columns.push(lamp_column());
    let has_lamp = text.has_quantity(&format, layout.log, LAMP);
    format.columns.truncate(format.columns.len() - usize::from(!has_lamp));
    let Logged { log: rows, sampling } = text.parse(&format, layout.log)?;
    let mut log = PressureLog::of(layout.channels);
    log.time = column_values(&rows, 0);
    log.channels.iter_mut().enumerate().for_each(|(k, channel)| channel.measured = pressure_values(&rows, 1 + k));
    if has_lamp {
        log.led = column_values(&rows, 1 + layout.channels.len());
    }
    Ok(Logged { log, sampling })
}

/// What the stamps of the log in `text` show, whether or not it can be used.
///
/// # Errors
/// [`Diagnostic`] when a column is missing, or a field is no number or out of range.
pub fn stamps(text: &str, path: &Path, layout: Layout<'_>) -> Result<StampReport, Diagnostic> {
    LogText::new(text, path).stamp_report(&log_format(layout), layout.log)
}

fn column_values(rows: &[Vec<f64>], k: usize) -> Vec<f64> {
    rows.iter().map(|row| row[k]).collect()
}

fn pressure_values(rows: &[Vec<f64>], k: usize) -> Vec<Pascal> {
    rows.iter().map(|row| row[k] * MILLIBAR).collect()
}

/// The text of `pressure.csv`; `remark` becomes its first line, after a `#`.
pub fn write(log: &PressureLog, remark: &str) -> String {
    let names: Vec<String> = log.channels.iter().map(|channel| channel.name.clone()).collect();
    let mut text = format!("# {remark}\n{}\n", titles(&names).join(","));
    for (i, time) in log.time.iter().enumerate() {
        let commands = log.channels.iter().map(|channel| channel.command[i]);
        let pressures = commands.chain(log.channels.iter().map(|channel| channel.measured[i]));
        let fields: String = pressures.map(|pressure| format!(",{:.2}", pressure / MILLIBAR)).collect();
        writeln!(text, "{time:.6}{fields},{}", log.led[i]).expect("a string takes any text");
    }
    text
}
