//! Making named records from what lies in the store: one record is one task of a workflow engine, on whichever machine.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::Runner;
use super::graph::{Job, reachable_records};
use super::hashes::Hashes;
use super::plan::{Action, judge_jobs};
use crate::needs::RecordId;
use crate::subject::Universe;
use diagnostics::{Diagnostic, Result};

/// Commands longer than this many names are given as a stage instead.
const MOST_NAMES: usize = 8;

/// The named records, and the contents of those that they read.
pub struct Task<U: 'static> {
    /// The named records, each after those that it reads.
    pub jobs: Vec<Job<U>>,
    /// What they read beside each other.
    pub contents: BTreeMap<RecordId, String>,
}

/// Splits the graph into the named records and their inputs, which must be up to date.
///
/// # Errors
/// A [`Diagnostic`] when there is no such record, or when an input is missing or stale.
pub(crate) fn split_task<U: Universe>(runner: &Runner<U>, jobs: Vec<Job<U>>, names: &[String]) -> Result<Task<U>> {
    let named = find_records(&jobs, names)?;
    let needed = reachable_records(&jobs, named.clone());
    let jobs: Vec<Job<U>> = jobs.into_iter().filter(|job| needed.contains(&job.id)).collect();
    let plan = judge_jobs(runner, &jobs);
    let stale = |(job, action): &(&Job<U>, &Action)| !named.contains(&job.id) && !action.keeps();
    let stale: Vec<(&Job<U>, &Action)> = jobs.iter().zip(&plan.actions).filter(stale).collect();
    if let Some((first, action)) = stale.first() {
        let readers = jobs.iter().filter(|job| named.contains(&job.id));
        let reader = readers
            .map(|job| &job.id)
            .find(|id| reachable_records(&jobs, BTreeSet::from([(*id).clone()])).contains(&first.id));
        let ids: Vec<&RecordId> = stale.iter().map(|(job, _)| &job.id).collect();
        return Err(not_up_to_date(reader.unwrap_or(&first.id), &ids, &action.in_words()));
    }
    let (requested, inputs): (Vec<Job<U>>, Vec<Job<U>>) = jobs.into_iter().partition(|job| named.contains(&job.id));
    let of_input = |(id, _): &(RecordId, String)| inputs.iter().any(|job| job.id == *id);
    let contents = plan.contents.into_iter().filter(of_input).collect();
    Ok(Task { jobs: requested, contents })
}

/// Holds that these records and all that they read are up to date.
///
/// # Errors
/// A [`Diagnostic`] when there is no such record, or that names the first that is not up to date.
pub(crate) fn require_current<U: Universe>(runner: &Runner<U>, jobs: Vec<Job<U>>, names: &[String]) -> Result<()> {
    let named = find_records(&jobs, names)?;
    let stages: Vec<&str> = named.iter().map(|id| id.stage).collect();
    let needed = reachable_records(&jobs, named.clone());
    let jobs: Vec<Job<U>> = jobs.into_iter().filter(|job| needed.contains(&job.id)).collect();
    let actions = judge_jobs(runner, &jobs).actions;
    match jobs.iter().zip(&actions).find(|(_, action)| !action.keeps()) {
        None => Ok(()),
        Some((job, action)) => Err(Diagnostic::new(
            format!("record `{}` is not up to date", job.id),
            action.in_words(),
            format!("study run {}", stages.join(" ")),
        )),
    }
}

fn find_records<U>(jobs: &[Job<U>], names: &[String]) -> Result<BTreeSet<RecordId>> {
    let ids: BTreeMap<String, &RecordId> = jobs.iter().map(|job| (job.id.to_string(), &job.id)).collect();
    let find = |name: &String| ids.get(name).map(|id| (*id).clone()).ok_or_else(|| unknown_record(name, &ids));
    names.iter().map(find).collect()
}

fn unknown_record(name: &str, ids: &BTreeMap<String, &RecordId>) -> Diagnostic {
    let stage = name.split('/').next().unwrap_or(name);
    let of_stage: Vec<&str> = ids.keys().map(String::as_str).filter(|id| id.split('/').next() == Some(stage)).collect();
    let reason = match of_stage.len() {
        0 => format!("no stage, figure or table `{stage}` makes a record here"),
        count => {
            let more = if count > MOST_NAMES { format!(" and {} more", count - MOST_NAMES) } else { String::new() };
            format!("the records of `{stage}` are {}{more}", of_stage[..count.min(MOST_NAMES)].join(", "))
        }
    };
    Diagnostic::new(format!("there is no record `{name}`"), reason, "study plan lists the records: STAGE/SUBJECT")
}

fn not_up_to_date(reader: &RecordId, stale: &[&RecordId], first: &str) -> Diagnostic {
    let remaining = match stale.len() {
        1 => String::new(),
        count => format!(", and {} more that it needs are not up to date", count - 1),
    };
    let names = || stale.iter().map(|id| id.to_string()).collect::<Vec<_>>().join(" ");
    let action = if stale.len() > MOST_NAMES {
        format!("study run {}", reader.stage)
    } else {
        format!("study make {}", names())
    };
    Diagnostic::new(
        format!("record `{reader}` cannot be made from what lies in the store"),
        format!("its input `{}` {}{first}{remaining}", stale[0], if first.starts_with("stale") { "is " } else { "" }),
        action,
    )
}

/// Writes what was hashed for each record beside it, so that the tasks that read it need not read its recordings again.
///
/// # Errors
/// When a file cannot be written.
pub(super) fn write_hashes<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>], hashes: &Hashes) -> std::io::Result<()> {
    let folders = &runner.folders;
    for job in jobs.iter().filter(|job| folders.record(&job.id).is_dir()) {
        let raw = job.inputs.as_ref().map_or(&[][..], |inputs| &inputs.raw);
        let mut files: Vec<PathBuf> = raw.iter().flat_map(|file| files_of(folders.raw_file(&file.path))).collect();
        for path in files_of(folders.record(&job.id)) {
            hashes.of(&path)?;
            files.push(path);
        }
        hashes.write_of(&files, &folders.record_hashes(&job.id))?;
    }
    Ok(())
}

/// A file, or the files of a folder.
fn files_of(path: PathBuf) -> Vec<PathBuf> {
    match std::fs::read_dir(&path) {
        Ok(entries) => entries.flatten().map(|entry| entry.path()).collect(),
        Err(_) => vec![path],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Why there is no record `sum/none` where there are so many others of its stage.
    fn why(count: usize) -> String {
        let ids: Vec<RecordId> = (0..count).map(|k| RecordId { stage: "sum", subject: format!("s{k}") }).collect();
        let summary = RecordId { stage: "summary", subject: "all".into() };
        let names = ids.iter().chain([&summary]).map(|id| (id.to_string(), id)).collect();
        unknown_record("sum/none", &names).why
    }

    #[test]
    fn of_the_records_of_a_stage_eight_are_named_and_the_others_counted() {
        assert_eq!(why(0), "no stage, figure or table `sum` makes a record here");
        assert_eq!(why(2), "the records of `sum` are sum/s0, sum/s1");
        assert!(why(8).ends_with(", sum/s6, sum/s7"), "{}", why(8));
        assert!(why(10).ends_with(", sum/s6, sum/s7 and 2 more"), "{}", why(10));
    }
}
