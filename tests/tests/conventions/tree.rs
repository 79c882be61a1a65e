//! The tree: the project's folders and files.

use std::fs;
use std::path::{Path, PathBuf};

use crate::source::Source;

/// The top of the project.
pub fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_path_buf).unwrap_or_default()
}

/// Every file of Rust below some folders of the project, by path.
pub fn sources(folders: &[&str]) -> Vec<Source> {
    let mut found = Vec::new();
    let mut open: Vec<PathBuf> = folders.iter().map(|folder| top().join(folder)).collect();
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten().map(|e| e.path()) {
            if entry.is_dir() {
                open.push(entry);
            } else if entry.extension().is_some_and(|e| e == "rs") {
                found.extend(fs::read_to_string(&entry).map(|text| Source::new(&below_top(&entry), &text)));
            }
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    mark_tests(found)
}

/// Marks files of tests and benches, and those that their parent declares under `#[cfg(test)]`.
fn mark_tests(mut found: Vec<Source>) -> Vec<Source> {
    let declared = |s: &Source| {
        let folder = s.path.rsplit_once('/').map_or("", |(folder, _)| folder);
        let own = s.path.trim_end_matches(".rs").to_owned();
        let modules = s.test_modules().into_iter();
        modules.flat_map(|m| [format!("{folder}/{m}"), format!("{own}/{m}")]).collect::<Vec<_>>()
    };
    let declared: Vec<String> = found.iter().flat_map(declared).collect();
    for source in &mut found {
        let own = source.path.trim_end_matches(".rs").trim_end_matches("/mod");
        source.test = ["/tests/", "/benches/"].iter().any(|folder| source.path.contains(folder))
            || declared.iter().any(|module| module == own);
    }
    found
}

/// The folders of the crates in `pipeline/`, by name.
pub fn crates() -> Vec<String> {
    let folders = fs::read_dir(top().join("pipeline")).into_iter().flatten().flatten();
    let with_manifest = folders.filter(|f| f.path().join("Cargo.toml").is_file());
    let mut names: Vec<String> = with_manifest.map(|f| f.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A file's text, empty when it does not exist.
pub fn text(path: &str) -> String {
    fs::read_to_string(top().join(path)).unwrap_or_default()
}

fn below_top(path: &Path) -> String {
    let below = path.strip_prefix(top()).unwrap_or(path);
    below.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

#[test]
fn a_file_that_only_tests_use_is_marked() {
    let parent = Source::new("pipeline/fem/src/materials/mod.rs", "#[cfg(test)]\nmod conformance;\nmod hooke;\n");
    let (child, other) = ("pipeline/fem/src/materials/conformance.rs", "pipeline/fem/src/materials/hooke.rs");
    let marked = mark_tests(vec![parent, Source::new(child, ""), Source::new(other, "")]);
    assert_eq!(marked.iter().map(|s| s.test).collect::<Vec<_>>(), [false, true, false]);
}

#[test]
fn the_tree_is_found() {
    assert!(crates().contains(&"si".to_owned()));
    assert!(sources(&["pipeline", "tests"]).iter().any(|s| s.path == "tests/tests/conventions/tree.rs"));
}
