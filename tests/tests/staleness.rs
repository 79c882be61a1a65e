//! What a stage reads and what its record is keyed by cannot differ: each field of a card is changed in turn, and every record that comes
//! out differently when all is made anew was called stale by the plan.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use mesh::stl;
use records::subject::{Specimen, Study};
use tail_cad::Tail;
use toml::{Table, Value};
use track::Gray;
use track::video::{Quality, Writer};
use workflow::entry::{Entry, stage};
use workflow::runner::{Folders, Found, Goal, Options, Runner, Store};
use workflow::settings::{Profile, Schema, Settings};

const CARD: &str = include_str!("../../pipeline/study/tests/card.toml");
const SETTINGS: &str = include_str!("../../study.toml");
const OPTIONS: Options = Options { quiet: true, jobs: Some(2), memory: None, keep_going: true, min_free_memory: 0.0 };

/// Real stages that a small recording feeds.
const STAGES: &[Entry<Study>] = &[stage::<study::stages::mesh::Mesh>(), stage::<study::stages::track::Track>()];
const LISTS: &[&[Entry<Study>]] = &[STAGES];

/// A project with one specimen of one trial, removed at the end.
struct Project(PathBuf);

impl Project {
    fn new(name: &str) -> Self {
        let project = Self(std::env::temp_dir().join(format!("staleness-{name}-{}", std::process::id())));
        let fish = project.0.join("data/raw/fish");
        for part in ["cad", "trials/static_left"] {
            fs::create_dir_all(fish.join(part)).unwrap();
        }
        let (body, spine) = Tail::nine_chambers().solids(4e-3).unwrap();
        fs::write(fish.join("cad/body.stl"), stl::write(&body, 1e-3, "body")).unwrap();
        fs::write(fish.join("cad/spine.stl"), stl::write(&spine, 1e-3, "spine")).unwrap();
        film(&fish.join("trials/static_left/video.mp4"));
        project
    }

    fn runner(&self, card: &str) -> Runner<Study> {
        let card = lab::card::parse(card, Path::new("card.toml")).unwrap();
        let sections: Vec<&str> = study::stages::ALL.iter().filter_map(|entry| entry.section).collect();
        let schema = Schema { sections: &sections, renamed: &[] };
        Runner {
            lists: LISTS,
            universe: Study { specimens: vec![Specimen { card: card.into() }] },
            settings: Settings::read(&SETTINGS.replace("edge = 0.004", "edge = 0.008"), Profile::Paper, schema)
                .unwrap(),
            profile: Profile::Paper,
            folders: Folders::new(&self.0, Profile::Paper),
            options: OPTIONS,
        }
    }

    /// Makes everything anew; the content of each record by name.
    fn made(&self, card: &str) -> BTreeMap<String, String> {
        let runner = self.runner(card);
        let _ = fs::remove_dir_all(runner.folders.processed());
        runner.run(&Goal::default(), false, &|_| Ok(())).unwrap();
        let store = Store::new(&runner.folders);
        let content = |id| match store.find(&id) {
            Found::Whole(manifest) => manifest.content,
            _ => "failed".to_owned(),
        };
        let jobs = runner.jobs_of(&Goal::default()).unwrap();
        jobs.into_iter().map(|job| (job.id.to_string(), content(job.id))).collect()
    }
}

impl Drop for Project {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A dark disc that moves a little on light ground, and a lamp that lights.
fn film(path: &Path) {
    let mut film = Writer::create(path, (320, 240), 60.0, Quality::Quantiser(20)).unwrap();
    for frame in 0..20 {
        let lamp = if frame > 9 { 240.0 } else { 90.0 };
        let picture = Gray::from_fn(320, 240, |u, v| {
            let from = |at: [f64; 2]| (u as f64 - at[0]).hypot(v as f64 - at[1]);
            match (from([40.0, 40.0]) < 16.0, from([200.0 + 0.25 * f64::from(frame), 120.0]) < 9.0) {
                (true, _) => lamp,
                (_, true) => 40.0,
                _ => 200.0,
            }
        });
        film.push(&picture).unwrap();
    }
    film.finish().unwrap();
}

/// The paths of all values of a card that are no tables or lists.
fn leaves(value: &Value, path: &str, found: &mut Vec<String>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        Value::Table(table) => table.iter().for_each(|(key, value)| leaves(value, &below(key), found)),
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, value)| leaves(value, &below(&i.to_string()), found))
        }
        _ => found.push(path.to_owned()),
    }
}

