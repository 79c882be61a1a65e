//! Cost of `study plan` on made-up stores in which every record is up to date: one as large as that of the paper, and one of a thousand
//! specimens. The records hold made-up bytes, but everything that a plan reads: manifests, hashes of recordings, sizes and dates.
#![allow(clippy::print_stdout, clippy::unwrap_used)] // a bench prints, and a panic ends it

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use lab::card::{Card, Experiment, Fixture, FixtureOf, Medium, Role, Split, Trial};
use study::Runner;
use workflow::needs::RecordId;
use workflow::runner::{Goal, Job, MadeFrom, Manifest, Options, Usage};
use workflow::settings::Profile;

/// Plans timed of each store, after one that is not.
const PLANS: usize = 11;

/// Specimens and flapping trials of each: the paper's three have 132 trials in all, a population's five each.
const STORES: [(&str, usize, usize); 2] = [("paper", 3, 41), ("thousand", 1000, 2)];

fn main() {
    for (name, specimens, flaps) in STORES {
        let root = std::env::temp_dir().join(format!("study-plan-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&root);
        let records = make_up(&root, specimens, flaps);
        let mut seconds: Vec<f64> = (0..=PLANS).map(|_| plan(&root, records)).skip(1).collect();
        seconds.sort_by(f64::total_cmp);
        println!(
            "plan_{name}: {records} records of {specimens} specimens, median {:.1} ms, least {:.1} ms",
            1e3 * seconds[PLANS / 2],
            1e3 * seconds[0]
        );
        fs::remove_dir_all(&root).unwrap();
    }
}

/// How long the program takes to plan, s.
fn plan(root: &Path, records: usize) -> f64 {
    let begun = Instant::now();
    let output = Command::new(env!("CARGO_BIN_EXE_study")).args(["plan", "--root"]).arg(root).output().unwrap();
    let took = begun.elapsed().as_secs_f64();
    let stdout = String::from_utf8(output.stdout).unwrap();
    assert_eq!(stdout.lines().last().unwrap(), format!("0 of {records} records would be made"));
    took
}

/// A project in which every record is up to date; returns their number.
fn make_up(root: &Path, specimens: usize, flaps: usize) -> usize {
    fs::create_dir_all(root.join("pipeline")).unwrap();
    let project_file = |file: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
    fs::copy(project_file("study.toml"), root.join("study.toml")).unwrap();
    for number in 0..specimens {
        write(&root.join(format!("data/raw/tail_{number:03}/specimen.toml")), card(number, flaps).as_bytes());
    }
    let options = Options { quiet: true, jobs: None, memory: None, keep_going: false, min_free_memory: 0.0 };
    let (runner, unreadable) = study::open(root, Profile::Paper, options).unwrap();
    assert!(unreadable.is_empty(), "{:?}", unreadable.first());
    let jobs = runner.jobs_of(&Goal::default()).unwrap();
    let mut store = MadeUp { runner: &runner, contents: BTreeMap::new(), hashes: BTreeMap::new() };
    jobs.iter().for_each(|job| store.write(job));
    write(&runner.folders.hashes(), &serde_json::to_vec(&store.hashes).unwrap());
    jobs.len()
}

/// The card of a specimen with three staircases and some flapping trials.
fn card(number: usize, flaps: usize) -> String {
    let mut card: Card = toml::from_str(include_str!("../../study/tests/card.toml")).unwrap();
    card.name = format!("tail_{number:03}");
    card.water = Some(lab::card::Water { surface: 0.05, index: 1.333 });
    card.tank = Some(lab::card::Tank { length: 0.45, depth: 0.15 });
    let template = card.trial[0].clone();
    let trial_like_template = |id: String, experiment: Experiment| Trial {
        video: Some(format!("trials/{id}/video.mp4")),
        pressure: format!("trials/{id}/pressure.csv"),
        experiment,
        id,
        ..template.clone()
    };
    for side in ["right", "both"] {
        card.trial.push(trial_like_template(format!("static_{side}"), template.experiment.clone()));
    }
    for repeat in 0..flaps {
        let channels = vec!["left".to_owned(), "right".to_owned()];
        let experiment = Experiment::Flapping { channels, amplitude: 2e4, frequency: 2.0, cycles: 3 };
        let (role, split) = if repeat % 5 == 0 { (Role::Validate, Split::Test) } else { (Role::Thrust, Split::Train) };
        let (medium, force) = (Medium::Water, Some(format!("trials/flap_{repeat:02}/force.csv")));
        let flap = trial_like_template(format!("flap_{repeat:02}"), experiment);
        card.trial.push(Trial { role, split: Some(split), medium, force, ..flap });
    }
    let (force, hammer) = ("trials/taps/force.csv".into(), "trials/taps/hammer.csv".into());
    let taps = FixtureOf::Taps { hammer, count: Some(6) };
    card.fixture.push(Fixture { id: "taps".into(), medium: Medium::Air, force, of: taps });
    let force = "trials/still_water/force.csv".into();
    card.fixture.push(Fixture { id: "still_water".into(), medium: Medium::Water, force, of: FixtureOf::StillWater });
    lab::card::write(&card)
}

/// The records that were made up so far.
struct MadeUp<'a> {
    runner: &'a Runner,
    contents: BTreeMap<RecordId, String>,
    /// Of every file, as a run writes them for later plans.
    hashes: BTreeMap<PathBuf, serde_json::Value>,
}

impl MadeUp<'_> {
    fn write(&mut self, job: &Job<records::subject::Study>) {
        let inputs = job.inputs.as_ref().unwrap();
        let folders = &self.runner.folders;
        let raw = inputs.raw.iter().map(|file| {
            let path = folders.raw_file(&file.path);
            if !path.exists() {
                write(&path, file.path.as_bytes());
            }
            (file.path.clone(), hashed(&mut self.hashes, &path))
        });
        let raw = raw.collect();
        let content = |id: &RecordId| (id.to_string(), self.contents[id].clone());
        let records = inputs.records.iter().map(content).collect();
        let (card, settings) = (inputs.card.clone(), inputs.settings.clone());
        let made_from = MadeFrom { version: job.entry.version, raw, card, settings, records };
        let (key, name) = (made_from.key(), job.id.to_string());
        let files = ["arrays.bin", "numbers.json", "table.parquet"].map(|file| {
            let path = folders.record(&job.id).join(file);
            write(&path, name.as_bytes());
            (file.to_owned(), hashed(&mut self.hashes, &path))
        });
        let (usage, content) = (Usage::default(), blake3::hash(name.as_bytes()).to_hex().to_string());
        self.contents.insert(job.id.clone(), content.clone());
        let (files, metrics, summary, seal) = (files.into(), Vec::new(), "made up".into(), String::new());
        let manifest = Manifest { key, content, made_from, files, metrics, summary, seconds: 1.0, usage, seal };
        let open = serde_json::to_string_pretty(&manifest).unwrap();
        let (before, after) = open.rsplit_once("\"seal\": \"\"").unwrap();
        let sealed = format!("{before}\"seal\": \"{}\"{after}", blake3::hash(open.as_bytes()).to_hex());
        write(&folders.record(&job.id).join("record.json"), sealed.as_bytes());
    }
}

/// The hash of a file, which is entered among the hashes with its length and date.
fn hashed(hashes: &mut BTreeMap<PathBuf, serde_json::Value>, path: &Path) -> String {
    let hash = blake3::hash(&fs::read(path).unwrap()).to_hex().to_string();
    let metadata = fs::metadata(path).unwrap();
    let date = metadata.modified().unwrap().duration_since(std::time::UNIX_EPOCH).unwrap().as_nanos() as u64;
    hashes.insert(path.to_owned(), serde_json::json!({ "length": metadata.len(), "date": date, "hash": hash }));
    hash
}

fn write(path: &Path, bytes: &[u8]) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}
