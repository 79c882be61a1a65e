//! Visibility: a function or constant that no other crate uses is `pub(crate)`.
//!
//! Use is judged by name: a name that stands in no other crate, test, bench, program or doctest cannot be used there. Types are left to
//! the compiler, since another crate may use a type without naming it.

use std::collections::BTreeSet;

use crate::assert_none;
use crate::source::Source;
use crate::tree::{crates, sources};

/// What declares an item, behind `pub`.
const KINDS: &[&str] = &["fn", "const fn", "unsafe fn", "const", "static"];

/// The words of a text: names and keywords.
fn words(text: &str) -> impl Iterator<Item = String> + '_ {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|w| !w.is_empty()).map(str::to_owned)
}

/// The words of the examples in a source's documentation.
fn example_words(source: &Source) -> Vec<String> {
    let mut within = false;
    let mut found = Vec::new();
    for line in source.text.lines().map(str::trim_start) {
        let Some(comment) = line.strip_prefix("///").or(line.strip_prefix("//!")) else { continue };
        if comment.trim_start().starts_with("```") {
            within = !within;
        } else if within {
            found.extend(words(comment));
        }
    }
    found
}

/// Whether a source belongs to the library of a crate.
fn is_library(source: &Source, name: &str) -> bool {
    let inside =
        source.path.strip_prefix("pipeline/").and_then(|p| p.strip_prefix(name)).and_then(|p| p.strip_prefix("/src/"));
    inside.is_some_and(|file| file != "main.rs")
}

/// The public functions and constants that a source declares, with their lines.
fn declared(source: &Source) -> Vec<(usize, String)> {
    let code = source.outside_tests(&source.code());
    let item = |line: &str| {
        let rest = line.trim_start().strip_prefix("pub ")?;
        let kind = KINDS.iter().find(|kind| rest.strip_prefix(**kind).is_some_and(|r| r.starts_with(' ')))?;
        words(&rest[kind.len()..]).next()
    };
    code.lines()
        .enumerate()
        .filter_map(|(i, line)| item(line).filter(|n| n != "fn").map(|name| (i + 1, name)))
        .collect()
}

/// Public items of the library of a crate that nothing outside of it names.
fn without_use(name: &str, all: &[Source]) -> Vec<String> {
    let (own, others): (Vec<&Source>, Vec<&Source>) = all.iter().partition(|s| is_library(s, name));
    let mut used: BTreeSet<String> = others.iter().flat_map(|s| words(&s.code()).collect::<Vec<_>>()).collect();
    used.extend(all.iter().flat_map(example_words));
    let items =
        own.iter().filter(|s| !s.test).flat_map(|s| declared(s).into_iter().map(|item| (s.path.as_str(), item)));
    items.filter(|(_, (_, n))| !used.contains(n)).map(|(path, (line, n))| format!("{path}:{line} {n}")).collect()
}

#[test]
fn a_function_that_no_other_crate_uses_is_not_public() {
    let all = sources(&["pipeline", "tests"]);
    let library = |name: &String| all.iter().any(|s| s.path == format!("pipeline/{name}/src/lib.rs"));
    assert_none(crates().iter().filter(|name| library(name)).flat_map(|name| without_use(name, &all)).collect());
}

#[test]
fn a_public_function_without_use_is_found() {
    let text = "/// ```\n/// a::shown();\n/// ```\npub fn shown() {}\npub fn hidden() {}\npub const fn used() {}\npub(crate) fn own() {}\n";
    let all =
        [Source::new("pipeline/a/src/lib.rs", text), Source::new("pipeline/b/src/lib.rs", "fn b() { a::used() }")];
    assert_eq!(without_use("a", &all), ["pipeline/a/src/lib.rs:5 hidden"]);
}
