//! A table of numbers as it stands in a file of which nothing is known: dialect, titles, units and columns.

use super::encoding::is_windows_1252;
use super::head::{Head, is_content, is_units, numbered_lines};
use super::time::iso8601;

/// A table in a text.
#[derive(Debug, Clone, PartialEq)]
pub struct RawTable {
    /// Between two fields; a blank stands for a run of blanks.
    pub separator: char,
    /// Whether a comma is the decimal sign.
    pub decimal_comma: bool,
    /// Titles of the columns, where there are some.
    pub titles: Option<Vec<String>>,
    /// Units of the columns, where a line of their own holds them.
    pub units: Option<Vec<String>>,
    /// Columns × rows; a field that is no number is NaN, a date or a time of day is in s.
    pub columns: Vec<Vec<f64>>,
    /// Whether each column holds dates or times of day.
    pub is_date: Vec<bool>,
}

/// Lines that are read at most: enough for hours of a log, and a bound for a file that is none.
const MAX_ROWS: usize = 2_000_000;

impl RawTable {
    /// The table of a text; none where it holds no two lines of numbers with two columns.
    pub fn new(text: &str) -> Option<Self> {
        let text = text.trim_start_matches('\u{feff}');
        let head = Head::new(text);
        let (dialect, width) = (head.dialect, head.width);
        let words = |line: &str| dialect.split_titles(line, width).iter().map(|field| field.to_string()).collect();
        let lines = || numbered_lines(text).filter(is_content);
        let titles: Option<Vec<String>> = head.titles.map(|(_, line)| words(line));
        let above = head.titles.map_or(0, |(number, _)| number);
        let between = lines().find(|(number, _)| *number > above && *number < head.begin);
        let units =
            between.filter(|(_, line)| above > 0 && is_units(line, dialect, width)).map(|(_, line)| words(line));
        let mut columns = vec![Vec::new(); width];
        let mut is_date = vec![false; width];
        for (_, line) in lines().filter(|(number, _)| *number >= head.begin).take(MAX_ROWS) {
            let fields = dialect.split_fields(line);
            for (k, column) in columns.iter_mut().enumerate() {
                let field = fields.get(k).map_or("", |field| field);
                let number = dialect.decimal_text(field).parse::<f64>().ok();
                let time = number.is_none().then(|| iso8601(field)).flatten();
                is_date[k] |= time.is_some();
                column.push(number.or(time).unwrap_or(f64::NAN));
            }
        }
        let has_numbers = |column: &Vec<f64>| column.iter().filter(|value| value.is_finite()).count() >= 2;
        let is_table = width >= 2 && columns.iter().filter(|column| has_numbers(column)).count() >= 2;
        let separator = char::from(dialect.separator);
        is_table.then_some(Self { separator, decimal_comma: dialect.decimal_comma, titles, units, columns, is_date })
    }
}

/// The encoding of a text, in words.
pub fn encoding_name(bytes: &[u8]) -> &'static str {
    match bytes {
        [0xef, 0xbb, 0xbf, ..] => "UTF-8 with a byte-order mark",
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "UTF-16",
        _ if is_windows_1252(bytes) => "Windows-1252",
        _ if bytes.is_ascii() && !bytes.contains(&0) => "ASCII",
        _ if std::str::from_utf8(bytes).is_ok_and(|text| !text.contains('\0')) => "UTF-8",
        _ => "UTF-16",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_units_and_numbers_of_a_table_come_back() {
        let text = "sep=;\nZeit;Kraft;Lampe\ns;mN;\n0,00;1,5;0\n0,01;;1\n0,02;1,7;1\n";
        let table = RawTable::new(text).unwrap();
        assert_eq!((table.separator, table.decimal_comma), (';', true));
        assert_eq!(table.titles.unwrap(), ["Zeit", "Kraft", "Lampe"]);
        assert_eq!(table.units.unwrap(), ["s", "mN", ""]);
        assert_eq!((&table.columns[0], &table.columns[2]), (&vec![0.0, 0.01, 0.02], &vec![0.0, 1.0, 1.0]));
        assert!(table.columns[1][1].is_nan() && table.columns[1][2] == 1.7);
    }

    #[test]
    fn dates_are_seconds_and_prose_is_no_table() {
        let table = RawTable::new("t,f\n2024-05-01T12:00:00.5,1\n2024-05-01T12:00:00.75,2\n").unwrap();
        assert_eq!(table.is_date, [true, false]);
        assert!((table.columns[0][1] - table.columns[0][0] - 0.25).abs() < 1e-6);
        assert!(RawTable::new("A note on the tests of May.\nThe lamp was new.\n").is_none());
        assert!(RawTable::new("").is_none());
    }

    #[test]
    fn encodings_have_their_names() {
        for (bytes, name) in [
            (&b"t,f"[..], "ASCII"),
            (b"\xef\xbb\xbft,f", "UTF-8 with a byte-order mark"),
            (b"\xff\xfet\0", "UTF-16"),
            (b"t,\0f\0", "UTF-16"),
            (b"T [\xb0C]", "Windows-1252"),
            ("T [°C]".as_bytes(), "UTF-8"),
        ] {
            assert_eq!(encoding_name(bytes), name, "{bytes:?}");
        }
    }
}