fn at<'a>(value: &'a mut Value, path: &str) -> &'a mut Value {
    path.split('.').fold(value, |value, key| match key.parse::<usize>() {
        Ok(i) => &mut value.as_array_mut().unwrap()[i],
        Err(_) => &mut value.as_table_mut().unwrap()[key],
    })
}

/// Other values that a field could have.
fn others(value: &Value) -> Vec<Value> {
    const WORDS: [&[&str]; 6] = [
        &["mm", "cm"],
        &["left", "right"],
        &["identify", "validate"],
        &["air", "water"],
        &["neo_hookean", "corotated"],
        &["laboratory", "virtual bench"],
    ];
    match value {
        Value::Float(v) => [1.02 * v, v + 0.01, 0.98 * v, v - 0.01].map(Value::Float).to_vec(),
        Value::Integer(v) => vec![Value::Integer(v + 1), Value::Integer(v - 1)],
        Value::String(word) => {
            let exchanged = WORDS.iter().filter(|all| all.contains(&word.as_str())).flat_map(|all| all.iter());
            let exchanged = exchanged.filter(|other| *other != word).map(|other| Value::String((*other).to_owned()));
            exchanged.chain([Value::String(format!("{word}x"))]).collect()
        }
        _ => Vec::new(),
    }
}

/// The card with one field changed, where it has another value that a card may hold.
fn changed(card: &str, path: &str) -> Option<String> {
    let table: Table = card.parse().unwrap();
    let now = at(&mut Value::Table(table.clone()), path).clone();
    others(&now).into_iter().find_map(|other| {
        let mut value = Value::Table(table.clone());
        *at(&mut value, path) = other;
        let text = toml::to_string(&value).unwrap();
        lab::card::parse(&text, Path::new("card.toml")).is_ok().then_some(text)
    })
}

#[test]
fn every_record_that_a_changed_field_changes_is_called_stale() {
    let card = CARD.replace("centre = [600.0, 40.0]", "centre = [40.0, 40.0]");
    let (project, anew) = (Project::new("kept"), Project::new("anew"));
    let before = project.made(&card);
    assert!(before.len() == 2 && before.values().all(|content| content != "failed"), "{before:?}");
    let mut fields = Vec::new();
    leaves(&Value::Table(card.parse().unwrap()), "", &mut fields);
    let (mut changes, mut missed, mut effective) = (0, Vec::new(), 0);
    for field in fields {
        let Some(other) = changed(&card, &field) else { continue };
        changes += 1;
        let stale = project.runner(&other).stale(&Goal::default()).unwrap();
        let differs = |(id, content): (&String, &String)| before.get(id) != Some(content);
        let after = anew.made(&other);
        let really: Vec<&String> = after.iter().filter(|record| differs(*record)).map(|(id, _)| id).collect();
        effective += usize::from(!really.is_empty());
        missed.extend(really.into_iter().filter(|id| !stale.contains(id)).map(|id| format!("{field}: {id}")));
    }
    assert!(missed.is_empty(), "not called stale:\n  {}", missed.join("\n  "));
    // so many fields could be changed, and so many of them changed a record: the test is not empty
    assert!(changes > 30 && effective > 8, "{changes} changes, {effective} with an effect");
}

#[test]
fn a_field_that_no_stage_reads_makes_nothing_stale() {
    let project = Project::new("unread");
    let card = CARD.replace("centre = [600.0, 40.0]", "centre = [40.0, 40.0]");
    project.made(&card);
    let other = changed(&card, "solid.body.density").unwrap();
    assert!(project.runner(&other).stale(&Goal::default()).unwrap().is_empty());
}
