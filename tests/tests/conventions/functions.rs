//! Functions: how many parameters they take.

use crate::assert_none;
use crate::source::Source;
use crate::tree::sources;

/// From so many parameters on (`self` not counted) a struct with named fields reads better.
const MANY: usize = 5;
/// Number of functions that may take so many.
const MAX_WITH_MANY: usize = 0;

/// `path:line name` of every function with many parameters, outside of tests.
fn with_many_parameters(source: &Source) -> Vec<String> {
    if source.test {
        return Vec::new();
    }
    let code = source.outside_tests(&source.code());
    let mut found = Vec::new();
    for (start, _) in code.match_indices("fn ") {
        let before = code[..start].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let rest = &code[start + 3..];
        let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        if !name.is_empty() && parameters(&rest[name.len()..]) >= MANY {
            let line = code[..start].matches('\n').count() + 1;
            found.push(format!("{}:{line} {name}", source.path));
        }
    }
    found
}

/// The number of parameters of the list that follows a function's name and generics, `self` not counted.
fn parameters(after_name: &str) -> usize {
    let Some(open) = list_start(after_name) else { return 0 };
    let (mut depth, mut count, mut word) = (0, 0, String::new());
    let mut previous = ' ';
    for c in after_name[open + 1..].chars() {
        match c {
            ')' if depth == 0 => break,
            '(' | '[' | '<' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            '>' if previous != '-' => depth -= 1,
            ',' if depth == 0 => {
                count += usize::from(counts(&word));
                word.clear();
            }
            _ => {}
        }
        if !(c == ',' && depth == 0) {
            word.push(c);
        }
        previous = c;
    }
    count + usize::from(counts(&word))
}

fn counts(parameter: &str) -> bool {
    let parameter = parameter.trim();
    !parameter.is_empty() && !parameter.trim_start_matches(['&', ' ']).trim_start_matches("mut ").starts_with("self")
}

/// The parenthesis that opens the list, behind generics.
fn list_start(text: &str) -> Option<usize> {
    let mut depth = 0;
    let mut previous = ' ';
    for (i, c) in text.char_indices() {
        match c {
            '<' => depth += 1,
            '>' if previous != '-' => depth -= 1,
            '(' if depth == 0 => return Some(i),
            c if depth == 0 && !c.is_whitespace() && c != '>' => return None,
            _ => {}
        }
        previous = c;
    }
    None
}

#[test]
fn few_functions_take_many_parameters() {
    let found: Vec<String> = sources(&["pipeline"]).iter().flat_map(with_many_parameters).collect();
    assert_none(if found.len() > MAX_WITH_MANY { found } else { Vec::new() });
}

#[test]
fn many_parameters_are_counted_through_generics_and_closures() {
    let found = |text: &str| with_many_parameters(&Source::new("a.rs", text)).len();
    assert_eq!(found("fn a(b: u8, c: u8, d: [u8; 2], e: (u8, u8), f: &dyn Fn(u8, u8) -> u8) {}"), 1);
    assert_eq!(found("fn a<T: Fn(u8) -> u8>(&mut self, b: u8, c: Vec<(u8, u8)>, d: u8, e: u8) {}"), 0);
    assert_eq!(found("fn a(\n    b: u8,\n    c: u8,\n    d: u8,\n    e: u8,\n    f: u8,\n) {}"), 1);
}
