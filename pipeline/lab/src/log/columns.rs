//! The columns of a file: where each quantity of a log stands, and its unit.

use std::borrow::Cow;
use std::path::Path;

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
    /// Number of titles in the file.
    titles: usize,
    /// Fields of its first line of numbers.
    width: usize,
    columns: Vec<Column>,
}

/// The first line of a file: its titles, or its first numbers.
pub(super) struct FirstLine<'a> {
    pub path: &'a Path,
    pub dialect: Dialect,
    /// Whether it holds titles.
    pub titled: bool,
    pub fields: Vec<Cow<'a, str>>,
    /// Fields of the first line of numbers.
    pub width: usize,
}

impl FirstLine<'_> {
    /// Whether a quantity stands in the file.
    pub(super) fn has(&self, form: &LogFormat, card: &Log, quantity: &str) -> bool {
        match card.column(quantity, form.instrument) {
            Some(LogColumn { column: Place::Position(at), .. }) => self.position(*at).is_some(),
            Some(LogColumn { column: Place::Title(title), .. }) => self.titled(title).next().is_some(),
            None => self.titled(quantity).next().is_some(),
        }
    }

    fn position(&self, at: usize) -> Option<usize> {
        at.checked_sub(1).filter(|index| *index < self.fields.len().max(self.width))
    }

    /// The columns of a title.
    fn titled(&self, title: &str) -> impl Iterator<Item = usize> {
        let is = move |(_, field): &(usize, &Cow<str>)| self.titled && *field == title;
        self.fields.iter().enumerate().filter(is).map(|(index, _)| index)
    }

    /// The only column of a title; none where there is no such column.
    fn only(&self, title: &str, quantity: &str) -> Result<Option<usize>, Diagnostic> {
        let all: Vec<usize> = self.titled(title).collect();
        let [first, _, ..] = all[..] else { return Ok(all.first().copied()) };
        let places: Vec<String> = all.iter().map(|index| (index + 1).to_string()).collect();
        let what = format!("{} columns have the title `{title}`", all.len());
        let why = format!("they stand at positions {}; {quantity} is one of them", places.join(" and "));
        let action = format!(
            "add [[log.columns]] with quantity = \"{quantity}\" and its position, such as column = {}, or rename one",
            first + 1
        );
        Err(Diagnostic::file(self.path, what, why, action))
    }

    /// The columns of a log of this form.
    ///
    /// # Errors
    /// [`Diagnostic`] when a quantity is in no column, or in several.
    pub(super) fn layout<'b>(&'b self, form: &'b LogFormat, card: &Log) -> Result<Layout<'b>, Diagnostic> {
        let columns = form.columns.iter().map(|c| self.column(form, card, &c.title)).collect::<Result<_, _>>()?;
        Ok(Layout {
            form,
            path: self.path,
            dialect: self.dialect,
            titles: self.fields.len(),
            width: self.width,
            columns,
        })
    }

    fn column(&self, form: &LogFormat, card: &Log, quantity: &str) -> Result<Column, Diagnostic> {
        if let Some(named) = card.column(quantity, form.instrument) {
            let index = match &named.column {
                Place::Position(at) => self.position(*at),
                Place::Title(title) => self.only(title, quantity)?,
            };
            let index = index.ok_or_else(|| self.no_such_place(named))?;
            let factor = named.scale * named.unit.map_or(1.0, Unit::in_log_units);
            return Ok(Column { index, unit: named.unit, factor });
        }
        let index = self.only(quantity, quantity)?.ok_or_else(|| self.missing(form, quantity))?;
        Ok(Column { index, unit: None, factor: 1.0 })
    }

    fn no_such_place(&self, named: &LogColumn) -> Diagnostic {
        let (what, why) = match &named.column {
            Place::Position(at) => (format!("there is no column {at}"), format!("the file has {}", self.fields.len())),
            Place::Title(title) if self.titled => {
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
        self.fields.join(", ")
    }

    fn missing(&self, form: &LogFormat, name: &str) -> Diagnostic {
        let why = format!("a {} has the columns {}", form.kind, form.titles().join(", "));
        let entry = format!("[[log.columns]] to specimen.toml with quantity = \"{name}\"");
        if !self.titled {
            let what = format!("the first line is `{}`: numbers, not titles", self.titles());
            return Diagnostic::file(self.path, what, why, format!("add {entry} and its position, such as column = 1"));
        }
        let present: Vec<&str> =
            self.fields.iter().map(|field| &**field).filter(|h| !form.titles().contains(h)).collect();
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
    /// [`Diagnostic`] when it has another number of fields, or one is no number.
    pub(super) fn row(&self, line: &str) -> Result<Vec<f64>, Diagnostic> {
        let fields = self.dialect.split(line);
        self.check_count(&fields)?;
        let number = |(column, form): (&Column, &ColumnFormat)| {
            self.number(&form.title, column, fields.get(column.index).map_or("", |field| field))
        };
        self.columns.iter().zip(&self.form.columns).map(number).collect()
    }

    /// Some programs end each line with a separator, or leave a remark's column out below its title; a line that is longer than the titles
    /// by a field with something in it has decimal commas.
    fn check_count(&self, fields: &[Cow<str>]) -> Result<(), Diagnostic> {
        let ends_empty = fields.len() == self.titles + 1 && fields.last().is_some_and(|last| last.is_empty());
        let as_first = fields.len() == self.width && (self.width < self.titles || ends_empty);
        if fields.len() == self.titles || as_first {
            return Ok(());
        }
        let what = format!("the line has {} fields", fields.len());
        let why = format!("the first line has {}; a decimal comma between commas also looks like this", self.titles);
        Err(Diagnostic::file(self.path, what, why, "write decimal points, and as many fields as columns"))
    }

    /// Whether the numbers of a line lie in their ranges.
    ///
    /// # Errors
    /// [`Diagnostic`] that names the first that does not.
    pub(super) fn check(&self, row: &[f64]) -> Result<(), Diagnostic> {
        let mut all = row.iter().zip(&self.form.columns);
        all.try_for_each(|(value, form)| range(self.path, &form.title, form.range, *value))
    }

    /// One of the file's numbers in a column, in the unit of our logs.
    pub(super) fn factor(&self, column: usize) -> f64 {
        self.columns[column].factor
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
