//! Pages that people read: the README stays short, holds the two commands that make and test everything, and no link of a page is dead.

use crate::assert_none;
use crate::tree::{crates, text, top};

/// What a reader takes in at one sitting; what is longer moves to the page of the crate that it concerns.
const MAX_README_WORDS: usize = 1_000;
/// One page; what a module's documentation says better stands there.
const MAX_CONTRIBUTING_WORDS: usize = 900;
/// Folders in which a path of CONTRIBUTING begins.
const BASES: [&str; 4] = ["", "pipeline", "pipeline/study/src", "tests/tests"];
/// From a fresh clone, the paper and the tests.
const COMMANDS: [&str; 2] = ["cargo install just --locked && just all", "cargo install just --locked && just test"];

/// The pages of the project and of its crates, those that exist.
pub fn pages() -> Vec<String> {
    let crate_pages = crates().into_iter().map(|name| format!("pipeline/{name}/README.md"));
    let pages = ["README.md", "CONTRIBUTING.md", "data/raw/README.md", "paper/README.md"].map(str::to_owned);
    pages.into_iter().chain(crate_pages).filter(|page| top().join(page).is_file()).collect()
}

/// Targets of the links `[text](target)` of a page that lie in the project.
fn link_targets(page: &str) -> Vec<&str> {
    let targets = page.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0));
    targets.filter(|target| !target.contains("://") && !target.starts_with('#')).collect()
}

fn dead_links(page: &str) -> Vec<String> {
    let folder = top().join(page).parent().map(std::path::Path::to_path_buf).unwrap_or_default();
    let content = text(page);
    let dead = link_targets(&content).into_iter().filter(|target| !folder.join(target).exists());
    dead.map(|target| format!("{page} links to {target}, which does not exist")).collect()
}

/// Paths between backquotes; those with a name to fill in are left out.
fn quoted_paths(page: &str) -> Vec<&str> {
    let quoted = page.split('`').skip(1).step_by(2);
    quoted
        .filter(|path| {
            path.contains('/') && !path.starts_with("//") && !path.contains([' ', '<', '{']) && !path.contains("NAME")
        })
        .collect()
}

#[test]
fn the_readme_and_contributing_are_short() {
    for (page, limit) in [("README.md", MAX_README_WORDS), ("CONTRIBUTING.md", MAX_CONTRIBUTING_WORDS)] {
        let words = text(page).split_whitespace().count();
        assert!(words <= limit, "{page} has {words} words; the limit is {limit}");
    }
}

#[test]
fn every_path_of_contributing_exists() {
    let page = text("CONTRIBUTING.md");
    let is_missing = |path: &&str| !BASES.iter().any(|base| top().join(base).join(path).exists());
    let missing = quoted_paths(&page).into_iter().filter(is_missing);
    assert_none(missing.map(|path| format!("CONTRIBUTING names `{path}`, which does not exist")).collect());
    assert!(quoted_paths(&page).len() > 20, "{:?}", quoted_paths(&page));
}

#[test]
fn the_readme_holds_the_commands_that_make_and_test_everything() {
    let readme = text("README.md");
    assert_none(
        COMMANDS
            .iter()
            .filter(|command| !readme.lines().any(|line| line == **command))
            .map(ToString::to_string)
            .collect(),
    );
}

#[test]
fn no_link_of_a_page_is_dead() {
    assert_none(pages().iter().flat_map(|page| dead_links(page)).collect());
}

#[test]
fn links_into_the_project_are_found_and_others_are_not() {
    assert_eq!(link_targets("![a](b/c.svg) and [d](e.md), [f](https://g.h), [i](#j)"), ["b/c.svg", "e.md"]);
}
