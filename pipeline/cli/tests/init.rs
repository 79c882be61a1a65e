//! The card that `study init` writes, compared with the keys of `lab` and with the guide: no key is missing, no
//! range differs, and only the marked values must be filled in.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use cli::init::CARD;
use lab::card::{self, Card};
use serde::de::DeserializeOwned;

/// The values of the marked lines, in their order.
const FILLED: [&str; 22] = [
    "0.1",
    "2.0e5",
    "[5.0e4, 1.0e6]",
    "3.0e9",
    "[1.0e9, 1.0e10]",
    "0.004",
    "[0.02, 0.006, 0.0]",
    "[0.02, -0.006, 0.0]",
    "[0.05, 0.0, 0.0174]",
    "[200.0, 120.0]",
    "0.004",
    "9",
    "6",
    "0.012",
    "[5.0, 6.0]",
    "[0.0, 0.0]",
    "-0.04",
    "[600.0, 40.0]",
    "12.0",
    "[5000.0, 10000.0]",
    "1.0",
    "0.5",
];

/// A line of the card with a key and a remark.
struct Entry {
    table: String,
    key: String,
    /// Unit and range, or what else bounds it; empty where the remark is a sentence alone.
    bound: String,
    meaning: String,
}

fn named(text: &str) -> String {
    text.replace("\"NAME\"", "\"finger\"")
}

/// The card with nothing changed but the marked lines.
fn filled() -> String {
    let mut values = FILLED.iter();
    let line = |line: &str| match line.split_once(" = ") {
        Some((key, rest)) if rest.contains("# FILL IN;") => format!("{key} = {}\n", values.next().unwrap()),
        _ => format!("{line}\n"),
    };
    let text: String = named(CARD).lines().map(line).collect();
    assert_eq!(values.next(), None, "more values than marked lines");
    text
}

/// The filled card with all optional parts; markers are detected, not clicked.
fn whole() -> String {
    let clicked = |line: &&str| !line.starts_with("clicked");
    filled().replace("#: ", "").lines().filter(clicked).map(|line| format!("{line}\n")).collect()
}

fn parsed(text: &str) -> Result<Card, diagnostics::Diagnostic> {
    card::parse(text, Path::new("finger/specimen.toml"))
}

fn entries() -> Vec<Entry> {
    let mut table = String::new();
    let mut entries = Vec::new();
    for line in CARD.replace("#: ", "").replace("#| ", "").lines() {
        if line.starts_with('[') {
            table = line.trim_matches(['[', ']']).to_owned();
        }
        let Some((key, rest)) = line.split_once(" = ").filter(|_| !line.starts_with('#')) else { continue };
        let Some((_, remark)) = rest.split_once("  # ") else { continue };
        let remark = remark.trim_start_matches("FILL IN; ");
        let (bound, meaning) = remark.split_once("; ").unwrap_or(("", remark));
        entries.push(Entry { table: table.clone(), key: key.into(), bound: bound.into(), meaning: meaning.into() });
    }
    entries
}

impl Entry {
    /// Lowest and highest number, where there are such.
    fn range(&self) -> Option<(f64, f64)> {
        let (_, range) = self.bound.split_once(", ")?;
        let (low, high) = range.split_once(" to ")?;
        Some((low.parse().ok()?, high.parse().ok()?))
    }
}

