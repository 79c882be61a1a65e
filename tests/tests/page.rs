//! The page, as it is before anything was made: everything of the lists has its place on it, and no address leaves it.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::PathBuf;

use study::runner::Runner;
use study::settings::Profile;

/// A project with one small specimen, removed at the end.
struct Project(PathBuf);

impl Project {
    fn new(name: &str) -> Self {
        let root = std::env::temp_dir().join(format!("page-{name}-{}", std::process::id()));
        let house = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
        fs::create_dir_all(root.join("data/raw/fish/cad")).unwrap();
        fs::create_dir_all(root.join("paper")).unwrap();
        fs::write(root.join("data/raw/fish/specimen.toml"), tests::CARD).unwrap();
        for page in ["study.toml", "paper/claims.toml", "paper/expected.toml"] {
            fs::copy(house.join(page), root.join(page)).unwrap();
        }
        Self(root)
    }

    fn open(&self) -> Runner {
        let (runner, faults) = study::open(&self.0, Profile::Paper, true, 1).unwrap();
        assert!(faults.is_empty(), "{faults:?}");
        runner
    }
}

impl Drop for Project {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn every_figure_table_stage_and_claim_has_its_place_on_the_page() {
    let project = Project::new("places");
    let runner = project.open();
    let html = fs::read_to_string(runner.page().unwrap()).unwrap();
    let made = |entry: &study::entry::Entry| !(entry.subjects)(&runner.study).is_empty();
    for (list, kind) in [(study::figures::ALL, "figure"), (study::tables::ALL, "table"), (study::stages::ALL, "stage")]
    {
        let missing = list.iter().filter(|e| made(e)).map(|e| format!("id=\"{kind}-{}\"", e.name));
        let missing: Vec<String> = missing.filter(|id| !html.contains(id)).collect();
        assert!(missing.is_empty(), "{missing:?}");
    }
    let claims = study::claims::read(&runner.folders.claims()).unwrap();
    assert_eq!(html.matches("<td class=\"verdict").count(), claims.len());
}

#[test]
fn the_page_asks_no_network_and_is_the_same_twice() {
    let project = Project::new("network");
    let runner = project.open();
    let first = fs::read_to_string(runner.page().unwrap()).unwrap();
    assert_eq!(first, fs::read_to_string(runner.page().unwrap()).unwrap());
    assert!(!first.contains("http:") && !first.contains("https:") && !first.contains("@import"));
    assert!(first.contains("default-src 'none'"));
}
