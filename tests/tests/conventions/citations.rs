//! Citations: a method that a comment cites by its key, as `[kelley1998]`, stands in `paper/refs.bib`.

use std::collections::BTreeSet;

use crate::assert_none;
use crate::source::Source;
use crate::tree::{sources, text};

/// The keys of a BibTeX file.
fn keys(bibliography: &str) -> BTreeSet<String> {
    let entries = bibliography.lines().filter_map(|line| line.strip_prefix('@')?.split_once('{'));
    entries.filter_map(|(_, rest)| Some(rest.split_once(',')?.0.to_owned())).collect()
}

/// Whether a word is a surname and a year: `lighthill1971`.
fn is_key(word: &str) -> bool {
    let name = word.trim_end_matches(|c: char| c.is_ascii_digit());
    name.len() >= 3 && word.len() == name.len() + 4 && name.chars().all(|c| c.is_ascii_lowercase())
}

/// The keys that a line of a comment cites: the first word within brackets, which rustdoc may need escaped.
fn cited(line: &str) -> Vec<String> {
    let comment = line.split_once("//").map_or("", |(_, comment)| comment);
    let within = comment.split('[').skip(1).filter_map(|rest| rest.split([']', ',', '\\', ' ']).next());
    within.filter(|word| is_key(word)).map(str::to_owned).collect()
}

/// Citations of a source that the bibliography lacks.
fn uncited(source: &Source, known: &BTreeSet<String>) -> Vec<String> {
    let lines = source.text.lines().enumerate();
    let all = lines.flat_map(|(i, line)| cited(line).into_iter().map(move |key| (i + 1, key)));
    all.filter(|(_, key)| !known.contains(key)).map(|(n, key)| format!("{}:{n} cites {key}", source.path)).collect()
}

#[test]
fn every_method_that_a_comment_cites_stands_in_the_bibliography() {
    let known = keys(&text("paper/refs.bib"));
    assert!(known.contains("lighthill1971"));
    assert_none(sources(&["pipeline"]).iter().flat_map(|s| uncited(s, &known)).collect());
}

#[test]
fn a_citation_that_the_bibliography_lacks_is_found() {
    let known = keys("@book{lamb1932, author = {Lamb, Horace}}\n");
    let source =
        Source::new("a.rs", "//! Waves [lamb1932, section 228].\n/// Drag \\[taylor1952\\].\nlet a = b[word1999];\n");
    assert_eq!(uncited(&source, &known), ["a.rs:2 cites taylor1952"]);
}
