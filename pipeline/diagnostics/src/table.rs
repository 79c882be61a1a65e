//! Pages of TOML: their numbers with keys and lines, and errors of the parser as diagnostics with the line and the closest known key.
//!
//! No page holds NaN or an infinity. Comparisons with NaN are false, so that a limit of NaN would switch off the check that it belongs to.

use std::fmt::Display;
use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::{Diagnostic, Result};

/// A number of a page.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// The path of its key, as in `trial.2.amplitude`.
    pub key: String,
    /// Its value; an integer as the nearest number.
    pub value: f64,
    /// Its bytes in the text.
    pub span: Range<usize>,
}

/// The line, from 1, of byte `offset`.
pub fn line_of_offset(text: &str, offset: usize) -> usize {
    1 + text.bytes().take(offset).filter(|b| *b == b'\n').count()
}

/// The line, from 1, of the value at a path such as `trial.2.amplitude`; the deepest part that exists.
pub fn line_of_path(text: &str, path: &str) -> Option<usize> {
    let (root, _) = DeTable::parse_recoverable(text);
    let mut parts = path.split('.');
    let mut value = root.get_ref().get(parts.next()?)?;
    for part in parts {
        let next = match value.get_ref() {
            DeValue::Table(table) => table.get(part),
            DeValue::Array(array) => part.parse().ok().and_then(|index: usize| array.get(index)),
            _ => None,
        };
        match next {
            Some(next) => value = next,
            None => break,
        }
    }
    Some(line_of_offset(text, value.span().start))
}

/// Calls `see` with the path of the key of every value, from the outside to the inside.
fn walk_values(text: &str, see: &mut dyn FnMut(&str, &Spanned<DeValue>)) {
    fn enter_value(key: &str, value: &Spanned<DeValue>, see: &mut dyn FnMut(&str, &Spanned<DeValue>)) {
        see(key, value);
        let mut child = |name: &dyn Display, value| enter_value(&format!("{key}.{name}"), value, see);
        match value.get_ref() {
            DeValue::Table(table) => table.iter().for_each(|(name, value)| child(name.get_ref(), value)),
            DeValue::Array(array) => array.iter().enumerate().for_each(|(i, value)| child(&i, value)),
            _ => {}
        }
    }
    let (root, _) = DeTable::parse_recoverable(text);
    root.get_ref().iter().for_each(|(name, value)| enter_value(name.get_ref(), value, see));
}

/// Every number of a page, in the order of its keys.
pub fn numbers(text: &str) -> Vec<Number> {
    let mut numbers = Vec::new();
    walk_values(text, &mut |key, value| {
        let number = match value.get_ref() {
            DeValue::Float(float) => float.as_str().parse().ok(),
            // more digits than an integer holds are refused by the parser; here they have a value, and so a range
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
            DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|n| n as f64),
            _ => None,
        };
        let span = value.span();
        numbers.extend(number.map(|value| Number { key: key.to_owned(), value, span }));
    });
    numbers
}

/// Refuses a page that holds NaN or an infinity; `see` says where its keys are explained.
///
/// # Errors
/// A [`Diagnostic`] with the key and its line.
pub fn check_finite(text: &str, path: &Path, see: &str) -> Result<()> {
    match numbers(text).into_iter().find(|number| !number.value.is_finite()) {
        None => Ok(()),
        Some(Number { key, value, span }) => {
            let message = format!("{key} = {value} is not a finite number");
            let reason = "neither a quantity nor a limit is NaN or infinite: a limit that is would never be exceeded";
            let line = line_of_offset(text, span.start);
            Err(Diagnostic::file(path, message, reason, format!("write a number; {see}")).at_line(line))
        }
    }
}

/// Any TOML error as a diagnostic: the key, the parser's message, the words it expected, the nearest one; `see` says where the keys are
/// explained.
pub fn toml_error(text: &str, path: &Path, error: &toml::de::Error, see: &str) -> Diagnostic {
    let message = error.message().lines().collect::<Vec<_>>().join(" ");
    let (what, expected) = message.split_once(", expected ").unwrap_or((&message, ""));
    let reason = match expected {
        "" => "a page holds every key of its tables once, with the type and unit it is documented with".to_owned(),
        words => format!("expected {words}"),
    };
    let line = error.span().map(|span| line_of_offset(text, span.start));
    let key = error.span().and_then(|span| key_of_span(text, &span));
    let named = key.map_or_else(|| what.to_owned(), |key| format!("{key}: {what}"));
    Diagnostic::file(path, named, reason, action_for(what, expected, see)).at_line(line)
}

