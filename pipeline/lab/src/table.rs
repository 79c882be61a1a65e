//! TOML texts: the line of a key, and errors of the parser as diagnostics with the line and the closest known key.

use std::path::Path;

use toml::de::{DeTable, DeValue};

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
    fn a_word_with_two_wrong_letters_is_found_and_an_unrelated_one_is_not() {
        let known = ["youngs_modulus", "poissons_ratio", "density"];
        assert_eq!(nearest("young_modulus", &known), Some("youngs_modulus"));
        assert_eq!(nearest("colour", &known), None);
    }
}
