//! Dependencies between the crates, and what every crate takes from the workspace.

use crate::assert_none;
use crate::tree::{crates, text};

/// Each crate, and the crates of the workspace that it may use, for its tests too; each stands after those that it uses.
const ALLOWED: &[(&str, &[&str])] = &[
    ("si", &[]),
    ("diagnostics", &[]),
    ("tetrahedralize", &["si"]),
    ("mesh", &["si", "tetrahedralize"]),
    ("tail_cad", &["si", "mesh"]),
    ("optimize", &["si"]),
    ("materials", &["si"]),
    ("sparse", &["si"]),
    ("fem", &["si", "materials", "sparse"]),
    ("continuation", &["si", "sparse", "fem"]),
    ("track", &["si", "optimize"]),
    ("signal", &["si", "optimize"]),
    ("hydro", &["si"]),
    ("plot", &["si"]),
    ("lab", &["si", "diagnostics"]),
    ("instruments", &["si", "diagnostics", "lab", "track", "signal", "plot"]),
    ("simulate", &["si", "diagnostics", "lab", "mesh", "tail_cad", "fem", "continuation"]),
    ("twin", &["materials"]),
    ("sysid", &["si", "diagnostics", "lab", "mesh", "fem", "signal", "optimize", "hydro", "plot", "simulate", "twin"]),
    (
        "thrust",
        &["si", "diagnostics", "lab", "mesh", "tail_cad", "fem", "signal", "optimize", "hydro", "sysid", "twin"],
    ),
    ("workflow", &["diagnostics", "plot"]),
    ("publish", &["si", "diagnostics", "plot", "twin", "workflow"]),
    ("rig", &["si", "diagnostics", "lab", "mesh", "tail_cad", "fem", "track", "signal", "simulate", "workflow"]),
    (
        "records",
        &[
            "si",
            "diagnostics",
            "lab",
            "mesh",
            "fem",
            "track",
            "signal",
            "optimize",
            "hydro",
            "sysid",
            "thrust",
            "workflow",
        ],
    ),
    (
        "study",
        &[
            "si",
            "diagnostics",
            "lab",
            "mesh",
            "tail_cad",
            "fem",
            "track",
            "signal",
            "optimize",
            "hydro",
            "plot",
            "simulate",
            "sysid",
            "twin",
            "thrust",
            "workflow",
            "publish",
            "records",
        ],
    ),
    (
        "cli",
        &[
            "si",
            "diagnostics",
            "lab",
            "mesh",
            "tail_cad",
            "track",
            "signal",
            "optimize",
            "instruments",
            "simulate",
            "sysid",
            "twin",
            "workflow",
            "publish",
            "records",
            "study",
        ],
    ),
    ("typeset", &["diagnostics"]),
    (
        "python",
        &["diagnostics", "mesh", "fem", "track", "instruments", "simulate", "sysid", "twin", "workflow", "study"],
    ),
];

/// Crates that `cargo build` leaves out: their dependencies take long or need Python, and nothing else needs them.
const LEFT_OUT: &[&str] = &["typeset", "python"];

/// What a manifest uses of the workspace beyond what it may.
fn forbidden_dependencies(name: &str, manifest: &str) -> Vec<String> {
    let Some((_, may)) = ALLOWED.iter().find(|(of, _)| *of == name) else {
        return vec![format!("the crate `{name}` has no line in the list of dependencies")];
    };
    let Ok(manifest) = manifest.parse::<toml::Table>() else {
        return vec![format!("pipeline/{name}/Cargo.toml cannot be read")];
    };
    let kinds = ["dependencies", "dev-dependencies", "build-dependencies"];
    let used = kinds.iter().filter_map(|kind| manifest.get(*kind)?.as_table()).flat_map(|t| t.keys());
    let workspace = used.filter(|used| ALLOWED.iter().any(|(of, _)| of == used));
    let wrong = workspace.filter(|used| !may.contains(&used.as_str()));
    wrong.map(|used| format!("`{name}` uses `{used}`; it may use {may:?}")).collect()
}

/// A crate that does not take the lints of the workspace.
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
fn crates_use_only_what_they_may() {
    assert_none(each_manifest(forbidden_dependencies));
}

#[test]
fn every_crate_takes_the_lints_of_the_workspace() {
    assert_none(each_manifest(without_lints));
}

#[test]
fn every_crate_is_named_in_the_table_of_contributing() {
    let page = text("CONTRIBUTING.md");
    if !page.is_empty() {
        assert_none(unnamed(&crates(), &page));
    }
}

#[test]
fn every_crate_but_those_left_out_is_built_by_default() {
    let manifest: toml::Table = text("Cargo.toml").parse().unwrap();
    let listed = manifest["workspace"]["default-members"].as_array().unwrap();
    let built = |name: &str| listed.iter().any(|l| l.as_str() == Some(&format!("pipeline/{name}")));
    let wrong = crates().into_iter().filter(|name| built(name) == LEFT_OUT.contains(&name.as_str()));
    assert_none(wrong.map(|name| format!("default-members are wrong about `{name}`")).collect());
}

#[test]
fn dependencies_point_downwards() {
    for (i, (_, may)) in ALLOWED.iter().enumerate() {
        assert!(may.iter().all(|used| ALLOWED[..i].iter().any(|(of, _)| of == used)));
    }
    let study = ALLOWED.iter().find(|(of, _)| *of == "study");
    assert!(study.is_some_and(|(_, may)| !may.contains(&"rig")));
}

#[test]
fn a_dependency_between_two_tools_is_found() {
    assert_eq!(forbidden_dependencies("fem", "[dependencies]\nsi.workspace = true\nmesh.workspace = true\n").len(), 1);
    assert_eq!(forbidden_dependencies("fem", "[dev-dependencies]\nmesh = { path = \"../mesh\" }\n").len(), 1);
    assert_eq!(forbidden_dependencies("study", "[dependencies]\nrig.workspace = true\n").len(), 1);
    assert_eq!(forbidden_dependencies("unknown", "").len(), 1);
    assert!(forbidden_dependencies("fem", "[dependencies]\nsi.workspace = true\nrayon = \"1\"\n").is_empty());
}

#[test]
fn a_manifest_without_lints_is_found() {
    assert_eq!(without_lints("fem", "[package]\nname = \"fem\"\n").len(), 1);
}

#[test]
fn a_crate_that_a_page_only_mentions_in_passing_is_found() {
    assert_eq!(unnamed(&["fem".to_owned()], "We like `fem`.\n| 2 | `mesh` | STL |\n").len(), 1);
}
