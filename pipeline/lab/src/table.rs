//! TOML texts: the line of a key, and errors of the parser as diagnostics with the line and the closest known key.

use std::path::Path;

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

use crate::range::Checked;
use diagnostics::Diagnostic;

/// Where the keys of a card are explained.
pub(crate) const SEE: &str = "data/raw/README.md has every key with its unit";

/// The line, from 1, of byte `offset`.
pub(crate) fn line_of_offset(text: &str, offset: usize) -> usize {
    1 + text.bytes().take(offset).filter(|b| *b == b'\n').count()
}

/// The line, from 1, of the value at a path such as `trial.2.amplitude`; the deepest part that exists.
pub fn line_of_path(text: &str, path: &str) -> Option<usize> {
    let (root, _) = DeTable::parse_recoverable(text);
    let mut parts = path.split('.');
    let mut here = root.get_ref().get(parts.next()?)?;
    for part in parts {
        let next = match here.get_ref() {
            DeValue::Table(table) => table.get(part),
            DeValue::Array(array) => part.parse().ok().and_then(|index: usize| array.get(index)),
            _ => None,
        };
        match next {
            Some(next) => here = next,
            None => break,
        }
    }
    Some(line_of_offset(text, here.span().start))
}

/// A page of TOML that passes its `check`; `see` says where its keys are explained.
///
/// # Errors
/// A [`Diagnostic`] with the line of an unknown, missing or mistyped key, or of the entry that the check found.
pub fn parse<T: DeserializeOwned>(
    text: &str,
    path: &Path,
    see: &str,
    check: impl FnOnce(&T) -> Checked,
) -> Result<T, Diagnostic> {
    let page: T = toml::from_str(text).map_err(|e| toml_error(text, path, &e, see))?;
    check(&page).map_err(|violation| {
        let line = line_of_path(text, &violation.key);
        Diagnostic::file(path, violation.what, violation.why, violation.action).at_line(line)
    })?;
    Ok(page)
}

/// Any TOML error as a diagnostic: the parser's message, the words it expected, the nearest one; `see` says where the keys are
/// explained.
pub fn toml_error(text: &str, path: &Path, error: &toml::de::Error, see: &str) -> Diagnostic {
    let message = error.message().lines().collect::<Vec<_>>().join(" ");
    let (what, expected) = message.split_once(", expected ").unwrap_or((&message, ""));
    let why = match expected {
        "" => "a page holds every key of its tables once, with the type and unit it is documented with".to_owned(),
        words => format!("expected {words}"),
    };
    let line = error.span().map(|span| line_of_offset(text, span.start));
    Diagnostic::file(path, what, why, action_for(what, expected, see)).at_line(line)
}

fn action_for(what: &str, expected: &str, see: &str) -> String {
    let quoted = |text: &str| text.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    let known = quoted(expected);
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    let wrong = quoted(what);
    let near = wrong.first().and_then(|word| nearest(word, &known).map(|near| (word, near)));
    match near {
        Some((word, near)) => format!("write `{near}` instead of `{word}`, or take the line out"),
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
pub(crate) fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
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
    fn a_page_is_refused_at_the_line_of_a_wrong_key_or_number_and_read_past_a_byte_order_mark() {
        #[derive(Debug, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Page {
            held: f64,
        }
        let check = |page: &Page| crate::range::within("held", page.held, 0.0..=9.0, "s");
        let read = |text: &str| parse::<Page>(text, Path::new("page.toml"), "see the manual", check);
        assert_eq!(read("\u{feff}held = 3.0").unwrap().held, 3.0);
        let line = |text: &str| read(text).unwrap_err().location.and_then(|at| at.line);
        assert_eq!([line("# s\nheld = 30.0"), line("held = 3.0\n\nhold = 1")], [Some(2), Some(3)]);
    }

    #[test]
    fn a_word_with_two_wrong_letters_is_found_and_an_unrelated_one_is_not() {
        let known = ["youngs_modulus", "poissons_ratio", "density"];
        assert_eq!(nearest("young_modulus", &known), Some("youngs_modulus"));
        assert_eq!(nearest("colour", &known), None);
    }
}
