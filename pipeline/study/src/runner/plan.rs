//! The plan: what a run would keep and make, and why, in words. It writes nothing.
//!
//! Stands on: inputs. Never knows: how a record is made.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::Runner;
use super::graph::Job;
use super::hashes::Hashes;
use super::inputs::{State, judged, made_from};
use super::store::{Found, Store};
use super::tree;
use crate::fault::{Fault, Outcome};
use crate::needs::Id;

/// What would become of one record.
enum Fate {
    Kept,
    Stale(Vec<String>),
    Waits(Id),
    Impossible(Fault),
}

/// One line a record, and a last line with the count.
pub fn text(runner: &Runner, jobs: &[Job]) -> String {
    let fates = fates(runner, jobs);
    let mut lines: Vec<String> = jobs.iter().zip(&fates).map(|(job, fate)| line(job, fate)).collect();
    let stale = fates.iter().filter(|fate| !matches!(fate, Fate::Kept)).count();
    lines.push(format!("{} of {} records would be made", stale, jobs.len()));
    lines.join("\n")
}

/// From what the records of one stage were made, and what would make them stale.
pub fn why(runner: &Runner, jobs: &[Job], entry: &str) -> String {
    let fates = fates(runner, jobs);
    let of_entry = jobs.iter().zip(&fates).filter(|(job, _)| job.id.stage == entry);
    of_entry.map(|(job, fate)| format!("{}\n{}", line(job, fate), history(runner, job))).collect::<Vec<_>>().join("\n")
}

/// How many records of a stage would be kept and made.
#[derive(Debug, Clone, Copy, Default)]
pub struct Share {
    kept: usize,
    made: usize,
}

impl Share {
    /// As a person says it.
    pub fn in_words(self) -> String {
        match (self.kept, self.made) {
            (kept, 0) => format!("{kept} kept"),
            (0, made) => format!("{made} to make"),
            (kept, made) => format!("{kept} kept, {made} to make"),
        }
    }
}

/// The share of each stage.
pub fn shares(runner: &Runner, jobs: &[Job]) -> BTreeMap<&'static str, Share> {
    let mut shares: BTreeMap<&'static str, Share> = BTreeMap::new();
    for (job, fate) in jobs.iter().zip(fates(runner, jobs)).filter(|(job, _)| tree::is_stage(job)) {
        let share = shares.entry(job.id.stage).or_default();
        match fate {
            Fate::Kept => share.kept += 1,
            _ => share.made += 1,
        }
    }
    shares
}

/// What a record would be made from is compared with what lies there, side by side: a record that reads one that is kept finds its
/// content on the disk, and one that reads another waits, whatever it was made from.
fn fates(runner: &Runner, jobs: &[Job]) -> Vec<Fate> {
    let hashes = Hashes::remembered(&runner.folders.hashes());
    let store = Store::new(&runner.folders);
    let found: Vec<Found> = jobs.par_iter().map(|job| store.look_by(&job.id, &hashes)).collect();
    let whole = |(job, found): (&Job, &Found)| Some((job.id.clone(), found.manifest()?.content.clone()));
    let contents: BTreeMap<Id, String> = jobs.iter().zip(&found).filter_map(whole).collect();
    let judge = |(job, found)| Ok(judged(found, &made_from(runner, job, &contents, &hashes)?));
    let states: Vec<Outcome<State>> = jobs.par_iter().zip(found).map(judge).collect();
    let mut changing = BTreeSet::new();
    let mut settle = |(job, state): (&Job, Outcome<State>)| {
        let fate = fate(job, state, &changing);
        if !matches!(fate, Fate::Kept) {
            changing.insert(job.id.clone());
        }
        fate
    };
    jobs.iter().zip(states).map(&mut settle).collect()
}

fn fate(job: &Job, state: Outcome<State>, changing: &BTreeSet<Id>) -> Fate {
    let upstream = job.reads().iter().find(|id| changing.contains(*id));
    match (state, upstream) {
        (Err(fault), _) => Fate::Impossible(fault),
        (_, Some(id)) => Fate::Waits(id.clone()),
        (Ok(State::Kept(_)), None) => Fate::Kept,
        (Ok(State::Stale(reasons)), None) => Fate::Stale(reasons),
        (Ok(State::Damaged(damage)), None) => Fate::Stale(vec![damage]),
    }
}

fn line(job: &Job, fate: &Fate) -> String {
    let name = format!("{:<16} {:<28}", job.id.stage, job.id.subject);
    match fate {
        Fate::Kept => format!("{name} kept"),
        Fate::Stale(reasons) => format!("{name} stale: {}", reasons.join("; ")),
        Fate::Waits(id) => format!("{name} stale: it reads {id}, which will be made"),
        Fate::Impossible(fault) => format!("{name} cannot be made: {}", fault.what),
    }
}

fn history(runner: &Runner, job: &Job) -> String {
    match Store::new(&runner.folders).look(&job.id) {
        Found::Whole(manifest) => {
            let from = &manifest.made_from;
            let mut lines = vec![format!(
                "  edition {}, made in {:.1} s, content {:.12}",
                from.edition, manifest.seconds, manifest.content
            )];
            lines.extend(from.raw.iter().map(|(place, hash)| format!("  recording {place}  {hash:.12}")));
            lines.extend(from.records.iter().map(|(id, hash)| format!("  record    {id}  {hash:.12}")));
            lines.push(format!("  settings  {}", from.settings));
            lines.push(format!("  card      {}", from.card));
            lines.join("\n")
        }
        Found::Nothing => "  it was never made".into(),
        Found::Damaged(damage) => format!("  {damage}"),
    }
}
