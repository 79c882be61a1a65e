//! Separators of thousands: 1,234 and 1.234 are one number or its thousandth.
//!
//! Where a comma may be a decimal sign, a sign that stands before three digits in all numbers of a column, and a number without a sign or another
//! sign that is a decimal one beside it, leave open which it is. Such a log is refused: its mean would be a thousandth, or a thousandfold.

/// Signs that part digits.
const SIGNS: [char; 2] = [',', '.'];

/// What the numbers of a column show.
#[derive(Debug, Clone, Default)]
struct Column {
    /// Whether each sign stands where a decimal sign alone does.
    is_decimal: [bool; 2],
    /// Line and text of the first number in which each sign may part thousands.
    grouped: [Option<(usize, String)>; 2],
    /// Whether a number below a thousand, other than zero, has no sign.
    has_plain: bool,
}

/// What the numbers of the columns of a log show of their signs.
#[derive(Debug)]
pub(super) struct Grouping {
    columns: Vec<Column>,
}

impl Grouping {
    /// Of so many columns without numbers.
    pub(super) fn new(columns: usize) -> Self {
        Self { columns: vec![Column::default(); columns] }
    }

    /// Takes in the number of a column that stands on a line.
    pub(super) fn note(&mut self, column: usize, line: usize, field: &str) {
        let column = &mut self.columns[column];
        let digits = field.trim_start_matches(['+', '-']);
        column.has_plain |= digits.len() < 4 && digits.parse::<u32>().is_ok_and(|number| number > 0);
        if !digits.starts_with(|c: char| c.is_ascii_digit()) || digits.contains(':') {
            return;
        }
        for (k, sign) in SIGNS.iter().enumerate().filter(|(_, sign)| digits.contains(**sign)) {
            if !is_grouped(digits, *sign) {
                column.is_decimal[k] = true;
            } else if column.grouped[k].is_none() {
                column.grouped[k] = Some((line, field.to_owned()));
            }
        }
    }

    /// Column, line and text of a number that may be a thousandfold.
    pub(super) fn ambiguous(&self) -> Option<(usize, usize, &str)> {
        let is_decimal = |k: usize| self.columns.iter().any(|column| column.is_decimal[k]);
        let open = |column: &Column, k: usize| !column.is_decimal[k] && (column.has_plain || is_decimal(1 - k));
        self.columns.iter().enumerate().find_map(|(index, column)| {
            let k = [0, 1].into_iter().find(|k| column.grouped[*k].is_some() && open(column, *k))?;
            column.grouped[k].as_ref().map(|(line, field)| (index, *line, field.as_str()))
        })
    }
}

/// Whether a sign may part thousands: it stands between groups of three digits, of which the first may be shorter and is no zero.
fn is_grouped(digits: &str, sign: char) -> bool {
    let mut groups = digits.split(sign);
    let first = groups.next().unwrap_or_default();
    let is_number = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
    (1..=3).contains(&first.len())
        && !first.starts_with('0')
        && is_number(first)
        && groups.all(|group| group.len() == 3 && is_number(group))
}

/// Whether a field that is no number has separators of thousands: 1'234, 1 234, or both signs.
pub(super) fn has_groups(field: &str) -> bool {
    let is_part = |c: char| c.is_ascii_digit() || "+-,.' \u{a0}\u{2009}\u{202f}\u{2019}".contains(c);
    let digits = field.chars().filter(char::is_ascii_digit).count();
    digits >= 4 && field.chars().all(is_part) && !field.starts_with(['.', ','])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of a table that may be a thousandfold, by its column.
    fn ambiguous(rows: &[[&str; 2]]) -> Option<(usize, String)> {
        let mut grouping = Grouping::new(2);
        for (line, row) in rows.iter().enumerate() {
            (0..2).for_each(|k| grouping.note(k, line, row[k]));
        }
        grouping.ambiguous().map(|(k, _, field)| (k, field.to_owned()))
    }

    #[test]
    fn a_sign_that_may_part_thousands_is_ambiguous_beside_a_decimal_sign_or_a_number_without_it() {
        for (rows, expected) in [
            ([["0.0125", "980"], ["0.0250", "2,380"]], Some("2,380")),
            ([["0,0125", "980"], ["0,0250", "-2.380"]], Some("-2.380")),
            ([["0", "980"], ["12", "2,380"]], Some("2,380")),
            ([["0", "1,234,567"], ["12", "12"]], Some("1,234,567")),
            ([["0,005", "1,234"], ["0,010", "1,235"]], None),
            ([["0.005", "1.234"], ["0.010", "-1.235"]], None),
            ([["0.005", "0"], ["0.010", "1.125"]], None),
            ([["0,005", "1,234"], ["0,010", "12,5"]], None),
            ([["1714557600.125", "1.234"], ["1714557600.250", "12.345"]], None),
            ([["12:00:00,125", "1.234"], ["12:00:00,250", "1.235"]], None),
        ] {
            assert_eq!(ambiguous(&rows).map(|(_, field)| field).as_deref(), expected, "{rows:?}");
        }
    }

    #[test]
    fn separators_of_thousands_are_told_from_words() {
        for field in ["1'234", "1 234,5", "2.380,0", "1,234,567", "-12\u{a0}345"] {
            assert!(has_groups(field), "{field}");
        }
        for field in ["#N/A", "", "-", "12a34", "OVLD", "1,5"] {
            assert!(!has_groups(field), "{field}");
        }
    }
}
