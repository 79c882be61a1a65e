//! A study of three small stages in a project of its own: text becomes its length, a length its half, nothing a number.
//!
//! Stands on: `study`. Never knows: what is tried with it.

use std::fs;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use study::entry::{Entry, stage};
use study::fault::{Fault, Outcome};
use study::record::{Parcel, Record, RecordError};
use study::runner::{Folders, Goal, Runner, Tally};
use study::settings::{Profile, Settings};
use study::stage::{Desk, RawFile, Stage};
use study::subject::{Specimen, Study};

#[derive(Serialize, Deserialize)]
struct Count(usize);

macro_rules! count_record {
    ($record:ident, $stage:literal) => {
        struct $record(usize);
        impl Record for $record {
            type Of = Specimen;
            const STAGE: &'static str = $stage;
            fn pack(&self) -> Result<Parcel, RecordError> {
                Parcel::default().scalars("count.json", &Count(self.0))
            }
            fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
                Ok(Self(parcel.read_scalars::<Count>("count.json")?.0))
            }
        }
    };
}

count_record!(Letters, "letters");
count_record!(Halved, "halved");
count_record!(Alone, "alone");

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Step {
    step: usize,
}

struct CountLetters;
impl Stage for CountLetters {
    type Settings = Step;
    type Needs = ();
    type Makes = Letters;
    const STORY: &'static str = "text becomes its length";
    const EDITION: u32 = 1;
    fn raw(of: &Specimen) -> Vec<RawFile> {
        vec![RawFile::new("text", &of.card.name, "cad/body.stl")]
    }
    fn card(of: &Specimen) -> Value {
        json!({ "length": of.card.length })
    }
    fn run(_: &Specimen, set: &Step, (): (), desk: &dyn Desk) -> Outcome<Letters> {
        Ok(Letters(desk.bytes("text")?.len() / set.step))
    }
}

struct Halve;
impl Stage for Halve {
    type Settings = Step;
    type Needs = Letters;
    type Makes = Halved;
    const STORY: &'static str = "a length becomes its half";
    const EDITION: u32 = 1;
    fn run(_: &Specimen, set: &Step, letters: Letters, _: &dyn Desk) -> Outcome<Halved> {
        match set.step {
            13 => Err(Fault::new("thirteen is not a step", "it brings bad luck", "choose another")),
            14 => panic!("fourteen breaks an assertion"),
            step => Ok(Halved(letters.0 / (2 * step))),
        }
    }
}

struct StandAlone;
impl Stage for StandAlone {
    type Settings = Step;
    type Needs = ();
    type Makes = Alone;
    const STORY: &'static str = "nothing becomes a number";
    const EDITION: u32 = 1;
    fn run(_: &Specimen, set: &Step, (): (), _: &dyn Desk) -> Outcome<Alone> {
        Ok(Alone(set.step))
    }
}

const STAGES: &[Entry] = &[stage::<CountLetters>(), stage::<Halve>(), stage::<StandAlone>()];
const LISTS: &[&[Entry]] = &[STAGES];
pub const SETTINGS: &str = "[letters]\nstep = 1\n[halved]\nstep = 1\n[alone]\nstep = 1\n";

/// A project of its own for each test, removed at the end.
pub struct Project(pub PathBuf);

impl Project {
    pub fn new(name: &str) -> Self {
        let root = std::env::temp_dir().join(format!("runner-{name}-{}", std::process::id()));
        let folder = root.join("data/raw/fish");
        fs::create_dir_all(folder.join("cad")).unwrap();
        fs::write(folder.join("cad/body.stl"), "twelve bytes").unwrap();
        fs::write(folder.join("specimen.toml"), tests::CARD).unwrap();
        Self(root)
    }

    pub fn runner(&self, settings: &str) -> Runner {
        let card = lab::card::read(&self.0.join("data/raw/fish/specimen.toml")).unwrap();
        Runner {
            lists: LISTS,
            study: Study { specimens: vec![Specimen { card: card.into() }] },
            settings: Settings::read(settings, Profile::Paper, &["letters", "halved", "alone"]).unwrap(),
            profile: Profile::Paper,
            folders: Folders::new(&self.0, Profile::Paper),
            quiet: true,
            jobs: 2,
            keep_going: true,
            spare: 0.0,
        }
    }

    pub fn run(&self, settings: &str) -> Tally {
        self.runner(settings).run(&Goal::default(), false).unwrap()
    }

    pub fn plan(&self, settings: &str) -> String {
        self.runner(settings).plan(&Goal::default()).unwrap()
    }

    pub fn record(&self, stage: &str) -> PathBuf {
        self.0.join("data/processed").join(stage).join("fish/record")
    }
}

impl Drop for Project {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

pub fn tally(made: usize, kept: usize, failed: usize, skipped: usize) -> Tally {
    Tally { made, kept, failed, skipped }
}
