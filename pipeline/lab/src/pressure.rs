//! Pressure logs (`pressure.csv`): commanded and measured pressure of both sides, and the lamp, on the log's own clock.
//!
//! ```text
//! # virtual bench
//! time_s,left_command_mbar,right_command_mbar,left_mbar,right_mbar,led
//! 0.0000,0.00,0.00,0.31,-0.22,0
//! ```
//! Lines that open with `#` are remarks. Columns may stand in any order and others may stand beside them. A byte-order
//! mark and CRLF are tolerated; the decimal sign is a point.
//!
//! Stands on: `si`. Never knows: the video's clock.

mod read;
mod write;

use si::{Hertz, MILLIBAR, Pascal, Second, Series};

use crate::card::Side;

pub use read::{parse, read};
pub use write::write;

/// The columns that every log has, in the order in which they are written.
pub const COLUMNS: [&str; 6] = ["time_s", "left_command_mbar", "right_command_mbar", "left_mbar", "right_mbar", "led"];

/// Measured or commanded pressures outside this range (Pa) are no soft actuator's.
pub const RANGE: [Pascal; 2] = [-20_000.0, 500_000.0];

/// One side of a log: `samples` each.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Channel {
    /// What the valve was asked for, Pa over ambient.
    pub command: Vec<Pascal>,
    /// What the sensor read, Pa over ambient.
    pub measured: Vec<Pascal>,
}

/// A pressure log, every list `samples` long.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PressureLog {
    /// Time on the log's clock, s, strictly increasing and even to a fifth of a step.
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
