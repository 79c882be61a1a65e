//! Entries: a stage, figure or table with its types put away, so that the runner can hold all of them in one list.
//!
//! Stands on: the contracts stage, figure and table. Never knows: a path, an order of running.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::fault::{Fault, Outcome};
use crate::figure::Figure;
use crate::metric::Metric;
use crate::needs::{Id, Needs, Shelf};
use crate::record::{Parcel, Record, RecordError};
use crate::settings::Settings;
use crate::stage::{Desk, RawFile, Stage};
use crate::subject::{Scope, Study};
use crate::table::Table;

/// What a thing on the list is; it decides where its product is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A stage: its record stays in `data/processed`.
    Stage,
    /// A figure: its SVG is also laid into `figures/`.
    Figure,
    /// A table: its CSV, LaTeX and SVG are also laid into `paper/tables/`.
    Table,
}

/// Everything that decides what a record is.
#[derive(Debug, Clone, PartialEq)]
pub struct Ingredients {
    /// Raw recordings read.
    pub raw: Vec<RawFile>,
    /// The part of the card read.
    pub card: Value,
    /// The section of the settings, as the stage understood it.
    pub settings: Value,
    /// Records read.
    pub records: Vec<Id>,
}

/// What a stage reads over a whole study: words of recordings, and stages.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reads {
    /// The stage's own words for recordings.
    pub raw: BTreeSet<String>,
    /// The stages whose records it reads.
    pub stages: BTreeSet<&'static str>,
}

/// One record to be: the name of its subject, and what it is made from or why that cannot be said.
pub type Planned = (String, Outcome<Ingredients>);

/// A record just made.
pub struct Made {
    /// Its files.
    pub parcel: Parcel,
    /// Its numbers.
    pub metrics: Vec<Metric>,
    /// Its one telling number.
    pub telling: String,
}

/// One line of a list of stages, figures or tables.
pub struct Entry {
    /// Its name.
    pub name: &'static str,
    /// Its section in `study.toml`; a figure or table has none.
    pub section: Option<&'static str>,
    /// What becomes what.
    pub story: &'static str,
    /// What it is.
    pub kind: Kind,
    /// Its edition.
    pub edition: u32,
    /// The names of its subjects.
    pub subjects: fn(&Study) -> Vec<String>,
    /// Its records, one a subject: all at once, since a subject is found among all of its kind.
    pub planned: fn(&Study, &Settings) -> Vec<Planned>,
    /// What it reads, over all its subjects.
    pub reads: fn(&Study) -> Reads,
    /// Makes the record.
    pub make: fn(&Study, &str, &Settings, &dyn Shelf, &dyn Desk) -> Outcome<Made>,
}

/// A stage as an entry.
pub const fn stage<S: Stage>() -> Entry {
    Entry {
        name: S::Makes::STAGE,
        section: Some(S::SECTION),
        story: S::STORY,
        kind: Kind::Stage,
        edition: S::EDITION,
        subjects: |study| of_stage::<S>(study).iter().map(Scope::name).collect(),
        planned: |study, settings| {
            let section = settings.section::<S::Settings>(S::SECTION).and_then(|section| as_json(&section));
            let of_one = |of: &<S::Makes as Record>::Of| {
                let settings = section.clone()?;
                Ok(Ingredients { raw: S::raw(of), card: S::card(of), settings, records: S::Needs::wanted(of) })
            };
            of_stage::<S>(study).iter().map(|of| (of.name(), of_one(of))).collect()
        },
        reads: |study| {
            let all = of_stage::<S>(study);
            Reads {
                raw: all.iter().flat_map(S::raw).map(|file| file.word).collect(),
                stages: all.iter().flat_map(S::Needs::wanted).map(|id| id.stage).collect(),
            }
        },
        make: |study, name, settings, shelf, desk| {
            let of = find(of_stage::<S>(study), name)?;
            let needs = S::Needs::fetch(&of, shelf)?;
            let record = S::run(&of, &settings.section(S::SECTION)?, needs, desk)?;
            let parcel = record.pack().map_err(unwritable)?;
            Ok(Made { parcel, metrics: record.metrics(&of), telling: record.telling() })
        },
    }
}

