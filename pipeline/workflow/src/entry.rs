//! Entries: a stage, figure or table with its types erased, so that the runner can hold all of them in one list.

use std::collections::BTreeSet;

use diagnostics::{Diagnostic, Result};
use serde::Serialize;
use serde_json::{Value, json};

use crate::figure::Figure;
use crate::metric::Metric;
use crate::needs::{Needs, RecordId, RecordReader};
use crate::record::{Record, RecordError, RecordFiles};
use crate::settings::Settings;
use crate::stage::{RawFile, Stage, StageContext};
use crate::subject::{Part, Subject, Universe};
use crate::table::Table;

/// What an entry makes; it decides where its product is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A stage: its record stays among the records.
    Stage,
    /// A figure: its SVG is also written to `figures/`.
    Figure,
    /// A table: its CSV, LaTeX and SVG are also written to `paper/tables/`.
    Table,
}

/// Everything that decides what a record is.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Raw files read.
    pub raw: Vec<RawFile>,
    /// The part of the card read.
    pub card: Value,
    /// The section of the settings, as parsed by the stage.
    pub settings: Value,
    /// Records read.
    pub records: Vec<RecordId>,
}

/// What a stage reads over all its subjects: names of raw files, and stages.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reads {
    /// The stage's own names for raw files.
    pub raw: BTreeSet<String>,
    /// The stages whose records it reads.
    pub stages: BTreeSet<&'static str>,
}

/// One record to be made: the name of its subject, and its inputs or why they cannot be determined.
pub type Planned = (String, Result<Inputs>);

/// A record just made.
pub struct Product {
    /// Its files.
    pub files: RecordFiles,
    /// Its numbers.
    pub metrics: Vec<Metric>,
    /// A summary with its main number.
    pub summary: String,
}

/// One line of a list of stages, figures or tables.
pub struct Entry<U> {
    /// Its name.
    pub name: &'static str,
    /// Its section in the settings; a figure or table has none.
    pub section: Option<&'static str>,
    /// Its description or caption.
    pub description: &'static str,
    /// What it makes.
    pub kind: Kind,
    /// Its version.
    pub version: u32,
    /// The names of its subjects.
    pub subjects: fn(&U) -> Vec<String>,
    /// Its records, one a subject: all at once, since subjects are looked up in the list of their kind.
    pub planned: fn(&U, &Settings) -> Vec<Planned>,
    /// What it reads, over all its subjects.
    pub reads: fn(&U) -> Reads,
    /// Makes the record.
    pub make: fn(&U, &str, &Settings, &dyn RecordReader, &dyn StageContext) -> Result<Product>,
}

type UniverseOf<S> = <<<S as Stage>::Makes as Record>::Of as Subject>::Universe;

/// A stage as an entry.
pub const fn stage<S: Stage>() -> Entry<UniverseOf<S>> {
    Entry {
        name: S::Makes::STAGE,
        section: Some(S::SECTION),
        description: S::DESCRIPTION,
        kind: Kind::Stage,
        version: S::VERSION,
        subjects: |universe| subjects_of::<S>(universe).iter().map(Subject::name).collect(),
        planned: |universe, settings| {
            let section = settings.section::<S::Settings>(S::SECTION).and_then(|section| as_json(&section));
            let of_one = |subject: &<S::Makes as Record>::Of| {
                let card = card_part(as_json(&S::Card::part_of(subject))?, S::Needs::parts(subject));
                Ok(Inputs { raw: S::raw(subject), card, settings: section.clone()?, records: S::Needs::ids(subject) })
            };
            subjects_of::<S>(universe).iter().map(|subject| (subject.name(), of_one(subject))).collect()
        },
        reads: |universe| {
            let subjects = subjects_of::<S>(universe);
            Reads {
                raw: subjects.iter().flat_map(S::raw).map(|file| file.name).collect(),
                stages: subjects.iter().flat_map(S::Needs::ids).map(|id| id.stage).collect(),
            }
        },
        make: |universe, name, settings, reader, context| {
            let subject = find_subject(subjects_of::<S>(universe), name)?;
            let needs = S::Needs::read(&subject, reader)?;
            let record = S::run(&S::Card::part_of(&subject), &settings.section(S::SECTION)?, needs, context)?;
            let files = record.to_files().map_err(pack_error)?;
            // What its own reader refuses, as a number that is none, would else be found by a later stage, after hours.
            S::Makes::from_files(&files).map_err(unreadable_error)?;
            Ok(Product { files, metrics: record.metrics(name), summary: record.summary() })
        },
    }
}

