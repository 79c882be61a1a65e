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
fn needed(all: &[Job], goal: &Goal) -> BTreeSet<Id> {
    let of_specimen = |id: &Id| match &goal.specimen {
        Some(name) => {
            let first = id.subject.split('/').next();
            first == Some(name) || first == Some("all") && !goal.entries.is_empty()
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
