//! What no file contains: unfinished work, panics outside of tests, skipped tests, specimens in the tool crates.
//!
//! The forbidden words are put together from pieces here, so that this file does not hold them itself.

use crate::assert_none;
use crate::source::Source;
use crate::tree::sources;

/// Crates that serve any tail and so name none.
const TOOLS: &[&str] = &[
    "si",
    "diagnostics",
    "mesh",
    "tail_cad",
    "materials",
    "sparse",
    "fem",
    "track",
    "signal",
    "optimize",
    "hydro",
    "plot",
    "lab",
    "simulate",
    "workflow",
];
/// The tails of the paper.
const SPECIMENS: &[&str] = &["nemo", "dory", "bruce"];

/// Places (`path:line`) in a view of a source where one of some words stands, and is not the end of a longer one.
pub fn places(source: &Source, view: &str, words: &[String]) -> Vec<String> {
    let before = |line: &str, at: usize| line[..at].chars().next_back();
    let longer = |line: &str, word: &str, at: usize| {
        let letter = |c: char| c.is_alphanumeric() || c == '_';
        word.starts_with(letter) && before(line, at).is_some_and(letter)
    };
    let stands = |line: &str, word: &str| line.match_indices(word).any(|(at, _)| !longer(line, word, at));
    let said = |line: &str| words.iter().find(|word| stands(line, word)).cloned();
    let lines = view.lines().enumerate();
    lines.filter_map(|(i, line)| said(line).map(|word| format!("{}:{} says {word}", source.path, i + 1))).collect()
}

fn unfinished(source: &Source) -> Vec<String> {
    let words = [["TO", "DO"], ["FIX", "ME"], ["to", "do!("], ["dbg", "!("], ["unimplement", "ed!("]];
    places(source, &source.text, &words.map(|pieces| pieces.concat()))
}

fn skipped_tests(source: &Source) -> Vec<String> {
    places(source, &source.code(), &[["#[ign", "ore"].concat()])
}

fn panics_on_the_way(source: &Source) -> Vec<String> {
    match source.test {
        true => vec![],
        false => places(source, &source.outside_tests(&source.code()), &[[".unw", "rap()"].concat()]),
    }
}

/// Printing past `diagnostics::output`, which alone survives a reader that has gone and a full disk.
fn prints(source: &Source) -> Vec<String> {
    let own = source.test || source.path.contains("/examples/") || source.path == "pipeline/diagnostics/src/output.rs";
    let macros = ["print", "println", "eprint", "eprintln"].map(|name| [name, "!("].concat());
    if own { vec![] } else { places(source, &source.outside_tests(&source.code()), &macros) }
}

/// Specimens named anywhere in a tool, in code, words or tests.
fn specimens_in_tools(source: &Source) -> Vec<String> {
    let in_tool = TOOLS.iter().any(|tool| source.path.starts_with(&format!("pipeline/{tool}/")));
    let lower = source.text.to_lowercase();
    let named = |line: &str| line.split(|c: char| !c.is_alphabetic()).any(|word| SPECIMENS.contains(&word));
    let lines = lower.lines().enumerate().filter(|(_, line)| in_tool && named(line));
    lines.map(|(i, line)| format!("{}:{} names a specimen: {}", source.path, i + 1, line.trim())).collect()
}

fn everywhere(folders: &[&str], check: fn(&Source) -> Vec<String>) -> Vec<String> {
    sources(folders).iter().flat_map(check).collect()
}

#[test]
fn nothing_is_left_for_later() {
    assert_none(everywhere(&["pipeline", "tests"], unfinished));
}

#[test]
fn no_test_is_skipped() {
    assert_none(everywhere(&["pipeline", "tests"], skipped_tests));
}

#[test]
fn nothing_is_unwrapped_outside_of_tests() {
    assert_none(everywhere(&["pipeline"], panics_on_the_way));
}

#[test]
fn only_one_module_prints() {
    assert_none(everywhere(&["pipeline"], prints));
}

#[test]
fn a_line_printed_past_the_output_is_found() {
    let call = ["eprint", "ln!(\"a\");"].concat();
    assert_eq!(prints(&Source::new("pipeline/cli/src/main.rs", &format!("fn a() {{ {call} }}\n"))).len(), 1);
    assert!(prints(&Source::new("pipeline/diagnostics/src/output.rs", &format!("fn a() {{ {call} }}\n"))).is_empty());
}

#[test]
fn no_tool_names_a_specimen() {
    assert_none(everywhere(&["pipeline"], specimens_in_tools));
}

#[test]
fn a_note_for_later_is_found_in_code_and_in_comments() {
    let text = format!("fn a() {{}}\n// {}DO: more\nfn b() {{ dbg{}1); }}\n", "TO", "!(");
    assert_eq!(unfinished(&Source::new("a.rs", &text)).len(), 2);
}

#[test]
fn a_skipped_test_is_found_and_a_word_about_it_is_not() {
    let mark = ["#[ign", "ore]"].concat();
    assert_eq!(skipped_tests(&Source::new("a.rs", &format!("#[test]\n{mark}\nfn a() {{}}\n"))).len(), 1);
    assert!(skipped_tests(&Source::new("a.rs", &format!("// never {mark}\n"))).is_empty());
}

#[test]
fn an_unwrap_is_found_outside_of_tests_alone() {
    let call = ["x.unw", "rap();"].concat();
    let text = format!("fn a() {{ {call} }}\n#[cfg(test)]\nmod tests {{ fn b() {{ {call} }} }}\n// {call}\n");
    let found = panics_on_the_way(&Source::new("pipeline/fem/src/mesh.rs", &text));
    assert_eq!(found.len(), 1);
    assert!(found[0].starts_with("pipeline/fem/src/mesh.rs:1 "));
    let beam = Source { test: true, ..Source::new("pipeline/fem/tests/beam.rs", &text) };
    assert!(panics_on_the_way(&beam).is_empty());
}

#[test]
fn a_specimen_is_found_in_a_tool_whatever_its_letters() {
    let bad = "let path = \"Nemo/trials\";\n";
    assert_eq!(specimens_in_tools(&Source::new("pipeline/fem/src/mesh.rs", bad)).len(), 1);
    assert!(specimens_in_tools(&Source::new("pipeline/rig/src/tails.rs", bad)).is_empty());
    assert!(specimens_in_tools(&Source::new("pipeline/fem/src/mesh.rs", "// phenomenon\n")).is_empty());
}
