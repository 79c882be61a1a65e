//! Logs: tables of text with their encoding, dialect, columns, units, and how long their lamp is on.

use diagnostics::{Diagnostic, Result, input};
use lab::log::table::{RawTable, encoding_name};

use super::columns::{Column, Role, columns, in_log_units, lit_interval, plausible_pressure};
use super::files::Recording;
use super::guess::{Confidence, Guess};
use super::pairing::Timed;

/// What wrote a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Commanded and measured pressures.
    Pressure,
    /// A load cell.
    Force,
}

/// A log of which the kind is told.
#[derive(Debug, Clone)]
pub(super) struct Log {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) columns: Vec<Column>,
    /// Its dialect, in words.
    pub(super) dialect: String,
    /// The clock's unit, how sure it is, and why.
    pub(super) clock: (&'static str, Confidence, String),
    /// When the lamp lights and goes out, s by the log's clock, where the log has one.
    pub(super) lit: Option<[f64; 2]>,
    /// Median step of the clock, s.
    pub(super) step: f64,
}

/// Steps of a log's clock between which instruments of a laboratory lie, s.
const STEPS: std::ops::Range<f64> = 4e-5..0.25;

/// The log in a text; none where it holds no table with a time and a pressure or a force.
///
/// # Errors
/// A [`Diagnostic`] when the file cannot be read.
pub(super) fn log(recording: &Recording) -> Result<Option<Log>> {
    let unreadable = |e| Diagnostic::io(&recording.path, e, "check its permissions");
    let bytes = input::read(&recording.path, input::LOG).map_err(unreadable)?;
    let encoding = encoding_name(&bytes);
    let Ok(text) = lab::log::decoded(bytes, &recording.path) else { return Ok(None) };
    let Some(table) = RawTable::new(&text) else { return Ok(None) };
    let columns = columns(&table);
    let has = |role: Role| columns.iter().any(|column| column.role == role);
    let kind = match (has(Role::Time), has(Role::Command), has(Role::Force)) {
        (true, true, _) => Kind::Pressure,
        (true, false, true) => Kind::Force,
        _ => return Ok(None),
    };
    Ok(Some(Log::new(recording, kind, columns, dialect(&table, encoding))))
}

/// Separator, decimal sign and encoding, in words.
fn dialect(table: &RawTable, encoding: &str) -> String {
    let separator = match table.separator {
        '\t' => "tabs".to_owned(),
        ' ' => "blanks".to_owned(),
        sign => format!("`{sign}`"),
    };
    let decimal =
        if table.decimal_comma && table.separator != ',' { "decimal points or commas" } else { "decimal points" };
    let titles = if table.titles.is_some() { "titles" } else { "no titles" };
    format!("{encoding}, columns between {separator}, {decimal}, {titles}")
}

impl Log {
    fn new(recording: &Recording, kind: Kind, columns: Vec<Column>, dialect: String) -> Self {
        let time = columns.iter().find(|column| column.role == Role::Time);
        let stamps = time.map_or(&[][..], |column| &column.values);
        let step = median_step(stamps);
        let clock = clock_unit(time.and_then(|column| column.unit), stamps, step);
        let factor = in_log_units(clock.0);
        let lamp = columns.iter().find(|column| column.role == Role::Lamp);
        let lit = lamp.and_then(|lamp| lit_interval(stamps, &lamp.values)).map(|times| times.map(|time| time * factor));
        Self { name: recording.name.clone(), kind, dialect, clock, lit, step: step * factor, columns }
    }

    /// The duration of its lamp for a comparison.
    pub(super) fn timed(&self) -> Option<Timed> {
        let [on, off] = self.lit?;
        Some(Timed { name: self.name.clone(), lit: off - on, resolution: self.step })
    }

    /// The columns of a role.
    pub(super) fn of_role(&self, role: Role) -> impl Iterator<Item = &Column> {
        self.columns.iter().filter(move |column| column.role == role)
    }

    /// The clock's stamps, s.
    pub(super) fn stamps(&self) -> Vec<f64> {
        let stamps = self.of_role(Role::Time).next().map_or(&[][..], |column| &column.values);
        stamps.iter().map(|stamp| stamp * in_log_units(self.clock.0)).collect()
    }

    /// The unit of its pressures, how sure it is, and why.
    pub(super) fn pressure_unit(&self) -> (&'static str, Confidence, String) {
        let named = self.of_role(Role::Command).chain(self.of_role(Role::Pressure)).find_map(|column| column.unit);
        if let Some(unit) = named {
            return (unit, Confidence::Certain, format!("{} names it", self.name));
        }
        let values = self.of_role(Role::Command).flat_map(|column| column.values.iter());
        let largest = values.fold(0.0, |l: f64, v| l.max(*v));
        let (unit, confidence) = plausible_pressure(largest);
        (
            unit,
            confidence,
            format!("no title names a unit; the largest command of {largest} is then that of a soft actuator"),
        )
    }

    /// Its guesses by themselves.
    pub(super) fn guesses(&self) -> Vec<Guess> {
        let kind = match self.kind {
            Kind::Pressure => "a log of pressures",
            Kind::Force => "a log of a force",
        };
        let titles = |role: Role| {
            let named: Vec<String> = self.of_role(role).filter_map(|column| column.title.clone()).collect();
            named.join(", ")
        };
        let evidence = match self.kind {
            Kind::Pressure => format!("commands that stay for many samples: {}", titles(Role::Command)),
            Kind::Force => format!("its column {}", titles(Role::Force)),
        };
        let is_titled = self.columns.iter().all(|column| column.title.is_some());
        let confidence = if is_titled { Confidence::Likely } else { Confidence::Unsure };
        vec![
            Guess::new(confidence, &self.name, kind, evidence.trim_end_matches([' ', ':'])),
            Guess::new(Confidence::Certain, &self.name, format!("text: {}", self.dialect), "read through"),
        ]
    }
}

fn median_step(stamps: &[f64]) -> f64 {
    let mut steps: Vec<f64> = stamps.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}

/// The unit that the file names, or the one by which the log's rate is that of an instrument.
fn clock_unit(named: Option<&'static str>, stamps: &[f64], step: f64) -> (&'static str, Confidence, String) {
    // whatever its title says: a spreadsheet turns a column of dates into days and leaves the title
    if lab::log::are_spreadsheet_days(stamps) {
        return ("day", Confidence::Likely, format!("{} and steps of {step:.2e} are days of a spreadsheet", stamps[0]));
    }
    if let Some(unit) = named {
        return (unit, Confidence::Certain, "the column names it".to_owned());
    }
    let fits: Vec<&'static str> =
        ["s", "ms", "us"].into_iter().filter(|unit| STEPS.contains(&(step * in_log_units(unit)))).collect();
    let unit = fits.first().copied().unwrap_or("s");
    let confidence = if fits.len() == 1 { Confidence::Likely } else { Confidence::Unsure };
    (unit, confidence, format!("a step of {step} would be too fast or too slow for a logger in another unit"))
}
