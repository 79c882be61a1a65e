//! The dialect of a table of numbers: separator and decimal sign.
//!
//! Both are found in the first line of numbers. The separator is the first of tab, `;`, `,` and runs of blanks by which the line falls into
//! numbers; where it is not `,`, or where numbers stand in quotes, a comma within a number is a decimal sign.

use std::borrow::Cow;

use super::time::iso8601;

/// How a file writes its table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Dialect {
    /// Between two fields; a blank stands for a run of blanks.
    pub separator: u8,
    /// Whether a comma within a field is a decimal sign.
    pub decimal_comma: bool,
}

/// By priority: a comma between tabs or semicolons is a decimal sign, a blank beside a comma is an ornament.
const SEPARATORS: [u8; 4] = *b"\t;, ";

impl Dialect {
    /// With this separator, and the decimal sign that it leaves.
    pub fn new(separator: u8) -> Self {
        Self { separator, decimal_comma: separator != b',' }
    }

    /// Of a line of titles, or of no numbers at all.
    pub fn titles(line: &str) -> Self {
        let separator = SEPARATORS[..3].iter().find(|s| line.as_bytes().contains(s));
        Self::new(*separator.unwrap_or(&b','))
    }

    /// Of a line of numbers; `named_separator` is a separator that the file names. None where the line holds none.
    pub fn numbers(line: &str, named_separator: Option<u8>) -> Option<Self> {
        let separators = SEPARATORS.into_iter().filter(|s| named_separator.is_none_or(|separator| separator == *s));
        let dialects = separators
            .chain(named_separator.filter(|s| !SEPARATORS.contains(s)))
            .map(|s| Self::new(s).with_quoted_commas(line));
        // a column of words may stand beside the numbers, which begin with the time
        let dialects: Vec<Self> = dialects.filter(|dialect| line.as_bytes().contains(&dialect.separator)).collect();
        let numeric_share = |dialect: &Self| dialect.numeric_part(line);
        let all_numeric = dialects.iter().find(|dialect| numeric_share(dialect) == Some(1.0));
        all_numeric
            .or_else(|| dialects.iter().find(|dialect| numeric_share(dialect).is_some_and(|share| share > 0.5)))
            .copied()
    }

    /// Between commas, numbers such as "1,5" in quotes have decimal commas where none of the line has a point.
    fn with_quoted_commas(self, line: &str) -> Self {
        let fields = self.split_fields(line);
        let has_decimal_comma = fields.iter().any(|field| field.contains(',')) && !line.contains('.');
        Self { decimal_comma: self.decimal_comma || has_decimal_comma, ..self }
    }

    /// Numbers among the fields that are not empty; none of a single field, or where the first is none.
    fn numeric_part(&self, line: &str) -> Option<f64> {
        let fields = self.split_fields(line);
        let present: Vec<&Cow<str>> = fields.iter().filter(|field| !field.is_empty()).collect();
        let first = present.first().filter(|_| fields.len() > 1)?;
        let count = present.iter().filter(|field| self.is_number(field)).count();
        self.is_number(first).then(|| count as f64 / present.len() as f64)
    }

    /// Whether a field is a number, a date or a time.
    pub fn is_number(&self, field: &str) -> bool {
        self.decimal_text(field).parse::<f64>().is_ok() || iso8601(field).is_some() || is_date(field)
    }

