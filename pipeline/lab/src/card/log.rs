//! `[log]`: how the instruments of a laboratory write their logs, and the load cell's own lag.
//!
//! Nothing of it is needed for logs with the titles and units of `data/raw/README.md`. Separator and decimal sign are found in the file.

use serde::{Deserialize, Serialize};
use si::{MILLIBAR, Second};

/// `[log]`.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Log {
    /// A longer time between two samples is a gap, s; three median steps where it is not given, one and a half at least.
    #[serde(default)]
    pub longest_gap: Option<Second>,
    /// How much later than the force the load cell's log shows it, s; estimated from staircases where it is not given.
    #[serde(default)]
    pub force_lag: Option<Second>,
    /// Its standard deviation, s.
    #[serde(default)]
    pub force_lag_sigma: Second,
    /// Columns with other titles, other units or no titles.
    #[serde(default)]
    pub columns: Vec<LogColumn>,
}

/// `[[log.columns]]`: where a quantity stands in the logs.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LogColumn {
    /// The quantity, by the title that its column has in `data/raw/README.md`.
    pub quantity: String,
    /// Its title in the file, or its position from 1.
    pub column: Place,
    /// Its unit; that of the quantity's title where it is not given.
    #[serde(default)]
    pub unit: Option<Unit>,
    /// Of the unit, in which one of the file's numbers is counted: volts or an amplifier's counts have one.
    #[serde(default = "unit_scale")]
    pub scale: f64,
    /// The kind of log that it holds for; every log that has the quantity where it is not given.
    #[serde(default)]
    pub of: Option<LogKind>,
}

fn unit_scale() -> f64 {
    1.0
}

/// A column of a file.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum Place {
    /// From 1.
    Position(usize),
    /// By its title.
    Title(String),
}

/// The instruments that write logs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LogKind {
    /// Commanded and measured pressures.
    Pressure,
    /// The load cell.
    Force,
    /// The instrumented hammer.
    Hammer,
}

/// The unit of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
pub enum Unit {
    /// Seconds.
    #[serde(rename = "s")]
    Second,
    /// Milliseconds.
    #[serde(rename = "ms")]
    Millisecond,
    /// Microseconds.
    #[serde(rename = "us")]
    Microsecond,
    /// Days, as a spreadsheet counts its dates.
    #[serde(rename = "day")]
    Day,
    /// A date with a time of day, `2024-05-01T12:00:00.125`, or a time of day alone.
    #[serde(rename = "iso8601")]
    Iso8601,
    /// Pascals.
    #[serde(rename = "Pa")]
    Pascal,
    /// Millibars.
    #[serde(rename = "mbar")]
    Millibar,
    /// Kilopascals.
    #[serde(rename = "kPa")]
    Kilopascal,
    /// Bars.
    #[serde(rename = "bar")]
    Bar,
    /// Pounds per square inch.
    #[serde(rename = "psi")]
    PoundPerSquareInch,
    /// Newtons.
    #[serde(rename = "N")]
    Newton,
    /// Millinewtons.
    #[serde(rename = "mN")]
    Millinewton,
    /// The weight of a gram, as scales show it.
    #[serde(rename = "gf")]
    GramForce,
    /// No unit.
    #[serde(rename = "1")]
    Ratio,
}

/// Seconds, pascals, newtons or no unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dimension {
    Time,
    Pressure,
    Force,
    None,
}

/// Standard acceleration of free fall, m/s².
const STANDARD_GRAVITY: f64 = 9.806_65;
/// One pound per square inch, Pa.
const PSI: f64 = 6_894.757;

impl LogKind {
    /// The value on the card.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Pressure => "pressure",
            Self::Force => "force",
            Self::Hammer => "hammer",
        }
    }
}

impl Unit {
    /// The value on the card.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Second => "s",
            Self::Millisecond => "ms",
            Self::Microsecond => "us",
            Self::Day => "day",
            Self::Iso8601 => "iso8601",
            Self::Pascal => "Pa",
            Self::Millibar => "mbar",
            Self::Kilopascal => "kPa",
            Self::Bar => "bar",
            Self::PoundPerSquareInch => "psi",
            Self::Newton => "N",
            Self::Millinewton => "mN",
            Self::GramForce => "gf",
            Self::Ratio => "1",
        }
    }

    /// What it measures.
    pub(crate) fn dimension(self) -> Dimension {
        match self {
            Self::Second | Self::Millisecond | Self::Microsecond | Self::Day | Self::Iso8601 => Dimension::Time,
            Self::Pascal | Self::Millibar | Self::Kilopascal | Self::Bar | Self::PoundPerSquareInch => {
                Dimension::Pressure
            }
            Self::Newton | Self::Millinewton | Self::GramForce => Dimension::Force,
            Self::Ratio => Dimension::None,
        }
    }

    /// One of it in the units of our logs: s, mbar, N or none.
    pub(crate) fn in_log_units(self) -> f64 {
        match self {
            Self::Second | Self::Iso8601 | Self::Millibar | Self::Newton | Self::Ratio => 1.0,
            Self::Millisecond | Self::Millinewton => 1e-3,
            Self::Microsecond => 1e-6,
            Self::Day => 86_400.0,
            Self::Pascal => 1.0 / MILLIBAR,
            Self::Kilopascal => 1e3 / MILLIBAR,
            Self::Bar => 1e5 / MILLIBAR,
            Self::PoundPerSquareInch => PSI / MILLIBAR,
            Self::GramForce => 1e-3 * STANDARD_GRAVITY,
        }
    }
}

impl Log {
    /// The entry of the card for a quantity of a log of this kind.
    pub(crate) fn named_column(&self, quantity: &str, kind: LogKind) -> Option<&LogColumn> {
        self.columns.iter().find(|c| c.quantity == quantity && c.of.is_none_or(|of| of == kind))
    }
}

/// What a quantity measures, by the title of its column.
pub(crate) fn dimension_of(quantity: &str) -> Dimension {
    match quantity {
        "time_s" => Dimension::Time,
        "force_n" => Dimension::Force,
        pressure if pressure.ends_with("_mbar") => Dimension::Pressure,
        _ => Dimension::None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_worth_what_physics_says() {
        let worth = [
            (Unit::Second, 1.0),
            (Unit::Millisecond, 1e-3),
            (Unit::Microsecond, 1e-6),
            (Unit::Day, 86_400.0),
            (Unit::Pascal, 0.01),
            (Unit::Millibar, 1.0),
            (Unit::Kilopascal, 10.0),
            (Unit::Bar, 1e3),
            (Unit::PoundPerSquareInch, 68.947_57),
            (Unit::Newton, 1.0),
            (Unit::Millinewton, 1e-3),
            (Unit::GramForce, 9.806_65e-3),
            (Unit::Ratio, 1.0),
        ];
        for (unit, expected) in worth {
            assert!((unit.in_log_units() / expected - 1.0).abs() < 1e-12, "{}", unit.word());
        }
    }
}
