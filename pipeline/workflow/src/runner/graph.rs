//! The directed acyclic graph of records, in an order in which each comes after those that it reads.

use std::collections::BTreeSet;

use diagnostics::{Diagnostic, Result};
use rayon::prelude::*;

use super::Runner;
use crate::entry::{Entry, Inputs};
use crate::needs::RecordId;
use crate::subject::Universe;

/// One record to be made: its entry, its name, and its inputs.
pub struct Job<U: 'static> {
    /// The stage, figure or table.
    pub entry: &'static Entry<U>,
    /// The record's name.
    pub id: RecordId,
    /// Its inputs, or why they cannot be determined.
    pub inputs: Result<Inputs>,
}

impl<U> Job<U> {
    /// The records that this one reads.
    pub fn reads(&self) -> &[RecordId] {
        self.inputs.as_ref().map_or(&[], |i| i.records.as_slice())
    }
}

/// The requested part of a project.
#[derive(Debug, Clone, Default)]
pub struct Goal {
    /// Stages, figures or tables by name; none means all.
    pub entries: Vec<String>,
    /// Only this group of subjects.
    pub group: Option<String>,
}

/// Every record of the project in running order, then only those that the goal needs.
///
/// # Errors
/// A [`Diagnostic`] when the goal names an entry or a group that does not exist.
pub(crate) fn goal_jobs<U: Universe>(runner: &Runner<U>, goal: &Goal) -> Result<Vec<Job<U>>> {
    let entries: Vec<&'static Entry<U>> = runner.lists.iter().flat_map(|list| list.iter()).collect();
    check_goal(&entries, &runner.universe, goal)?;
    let planned = |entry: &&'static Entry<U>| -> Vec<Job<U>> {
        let job = |(subject, inputs)| Job { entry, id: RecordId { stage: entry.name, subject }, inputs };
        (entry.planned)(&runner.universe, &runner.settings).into_iter().map(job).collect()
    };
    let jobs: Vec<Job<U>> = entries.par_iter().map(planned).collect::<Vec<_>>().into_iter().flatten().collect();
    let needed = needed_records(&jobs, goal);
    Ok(jobs.into_iter().filter(|job| needed.contains(&job.id)).collect())
}

fn check_goal<U: Universe>(entries: &[&'static Entry<U>], universe: &U, goal: &Goal) -> Result<()> {
    let names: Vec<&str> = entries.iter().map(|e| e.name).collect();
    if let Some(name) = goal.entries.iter().find(|name| !names.contains(&name.as_str())) {
        let action = format!("choose from: {}", names.join(", "));
        return Err(Diagnostic::new(
            format!("there is no stage, figure or table `{name}`"),
            "no list names it",
            action,
        ));
    }
    let names = universe.groups();
    match &goal.group {
        Some(name) if !names.contains(name) => Err(Diagnostic::new(
            format!("there is no {} `{name}`", U::GROUP),
            format!("there are cards of: {}", names.join(", ")),
            "record it, or correct the name",
        )),
        _ => Ok(()),
    }
}

/// The goal's own records and, going back through the list, everything that they read.
///
/// Of an entry that has a record of the group alone, that one; of an entry that has only one of the whole project, that.
fn needed_records<U>(jobs: &[Job<U>], goal: &Goal) -> BTreeSet<RecordId> {
    let is_of = |id: &RecordId, name: &str| id.subject.split('/').next() == Some(name);
    let of_group = |id: &RecordId| match &goal.group {
        Some(name) => {
            let has_own = || jobs.iter().any(|job| job.id.stage == id.stage && is_of(&job.id, name));
            is_of(id, name) || is_of(id, "all") && !goal.entries.is_empty() && !has_own()
        }
        None => true,
    };
    let asked = |id: &RecordId| goal.entries.is_empty() || goal.entries.iter().any(|name| name == id.stage);
    reachable_records(jobs, jobs.iter().map(|job| &job.id).filter(|id| asked(id) && of_group(id)).cloned().collect())
}

/// These records and, going back through the list, everything that they read.
pub(super) fn reachable_records<U>(jobs: &[Job<U>], mut needed: BTreeSet<RecordId>) -> BTreeSet<RecordId> {
    for job in jobs.iter().rev() {
        if needed.contains(&job.id) {
            needed.extend(job.reads().iter().cloned());
        }
    }
    needed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{ALL, Whole};
    use serde_json::Value;

    fn job(stage: &'static str, subject: &str) -> Job<Whole> {
        let inputs = Inputs { raw: Vec::new(), card: Value::Null, settings: Value::Null, records: Vec::new() };
        Job { entry: &ALL[0], id: RecordId { stage, subject: subject.into() }, inputs: Ok(inputs) }
    }

    #[test]
    fn of_an_entry_with_records_of_both_kinds_a_group_asks_for_its_own_alone() {
        let jobs = [job("both", "a"), job("both", "b"), job("both", "all"), job("drawn", "all")];
        let needed = |names: &[&str]| {
            let entries = names.iter().map(|name| (*name).into()).collect();
            let ids = needed_records(&jobs, &Goal { entries, group: Some("b".into()) });
            ids.iter().map(|id| id.to_string()).collect::<Vec<_>>()
        };
        assert_eq!(needed(&["both"]), ["both/b"]);
        assert_eq!(needed(&["drawn"]), ["drawn/all"]);
        assert_eq!(needed(&[]), ["both/b"]);
    }
}