/// A figure as an entry.
pub const fn figure<F: Figure>() -> Entry<F::Of> {
    Entry {
        name: F::NAME,
        section: None,
        description: F::CAPTION,
        kind: Kind::Figure,
        version: F::VERSION,
        subjects: |universe| figure_subject::<F>(universe).into_iter().collect(),
        planned: |universe, _| {
            let of_one = |name| (name, Ok(exhibit_inputs::<F::Of, F::Needs>(universe)));
            figure_subject::<F>(universe).into_iter().map(of_one).collect()
        },
        reads: |universe| exhibit_reads(F::Needs::ids(universe)),
        make: |universe, _, _, reader, _| {
            let svg = F::draw(F::Needs::read(universe, reader)?)?.svg()?;
            let summary = format!("{} KiB", svg.len().div_ceil(1024));
            let files = RecordFiles::default().file(&format!("{}.svg", F::NAME), svg.into_bytes());
            Ok(Product { files, metrics: Vec::new(), summary })
        },
    }
}

/// A table as an entry.
pub const fn table<T: Table>() -> Entry<T::Of> {
    Entry {
        name: T::NAME,
        section: None,
        description: T::CAPTION,
        kind: Kind::Table,
        version: T::VERSION,
        subjects: |universe| table_subject::<T>(universe).into_iter().collect(),
        planned: |universe, _| {
            let of_one = |name| (name, Ok(exhibit_inputs::<T::Of, T::Needs>(universe)));
            table_subject::<T>(universe).into_iter().map(of_one).collect()
        },
        reads: |universe| exhibit_reads(T::Needs::ids(universe)),
        make: |universe, _, _, reader, _| {
            let table = T::fill(T::Needs::read(universe, reader)?)?;
            let files = table_files(T::NAME, &table)?;
            Ok(Product { files, metrics: Vec::new(), summary: format!("{} rows", table.rows.len()) })
        },
    }
}

/// A table as CSV, LaTeX and SVG.
fn table_files(name: &str, table: &plot::Table) -> Result<RecordFiles> {
    let (csv, tex, svg) = (table.csv(), table.latex(), table.svg()?);
    let untimed = table.without_durations().map(|untimed| untimed.csv().into_bytes());
    Ok([("csv", csv), ("tex", tex), ("svg", svg)].into_iter().fold(RecordFiles::default(), |files, (ending, text)| {
        let file = format!("{name}.{ending}");
        match &untimed {
            Some(untimed) => files.timed_file(&file, text.into_bytes(), untimed.clone()),
            None => files.file(&file, text.into_bytes()),
        }
    }))
}

/// The universe's name where the figure is made for it: without groups there is nothing to show.
fn figure_subject<F: Figure>(universe: &F::Of) -> Option<String> {
    (!universe.groups().is_empty() && F::is_made_for(universe)).then(|| universe.name())
}

fn table_subject<T: Table>(universe: &T::Of) -> Option<String> {
    (!universe.groups().is_empty() && T::is_made_for(universe)).then(|| format!("{}/table", universe.name()))
}

fn subjects_of<S: Stage>(universe: &UniverseOf<S>) -> Vec<<S::Makes as Record>::Of> {
    <S::Makes as Record>::Of::all(universe).into_iter().filter(S::Makes::is_made_for).collect()
}

fn find_subject<Of: Subject>(subjects: Vec<Of>, name: &str) -> Result<Of> {
    subjects.into_iter().find(|subject| subject.name() == name).ok_or_else(|| {
        Diagnostic::new(format!("there is no `{name}`"), "no card names it", "study plan lists the subjects")
    })
}

/// The card's part of a key: what the entry reads itself, and what its needs read of their subjects.
fn card_part(own_part: Value, needs_part: Value) -> Value {
    if needs_part.is_null() { own_part } else { json!({ "own": own_part, "needs": needs_part }) }
}

fn exhibit_inputs<U, N: Needs<U>>(universe: &U) -> Inputs {
    Inputs { raw: Vec::new(), card: N::parts(universe), settings: Value::Null, records: N::ids(universe) }
}

fn exhibit_reads(records: Vec<RecordId>) -> Reads {
    Reads { raw: BTreeSet::new(), stages: records.into_iter().map(|id| id.stage).collect() }
}

fn as_json(value: &impl Serialize) -> Result<Value> {
    Ok(serde_json::to_value(value)?)
}

fn unreadable_error(error: RecordError) -> Diagnostic {
    let action = "report it: a stage made a number that is not finite, or a list that its record cannot hold";
    Diagnostic::new("the record could not be read again and is not stored", &error, action).caused_by(error)
}

fn pack_error(error: RecordError) -> Diagnostic {
    let action = "report it: a stage made a table with columns of different lengths";
    Diagnostic::new("the record cannot be written", &error, action).caused_by(error)
}
