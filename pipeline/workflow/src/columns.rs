//! Columns: a table of named columns of equal length, stored in a record as Parquet.
//!
//! Names carry their unit at the end (`time_s`, `x_m`), so that pandas or MATLAB can read a record without this code.

use std::io::Cursor;

use polars::prelude::{
    Column, DataFrame, DataType, NamedFrom, ParquetCompression, ParquetReader, ParquetWriter, SerReader, Series,
};

/// A table with columns of numbers or words.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Columns {
    columns: Vec<(String, Cells)>,
}

/// One column's cells.
#[derive(Debug, Clone, PartialEq)]
enum Cells {
    Numbers(Vec<f64>),
    Counts(Vec<u32>),
    Words(Vec<String>),
}

/// An error of a record's table.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ColumnsError {
    /// The bytes are not Parquet, or columns differ in length.
    #[error("the table cannot be read or written: {0}")]
    Format(String),
    /// A column is absent or holds another type.
    #[error("the table has no column `{0}` of the expected type")]
    Missing(String),
    /// A column has cells without a value, so many.
    #[error("{1} cells of the column `{0}` are empty")]
    Empty(String, usize),
}

impl Columns {
    /// Adds a column of numbers.
    pub fn numbers(mut self, name: &str, values: Vec<f64>) -> Self {
        self.columns.push((name.into(), Cells::Numbers(values)));
        self
    }

    /// Adds a column of whole numbers.
    pub fn counts(mut self, name: &str, values: Vec<u32>) -> Self {
        self.columns.push((name.into(), Cells::Counts(values)));
        self
    }

    /// Adds a column of whole numbers, `name` with its number, for each place in a row; all rows are as long.
    pub fn rows<'a>(self, name: &str, rows: impl Iterator<Item = &'a [u32]> + Clone) -> Self {
        let places = rows.clone().next().map_or(0, <[u32]>::len);
        (0..places).fold(self, |table, k| table.counts(&format!("{name}{k}"), rows.clone().map(|row| row[k]).collect()))
    }

    /// The rows of such columns, as many as there are.
    pub fn read_rows(&self, name: &str) -> Vec<Vec<u32>> {
        let columns: Vec<Vec<u32>> = (0..).map_while(|k| self.u32(&format!("{name}{k}")).ok()).collect();
        let count = columns.first().map_or(0, Vec::len);
        // length: columns of one table are equally long
        (0..count).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
    }

    /// Adds a column of words.
    pub fn words(mut self, name: &str, values: Vec<String>) -> Self {
        self.columns.push((name.into(), Cells::Words(values)));
        self
    }

    /// The numbers of a column.
    ///
    /// # Errors
    /// [`ColumnsError::Missing`] when there is no such column of numbers.
    pub fn f64(&self, name: &str) -> Result<Vec<f64>, ColumnsError> {
        match self.column_cells(name)? {
            Cells::Numbers(values) => Ok(values.clone()),
            _ => Err(ColumnsError::Missing(name.into())),
        }
    }

    /// The whole numbers of a column.
    ///
    /// # Errors
    /// [`ColumnsError::Missing`] when there is no such column of whole numbers.
    pub fn u32(&self, name: &str) -> Result<Vec<u32>, ColumnsError> {
        match self.column_cells(name)? {
            Cells::Counts(values) => Ok(values.clone()),
            _ => Err(ColumnsError::Missing(name.into())),
        }
    }

    /// The words of a column.
    ///
    /// # Errors
    /// [`ColumnsError::Missing`] when there is no such column of words.
    pub fn text(&self, name: &str) -> Result<Vec<String>, ColumnsError> {
        match self.column_cells(name)? {
            Cells::Words(values) => Ok(values.clone()),
            _ => Err(ColumnsError::Missing(name.into())),
        }
    }

    fn column_cells(&self, name: &str) -> Result<&Cells, ColumnsError> {
        let column = self.columns.iter().find(|(n, _)| n == name);
        column.map(|(_, cells)| cells).ok_or_else(|| ColumnsError::Missing(name.into()))
    }

    /// The table as the bytes of a Parquet file; the same table gives the same bytes.
    ///
    /// # Errors
    /// [`ColumnsError::Format`] when columns differ in length.
    pub fn to_parquet(&self) -> Result<Vec<u8>, ColumnsError> {
        let height = self.columns.first().map_or(0, |(_, cells)| cells.len());
        let columns = self.columns.iter().map(|(name, cells)| cells.to_column(name)).collect();
        let mut frame = DataFrame::new(height, columns).map_err(format_error)?;
        let mut bytes = Vec::new();
        let writer = ParquetWriter::new(&mut bytes).with_compression(ParquetCompression::Uncompressed);
        writer.set_parallel(false).finish(&mut frame).map_err(format_error)?;
        Ok(bytes)
    }

    /// A table from the bytes of a Parquet file.
    ///
    /// # Errors
    /// [`ColumnsError::Format`] when the bytes are not Parquet or hold another type of column, [`ColumnsError::Empty`] when a cell has no value.
    pub fn from_parquet(bytes: &[u8]) -> Result<Self, ColumnsError> {
        let frame = ParquetReader::new(Cursor::new(bytes)).finish().map_err(format_error)?;
        let columns = frame.columns().iter().map(|c| Ok((c.name().to_string(), Cells::of(c)?)));
        Ok(Self { columns: columns.collect::<Result<_, ColumnsError>>()? })
    }
}

