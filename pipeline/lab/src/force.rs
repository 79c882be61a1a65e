//! Force logs (`force.csv`, `hammer.csv`): a force over time, on the clock of the force amplifier.
//!
//! ```text
//! # virtual bench
//! time_s,force_n
//! 0.000000,0.012
//! ```
//! `force.csv` is the load cell's force at about 10 or 80 Hz. `hammer.csv` is the force of an instrumented hammer on the
//! cell's fixture, at a much higher rate, on the same clock. Both hold newtons to a millinewton, thrust positive
//! forwards (along −x of the CAD frame). A log of a filmed trial has a third column, `led`: the drive of the lamp from 0 to 1, a
//! mean over the sampling interval around each time, which ties its clock to the film's. Lines that open with `#` are remarks;
//! other columns may stand beside these.

use std::fmt::Write;
use std::path::Path;

use si::{Hertz, Newton, Second, Series};

use crate::card::{Log, LogKind};
use crate::log::{self, ColumnFormat, LogFormat, LogText, Logged, Spikes, StampReport};
use diagnostics::Diagnostic;

/// The columns that every force log has, in the order in which they are written.
pub const COLUMNS: [&str; 2] = ["time_s", "force_n"];

/// Plausible forces of a soft tail and of a light hammer, N.
pub(crate) const RANGE: [Newton; 2] = [-50.0, 50.0];

/// The column of the lamp, where there is one.
pub const LAMP: &str = "led";

const ABSENT: &str = "put the force log there, or correct `force` or `hammer` in specimen.toml";

const FORCE: (f64, f64, &str) = (RANGE[0], RANGE[1], "N");

fn force_format(instrument: LogKind) -> LogFormat {
    let columns = vec![ColumnFormat::time(), ColumnFormat::measured(COLUMNS[1], FORCE)];
    LogFormat { kind: "force log", instrument, columns, spikes: spike_kinds(instrument) }
}

/// A hammer's blow is as short as a spike, but does not reach full scale.
fn spike_kinds(instrument: LogKind) -> Spikes {
    match instrument {
        LogKind::Force => Spikes::LoneJumps,
        LogKind::Hammer => Spikes::FullScale,
        LogKind::Pressure => Spikes::None,
    }
}

fn lamp_format(instrument: LogKind) -> LogFormat {
    let mut format = force_format(instrument);
    format.columns.push(ColumnFormat::measured(LAMP, (0.0, 1.0, "(off to on)")));
    format
}

/// A force log, every list `samples` long.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ForceLog {
    /// Time on the amplifier's clock, s, strictly increasing and even.
    pub time: Vec<Second>,
    /// Force with the amplifier's zero offset, N.
    pub force: Vec<Newton>,
    /// Drive of the lamp, 0 to 1; empty where the log has no such column.
    pub led: Vec<f64>,
}

impl ForceLog {
    /// Mean sampling rate, Hz.
    pub fn rate(&self) -> Hertz {
        let last = self.time.len() - 1;
        last as f64 / (self.time[last] - self.time[0])
    }

    /// The force (N) as a series on the log's clock.
    pub fn series(&self) -> Series {
        Series::new(self.time[0], self.rate(), self.force.clone())
            .expect("a log is read with finite samples and rising time")
    }
}

/// The log in the file `path`, checked, of columns as `data/raw/README.md` has them.
///
/// # Errors
/// [`Diagnostic`] when the file cannot be read, lacks a column, holds a NaN, a number out of range, a gap, or time that does not rise.
pub fn read(path: &Path) -> Result<ForceLog, Diagnostic> {
    parse(&log::read_text(path, ABSENT)?, path)
}

/// The log in `text`; `path` appears only in diagnostics.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<ForceLog, Diagnostic> {
    parse_as(text, path, (LogKind::Force, &Log::default())).map(|logged| logged.log)
}

/// The log of an instrument in `text`, of columns as the card has them, on an even clock; `path` appears only in diagnostics.
///
/// # Errors
/// As [`read`].
pub fn parse_as(text: &str, path: &Path, (kind, card): (LogKind, &Log)) -> Result<Logged<ForceLog>, Diagnostic> {
    parse_force(&LogText::new(text, path), &spike_kinds(kind), (kind, card))
}

/// The load cell's log in `text` while its fixture was tapped: a sample alone may be a tap, unless it is at full scale.
///
/// # Errors
/// As [`read`].
pub fn parse_taps(text: &str, path: &Path, card: &Log) -> Result<Logged<ForceLog>, Diagnostic> {
    parse_force(&LogText::new(text, path), &Spikes::FullScale, (LogKind::Force, card))
}

fn parse_force(text: &LogText, spikes: &Spikes, (kind, card): (LogKind, &Log)) -> Result<Logged<ForceLog>, Diagnostic> {
    let with_led = LogFormat { spikes: *spikes, ..lamp_format(kind) };
    if !text.has_quantity(&with_led, card, LAMP) {
        let Logged { log, sampling } = text.parse(&LogFormat { spikes: *spikes, ..self::force_format(kind) }, card)?;
        return Ok(Logged { log: from_rows(log), sampling });
    }
    let Logged { log: rows, sampling } = text.parse(&with_led, card)?;
    let led = rows.iter().map(|row| row[2]).collect();
    Ok(Logged { log: ForceLog { led, ..from_rows(rows) }, sampling })
}

/// What the stamps of an instrument's log in `text` show, whether or not it can be used.
///
/// # Errors
/// [`Diagnostic`] when a column is missing, or a field is no number or out of range.
pub fn stamps(text: &str, path: &Path, (kind, card): (LogKind, &Log)) -> Result<StampReport, Diagnostic> {
    LogText::new(text, path).stamp_report(&force_format(kind), card)
}

/// What the stamps of the load cell's log of taps in `text` show.
///
/// # Errors
/// As [`stamps`].
pub fn stamps_of_taps(text: &str, path: &Path, card: &Log) -> Result<StampReport, Diagnostic> {
    let format = LogFormat { spikes: Spikes::FullScale, ..force_format(LogKind::Force) };
    LogText::new(text, path).stamp_report(&format, card)
}

/// The text of a force log, with fixed digits; `remark` becomes its first line, after a `#`.
pub fn write(log: &ForceLog, remark: &str) -> String {
    let has_lamp = !log.led.is_empty();
    let lamp_title = if has_lamp { format!(",{LAMP}") } else { String::new() };
    let mut text = format!("# {remark}\n{}{lamp_title}\n", COLUMNS.join(","));
    for (i, (time, force)) in log.time.iter().zip(&log.force).enumerate() {
        write!(text, "{time:.6},{force:.3}").expect("a string takes any text");
        if has_lamp {
            write!(text, ",{:.3}", log.led[i]).expect("a string takes any text");
        }
        text.push('\n');
    }
    text
}

fn from_rows(rows: Vec<Vec<f64>>) -> ForceLog {
    let (time, force) = rows.into_iter().map(|row| (row[0], row[1])).unzip();
    ForceLog { time, force, led: Vec::new() }
}