/// A figure as an entry.
pub const fn figure<F: Figure>() -> Entry {
    Entry {
        name: F::NAME,
        section: None,
        story: F::SHOWS,
        kind: Kind::Figure,
        edition: F::EDITION,
        subjects: |study| figure_subject::<F>(study).into_iter().collect(),
        planned: |study, _| {
            let of_one = |name| (name, Ok(Ingredients { card: F::card(study), ..shown(F::Needs::wanted(study)) }));
            figure_subject::<F>(study).into_iter().map(of_one).collect()
        },
        reads: |study| shows(F::Needs::wanted(study)),
        make: |study, _, _, shelf, _| {
            let svg = F::draw(F::Needs::fetch(study, shelf)?)?.svg().map_err(Fault::from_tool)?;
            let telling = format!("{} KiB", svg.len().div_ceil(1024));
            let parcel = Parcel::default().file(&format!("{}.svg", F::NAME), svg.into_bytes());
            Ok(Made { parcel, metrics: Vec::new(), telling })
        },
    }
}

/// A table as an entry.
pub const fn table<T: Table>() -> Entry {
    Entry {
        name: T::NAME,
        section: None,
        story: T::SHOWS,
        kind: Kind::Table,
        edition: T::EDITION,
        subjects: |study| table_subject::<T>(study).into_iter().collect(),
        planned: |study, _| {
            let of_one = |name| (name, Ok(shown(T::Needs::wanted(study))));
            table_subject::<T>(study).into_iter().map(of_one).collect()
        },
        reads: |study| shows(T::Needs::wanted(study)),
        make: |study, _, _, shelf, _| {
            let table = T::fill(T::Needs::fetch(study, shelf)?)?;
            let parcel = Parcel::default()
                .file(&format!("{}.csv", T::NAME), table.csv().into_bytes())
                .file(&format!("{}.tex", T::NAME), table.latex().into_bytes())
                .file(&format!("{}.svg", T::NAME), table.svg().map_err(Fault::from_tool)?.into_bytes());
            Ok(Made { parcel, metrics: Vec::new(), telling: format!("{} rows", table.rows.len()) })
        },
    }
}

/// The study's name where the figure is made for it: where no specimen was found nothing can be shown.
fn figure_subject<F: Figure>(study: &Study) -> Option<String> {
    (!study.specimens.is_empty() && F::is_made_for(study)).then(|| study.name())
}

fn table_subject<T: Table>(study: &Study) -> Option<String> {
    (!study.specimens.is_empty() && T::is_made_for(study)).then(|| format!("{}/table", study.name()))
}

fn of_stage<S: Stage>(study: &Study) -> Vec<<S::Makes as Record>::Of> {
    <S::Makes as Record>::Of::all(study).into_iter().filter(S::Makes::is_made_for).collect()
}

fn find<Of: Scope>(all: Vec<Of>, name: &str) -> Outcome<Of> {
    all.into_iter().find(|of| of.name() == name).ok_or_else(|| {
        Fault::new(format!("there is no `{name}`"), "no card names it", "study plan lists what there is")
    })
}

fn shown(records: Vec<Id>) -> Ingredients {
    Ingredients { raw: Vec::new(), card: Value::Null, settings: Value::Null, records }
}

fn shows(records: Vec<Id>) -> Reads {
    Reads { raw: BTreeSet::new(), stages: records.into_iter().map(|id| id.stage).collect() }
}

fn as_json(value: &impl serde::Serialize) -> Outcome<Value> {
    serde_json::to_value(value).map_err(Fault::from_tool)
}

fn unwritable(error: RecordError) -> Fault {
    Fault::new("the record cannot be written", error, "report it: a stage made a table with ragged columns")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subject::Specimen;

    #[test]
    fn no_two_entries_make_the_same_record() {
        let card = lab::card::parse(include_str!("../tests/card.toml"), std::path::Path::new("card.toml")).unwrap();
        let study = Study { specimens: vec![Specimen { card: card.into() }] };
        let entries = crate::LISTS.iter().flat_map(|list| list.iter());
        let mut ids: Vec<(&str, String)> =
            entries.flat_map(|e| (e.subjects)(&study).into_iter().map(|subject| (e.name, subject))).collect();
        let all = ids.len();
        ids.sort();
        ids.dedup();
        assert_eq!(ids.len(), all);
    }
}
