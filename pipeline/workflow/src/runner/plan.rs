//! The plan: what a run would keep and make, and why, in words. It writes nothing.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use serde::Serialize;

use super::Runner;
use super::graph::Job;
use super::hashes::Hashes;
use super::manifest::Outline;
use super::staleness::{State, present_inputs, record_state};
use super::store::{Found, Store};
use crate::entry::Kind;
use crate::needs::RecordId;
use crate::subject::Universe;
use diagnostics::{Diagnostic, Result};

/// The action for one record.
pub(super) enum Action {
    Kept,
    Stale(Vec<String>),
    Waits(RecordId),
    Impossible(Diagnostic),
}

/// One line a record, and a last line with the count.
pub(crate) fn plan_text<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>]) -> String {
    let actions = judge_jobs(runner, jobs).actions;
    let mut lines: Vec<String> = jobs.iter().zip(&actions).map(|(job, action)| plan_line(job, action)).collect();
    let stale = actions.iter().filter(|action| !action.keeps()).count();
    lines.push(format!("{} of {} records would be made", stale, jobs.len()));
    lines.join("\n")
}

/// A record of a plan, as another program reads it.
#[derive(Serialize)]
struct PlannedRecord<'a> {
    /// As `study make` takes it.
    record: String,
    stage: &'a str,
    subject: String,
    /// Whether a run would keep it.
    kept: bool,
    /// As the plan in words has it.
    why: String,
    /// The records that it reads.
    reads: Vec<String>,
}

/// The plan as JSON, an object a record in the order in which a run would make them.
pub(crate) fn plan_json<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>]) -> serde_json::Result<String> {
    let actions = judge_jobs(runner, jobs).actions;
    let planned = |(job, action): (&Job<U>, &Action)| PlannedRecord {
        record: job.id.to_string(),
        stage: job.id.stage,
        subject: job.id.subject.to_string(),
        kept: action.keeps(),
        why: action.in_words(),
        reads: job.reads().iter().map(|id| id.to_string()).collect(),
    };
    // length: an action for each job
    serde_json::to_string_pretty(&jobs.iter().zip(&actions).map(planned).collect::<Vec<_>>())
}

/// The names of the records that would be made.
pub(crate) fn stale_records<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>]) -> Vec<String> {
    let actions = judge_jobs(runner, jobs).actions;
    let stale = jobs.iter().zip(&actions).filter(|(_, action)| !action.keeps());
    stale.map(|(job, _)| job.id.to_string()).collect()
}

/// The records that a run would keep.
pub(crate) fn up_to_date<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>]) -> BTreeSet<RecordId> {
    let actions = judge_jobs(runner, jobs).actions;
    jobs.iter().zip(&actions).filter(|(_, action)| action.keeps()).map(|(job, _)| job.id.clone()).collect()
}

/// A record in the store that a run would make again, or could not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outdated {
    /// The record.
    pub id: RecordId,
    /// Why, as a plan prints it.
    pub reason: String,
}

/// The records in the store that a run would not keep: what is shown or exported of them would be of other inputs than the present ones.
pub(crate) fn outdated_records<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>]) -> Vec<Outdated> {
    let plan = judge_jobs(runner, jobs);
    let in_store = |job: &Job<U>| runner.folders.record(&job.id).exists();
    let outdated = jobs.iter().zip(&plan.actions).filter(|(job, action)| !action.keeps() && in_store(job));
    outdated.map(|(job, action)| Outdated { id: job.id.clone(), reason: action.in_words() }).collect()
}

/// The inputs of the records of one stage, and the differences that make them stale.
pub(crate) fn explain_staleness<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>], entry: &str) -> String {
    let actions = judge_jobs(runner, jobs).actions;
    let of_entry = jobs.iter().zip(&actions).filter(|(job, _)| job.id.stage == entry);
    of_entry
        .map(|(job, action)| format!("{}\n{}", plan_line(job, action), record_history(runner, job)))
        .collect::<Vec<_>>()
        .join("\n")
}

/// How many records of a stage would be kept and made.
#[derive(Debug, Clone, Copy, Default)]
pub struct Share {
    kept: usize,
    made: usize,
}

impl Share {
    /// As text.
    pub fn in_words(self) -> String {
        match (self.kept, self.made) {
            (kept, 0) => format!("{kept} kept"),
            (0, made) => format!("{made} to make"),
            (kept, made) => format!("{kept} kept, {made} to make"),
        }
    }
}

