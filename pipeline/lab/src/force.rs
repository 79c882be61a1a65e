//! Force logs (`force.csv`, `hammer.csv`): a force over time, on the clock of the force amplifier.
//!
//! ```text
//! # virtual bench
//! time_s,force_n
//! 0.000000,0.012
//! ```
//! `force.csv` is what the load cell says, some 10 or 80 times a second. `hammer.csv` is what an instrumented hammer says of
//! its blows on the cell's fixture, much faster, on the same clock. Both hold newtons to a millinewton, thrust positive
//! forwards (along −x of the CAD frame). Lines that open with `#` are remarks; other columns may stand beside these.
//!
//! Stands on: `si`, the form of logs. Never knows: the clocks of the video and of the pressure log.

use std::fmt::Write;
use std::path::Path;

use si::{Hertz, Newton, Second, Series};

use crate::Refusal;
use crate::log::{self, Form, TIMES};

/// The columns that every force log has, in the order in which they are written.
pub const COLUMNS: [&str; 2] = ["time_s", "force_n"];

/// Forces outside this range (N) are no soft tail's and no light hammer's.
pub const RANGE: [Newton; 2] = [-50.0, 50.0];

const FORM: Form<2> = Form {
    kind: "force log",
    columns: COLUMNS,
    ranges: [TIMES, (RANGE[0], RANGE[1], "N")],
    absent: "put the force log there, or correct `force` or `hammer` in specimen.toml",
};

/// A force log, both lists `samples` long.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ForceLog {
    /// Time on the amplifier's clock, s, strictly increasing and even to a fifth of a step.
    pub time: Vec<Second>,
    /// N, the zero of the amplifier in it.
    pub force: Vec<Newton>,
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
/// [`Refusal`] when the file cannot be read, lacks a column, holds a NaN, a decimal comma, a number out of range, or
/// time that does not rise evenly.
pub fn read(path: &Path) -> Result<ForceLog, Refusal> {
    log::read(&FORM, path).map(gathered)
}

/// The log in `text`; `path` is only quoted in refusals.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<ForceLog, Refusal> {
    log::parse(&FORM, text, path).map(gathered)
}

/// The text of a force log, with fixed digits; `remark` becomes its first line, after a `#`.
pub fn write(log: &ForceLog, remark: &str) -> String {
    let mut text = format!("# {remark}\n{}\n", COLUMNS.join(","));
    for (time, force) in log.time.iter().zip(&log.force) {
        writeln!(text, "{time:.6},{force:.3}").expect("a string takes any text");
    }
    text
}

fn gathered(rows: Vec<[f64; 2]>) -> ForceLog {
    let (time, force) = rows.into_iter().map(|[time, force]| (time, force)).unzip();
    ForceLog { time, force }
}
