//! The page, as it is before anything was made: everything of the lists has its place on it, and no address leaves it.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::PathBuf;

use study::Runner;
use workflow::runner::Options;
use workflow::settings::Profile;

const OPTIONS: Options = Options { quiet: true, jobs: Some(1), memory: None, keep_going: false, min_free_memory: 0.0 };

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
        let (runner, diagnostics) = study::open(&self.0, Profile::Paper, OPTIONS).unwrap();
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
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
    let html = fs::read_to_string(study::page(&runner).unwrap()).unwrap();
    let made = |entry: &workflow::entry::Entry<records::subject::Study>| !(entry.subjects)(&runner.universe).is_empty();
    for (list, kind) in [(study::figures::ALL, "figure"), (study::tables::ALL, "table"), (study::stages::ALL, "stage")]
    {
        let missing = list.iter().filter(|e| made(e)).map(|e| format!("id=\"{kind}-{}\"", e.name));
        let missing: Vec<String> = missing.filter(|id| !html.contains(id)).collect();
        assert!(missing.is_empty(), "{missing:?}");
    }
    let claims = publish::claims::read(&runner.folders.claims()).unwrap();
    assert_eq!(html.matches("<td class=\"verdict").count(), claims.len());
}

#[test]
fn the_page_asks_no_network_and_is_the_same_twice() {
    let project = Project::new("network");
    let runner = project.open();
    let first = fs::read_to_string(study::page(&runner).unwrap()).unwrap();
    assert_eq!(first, fs::read_to_string(study::page(&runner).unwrap()).unwrap());
    assert!(!first.contains("http:") && !first.contains("https:") && !first.contains("@import"));
    assert!(first.contains("default-src 'none'"));
}
