//! Writing a pressure log with fixed digits, so that the same log has the same bytes.
//!
//! Stands on: the log's columns. Never knows: where the file goes.

use std::fmt::Write;

use super::{COLUMNS, PressureLog};
use si::MILLIBAR;

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
