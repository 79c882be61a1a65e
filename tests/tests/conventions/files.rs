//! Files: their first line, names, lengths, module layout, and what git tracks.

use std::process::Command;

use crate::assert_none;
use crate::source::Source;
use crate::tree::{crates, sources, top};

/// A longer file holds two things.
const MOST_LINES: usize = 450;
/// Recordings and records are made, not kept in git.
const MOST_BYTES: u64 = 1 << 20;
/// What is kept to be read without a build, and how large it may be.
const PAPER: (&str, u64) = ("paper/paper.pdf", 3 << 20);

fn without_head(source: &Source) -> bool {
    !source.text.starts_with("//!")
}

fn named_for_nothing(source: &Source) -> bool {
    let vague = ["utils", "util", "misc", "common", "helpers", "helper"];
    source.path.trim_end_matches(".rs").split('/').any(|part| vague.contains(&part))
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

fn heavy(path: &str, size: u64) -> bool {
    size > if path == PAPER.0 { PAPER.1 } else { MOST_BYTES }
}

#[test]
fn every_file_opens_with_what_it_is_for() {
    let sources = sources(&["pipeline", "tests"]);
    assert_none(complaints(&sources, without_head, "does not open with //!"));
}

#[test]
fn no_file_is_called_utils() {
    let sources = sources(&["pipeline", "tests"]);
    assert_none(complaints(&sources, named_for_nothing, "has a name that says nothing; name what it does"));
}

#[test]
fn no_file_is_too_long() {
    let sources = sources(&["pipeline", "tests"]);
    assert_none(complaints(&sources, too_long, &format!("has more than {MOST_LINES} lines")));
}

#[test]
fn git_keeps_no_large_file() {
    let size = |path: &String| std::fs::metadata(top().join(path)).map_or(0, |m| m.len());
    let large = kept().into_iter().filter(|path| heavy(path, size(path)));
    assert_none(large.map(|path| format!("{path} is too large to be kept")).collect());
}

#[test]
fn a_file_without_a_head_is_found() {
    let bad = [Source::new("pipeline/fem/src/mesh.rs", "use si::Metre;\n//! Meshes.\n")];
    assert_eq!(complaints(&bad, without_head, ""), ["pipeline/fem/src/mesh.rs "]);
}

#[test]
fn a_vague_name_is_found_as_a_file_and_as_a_folder() {
    assert!(named_for_nothing(&Source::new("pipeline/fem/src/utils.rs", "")));
    assert!(named_for_nothing(&Source::new("pipeline/fem/src/common/mod.rs", "")));
    assert!(!named_for_nothing(&Source::new("pipeline/fem/src/commons_of_oxford.rs", "")));
}

#[test]
fn a_line_too_many_is_found() {
    assert!(too_long(&Source::new("a.rs", &"//!\n".repeat(MOST_LINES + 1))));
    assert!(!too_long(&Source::new("a.rs", &"//!\n".repeat(MOST_LINES))));
}

#[test]
fn a_byte_too_many_is_found() {
    assert!(heavy("a.bin", MOST_BYTES + 1) && !heavy("a.bin", MOST_BYTES));
    assert!(heavy(PAPER.0, PAPER.1 + 1) && !heavy(PAPER.0, PAPER.1));
}

/// A module with children lies in `name/mod.rs`, never in `name.rs` beside the folder.
fn beside_its_folder(paths: &[String]) -> Vec<String> {
    let folder =
        |path: &&String| paths.iter().any(|other| other.starts_with(&format!("{}/", path.trim_end_matches(".rs"))));
    paths.iter().filter(folder).map(|path| format!("{path} lies beside its folder; move it to mod.rs")).collect()
}

#[test]
fn a_module_with_children_is_a_folder_with_mod_rs() {
    assert_none(beside_its_folder(&sources(&["pipeline", "tests"]).into_iter().map(|s| s.path).collect::<Vec<_>>()));
}

#[test]
fn a_module_beside_its_folder_is_found() {
    assert_eq!(beside_its_folder(&["a/b.rs".into(), "a/b/c.rs".into(), "a/d/mod.rs".into()]).len(), 1);
}

/// Lines of Rust in a crate beyond which it should be two. Tests do not count: no one should leave one out for want of lines.
const MAX_CRATE_LINES: usize = 12_800;

/// The number of lines before a file's tests.
fn lines_of_code(text: &str) -> usize {
    text.lines().take_while(|line| *line != "#[cfg(test)]").count()
}

fn too_large(sizes: &[(String, usize)]) -> Vec<String> {
    let large = sizes.iter().filter(|(_, lines)| *lines > MAX_CRATE_LINES);
    large.map(|(name, lines)| format!("`{name}` has {lines} lines; the limit is {MAX_CRATE_LINES}")).collect()
}

#[test]
fn no_crate_is_too_large() {
    let files = sources(&["pipeline"]);
    let lines = |name: &String| {
        let own = files.iter().filter(|s| s.path.starts_with(&format!("pipeline/{name}/src/")));
        own.map(|s| lines_of_code(&s.text)).sum::<usize>()
    };
    assert_none(too_large(&crates().into_iter().map(|name| (name.clone(), lines(&name))).collect::<Vec<_>>()));
}

#[test]
fn tests_are_no_lines_of_a_crate() {
    assert_eq!(lines_of_code("fn a() {}\n\n#[cfg(test)]\nmod tests {}\n"), 2);
}

#[test]
fn a_crate_of_one_line_too_many_is_found() {
    assert_eq!(too_large(&[("a".into(), MAX_CRATE_LINES), ("b".into(), MAX_CRATE_LINES + 1)]).len(), 1);
}
