//! A project for tests: groups without items, and one entry that makes nothing.

use crate::entry::{Entry, Kind, Product, Reads};
use crate::record::RecordFiles;
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
