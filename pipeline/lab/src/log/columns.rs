//! The columns of a file: where each quantity of a log stands, and its unit.

use std::borrow::Cow;
use std::path::Path;

use super::dialect::Dialect;
use super::grouping::{self, Grouping};
use super::head::Line;
use super::time::{are_spreadsheet_days, iso8601};
use super::units::file_unit;
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
    format: &'a LogFormat,
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
    /// Units of the columns, where a line of their own holds them.
    pub units: Vec<Cow<'a, str>>,
    /// Fields of the first line of numbers.
    pub width: usize,
}

impl FirstLine<'_> {
    /// Whether a quantity stands in the file.
    pub(super) fn has_quantity(&self, format: &LogFormat, card: &Log, quantity: &str) -> bool {
        match card.named_column(quantity, format.instrument) {
            Some(LogColumn { column: Place::Position(at), .. }) => self.column_index(*at).is_some(),
            Some(LogColumn { column: Place::Title(title), .. }) => self.columns_titled(title).next().is_some(),
            None => self.columns_titled(quantity).next().is_some(),
        }
    }

    fn column_index(&self, at: usize) -> Option<usize> {
        at.checked_sub(1).filter(|index| *index < self.fields.len().max(self.width))
    }

    /// The columns of a title.
    fn columns_titled(&self, title: &str) -> impl Iterator<Item = usize> {
        let has_title = move |(_, field): &(usize, &Cow<str>)| self.titled && *field == title;
        self.fields.iter().enumerate().filter(has_title).map(|(index, _)| index)
    }

    /// The only column of a title; none where there is no such column.
    fn only_column(&self, title: &str, quantity: &str) -> Result<Option<usize>, Diagnostic> {
        let matches: Vec<usize> = self.columns_titled(title).collect();
        let [first, _, ..] = matches[..] else { return Ok(matches.first().copied()) };
        let positions: Vec<String> = matches.iter().map(|index| (index + 1).to_string()).collect();
        let defect = format!("{} columns have the title `{title}`", matches.len());
        let reason = format!("they stand at positions {}; {quantity} is one of them", positions.join(" and "));
        let action = format!(
            "add [[log.columns]] with quantity = \"{quantity}\" and its position, such as column = {}, or rename one",
            first + 1
        );
        Err(Diagnostic::file(self.path, defect, reason, action))
    }

    /// The columns of a log of this form.
    ///
    /// # Errors
    /// [`Diagnostic`] when a quantity is in no column, or in several.
    pub(super) fn column_layout<'b>(&'b self, format: &'b LogFormat, card: &Log) -> Result<Layout<'b>, Diagnostic> {
        let columns =
            format.columns.iter().map(|c| self.resolve_column(format, card, &c.title)).collect::<Result<_, _>>()?;
        Ok(Layout {
            format,
            path: self.path,
            dialect: self.dialect,
            titles: self.fields.len(),
            width: self.width,
            columns,
        })
    }

    fn resolve_column(&self, format: &LogFormat, card: &Log, quantity: &str) -> Result<Column, Diagnostic> {
        if let Some(entry) = card.named_column(quantity, format.instrument) {
            let index = match &entry.column {
                Place::Position(at) => self.column_index(*at),
                Place::Title(title) => self.only_column(title, quantity)?,
            };
            let index = index.ok_or_else(|| self.misnamed_column(entry))?;
            self.check_unit(quantity, index, Some(entry))?;
            let factor = entry.scale * entry.unit.map_or(1.0, Unit::in_log_units);
            return Ok(Column { index, unit: entry.unit, factor });
        }
        let index = self.only_column(quantity, quantity)?.ok_or_else(|| self.missing_column(format, quantity))?;
        self.check_unit(quantity, index, None)?;
        Ok(Column { index, unit: None, factor: 1.0 })
    }

    /// Whether the unit that the file names of a column is that of the card, or without an entry that of the quantity.
    fn check_unit(&self, quantity: &str, index: usize, entry: Option<&LogColumn>) -> Result<(), Diagnostic> {
        let title = self.fields.get(index).filter(|_| self.titled).map(|title| &**title);
        let unit = self.units.get(index).map(|unit| &**unit);
        // a card that gives a unit takes that of the guide's title back, such as of time_s; brackets are the file's own
        let before: &[char] = if entry.is_some_and(|e| e.unit.is_some()) { &['[', '('] } else { &['[', '(', '_'] };
        let Some(named) = file_unit([title, unit], before, quantity) else { return Ok(()) };
        let Some(declared) = named.contradicting_unit(quantity, entry) else { return Ok(()) };
        let (defect, named) = (format!("{quantity} is in {} by the file", named.word()), named.word());
        let action =
            format!("set unit = \"{named}\" in [[log.columns]] with quantity = \"{quantity}\", or correct the file");
        Err(Diagnostic::file(self.path, defect, format!("the card has it in {declared}"), action))
    }

    fn misnamed_column(&self, entry: &LogColumn) -> Diagnostic {
        let (defect, reason) = match &entry.column {
            Place::Position(position) => {
                (format!("there is no column {position}"), format!("the file has {}", self.fields.len()))
            }
            Place::Title(title) if self.titled => {
                (format!("there is no column `{title}`"), format!("the file has {}", self.joined_titles()))
            }
            Place::Title(title) => {
                (format!("there is no column `{title}`"), "its first line is numbers, not titles".to_owned())
            }
        };
        let action = format!("correct column of {} in [[log.columns]] of specimen.toml", entry.quantity);
        Diagnostic::file(self.path, defect, reason, action)
    }

    fn joined_titles(&self) -> String {
        self.fields.join(", ")
    }

    fn missing_column(&self, format: &LogFormat, name: &str) -> Diagnostic {
        let reason = format!("a {} has the columns {}", format.kind, format.column_titles().join(", "));
        let entry = format!("[[log.columns]] to specimen.toml with quantity = \"{name}\"");
        if !self.titled {
            let defect = format!("the first line is `{}`: numbers, not titles", self.joined_titles());
            return Diagnostic::file(
                self.path,
                defect,
                reason,
                format!("add {entry} and its position, such as column = 1"),
            );
        }
        let other_titles: Vec<&str> =
            self.fields.iter().map(|field| &**field).filter(|h| !format.column_titles().contains(h)).collect();
        let action = match nearest(name, &other_titles) {
            Some(similar) => {
                format!("rename the column `{similar}` to `{name}`, or add {entry} and column = \"{similar}\"")
            }
            None => format!("add the column `{name}`, or {entry} and the title of its column"),
        };
        Diagnostic::file(self.path, format!("the column `{name}` is missing"), reason, action)
    }
}