/// The share of each stage.
pub(crate) fn stage_shares<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>]) -> BTreeMap<&'static str, Share> {
    let mut shares: BTreeMap<&'static str, Share> = BTreeMap::new();
    for (job, action) in
        jobs.iter().zip(judge_jobs(runner, jobs).actions).filter(|(job, _)| job.entry.kind == Kind::Stage)
    {
        let share = shares.entry(job.id.stage).or_default();
        match action {
            Action::Kept => share.kept += 1,
            _ => share.made += 1,
        }
    }
    shares
}

/// What a run would do with each record, and the contents of those that exist.
pub(super) struct Plan {
    /// One action a record.
    pub actions: Vec<Action>,
    /// Of the records whose bytes are those that were written.
    pub contents: BTreeMap<RecordId, String>,
}

/// Compares the inputs of all records with their manifests, in parallel. A record that reads a kept one takes its content from the
/// disk; one that reads a record to be made waits.
pub(super) fn judge_jobs<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>]) -> Plan {
    let record_hashes = jobs.par_iter().map(|job| runner.folders.record_hashes(&job.id));
    let hashes = Hashes::from_caches(&runner.folders.hashes(), record_hashes);
    let store = Store::new(&runner.folders);
    let stored: Vec<Found<Outline>> = jobs.par_iter().map(|job| store.find_with(&job.id, &hashes)).collect();
    let content =
        |(job, stored): (&Job<U>, &Found<Outline>)| Some((job.id.clone(), stored.manifest()?.content.clone()));
    let contents: BTreeMap<RecordId, String> = jobs.iter().zip(&stored).filter_map(content).collect();
    // The whole manifest is read of stale records alone, for their differences.
    let judge = |(job, stored): (&Job<U>, &Found<Outline>)| {
        let now = present_inputs(runner, job, &contents, &hashes)?;
        let unchanged = stored.manifest().is_some_and(|outline| outline.key == now.key());
        Ok(if unchanged { None } else { Some(record_state(runner, job, &now.made_from(), &hashes)) })
    };
    let states: Vec<Result<Option<State>>> = jobs.par_iter().zip(&stored).map(judge).collect();
    let mut changing = BTreeSet::new();
    let mut settle = |(job, state): (&Job<U>, Result<Option<State>>)| {
        let action = action_for(job, state, &changing);
        if !action.keeps() {
            changing.insert(job.id.clone());
        }
        action
    };
    let actions = jobs.iter().zip(states).map(&mut settle).collect();
    Plan { actions, contents }
}

fn action_for<U: Universe>(job: &Job<U>, state: Result<Option<State>>, changing: &BTreeSet<RecordId>) -> Action {
    let upstream = job.reads().iter().find(|id| changing.contains(*id));
    match (state, upstream) {
        (Err(diagnostic), _) => Action::Impossible(diagnostic),
        (_, Some(id)) => Action::Waits(id.clone()),
        (Ok(None | Some(State::Kept(_))), None) => Action::Kept,
        (Ok(Some(State::Stale(reasons))), None) => Action::Stale(reasons),
        (Ok(Some(State::Damaged(damage))), None) => Action::Stale(vec![damage]),
    }
}

fn plan_line<U: Universe>(job: &Job<U>, action: &Action) -> String {
    format!("{:<16} {:<28} {}", job.id.stage, job.id.subject, action.in_words())
}

impl Action {
    /// Whether a run would keep the record.
    pub fn keeps(&self) -> bool {
        matches!(self, Self::Kept)
    }

    /// As a plan prints it.
    pub fn in_words(&self) -> String {
        match self {
            Self::Kept => "kept".into(),
            Self::Stale(reasons) => format!("stale: {}", reasons.join("; ")),
            Self::Waits(id) => format!("stale: it reads {id}, which will be made"),
            Self::Impossible(diagnostic) => format!("cannot be made: {}", diagnostic.what),
        }
    }
}

fn record_history<U: Universe>(runner: &Runner<U>, job: &Job<U>) -> String {
    match Store::new(&runner.folders).find(&job.id) {
        Found::Whole(manifest) => {
            let inputs = &manifest.made_from;
            let mut lines = vec![format!(
                "  version {}, made in {:.1} s, content {:.12}",
                inputs.version, manifest.seconds, manifest.content
            )];
            lines.extend(inputs.raw.iter().map(|(path, hash)| format!("  recording {path}  {hash:.12}")));
            lines.extend(inputs.records.iter().map(|(id, hash)| format!("  record    {id}  {hash:.12}")));
            lines.push(format!("  settings  {}", inputs.settings));
            lines.push(format!("  card      {}", inputs.card));
            lines.join("\n")
        }
        Found::Nothing => "  it was never made".into(),
        Found::Damaged(damage) => format!("  {damage}"),
    }
}
