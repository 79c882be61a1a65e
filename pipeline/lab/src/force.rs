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

use crate::log::{self, LogFormat, TIMES};
use diagnostics::{Diagnostic, input};

/// The columns that every force log has, in the order in which they are written.
pub const COLUMNS: [&str; 2] = ["time_s", "force_n"];

/// Plausible forces of a soft tail and of a light hammer, N.
pub(crate) const RANGE: [Newton; 2] = [-50.0, 50.0];

/// The column of the lamp, where there is one.
pub const LAMP: &str = "led";

const WITH_LAMP: LogFormat<3> = LogFormat {
    kind: FORM.kind,
    columns: [COLUMNS[0], COLUMNS[1], LAMP],
    ranges: [TIMES, (RANGE[0], RANGE[1], "N"), (0.0, 1.0, "(off to on)")],
    absent: FORM.absent,
};

const FORM: LogFormat<2> = LogFormat {
    kind: "force log",
    columns: COLUMNS,
    ranges: [TIMES, (RANGE[0], RANGE[1], "N")],
    absent: "put the force log there, or correct `force` or `hammer` in specimen.toml",
};

/// A force log, every list `samples` long.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ForceLog {
    /// Time on the amplifier's clock, s, strictly increasing and even to a fifth of a step.
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

/// The log in the file `path`, checked.
///
/// # Errors
/// [`Diagnostic`] when the file cannot be read, lacks a column, holds a NaN, a decimal comma, a number out of range, or
/// time that does not rise evenly.
pub fn read(path: &Path) -> Result<ForceLog, Diagnostic> {
    let bytes = input::read(path, input::LOG).map_err(|e| Diagnostic::io(path, e, FORM.absent))?;
    match String::from_utf8(bytes) {
        Ok(text) => parse(&text, path),
        Err(_) => log::read(&FORM, path).map(from_rows),
    }
}

/// The log in `text`; `path` appears only in diagnostics.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<ForceLog, Diagnostic> {
    let header = text.lines().find(|line| !line.starts_with('#') && !line.trim().is_empty()).unwrap_or_default();
    if !header.split(',').any(|name| name.trim() == LAMP) {
        return log::parse(&FORM, text, path).map(from_rows);
    }
    let rows = log::parse(&WITH_LAMP, text, path)?;
    let led = rows.iter().map(|row| row[2]).collect();
    Ok(ForceLog { led, ..from_rows(rows.into_iter().map(|[time, force, _]| [time, force]).collect()) })
}

/// The text of a force log, with fixed digits; `remark` becomes its first line, after a `#`.
pub fn write(log: &ForceLog, remark: &str) -> String {
    let lit = !log.led.is_empty();
    let lamp = if lit { format!(",{LAMP}") } else { String::new() };
    let mut text = format!("# {remark}\n{}{lamp}\n", COLUMNS.join(","));
    for (i, (time, force)) in log.time.iter().zip(&log.force).enumerate() {
        write!(text, "{time:.6},{force:.3}").expect("a string takes any text");
        if lit {
            write!(text, ",{:.3}", log.led[i]).expect("a string takes any text");
        }
        text.push('\n');
    }
    text
}

fn from_rows(rows: Vec<[f64; 2]>) -> ForceLog {
    let (time, force) = rows.into_iter().map(|[time, force]| (time, force)).unzip();
    ForceLog { time, force, led: Vec::new() }
}
