//! Arrows: which crate may use which, and what every crate takes from the workspace.
//!
//! The list is DESIGN's table; CONTRIBUTING repeats it for people.
//!
//! Stands on: `tree`. Never knows: Rust.

use crate::nobody_complains;
use crate::tree::{crates, text};

/// Each crate of the house, and the crates of the house that it may use, for its tests too.
const ARROWS: &[(&str, &[&str])] = &[
    ("si", &[]),
    ("shape", &["si"]),
    ("fem", &["si"]),
    ("track", &["si"]),
    ("signal", &["si"]),
    ("fit", &["si"]),
    ("hydro", &["si"]),
    ("plot", &["si"]),
    ("lab", &["si"]),
    ("rig", &["si", "lab", "shape", "fem", "track", "signal"]),
    ("study", &["si", "lab", "shape", "fem", "track", "signal", "fit", "hydro", "plot"]),
    ("typeset", &[]),
];

/// Crates that `cargo build` leaves out: their dependencies take long, and nothing of the house needs them.
const LEFT_OUT: &[&str] = &["typeset"];

/// What a manifest uses of the house beyond its arrows.
fn wrong_arrows(name: &str, manifest: &str) -> Vec<String> {
    let Some((_, may)) = ARROWS.iter().find(|(of, _)| *of == name) else {
        return vec![format!("the crate `{name}` has no line in the list of arrows")];
    };
    let Ok(manifest) = manifest.parse::<toml::Table>() else {
        return vec![format!("pipeline/{name}/Cargo.toml cannot be read")];
    };
    let kinds = ["dependencies", "dev-dependencies", "build-dependencies"];
    let used = kinds.iter().filter_map(|kind| manifest.get(*kind)?.as_table()).flat_map(|t| t.keys());
    let house = used.filter(|used| ARROWS.iter().any(|(of, _)| of == used));
    let wrong = house.filter(|used| !may.contains(&used.as_str()));
    wrong.map(|used| format!("`{name}` uses `{used}`; its arrows lead to {may:?}")).collect()
}

/// A crate that does not take the lints of the house.
fn without_lints(name: &str, manifest: &str) -> Vec<String> {
    let manifest = manifest.parse::<toml::Table>().unwrap_or_default();
    let taken = manifest.get("lints").and_then(|l| l.get("workspace")).and_then(toml::Value::as_bool);
    if taken == Some(true) { vec![] } else { vec![format!("`{name}` does not take the lints of the workspace")] }
}

/// Crates that a page does not name in a table.
fn unnamed(crates: &[String], page: &str) -> Vec<String> {
    let in_table = |name: &String| page.lines().any(|l| l.starts_with('|') && l.contains(&format!("`{name}`")));
    crates.iter().filter(|name| !in_table(name)).map(|name| format!("CONTRIBUTING has no line for `{name}`")).collect()
}

fn each_manifest(check: fn(&str, &str) -> Vec<String>) -> Vec<String> {
    crates().iter().flat_map(|name| check(name, &text(&format!("pipeline/{name}/Cargo.toml")))).collect()
}

#[test]
fn crates_use_only_what_their_arrows_lead_to() {
    nobody_complains(each_manifest(wrong_arrows));
}

#[test]
fn every_crate_takes_the_lints_of_the_house() {
    nobody_complains(each_manifest(without_lints));
}

#[test]
fn every_crate_is_named_in_the_table_of_contributing() {
    let page = text("CONTRIBUTING.md");
    if !page.is_empty() {
        nobody_complains(unnamed(&crates(), &page));
    }
}

#[test]
fn every_crate_but_those_left_out_is_built_by_default() {
    let manifest: toml::Table = text("Cargo.toml").parse().unwrap();
    let listed = manifest["workspace"]["default-members"].as_array().unwrap();
    let built = |name: &str| listed.iter().any(|l| l.as_str() == Some(&format!("pipeline/{name}")));
    let wrong = crates().into_iter().filter(|name| built(name) == LEFT_OUT.contains(&name.as_str()));
    nobody_complains(wrong.map(|name| format!("default-members are wrong about `{name}`")).collect());
}

#[test]
fn the_arrows_only_point_down() {
    for (i, (_, may)) in ARROWS.iter().enumerate() {
        assert!(may.iter().all(|used| ARROWS[..i].iter().any(|(of, _)| of == used)));
    }
    let study = ARROWS.iter().find(|(of, _)| *of == "study");
    assert!(study.is_some_and(|(_, may)| !may.contains(&"rig")));
}

#[test]
fn an_arrow_between_two_tools_is_found() {
    assert_eq!(wrong_arrows("fem", "[dependencies]\nsi.workspace = true\nshape.workspace = true\n").len(), 1);
    assert_eq!(wrong_arrows("fem", "[dev-dependencies]\nshape = { path = \"../shape\" }\n").len(), 1);
    assert_eq!(wrong_arrows("study", "[dependencies]\nrig.workspace = true\n").len(), 1);
    assert_eq!(wrong_arrows("cellar", "").len(), 1);
    assert!(wrong_arrows("fem", "[dependencies]\nsi.workspace = true\nrayon = \"1\"\n").is_empty());
}

#[test]
fn a_manifest_without_lints_is_found() {
    assert_eq!(without_lints("fem", "[package]\nname = \"fem\"\n").len(), 1);
}

#[test]
fn a_crate_that_a_page_only_mentions_in_passing_is_found() {
    assert_eq!(unnamed(&["fem".to_owned()], "We like `fem`.\n| 2 | `shape` | STL |\n").len(), 1);
}
