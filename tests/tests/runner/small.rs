//! A study of three small stages in a project of its own: text becomes its length, a length its half, nothing a number.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;

use diagnostics::{Diagnostic, Result};
use records::subject::{Specimen, Study};
use serde::{Deserialize, Serialize};
use workflow::entry::{Entry, stage};
use workflow::record::{Record, RecordError, RecordFiles};
use workflow::runner::{Folders, Goal, Options, RunSummary, Runner};
use workflow::settings::{Profile, Schema, Settings};
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

#[derive(Serialize, Deserialize)]
struct Count(usize);

/// A count that is written and cannot be read.
const UNREADABLE: usize = 15;

macro_rules! count_record {
    ($record:ident, $stage:literal) => {
        struct $record(usize);
        impl Record for $record {
            type Of = Specimen;
            const STAGE: &'static str = $stage;
            fn to_files(&self) -> Result<RecordFiles, RecordError> {
                RecordFiles::default().scalars("count.json", &Count(self.0))
            }
            fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
                match files.read_scalars("count.json")? {
                    Count(UNREADABLE) => Err(RecordError::Absent("count".into())),
                    Count(count) => Ok(Self(count)),
                }
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

#[derive(Serialize)]
struct Length {
    length: f64,
}

impl Part<Specimen> for Length {
    fn part_of(of: &Specimen) -> Self {
        Self { length: of.card.length }
    }
}

/// Names a file in which each stage that begins writes its name.
pub const BEGUN: &str = "STAGES_THAT_HAVE_BEGUN";

/// Writes down that a stage begins, and takes some time, so that other processes meet it.
fn begin(stage: &str) {
    let Some(file) = std::env::var_os(BEGUN) else { return };
    let mut file = fs::File::options().create(true).append(true).open(file).unwrap();
    file.write_all(format!("{stage}\n").as_bytes()).unwrap();
    std::thread::sleep(Duration::from_millis(30));
}

struct CountLetters;
impl Stage for CountLetters {
    type Settings = Step;
    type Card = Length;
    type Needs = ();
    type Makes = Letters;
    const DESCRIPTION: &'static str = "text becomes its length";
    const VERSION: u32 = 1;
    fn raw(of: &Specimen) -> Vec<RawFile> {
        vec![RawFile::new("text", &of.card.name, "cad/body.stl")]
    }
    fn run(_: &Length, set: &Step, (): (), context: &dyn StageContext) -> Result<Letters> {
        begin("letters");
        Ok(Letters(context.bytes("text")?.len() / set.step))
    }
}

struct Halve;
impl Stage for Halve {
    type Settings = Step;
    type Card = ();
    type Needs = Letters;
    type Makes = Halved;
    const DESCRIPTION: &'static str = "a length becomes its half";
    const VERSION: u32 = 1;
    fn run((): &(), set: &Step, letters: Letters, _: &dyn StageContext) -> Result<Halved> {
        begin("halved");
        match set.step {
            13 => Err(Diagnostic::new("thirteen is not a step", "it brings bad luck", "choose another")),
            14 => panic!("fourteen breaks an assertion"),
            15 => Ok(Halved(UNREADABLE)),
            step => Ok(Halved(letters.0 / (2 * step))),
        }
    }
}

struct StandAlone;
impl Stage for StandAlone {
    type Settings = Step;
    type Card = ();
    type Needs = ();
    type Makes = Alone;
    const DESCRIPTION: &'static str = "nothing becomes a number";
    const VERSION: u32 = 1;
    fn run((): &(), set: &Step, (): (), _: &dyn StageContext) -> Result<Alone> {
        begin("alone");
        Ok(Alone(set.step))
    }
}

const STAGES: &[Entry<Study>] = &[stage::<CountLetters>(), stage::<Halve>(), stage::<StandAlone>()];
const LISTS: &[&[Entry<Study>]] = &[STAGES];
pub const SETTINGS: &str = "[letters]\nstep = 1\n[halved]\nstep = 1\n[alone]\nstep = 1\n";

const SCHEMA: Schema = Schema { sections: &["letters", "halved", "alone"], renamed: &[] };

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

    pub fn runner(&self, settings: &str) -> Runner<Study> {
        let card = lab::card::read(&self.0.join("data/raw/fish/specimen.toml")).unwrap();
        Runner {
            lists: LISTS,
            universe: Study { specimens: vec![Specimen { card: card.into() }] },
            settings: Settings::read(settings, Profile::Paper, SCHEMA).unwrap(),
            profile: Profile::Paper,
            folders: Folders::new(&self.0, Profile::Paper),
            options: Options { quiet: true, jobs: Some(2), memory: None, keep_going: true, min_free_memory: 0.0 },
        }
    }

    pub fn run(&self, settings: &str) -> RunSummary {
        study::run(&self.runner(settings), &Goal::default(), false).unwrap()
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

pub fn summary(made: usize, kept: usize, failed: usize, skipped: usize) -> RunSummary {
    RunSummary { made, kept, failed, skipped }
}
