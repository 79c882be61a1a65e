//! Marks: an empty file for each record that is up to date, by which Snakemake knows what is left to do; and the table of what reads what.
//!
//! Snakemake removes a mark before it runs the job of its record, and sets it when the job has succeeded. A job that was killed or refused
//! leaves none. All marks that a plan sets have one date, so that no record seems newer than one that reads it.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use diagnostics::{Diagnostic, Result, input};
use serde_json::{Map, Value, json};

use super::{as_text, relative_path};
use crate::entry::{Entry, Kind};
use crate::runner::{Folders, Goal, Job, Runner, up_to_date, write_atomically};
use crate::subject::Universe;

/// What is marked as done once numbers, description and page were written; no record has such a name, which would have two parts.
pub(super) const PUBLICATION: &str = "published";
/// The table of records.
pub(super) const TABLE: &str = "records.json";
/// The date of every mark that a plan sets: 2000-01-01, older than any that Snakemake sets.
const DATE: Duration = Duration::from_secs(946_684_800);

/// Writes the table of records in the workflow's folder and sets the marks of those that are up to date, of what the goal needs now: cards,
/// settings and recordings may have changed since the export.
///
/// # Errors
/// A [`Diagnostic`] when the goal is unknown or a file cannot be written.
pub fn update<U: Universe>(runner: &Runner<U>, folder: &Path, goal: &Goal) -> Result<()> {
    let jobs = runner.jobs_of(goal)?;
    let (table, text) = (folder.join(TABLE), record_table(&jobs)?);
    if !input::read(&table, input::MESH).is_ok_and(|former| former == text.as_bytes()) {
        write_atomically(&table, text.as_bytes()).map_err(|e| write_error(&table, e))?;
    }
    let up_to_date = up_to_date(runner, &jobs);
    let mut changed = !runner.folders.metrics().is_file();
    for job in &jobs {
        let mark = runner.folders.base().join(mark_path(&runner.folders, &job.id.to_string()));
        changed |= set_mark(&mark, up_to_date.contains(&job.id)).map_err(|e| write_error(&mark, e))?;
    }
    if changed {
        let mark = runner.folders.base().join(mark_path(&runner.folders, PUBLICATION));
        set_mark(&mark, false).map_err(|e| write_error(&mark, e))?;
    }
    Ok(())
}

/// The mark of a record, from the profile's folder.
pub(super) fn mark_path(folders: &Folders, record: &str) -> String {
    format!("{}/.made/{record}.done", relative_path(folders, &folders.processed()))
}

/// The rule that makes each record, and the records that it reads.
fn record_table<U: Universe>(jobs: &[Job<U>]) -> Result<String> {
    let row = |job: &Job<U>| {
        let reads: Vec<String> = job.reads().iter().map(ToString::to_string).collect();
        (job.id.to_string(), json!({ "rule": rule_name(job.entry), "reads": reads }))
    };
    as_text(&Value::from(jobs.iter().map(row).collect::<Map<_, _>>()))
}

/// A stage by its name, a figure and a table by what it is as well: a stage may share the name of the figure that shows it.
pub(super) fn rule_name<U>(entry: &Entry<U>) -> String {
    match entry.kind {
        Kind::Stage => entry.name.into(),
        Kind::Figure => format!("figure_{}", entry.name),
        Kind::Table => format!("table_{}", entry.name),
    }
}

/// Sets or removes a mark; whether it was otherwise before.
fn set_mark(mark: &PathBuf, is_done: bool) -> io::Result<bool> {
    let date = UNIX_EPOCH + DATE;
    let mark_date = mark.metadata().and_then(|metadata| metadata.modified()).ok();
    match (mark_date, is_done) {
        (None, false) => Ok(false),
        (Some(_), false) => fs::remove_file(mark).map(|()| true),
        (Some(former), true) if former == date => Ok(false),
        (former, true) => {
            if let Some(folder) = mark.parent() {
                fs::create_dir_all(folder)?;
            }
            set_date(mark, date)?;
            Ok(former.is_none())
        }
    }
}

fn set_date(mark: &PathBuf, date: SystemTime) -> io::Result<()> {
    File::options().create(true).append(true).open(mark)?.set_modified(date)
}

fn write_error(path: &Path, error: io::Error) -> Diagnostic {
    Diagnostic::io(path, error, "free some disk space or correct the folder's permissions")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{job, runner};

    #[test]
    fn the_table_holds_what_each_record_reads() {
        let jobs = [job("b/first", &[], &[]), job("all", &[("a/lit.csv", false)], &["b/first"])];
        let table: Value = serde_json::from_str(&record_table(&jobs).unwrap()).unwrap();
        let rule = |reads: &[&str]| json!({ "rule": "nothing", "reads": reads });
        assert_eq!(table, json!({ "nothing/b/first": rule(&[]), "nothing/all": rule(&["nothing/b/first"]) }));
    }

    #[test]
    fn a_mark_has_the_date_of_all_others_and_its_change_is_known() {
        let root = std::env::temp_dir().join(format!("marks-{}", std::process::id()));
        let mark = root.join(mark_path(&runner(&root).folders, "mesh/a"));
        assert!(mark.ends_with("data/processed/.made/mesh/a.done"), "{}", mark.display());
        let date = || mark.metadata().unwrap().modified().unwrap();
        assert!(!set_mark(&mark, false).unwrap() && set_mark(&mark, true).unwrap() && !set_mark(&mark, true).unwrap());
        File::options().append(true).open(&mark).unwrap().set_modified(SystemTime::now()).unwrap();
        assert!(!set_mark(&mark, true).unwrap(), "a job has set it");
        assert_eq!(date(), UNIX_EPOCH + DATE);
        assert!(set_mark(&mark, false).unwrap() && !mark.exists());
        fs::remove_dir_all(&root).unwrap();
    }
}