    /// The fields of a line, without quotes and the blanks around them.
    pub(crate) fn split_fields<'a>(&self, line: &'a str) -> Vec<Cow<'a, str>> {
        if self.separator == b' ' {
            return line.split_whitespace().map(|word| Cow::Borrowed(word.trim_matches('"'))).collect();
        }
        let mut fields = Vec::new();
        let mut remainder = line;
        loop {
            let (field, following) = self.first_field(remainder);
            fields.push(field);
            match following {
                Some(following) => remainder = following,
                None => return fields,
            }
        }
    }

    /// The first field of a line and what follows its separator.
    fn first_field<'a>(&self, line: &'a str) -> (Cow<'a, str>, Option<&'a str>) {
        let separator = char::from(self.separator);
        let is_blank = |c: char| c.is_whitespace() && c != separator;
        let Some(quoted) = line.trim_start_matches(is_blank).strip_prefix('"') else {
            let (field, following) =
                line.split_once(separator).map_or((line, None), |(field, following)| (field, Some(following)));
            return (Cow::Borrowed(field.trim()), following);
        };
        // a doubled quote within quotes is a quote
        let mut end = 0;
        while let Some(next) = quoted[end..].find('"') {
            end += next;
            if !quoted[end + 1..].starts_with('"') {
                let following = quoted[end + 1..].split_once(separator).map(|(_, following)| following);
                return (unescape_quotes(&quoted[..end]), following);
            }
            end += 2;
        }
        (unescape_quotes(quoted), None)
    }

    /// A field with a decimal point.
    pub(crate) fn decimal_text<'a>(&self, field: &'a str) -> Cow<'a, str> {
        if self.decimal_comma && field.contains(',') {
            Cow::Owned(field.replacen(',', ".", 1))
        } else {
            Cow::Borrowed(field)
        }
    }
}

fn unescape_quotes(field: &str) -> Cow<'_, str> {
    let field = field.trim();
    if field.contains("\"\"") { Cow::Owned(field.replace("\"\"", "\"")) } else { Cow::Borrowed(field) }
}

/// Digits and the signs between those of dates and times, such as 01/05/2024.
fn is_date(field: &str) -> bool {
    let sign = |c: char| c.is_ascii_digit() || "-/:.,T+Z".contains(c);
    let (day, time) = field.split_once(' ').unwrap_or((field, "AM"));
    let has_time = time.contains(':') || matches!(time, "AM" | "PM");
    let day_or_time = |text: &str| text.trim_end_matches([' ', 'A', 'P', 'M']).chars().all(sign);
    let begins = field.starts_with(|c: char| c.is_ascii_digit()) && day.contains(['-', '/', ':', '.']);
    begins && has_time && day_or_time(day) && day_or_time(time)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separator_and_decimal_sign_are_found_in_a_line_of_numbers() {
        for (line, separator, comma, fields) in [
            ("0,1", b',', false, 2),
            ("0,5;1", b';', true, 2),
            ("0,5\t1,25\t", b'\t', true, 3),
            ("0.5,1e-3", b',', false, 2),
            ("0.5, 1.2, open", b',', false, 3),
            ("  0.5   1.2", b' ', true, 2),
            ("0,5 1,2", b' ', true, 2),
            ("\"0,5\";\"1,2\"", b';', true, 2),
            ("\"0,5\",\"1,2\"", b',', true, 2),
            ("2024-05-01 12:00:00,125;0,5", b';', true, 2),
            ("2024-05-01T12:00:00.5,0.5", b',', false, 2),
            ("01.05.2024 12:00:00\t0,5", b'\t', true, 2),
            ("05/01/2024 01:00:00 PM;0,5", b';', true, 2),
            ("12:00:00 0,5", b' ', true, 2),
        ] {
            let dialect = Dialect::numbers(line, None).unwrap_or_else(|| panic!("{line}"));
            assert_eq!((dialect.separator, dialect.decimal_comma), (separator, comma), "{line}");
            assert_eq!(dialect.split_fields(line).len(), fields, "{line}");
        }
        assert_eq!(Dialect::numbers("0|1", Some(b'|')).map(|dialect| dialect.separator), Some(b'|'));
    }

    #[test]
    fn titles_and_single_numbers_are_no_line_of_numbers() {
        for line in
            ["", "0.5", "time_s,force_n", "Rate,100", "Date\t2024/05/01", "Force (N)", "***End_of_Header***", "s;N"]
        {
            assert_eq!(Dialect::numbers(line, None), None, "{line}");
        }
    }

    #[test]
    fn quotes_hold_separators_and_doubled_quotes() {
        let fields = Dialect::new(b',').split_fields(" \"a, b\" ,c \"d\", \"say \"\"x\"\"\",");
        assert_eq!(fields, ["a, b", "c \"d\"", "say \"x\"", ""]);
        assert_eq!(Dialect::new(b';').split_fields("\"open;1"), ["open;1"]);
    }
}