/// The keys of a part of the card, as its reader lists them for an unknown key.
fn keys<T: DeserializeOwned>() -> Vec<String> {
    let error = toml::from_str::<T>("another_key = 1\n").err().unwrap();
    let expected = error.message().split_once("expected ").unwrap().1.to_owned();
    expected.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn a_new_card_is_read_when_only_its_marked_lines_are_filled_in() {
    let card = parsed(&filled()).unwrap();
    assert_eq!((card.name.as_str(), card.length, card.trial.len()), ("finger", 0.1, 1));
    assert_eq!(card.camera.unwrap().board.columns, 9);
}

#[test]
fn the_card_of_a_beginning_is_refused_as_it_stands() {
    assert!(parsed(&named(CARD)).is_err());
}

#[test]
fn all_that_is_optional_can_be_taken_in_at_once() {
    let card = parsed(&whole()).unwrap();
    assert!(
        card.search.is_some()
            && card.water.is_some()
            && card.camera.is_some_and(|camera| camera.coefficients.is_some())
    );
    assert_eq!((card.trial.len(), card.tracks.len(), card.fixture.len()), (2, 1, 1));
    assert!(card.tank.is_some() && card.log.force_lag == Some(0.2) && card.log.columns.len() == 1);
}

/// Keys that earlier cards have in the place of others.
const EARLIER: [(&str, &str); 2] = [("chamber", "log"), ("trial", "side")];

#[test]
fn every_key_of_a_card_is_explained_in_its_part() {
    let known: Vec<(&str, Vec<String>)> = vec![
        ("", keys::<Card>()),
        ("solid", ["unit", "mesh"].map(str::to_owned).to_vec()),
        ("solid.body", keys::<card::Solid>()),
        ("solid.spine", keys::<card::Solid>()),
        ("clamp", keys::<card::Clamp>()),
        ("chamber", keys::<card::Chamber>()),
        ("marker", keys::<card::Marker>()),
        ("search", keys::<card::Search>()),
        ("camera", keys::<card::Camera>()),
        ("camera.board", keys::<card::Board>()),
        ("camera.plane", keys::<card::Plane>()),
        ("water", keys::<card::Water>()),
        ("led", keys::<card::Led>()),
        ("trial", keys::<card::Trial>()),
        ("tracks", keys::<card::Tracks>()),
        ("tracks.space", keys::<card::Axes>()),
        ("fixture", keys::<card::Fixture>()),
        ("log", keys::<card::Log>()),
        ("log.columns", keys::<card::LogColumn>()),
        ("tank", keys::<card::Tank>()),
    ];
    let evaluated: BTreeSet<String> = entries().iter().map(|e| format!("{}/{}", e.table, e.key)).collect();
    let tables: BTreeSet<&str> = known.iter().map(|(table, _)| *table).collect();
    for (table, keys) in &known {
        assert!(!keys.is_empty(), "[{table}] lists no keys");
        for key in keys.iter().filter(|key| !EARLIER.contains(&(*table, key.as_str()))) {
            let below = if table.is_empty() { key.clone() } else { format!("{table}.{key}") };
            let there = tables.contains(below.as_str()) || evaluated.contains(&format!("{table}/{key}"));
            assert!(there, "`{key}` of [{table}] is not explained");
        }
    }
}

#[test]
fn every_range_on_the_card_is_the_one_that_is_enforced() {
    let entries = entries();
    let ranged: Vec<&Entry> = entries.iter().filter(|e| e.range().is_some()).collect();
    assert!(ranged.len() > 30, "only {} ranges are stated", ranged.len());
    for entry in ranged {
        let (low, high) = entry.range().unwrap();
        let text = if entry.key == "clicked" { filled() } else { whole() };
        let diagnostic = parsed(&beyond(&text, entry, high)).err();
        let why = diagnostic.unwrap_or_else(|| panic!("{} of [{}] may be over {high}", entry.key, entry.table)).why;
        assert!(why.starts_with(&format!("the range is {low} to {high}")), "{} of [{}]: {why}", entry.key, entry.table);
    }
}

/// The card with an entry's numbers beyond the highest, as whole numbers where they were.
fn beyond(text: &str, entry: &Entry, high: f64) -> String {
    let mut table = String::new();
    let mut change = |line: &str| {
        if line.starts_with('[') {
            table = line.trim_matches(['[', ']']).to_owned();
        }
        let Some((key, rest)) = line.split_once(" = ") else { return format!("{line}\n") };
        if table != entry.table || key != entry.key {
            return format!("{line}\n");
        }
        let value = rest.split("  # ").next().unwrap();
        let whole = !value.contains(['.', 'e']);
        let number = if whole { format!("{}", high as i64 + 1) } else { format!("{:e}", high * 1.5 + 1e-9) };
        let count = value.split(',').count();
        let list = vec![number.clone(); count].join(", ");
        format!("{key} = {}\n", if value.starts_with('[') { format!("[{list}]") } else { number })
    };
    text.lines().map(&mut change).collect()
}

#[test]
fn the_guide_explains_every_key_in_the_words_of_the_card() {
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/raw/README.md");
    let guide = fs::read_to_string(guide).unwrap();
    for e in entries() {
        let row = format!("| `{}` | {} | {} |", e.key, e.bound, e.meaning);
        assert!(guide.contains(&row), "the guide lacks the row of [{}]:\n{row}", e.table);
    }
}

/// A project without specimens.
struct Project(PathBuf);

impl Project {
    fn new(name: &str) -> Self {
        let root = std::env::temp_dir().join(format!("init-{name}-{}", std::process::id()));
        fs::create_dir_all(&root).unwrap();
        fs::write(root.join("study.toml"), include_str!("../../../study.toml")).unwrap();
        Self(root)
    }

    fn study(&self, words: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_study")).args(words).arg("--root").arg(&self.0).output().unwrap()
    }
}

impl Drop for Project {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_beginning_makes_card_and_folders_and_never_writes_over_a_card() {
    let project = Project::new("twice");
    assert!(project.study(&["init", "finger"]).status.success());
    let folder = project.0.join("data/raw/finger");
    assert!(["cad", "camera", "trials/static_left"].iter().all(|place| folder.join(place).is_dir()));
    fs::write(folder.join("specimen.toml"), "mine").unwrap();
    let again = project.study(&["init", "finger"]);
    let said = String::from_utf8_lossy(&again.stderr).into_owned();
    assert_eq!(again.status.code(), Some(1), "{said}");
    assert!(said.contains("exists already") && said.contains("do:"), "{said}");
    assert_eq!(fs::read_to_string(folder.join("specimen.toml")).unwrap(), "mine");
}

#[test]
fn a_name_that_leaves_the_folder_is_refused() {
    let project = Project::new("name");
    let output = project.study(&["init", "../finger"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(!project.0.join("data").exists());
}

#[test]
fn the_doctor_names_every_line_of_a_new_card_that_is_open() {
    let project = Project::new("open");
    assert!(project.study(&["init", "finger"]).status.success());
    let output = project.study(&["doctor", "finger"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert_eq!(said.lines().filter(|line| line.contains("is not filled in")).count(), FILLED.len(), "{said}");
}
