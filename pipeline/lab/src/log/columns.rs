//! The columns of a file: where each quantity of a log stands, and its unit.

use std::path::Path;

use csv::StringRecord;

use super::dialect::Dialect;
use super::time::iso8601;
use super::{ColumnFormat, LogFormat};
use crate::card::{Log, LogColumn, Place, Unit};
use crate::table::nearest;
use diagnostics::Diagnostic;

/// A column in which a quantity stands.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Column {
    index: usize,
    unit: Option<Unit>,
    /// One of the file's numbers in the unit of our logs.
    factor: f64,
}

/// The columns of one file.
pub(super) struct Layout<'a> {
    form: &'a LogFormat,
    path: &'a Path,
    dialect: Dialect,
    /// Number of columns in the file.
    width: usize,
    columns: Vec<Column>,
}

/// The first line of a file: its titles, or its first numbers.
pub(super) struct FirstLine<'a> {
    pub path: &'a Path,
    pub dialect: Dialect,
    pub fields: StringRecord,
}

impl FirstLine<'_> {
    /// Whether a quantity stands in the file.
    pub(super) fn has(&self, form: &LogFormat, card: &Log, quantity: &str) -> bool {
        let titled = self.dialect.titled && self.fields.iter().any(|title| title == quantity);
        match card.column(quantity, form.instrument) {
            Some(column) => self.position(column).is_some(),
            None => titled,
        }
    }

    fn position(&self, column: &LogColumn) -> Option<usize> {
        match &column.column {
            Place::Position(at) => at.checked_sub(1).filter(|index| *index < self.fields.len()),
            Place::Title(title) if self.dialect.titled => self.fields.iter().position(|t| t == title),
            Place::Title(_) => None,
        }
    }

    /// The columns of a log of this form.
    ///
    /// # Errors
    /// [`Diagnostic`] when a quantity is in no column.
    pub(super) fn layout<'b>(&'b self, form: &'b LogFormat, card: &Log) -> Result<Layout<'b>, Diagnostic> {
        let columns = form.columns.iter().map(|c| self.column(form, card, &c.title)).collect::<Result<_, _>>()?;
        Ok(Layout { form, path: self.path, dialect: self.dialect, width: self.fields.len(), columns })
    }

    fn column(&self, form: &LogFormat, card: &Log, quantity: &str) -> Result<Column, Diagnostic> {
        if let Some(named) = card.column(quantity, form.instrument) {
            let index = self.position(named).ok_or_else(|| self.no_such_place(named))?;
            let factor = named.scale * named.unit.map_or(1.0, Unit::in_log_units);
            return Ok(Column { index, unit: named.unit, factor });
        }
        let found = self.fields.iter().position(|title| self.dialect.titled && title == quantity);
        let index = found.ok_or_else(|| self.missing(form, quantity))?;
        Ok(Column { index, unit: None, factor: 1.0 })
    }

    fn no_such_place(&self, named: &LogColumn) -> Diagnostic {
        let (what, why) = match &named.column {
            Place::Position(at) => (format!("there is no column {at}"), format!("the file has {}", self.fields.len())),
            Place::Title(title) if self.dialect.titled => {
                (format!("there is no column `{title}`"), format!("the file has {}", self.titles()))
            }
            Place::Title(title) => {
                (format!("there is no column `{title}`"), "its first line is numbers, not titles".to_owned())
            }
        };
        let action = format!("correct column of {} in [[log.columns]] of specimen.toml", named.quantity);
        Diagnostic::file(self.path, what, why, action)
    }

    fn titles(&self) -> String {
        self.fields.iter().collect::<Vec<_>>().join(", ")
    }

    fn missing(&self, form: &LogFormat, name: &str) -> Diagnostic {
        let why = format!("a {} has the columns {}", form.kind, form.titles().join(", "));
        let entry = format!("[[log.columns]] to specimen.toml with quantity = \"{name}\"");
        if !self.dialect.titled {
            let what = format!("the first line is `{}`: numbers, not titles", self.titles());
            return Diagnostic::file(self.path, what, why, format!("add {entry} and its position, such as column = 1"));
        }
        let present: Vec<&str> = self.fields.iter().filter(|h| !form.titles().contains(h)).collect();
        let action = match nearest(name, &present) {
            Some(near) => format!("rename the column `{near}` to `{name}`, or add {entry} and column = \"{near}\""),
            None => format!("add the column `{name}`, or {entry} and the title of its column"),
        };
        Diagnostic::file(self.path, format!("the column `{name}` is missing"), why, action)
    }
}

impl Layout<'_> {
    /// The numbers of a line in the units of our logs.
    ///
    /// # Errors
    /// [`Diagnostic`] when it has another number of fields, or one is no number or out of range.
    pub(super) fn row(&self, record: &StringRecord) -> Result<Vec<f64>, Diagnostic> {
        if record.len() != self.width {
            let what = format!("the line has {} fields", record.len());
            let why = format!("the first line has {}; a decimal comma between commas also looks like this", self.width);
            return Err(Diagnostic::file(self.path, what, why, "write decimal points, and as many fields as columns"));
        }
        let number = |(column, form): (&Column, &ColumnFormat)| {
            let value = self.number(&form.title, column, &record[column.index])?;
            range(self.path, &form.title, form.range, value).map(|()| value)
        };
        self.columns.iter().zip(&self.form.columns).map(number).collect()
    }

    fn number(&self, quantity: &str, column: &Column, field: &str) -> Result<f64, Diagnostic> {
        let refused =
            |why: &str, action: &str| Diagnostic::file(self.path, format!("{quantity} is `{field}`"), why, action);
        if column.unit == Some(Unit::Iso8601) {
            let action = "write it as 2024-05-01T12:00:00.125, or correct its unit in [[log.columns]]";
            return iso8601(field).ok_or_else(|| refused("a time in ISO 8601 was expected", action));
        }
        let plain = self.dialect.plain(field);
        match plain.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value * column.factor),
            Ok(_) => {
                Err(refused("every sample must be a finite number", "cut the log there, or record the trial again"))
            }
            Err(_) if plain.contains(',') => {
                Err(refused("a comma separates the columns", "export with decimal points, or with ; between columns"))
            }
            Err(_) if quantity == "time_s" && iso8601(field).is_some() => Err(refused(
                "a number was expected",
                "add [[log.columns]] to specimen.toml with quantity = \"time_s\", its column and unit = \"iso8601\"",
            )),
            Err(_) => Err(refused("a number was expected", "correct the field, or cut the line out")),
        }
    }
}

fn range(path: &Path, column: &str, (low, high, unit): (f64, f64, &str), value: f64) -> Result<(), Diagnostic> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let what = format!("{column} = {value} is out of range");
    Err(Diagnostic::file(path, what, format!("the range is {low} to {high} {unit}"), "check the unit of the column"))
}
