//! The dialect of a table of numbers: separator, decimal sign, and whether it has titles.
//!
//! All three are found in the text. The separator is the first of tab, `;` and `,` that stands in the first line; where it is not `,`, a
//! comma within a number is a decimal sign.

use std::borrow::Cow;

/// How a file writes its table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Dialect {
    /// Between two fields.
    pub separator: u8,
    /// Whether the first line holds titles.
    pub titled: bool,
}

impl Dialect {
    /// Of the text, by its first line that is neither empty nor a remark.
    pub fn of(text: &str) -> Self {
        let first = text.lines().find(|line| !line.starts_with('#') && !line.trim().is_empty()).unwrap_or_default();
        let separator = *b"\t;,".iter().find(|s| first.as_bytes().contains(s)).unwrap_or(&b',');
        let dialect = Self { separator, titled: true };
        let numeric = |field: &str| {
            let plain = dialect.plain(field.trim());
            plain.parse::<f64>().is_ok() || plain.starts_with(|c: char| c.is_ascii_digit())
        };
        let mut fields = first.split(char::from(separator)).filter(|field| !field.trim().is_empty());
        let titled = first.is_empty() || !fields.all(numeric);
        Self { titled, ..dialect }
    }

    /// A field with a decimal point.
    pub fn plain<'a>(&self, field: &'a str) -> Cow<'a, str> {
        if self.separator != b',' && field.contains(',') {
            Cow::Owned(field.replacen(',', ".", 1))
        } else {
            Cow::Borrowed(field)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separator_and_titles_are_found_in_the_first_line() {
        for (text, separator, titled) in [
            ("# made by us\ntime_s,led\n0,1\n", b',', true),
            ("time_s;led\n0,5;1\n", b';', true),
            ("0,5\t1,25\n", b'\t', false),
            ("0.5,1e-3\n", b',', false),
            ("2024-05-01 12:00:00,125;0,5\n", b';', false),
            ("", b',', true),
        ] {
            assert_eq!(Dialect::of(text), Dialect { separator, titled }, "{text}");
        }
    }

    #[test]
    fn a_comma_is_a_decimal_sign_where_it_separates_nothing() {
        assert_eq!(Dialect { separator: b';', titled: true }.plain("-1,5e3"), "-1.5e3");
        assert_eq!(Dialect { separator: b',', titled: true }.plain("1,5"), "1,5");
    }
}