/// The path of the key whose value takes these bytes.
fn key_of_span(text: &str, span: &Range<usize>) -> Option<String> {
    let mut path = None;
    walk_values(text, &mut |key, value| {
        if value.span() == *span {
            path = Some(key.to_owned());
        }
    });
    path
}

fn action_for(what: &str, expected: &str, see: &str) -> String {
    let quoted = |text: &str| text.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    let expected_words = quoted(expected);
    let expected_words: Vec<&str> = expected_words.iter().map(String::as_str).collect();
    let wrong = quoted(what);
    let suggestion = wrong.first().and_then(|word| nearest(word, &expected_words).map(|suggestion| (word, suggestion)));
    match suggestion {
        Some((word, suggestion)) => format!("write `{suggestion}` instead of `{word}`, or take the line out"),
        None if what.starts_with("unknown") => format!("take the line out; {see}"),
        None if what.starts_with("missing field") => format!("add it; {see}"),
        None => format!("correct it; {see}"),
    }
}

/// Levenshtein distance between two words.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut corner = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let change = corner + usize::from(from != *to);
            corner = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(corner + 1);
        }
    }
    row[b.len()]
}

/// The word of `known` that is nearest to `word`, if it is close enough to be a typing error (a third of its letters, or two).
pub fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let (steps, best) = known.iter().map(|k| (distance(word, k), *k)).min()?;
    (steps <= 2.max(word.chars().count() / 3)).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_of_the_second_table_of_a_list_is_found_on_its_line() {
        let text = "a = 1\n[[trial]]\nid = 1\n[[trial]]\nid = 2\n";
        assert_eq!(line_of_path(text, "trial.1.id"), Some(5));
        assert_eq!(line_of_path(text, "absent"), None);
    }

    #[test]
    fn a_word_with_two_wrong_letters_is_found_and_an_unrelated_one_is_not() {
        let known = ["youngs_modulus", "poissons_ratio", "density"];
        assert_eq!(nearest("young_modulus", &known), Some("youngs_modulus"));
        assert_eq!(nearest("colour", &known), None);
    }

    #[test]
    fn every_number_is_found_with_its_key_and_its_bytes() {
        let text = "a = 1_000\n[b]\nc = [0x10, -2.5, { d = 18446744073709551615 }]\n[[e]]\nf = -1e3\ng = 'no'\n";
        let keys: Vec<(String, f64, &str)> =
            numbers(text).into_iter().map(|n| (n.key, n.value, &text[n.span])).collect();
        let expected = [
            ("a", 1000.0, "1_000"),
            ("b.c.0", 16.0, "0x10"),
            ("b.c.1", -2.5, "-2.5"),
            ("b.c.2.d", 2_f64.powi(64), "18446744073709551615"),
            ("e.0.f", -1000.0, "-1e3"),
        ];
        assert_eq!(keys, expected.map(|(key, value, bytes)| (key.to_owned(), value, bytes)));
    }

    #[test]
    fn nan_and_infinities_are_refused_with_key_and_line_however_deep_they_stand() {
        for number in ["nan", "-nan", "inf", "-inf", "+inf", "1e400", "-1e400"] {
            let text = format!("[a]\nb = [1.0, {{ c = {number} }}]\n");
            let refused = check_finite(&text, Path::new("page.toml"), "see the manual").unwrap_err().to_string();
            assert!(refused.starts_with("page.toml, line 2: a.b.1.c = ") && refused.contains("finite"), "{refused}");
        }
        assert!(check_finite("a = 1e308\nb = -1\n", Path::new("page.toml"), "").is_ok());
    }

    #[test]
    fn a_value_of_a_wrong_type_is_refused_with_its_key() {
        #[derive(Debug, serde::Deserialize)]
        #[allow(dead_code)]
        struct Page {
            count: u32,
        }
        for value in ["2.5", "1e18", "'x'", "-1", "18446744073709551615"] {
            let text = format!("# a page\ncount = {value}\n");
            let error = toml::from_str::<Page>(&text).unwrap_err();
            let refused = toml_error(&text, Path::new("page.toml"), &error, "see the manual").to_string();
            assert!(refused.starts_with("page.toml, line 2: count: "), "{refused}");
        }
    }
}