impl Layout<'_> {
    /// The numbers of a line in the units of our logs.
    ///
    /// # Errors
    /// [`Diagnostic`] when it has another number of fields, or one is no number.
    pub(super) fn row_values(&self, line: &str) -> Result<Vec<f64>, Diagnostic> {
        let fields = self.dialect.split_fields(line);
        self.check_count(&fields)?;
        let number = |(column, format): (&Column, &ColumnFormat)| {
            self.field_value(&format.title, column, fields.get(column.index).map_or("", |field| field))
        };
        self.columns.iter().zip(&self.format.columns).map(number).collect()
    }

    /// Some programs end each line with a separator, or leave a remark's column out below its title; a line that is longer than the titles
    /// by a field with something in it has decimal commas.
    fn check_count(&self, fields: &[Cow<str>]) -> Result<(), Diagnostic> {
        let ends_empty = fields.len() == self.titles + 1 && fields.last().is_some_and(|last| last.is_empty());
        let matches_first = fields.len() == self.width && (self.width < self.titles || ends_empty);
        if fields.len() == self.titles || matches_first {
            return Ok(());
        }
        let defect = format!("the line has {} fields", fields.len());
        let reason = format!("the first line has {}; a decimal comma between commas also looks like this", self.titles);
        Err(Diagnostic::file(self.path, defect, reason, "write decimal points, and as many fields as columns"))
    }

    /// Whether the commas and points of the numbers are decimal signs.
    ///
    /// # Errors
    /// [`Diagnostic`] that names the first number that may have a separator of thousands.
    pub(super) fn check_grouping<'a, I: Iterator<Item = Line<'a>>>(
        &self,
        lines: impl Fn() -> I,
    ) -> Result<(), Diagnostic> {
        if !self.dialect.decimal_comma {
            return Ok(()); // a comma is the separator, and within a number refused
        }
        let mut grouping = Grouping::new(self.columns.len());
        for (line, text) in lines() {
            let fields = self.dialect.split_fields(text);
            for (k, column) in self.columns.iter().enumerate() {
                grouping.note(k, line, fields.get(column.index).map_or("", |field| field));
            }
        }
        let Some((k, line, field)) = grouping.ambiguous() else { return Ok(()) };
        let [whole, decimal] = ["", "."].map(|sign| field.replace([',', '.'], sign));
        let defect = format!("{} is `{field}`", self.format.columns[k].title);
        let reason =
            format!("it may be {whole} or {decimal}: its sign stands before three digits in all of the column");
        let action = "export the log without separators of thousands, and with one decimal sign";
        Err(Diagnostic::file(self.path, defect, reason, action).at_line(line))
    }

    /// Whether times (s) without a unit on the card are seconds.
    ///
    /// # Errors
    /// [`Diagnostic`] when they look like days of a spreadsheet.
    pub(super) fn check_clock(&self, times: &[f64]) -> Result<(), Diagnostic> {
        if self.columns[0].unit.is_some() || !are_spreadsheet_days(times) {
            return Ok(());
        }
        let defect = format!("time_s begins at {} and rises by {:.2e} a line", times[0], times[1] - times[0]);
        let action =
            "give the column unit = \"day\" in [[log.columns]] with quantity = \"time_s\", or \"s\" if it is right";
        Err(Diagnostic::file(self.path, defect, "these look like the days of a spreadsheet, not seconds", action))
    }

    /// Whether the numbers of a line lie in their ranges.
    ///
    /// # Errors
    /// [`Diagnostic`] that names the first that does not.
    pub(super) fn check_ranges(&self, row: &[f64]) -> Result<(), Diagnostic> {
        let mut cells = row.iter().zip(&self.format.columns);
        cells.try_for_each(|(value, format)| check_range(self.path, &format.title, format.range, *value))
    }

    /// One of the file's numbers in a column, in the unit of our logs.
    pub(super) fn unit_factor(&self, column: usize) -> f64 {
        self.columns[column].factor
    }

    fn field_value(&self, quantity: &str, column: &Column, field: &str) -> Result<f64, Diagnostic> {
        let refusal = |reason: &str, action: &str| {
            Diagnostic::file(self.path, format!("{quantity} is `{field}`"), reason, action)
        };
        if column.unit == Some(Unit::Iso8601) {
            let action = "write it as 2024-05-01T12:00:00.125, or correct its unit in [[log.columns]]";
            return iso8601(field).ok_or_else(|| refusal("a time in ISO 8601 was expected", action));
        }
        let decimal = self.dialect.decimal_text(field);
        match decimal.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value * column.factor),
            Ok(_) => {
                Err(refusal("every sample must be a finite number", "cut the log there, or record the trial again"))
            }
            Err(_) if decimal.contains(',') => {
                Err(refusal("a comma separates the columns", "export with decimal points, or with ; between columns"))
            }
            Err(_) if quantity == "time_s" && iso8601(field).is_some() => Err(refusal(
                "a number was expected",
                "add [[log.columns]] to specimen.toml with quantity = \"time_s\", its column and unit = \"iso8601\"",
            )),
            Err(_) if grouping::has_groups(field) => Err(refusal(
                "it has more signs than a decimal one; separators of thousands are not read",
                "export the log without separators of thousands",
            )),
            Err(_) => Err(refusal("a number was expected", "correct the field, or cut the line out")),
        }
    }
}

fn check_range(path: &Path, column: &str, (low, high, unit): (f64, f64, &str), value: f64) -> Result<(), Diagnostic> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let defect = format!("{column} = {value} is out of range");
    Err(Diagnostic::file(path, defect, format!("the range is {low} to {high} {unit}"), "check the unit of the column"))
}
