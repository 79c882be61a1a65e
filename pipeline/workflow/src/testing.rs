//! A project for tests: groups without items, and one entry that makes nothing.

use std::path::Path;

use serde_json::{Value, json};

use crate::entry::{Entry, Inputs, Kind, Planned, Product, Reads};
use crate::needs::RecordId;
use crate::record::RecordFiles;
use crate::runner::{Folders, Job, Options, Runner};
use crate::settings::{Profile, Schema, Settings};
use crate::stage::RawFile;
use crate::subject::{Subject, Universe};

/// The whole.
#[derive(Debug, Clone)]
pub struct Whole;

impl Subject for Whole {
    type Universe = Whole;

    fn all(_: &Whole) -> Vec<Self> {
        vec![Whole]
    }

    fn name(&self) -> String {
        "all".into()
    }
}

impl Universe for Whole {
    const GROUP: &'static str = "group";
    const ITEM: &'static str = "item";

    fn groups(&self) -> Vec<String> {
        vec!["a".into(), "b".into()]
    }
}

/// One entry.
pub const ALL: &[Entry<Whole>] = &[Entry {
    name: "nothing",
    section: None,
    description: "makes nothing",
    kind: Kind::Stage,
    version: 1,
    subjects: |_| Vec::new(),
    planned: |_, _| Vec::new(),
    reads: |_| Reads::default(),
    make: |_, _, _, _, _| Ok(Product { files: RecordFiles::default(), metrics: Vec::new(), summary: String::new() }),
}];

/// A runner of [`ALL`] in the folder `root`.
pub fn runner(root: &Path) -> Runner<Whole> {
    Runner {
        lists: &[ALL],
        universe: Whole,
        settings: Settings::read("", Profile::Paper, Schema { sections: &[], renamed: &[] }).unwrap(),
        profile: Profile::Paper,
        folders: Folders::new(root, Profile::Paper),
        options: Options { quiet: true, jobs: Some(1), memory: None, keep_going: true, min_free_memory: 0.0 },
    }
}

/// A record of `ALL`'s entry that reads a card, settings and `records`, and the raw files `raw`, of which some are optional.
pub fn job(subject: &str, raw: &[(&str, bool)], records: &[&str]) -> Job<Whole> {
    let id = |subject: &str| RecordId { stage: ALL[0].name, subject: subject.into() };
    let file =
        |(path, optional): &(&str, bool)| RawFile { name: (*path).into(), path: (*path).into(), optional: *optional };
    let inputs = Inputs {
        raw: raw.iter().map(file).collect(),
        card: json!({ "length": 1 }),
        settings: if raw.is_empty() { Value::Null } else { json!({ "step": 1 }) },
        records: records.iter().map(|subject| id(subject)).collect(),
    };
    Job { entry: &ALL[0], id: id(subject), inputs: Ok(inputs) }
}

/// A stage of which each record holds its subject's name.
const fn named(name: &'static str, planned: fn(&Whole, &Settings) -> Vec<Planned>) -> Entry<Whole> {
    Entry {
        name,
        planned,
        make: |_, subject, _, _, _| {
            let files = RecordFiles::default().file("name.txt", subject.as_bytes().to_vec());
            Ok(Product { files, metrics: Vec::new(), summary: String::new() })
        },
        ..ALL[0]
    }
}

/// A stage of group `a` that reads its recording, and one of the whole project that reads the former.
pub const CHAIN: &[Entry<Whole>] = &[
    named("first", |_, _| {
        let raw = vec![RawFile::new("lit", "a", "lit.csv")];
        let inputs = Inputs { raw, card: json!({ "length": 1 }), settings: json!({ "step": 1 }), records: Vec::new() };
        vec![("a".into(), Ok(inputs))]
    }),
    named("second", |_, _| {
        let records = vec![RecordId { stage: "first", subject: "a".into() }];
        let inputs = Inputs { raw: Vec::new(), card: Value::Null, settings: json!({ "step": 2 }), records };
        vec![("all".into(), Ok(inputs))]
    }),
];
