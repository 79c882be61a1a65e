//! The shape of files: their heads, names, lengths, and what git keeps.
//!
//! Stands on: `tree`, `source`. Never knows: what a file is about.

use std::process::Command;

use crate::nobody_complains;
use crate::source::Source;
use crate::tree::{sources, top};

/// A file that is longer holds two rooms.
const MOST_LINES: usize = 450;
/// Recordings and records are made, not kept in git.
const MOST_BYTES: u64 = 1 << 20;

fn without_head(source: &Source) -> bool {
    !source.text.starts_with("//!")
}

fn named_like_a_drawer(source: &Source) -> bool {
    let drawers = ["utils", "util", "misc", "common", "helpers", "helper"];
    source.path.trim_end_matches(".rs").split('/').any(|part| drawers.contains(&part))
}

fn too_long(source: &Source) -> bool {
    source.text.lines().count() > MOST_LINES
}

fn complaints(sources: &[Source], bad: fn(&Source) -> bool, what: &str) -> Vec<String> {
    sources.iter().filter(|s| bad(s)).map(|s| format!("{} {what}", s.path)).collect()
}

/// The files that git keeps, or none where this is no checkout.
fn kept() -> Vec<String> {
    let listed = Command::new("git").arg("-C").arg(top()).args(["ls-files", "-z"]).output();
    let bytes = listed.map(|out| out.stdout).unwrap_or_default();
    String::from_utf8_lossy(&bytes).split('\0').filter(|p| !p.is_empty()).map(str::to_owned).collect()
}

fn heavy(size: u64) -> bool {
    size > MOST_BYTES
}

#[test]
fn every_file_opens_with_what_it_is_for() {
    let sources = sources(&["pipeline", "tests"]);
    nobody_complains(complaints(&sources, without_head, "does not open with //!"));
}

#[test]
fn no_file_is_called_utils() {
    let sources = sources(&["pipeline", "tests"]);
    nobody_complains(complaints(&sources, named_like_a_drawer, "is a drawer for anything; name what it does"));
}

#[test]
fn no_file_holds_two_rooms() {
    let sources = sources(&["pipeline", "tests"]);
    nobody_complains(complaints(&sources, too_long, &format!("has more than {MOST_LINES} lines")));
}

#[test]
fn git_keeps_no_large_file() {
    let size = |path: &String| std::fs::metadata(top().join(path)).map_or(0, |m| m.len());
    let large = kept().into_iter().filter(|path| heavy(size(path)));
    nobody_complains(large.map(|path| format!("{path} is larger than {MOST_BYTES} bytes")).collect());
}

#[test]
fn a_file_without_a_head_is_found() {
    let bad = [Source::new("pipeline/fem/src/mesh.rs", "use si::Metre;\n//! Meshes.\n")];
    assert_eq!(complaints(&bad, without_head, ""), ["pipeline/fem/src/mesh.rs "]);
}

#[test]
fn a_drawer_is_found_as_a_file_and_as_a_folder() {
    assert!(named_like_a_drawer(&Source::new("pipeline/fem/src/utils.rs", "")));
    assert!(named_like_a_drawer(&Source::new("pipeline/fem/src/common/mod.rs", "")));
    assert!(!named_like_a_drawer(&Source::new("pipeline/fem/src/commons_of_oxford.rs", "")));
}

#[test]
fn a_line_too_many_is_found() {
    assert!(too_long(&Source::new("a.rs", &"//!\n".repeat(MOST_LINES + 1))));
    assert!(!too_long(&Source::new("a.rs", &"//!\n".repeat(MOST_LINES))));
}

#[test]
fn a_byte_too_many_is_found() {
    assert!(heavy(MOST_BYTES + 1) && !heavy(MOST_BYTES));
}
