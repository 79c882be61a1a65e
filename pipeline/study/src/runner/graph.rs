//! The graph: every record of a study, in an order in which each comes after those it reads.
//!
//! Stands on: entry, subject. Never knows: a disk.

use std::collections::BTreeSet;

use crate::entry::{Entry, Ingredients};
use crate::fault::{Fault, Outcome};
use crate::needs::Id;
use crate::settings::Settings;
use crate::subject::Study;

/// One record to be: its entry, its name, and what it is made from.
pub struct Job {
    /// The stage, figure or table.
    pub entry: &'static Entry,
    /// The record's name.
    pub id: Id,
    /// What it is made from, or why that cannot be said.
    pub ingredients: Outcome<Ingredients>,
}

impl Job {
    /// The records that this one reads.
    pub fn reads(&self) -> &[Id] {
        self.ingredients.as_ref().map_or(&[], |i| i.records.as_slice())
    }
}

/// Which part of a study is asked for.
#[derive(Debug, Clone, Default)]
pub struct Goal {
    /// Stages, figures or tables by name; none means all.
    pub entries: Vec<String>,
    /// One specimen alone.
    pub specimen: Option<String>,
}

/// Every record of the study in running order, then only those that the goal needs.
///
/// # Errors
/// A [`Fault`] when the goal names a stage or specimen that is not there.
pub fn jobs(lists: &[&'static [Entry]], study: &Study, settings: &Settings, goal: &Goal) -> Outcome<Vec<Job>> {
    let entries: Vec<&'static Entry> = lists.iter().flat_map(|list| list.iter()).collect();
    check_goal(&entries, study, goal)?;
    let mut all: Vec<Job> = Vec::new();
    for entry in &entries {
        for (subject, ingredients) in (entry.planned)(study, settings) {
            all.push(Job { entry, id: Id { stage: entry.name, subject }, ingredients });
        }
    }
    let needed = needed(&all, goal);
    Ok(all.into_iter().filter(|job| needed.contains(&job.id)).collect())
}

fn check_goal(entries: &[&'static Entry], study: &Study, goal: &Goal) -> Outcome<()> {
    let known: Vec<&str> = entries.iter().map(|e| e.name).collect();
    if let Some(name) = goal.entries.iter().find(|name| !known.contains(&name.as_str())) {
        let next = format!("choose from: {}", known.join(", "));
        return Err(Fault::new(format!("there is no stage, figure or table `{name}`"), "no list names it", next));
    }
    let names: Vec<&str> = study.specimens.iter().map(|s| s.card.name.as_str()).collect();
    match &goal.specimen {
        Some(name) if !names.contains(&name.as_str()) => Err(Fault::new(
            format!("there is no specimen `{name}`"),
            format!("data/raw holds cards of: {}", names.join(", ")),
            "record it, or correct the name",
        )),
        _ => Ok(()),
    }
}

/// The goal's own records and, going back through the list, everything that they read.
///
/// Of a name that has a record of the specimen alone, that one; of a name that has only one of the whole study, that.
fn needed(all: &[Job], goal: &Goal) -> BTreeSet<Id> {
    let is_of = |id: &Id, name: &str| id.subject.split('/').next() == Some(name);
    let of_specimen = |id: &Id| match &goal.specimen {
        Some(name) => {
            let has_own = || all.iter().any(|job| job.id.stage == id.stage && is_of(&job.id, name));
            is_of(id, name) || is_of(id, "all") && !goal.entries.is_empty() && !has_own()
        }
        None => true,
    };
    let asked = |id: &Id| goal.entries.is_empty() || goal.entries.iter().any(|name| name == id.stage);
    let mut needed: BTreeSet<Id> =
        all.iter().map(|job| &job.id).filter(|id| asked(id) && of_specimen(id)).cloned().collect();
    for job in all.iter().rev() {
        if needed.contains(&job.id) {
            needed.extend(job.reads().iter().cloned());
        }
    }
    needed
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    fn job(stage: &'static str, subject: &str) -> Job {
        let ingredients =
            Ingredients { raw: Vec::new(), card: Value::Null, settings: Value::Null, records: Vec::new() };
        Job { entry: &crate::stages::ALL[0], id: Id { stage, subject: subject.into() }, ingredients: Ok(ingredients) }
    }

    #[test]
    fn of_a_stage_and_a_figure_of_one_name_a_specimen_asks_for_its_own_record_alone() {
        let all = [job("both", "nemo"), job("both", "dory"), job("both", "all"), job("drawn", "all")];
        let needed = |names: &[&str]| {
            let entries = names.iter().map(|name| (*name).into()).collect();
            let ids = needed(&all, &Goal { entries, specimen: Some("dory".into()) });
            ids.iter().map(|id| id.to_string()).collect::<Vec<_>>()
        };
        assert_eq!(needed(&["both"]), ["both/dory"]);
        assert_eq!(needed(&["drawn"]), ["drawn/all"]);
        assert_eq!(needed(&[]), ["both/dory"]);
    }
}