impl Cells {
    fn len(&self) -> usize {
        match self {
            Cells::Numbers(v) => v.len(),
            Cells::Counts(v) => v.len(),
            Cells::Words(v) => v.len(),
        }
    }

    fn to_column(&self, name: &str) -> Column {
        match self {
            Cells::Numbers(v) => Series::new(name.into(), v).into(),
            Cells::Counts(v) => Series::new(name.into(), v).into(),
            Cells::Words(v) => Series::new(name.into(), v).into(),
        }
    }

    fn of(column: &Column) -> Result<Self, ColumnsError> {
        // what was written has a value in every row: an empty cell read as NaN, 0 or "" would be a value that nobody wrote
        if column.null_count() > 0 {
            return Err(ColumnsError::Empty(column.name().to_string(), column.null_count()));
        }
        Ok(match column.dtype() {
            DataType::Float64 => Cells::Numbers(column.f64().map_err(format_error)?.iter().flatten().collect()),
            DataType::UInt32 => Cells::Counts(column.u32().map_err(format_error)?.iter().flatten().collect()),
            _ => Cells::Words(column.str().map_err(format_error)?.iter().flatten().map(str::to_owned).collect()),
        })
    }
}

fn format_error(error: polars::prelude::PolarsError) -> ColumnsError {
    ColumnsError::Format(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small() -> Columns {
        Columns::default()
            .numbers("x_m", vec![0.1, -2.0])
            .counts("node", vec![7, 8])
            .words("id", vec!["a".into(), "b".into()])
    }

    #[test]
    fn a_table_survives_parquet_and_gives_the_same_bytes_twice() {
        let bytes = small().to_parquet().unwrap();
        assert_eq!(bytes, small().to_parquet().unwrap());
        assert_eq!(Columns::from_parquet(&bytes).unwrap(), small());
    }

    #[test]
    fn a_missing_column_is_named() {
        assert_eq!(small().f64("y_m"), Err(ColumnsError::Missing("y_m".into())));
        assert!(Columns::from_parquet(b"PAR0").is_err());
    }

    #[test]
    fn cells_without_a_value_are_refused_with_their_column() {
        let columns: [Series; 3] = [
            Series::new("x_m".into(), [Some(0.1), None]),
            Series::new("node".into(), [None, Some(7_u32)]),
            Series::new("id".into(), [None::<&str>, None]),
        ];
        for (column, count) in columns.into_iter().zip([1, 1, 2]) {
            let name = column.name().to_string();
            let (mut frame, mut bytes) = (DataFrame::new(2, vec![column.into()]).unwrap(), Vec::new());
            ParquetWriter::new(&mut bytes).finish(&mut frame).unwrap();
            assert_eq!(Columns::from_parquet(&bytes), Err(ColumnsError::Empty(name, count)));
        }
    }
}
