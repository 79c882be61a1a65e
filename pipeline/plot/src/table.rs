//! Tables: rows of cells under column heads; a column can have published values beside it.

use crate::PlotError;

/// The alignment of a column's cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Alignment {
    /// For text.
    Left,
    /// For numbers.
    Right,
}

/// A column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its head.
    pub title: String,
    /// Its unit; empty for none.
    pub unit: String,
    /// A head over this and its neighbours of the same group; empty for none.
    pub group: String,
    /// The alignment of its cells.
    pub alignment: Alignment,
    /// Whether its values were published by others; they are printed in another colour.
    pub published: bool,
    /// Whether its values are measured durations, which differ from run to run.
    pub timed: bool,
}

/// A table of text; numbers are formatted by the caller.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The columns.
    pub columns: Vec<Column>,
    /// Rows × columns; an empty cell is printed as a dash.
    pub rows: Vec<Vec<String>>,
    /// A small line under the table.
    pub note: Option<String>,
}

impl Column {
    /// A column of text.
    pub fn text(title: &str) -> Self {
        let (title, empty) = (title.to_owned(), String::new());
        Self { title, unit: empty.clone(), group: empty, alignment: Alignment::Left, published: false, timed: false }
    }

    /// A column of numbers.
    pub fn numbers(title: &str, unit: &str) -> Self {
        Self { unit: unit.to_owned(), alignment: Alignment::Right, ..Self::text(title) }
    }

    /// A column of our values and a column of published ones, under one head.
    pub fn beside_published(group: &str, unit: &str) -> [Self; 2] {
        let ours = Self { group: group.to_owned(), ..Self::numbers("ours", unit) };
        [ours.clone(), Self { title: "published".to_owned(), published: true, ..ours }]
    }

    /// The same column, of measured durations.
    pub fn of_durations(self) -> Self {
        Self { timed: true, ..self }
    }

    /// Title and unit: `time (s)`.
    pub fn head(&self) -> String {
        match self.unit.as_str() {
            "" => self.title.clone(),
            unit => format!("{} ({unit})", self.title),
        }
    }
}

impl Table {
    /// A table with one cell for each row and column.
    ///
    /// # Errors
    /// [`PlotError::Empty`] without columns, [`PlotError::Length`] when a row has more or fewer cells than there are columns.
    pub fn new(columns: Vec<Column>, rows: Vec<Vec<String>>) -> Result<Self, PlotError> {
        let expected = columns.len();
        if expected == 0 {
            return Err(PlotError::Empty { what: "a table" });
        }
        match rows.iter().position(|row| row.len() != expected) {
            Some(i) => Err(PlotError::Length { what: format!("row {i} of a table"), found: rows[i].len(), expected }),
            None => Ok(Self { columns, rows, note: None }),
        }
    }

    /// The same table with a small line under it.
    pub fn noted(self, note: &str) -> Self {
        Self { note: Some(note.to_owned()), ..self }
    }

    /// The same table without the cells of measured durations; none when it has no column of them.
    pub fn without_durations(&self) -> Option<Self> {
        let cell_or_empty =
            |(column, cell): (&Column, &String)| if column.timed { String::new() } else { cell.clone() };
        let rows = self.rows.iter().map(|row| self.columns.iter().zip(row).map(cell_or_empty).collect()).collect();
        self.columns.iter().any(|column| column.timed).then(|| Self { rows, ..self.clone() })
    }

    /// Neighbouring columns of one group: its head, its first column and the one after its last.
    pub(crate) fn groups(&self) -> Vec<(&str, usize, usize)> {
        let mut groups: Vec<(&str, usize, usize)> = Vec::new();
        for (i, column) in self.columns.iter().enumerate() {
            match groups.last_mut() {
                Some((head, _, end)) if *head == column.group && !column.group.is_empty() => *end = i + 1,
                _ => groups.push((&column.group, i, i + 1)),
            }
        }
        groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_with_a_missing_cell_is_refused() {
        let columns = vec![Column::text("method"), Column::numbers("time", "s")];
        let error = Table::new(columns, vec![vec!["adam".to_owned()]]).unwrap_err();
        assert!(matches!(error, PlotError::Length { found: 1, expected: 2, .. }));
    }

    #[test]
    fn durations_are_left_out_and_all_else_is_kept() {
        let columns = vec![Column::text("method"), Column::numbers("time", "s").of_durations()];
        let table = Table::new(columns, vec![vec!["adam".to_owned(), "3.1".to_owned()]]).unwrap();
        assert_eq!(table.without_durations().unwrap().rows, [["adam", ""]]);
        let untimed = Table::new(vec![Column::text("method")], vec![vec!["adam".to_owned()]]).unwrap();
        assert!(untimed.without_durations().is_none());
    }

    #[test]
    fn neighbours_of_one_group_share_their_head() {
        let [ours, published] = Column::beside_published("loss", "");
        let table = Table::new(vec![Column::text("method"), ours, published], vec![]).unwrap();
        assert_eq!(table.groups(), [("", 0, 1), ("loss", 1, 3)]);
    }
}
