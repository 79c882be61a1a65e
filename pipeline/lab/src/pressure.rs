//! Pressure logs (`pressure.csv`): commanded and measured pressure of both sides, and the lamp, on the log's own clock.
//!
//! ```text
//! # virtual bench
//! time_s,left_command_mbar,right_command_mbar,left_mbar,right_mbar,led
//! 0.0000,0.00,0.00,0.31,-0.22,0
//! ```
//! Lines that open with `#` are remarks. Columns may stand in any order and others may stand beside them. A byte-order
//! mark, CRLF, tabs and semicolons, and decimal commas are tolerated; `[[log.columns]]` of the card names other titles and units.

use std::fmt::Write;
use std::path::Path;

use si::{Hertz, MILLIBAR, Pascal, Second, Series};

use crate::card::{Log, LogKind, Side};
use crate::log::{self, LogFormat, LogText, Logged, StampReport, TIMES};
use diagnostics::Diagnostic;

/// The columns that every log has, in the order in which they are written.
pub const COLUMNS: [&str; 6] = ["time_s", "left_command_mbar", "right_command_mbar", "left_mbar", "right_mbar", "led"];

/// Plausible pressures of a soft actuator, Pa.
pub(crate) const RANGE: [Pascal; 2] = [-20_000.0, 500_000.0];

/// One side of a log: `samples` each.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Channel {
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
    /// The left side.
    pub left: Channel,
    /// The right side.
    pub right: Channel,
    /// Drive of the lamp, 0 to 1.
    pub led: Vec<f64>,
}

impl PressureLog {
    /// One side.
    pub fn side(&self, side: Side) -> &Channel {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }

    /// Mean sampling rate, Hz.
    pub fn rate(&self) -> Hertz {
        let last = self.time.len() - 1;
        last as f64 / (self.time[last] - self.time[0])
    }

    /// Any list of the log (`log.led`, `log.left.measured`, …) as a series on the log's clock.
    pub fn series(&self, values: &[f64]) -> Series {
        Series::new(self.time[0], self.rate(), values.to_vec())
            .expect("a log is read with finite samples and rising time")
    }

    /// Measured pressure (Pa) of a side on the log's clock.
    pub fn measured(&self, side: Side) -> Series {
        self.series(&self.side(side).measured)
    }

    /// Commanded pressure (Pa) of a side on the log's clock.
    pub fn command(&self, side: Side) -> Series {
        self.series(&self.side(side).command)
    }

    /// Appends time (s) and measured pressures (mbar) alone.
    fn push_measured(&mut self, [time, left, right]: [f64; 3]) {
        self.time.push(time);
        self.left.measured.push(left * MILLIBAR);
        self.right.measured.push(right * MILLIBAR);
    }

    /// Appends a sample given in the units of the file (s, mbar, 0 to 1), in the order of [`COLUMNS`].
    fn push(&mut self, row: [f64; 6]) {
        self.time.push(row[0]);
        self.left.command.push(row[1] * MILLIBAR);
        self.right.command.push(row[2] * MILLIBAR);
        self.left.measured.push(row[3] * MILLIBAR);
        self.right.measured.push(row[4] * MILLIBAR);
        self.led.push(row[5]);
    }
}

const MBAR: (f64, f64, &str) = (RANGE[0] / MILLIBAR, RANGE[1] / MILLIBAR, "mbar");

const FORM: LogFormat<6> = LogFormat {
    kind: "pressure log",
    instrument: LogKind::Pressure,
    columns: COLUMNS,
    ranges: [TIMES, MBAR, MBAR, MBAR, MBAR, (0.0, 1.0, "(off to on)")],
    held: [false, true, true, false, false, false],
    absent: "put the trial's log there, or correct `pressure` of the trial in specimen.toml",
};

/// The log in the file `path`, checked, of columns as `data/raw/README.md` has them.
///
/// # Errors
/// [`Diagnostic`] when the file cannot be read, lacks a column, holds a NaN, a number out of range, a gap, or time that does not rise.
pub fn read(path: &Path) -> Result<PressureLog, Diagnostic> {
    parse(&log::text(path, FORM.absent)?, path)
}

/// The log in `text`; `path` appears only in diagnostics.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<PressureLog, Diagnostic> {
    parse_as(text, path, &Log::default()).map(|logged| logged.log)
}

/// The log in `text`, of columns as the card has them, on an even clock; `path` appears only in diagnostics.
///
/// # Errors
/// As [`read`].
pub fn parse_as(text: &str, path: &Path, card: &Log) -> Result<Logged<PressureLog>, Diagnostic> {
    let Logged { log, sampling } = LogText::new(text, path)?.parse(&FORM, card)?;
    Ok(Logged { log: from_rows(log), sampling })
}

/// A log of measured pressures, with or without a lamp; it has no commands.
const MEASURED: LogFormat<3> = LogFormat {
    kind: "pressure log",
    instrument: LogKind::Pressure,
    columns: ["time_s", "left_mbar", "right_mbar"],
    ranges: [TIMES, MBAR, MBAR],
    held: [false; 3],
    absent: FORM.absent,
};

const MEASURED_WITH_LAMP: LogFormat<4> = LogFormat {
    kind: "pressure log",
    instrument: LogKind::Pressure,
    columns: ["time_s", "left_mbar", "right_mbar", "led"],
    ranges: [TIMES, MBAR, MBAR, (0.0, 1.0, "(off to on)")],
    held: [false; 4],
    absent: FORM.absent,
};

/// The measured pressures of the log in `text`, which needs neither commands nor lamp; those lists are empty where it has none.
///
/// # Errors
/// As [`read`].
pub fn parse_measured(text: &str, path: &Path, card: &Log) -> Result<Logged<PressureLog>, Diagnostic> {
    let text = LogText::new(text, path)?;
    let mut log = PressureLog::default();
    let sampling = if text.has(&MEASURED_WITH_LAMP, card, "led") {
        let Logged { log: rows, sampling } = text.parse(&MEASURED_WITH_LAMP, card)?;
        rows.into_iter().for_each(|[time, left, right, led]| {
            log.push_measured([time, left, right]);
            log.led.push(led);
        });
        sampling
    } else {
        let Logged { log: rows, sampling } = text.parse(&MEASURED, card)?;
        rows.into_iter().for_each(|row| log.push_measured(row));
        sampling
    };
    Ok(Logged { log, sampling })
}

/// What the stamps of the log in `text` show, whether or not it can be used.
///
/// # Errors
/// [`Diagnostic`] when a column is missing, or a field is no number or out of range.
pub fn stamps(text: &str, path: &Path, card: &Log) -> Result<StampReport, Diagnostic> {
    LogText::new(text, path)?.stamps(&FORM, card)
}

fn from_rows(rows: Vec<[f64; 6]>) -> PressureLog {
    let mut log = PressureLog::default();
    rows.into_iter().for_each(|row| log.push(row));
    log
}

/// The text of `pressure.csv`; `remark` becomes its first line, after a `#`.
pub fn write(log: &PressureLog, remark: &str) -> String {
    let mut text = format!("# {remark}\n{}\n", COLUMNS.join(","));
    for (i, time) in log.time.iter().enumerate() {
        let mbar = |values: &[f64]| values[i] / MILLIBAR;
        let (left, right) = (&log.left, &log.right);
        writeln!(
            text,
            "{time:.6},{:.2},{:.2},{:.2},{:.2},{}",
            mbar(&left.command),
            mbar(&right.command),
            mbar(&left.measured),
            mbar(&right.measured),
            log.led[i]
        )
        .expect("a string takes any text");
    }
    text
}
