//! What is not up to date: records that a run would make again, and numbers that are not those of the records. Nothing of it is published
//! or exported as if it were.

use diagnostics::{Diagnostic, Result};
use workflow::runner::{Goal, Runner};
use workflow::subject::Universe;

use crate::metrics_file;

/// Every record in the store that a run for the goal would not keep, with the reason.
///
/// # Errors
/// A [`Diagnostic`] when the goal is unknown.
pub fn records<U: Universe>(runner: &Runner<U>, goal: &Goal) -> Result<Vec<String>> {
    let records = runner.outdated(goal)?;
    Ok(records.iter().map(|record| format!("{}: {}", record.id, record.reason)).collect())
}

/// The same of the whole project, and the file of the numbers where it is not of the records that a run would keep.
///
/// # Errors
/// A [`Diagnostic`] when the expectations cannot be read.
pub fn records_and_numbers<U: Universe>(runner: &Runner<U>) -> Result<Vec<String>> {
    let mut outdated = records(runner, &Goal::default())?;
    if !metrics_file::is_current(runner)? {
        let path = runner.folders.display(&runner.folders.metrics());
        outdated.push(format!("{path}: it does not hold the numbers of the records"));
    }
    Ok(outdated)
}

/// Holds that nothing is out of date, before it is used for `what`.
///
/// # Errors
/// A [`Diagnostic`] that counts what is out of date and names the first with its reason.
pub fn refuse(what: &str, outdated: &[String]) -> Result<()> {
    let Some(first) = outdated.first() else { return Ok(()) };
    let further = if outdated.len() > 1 { format!(", and {} more", outdated.len() - 1) } else { String::new() };
    let reason = format!("not everything in the store is up to date: {first}{further}");
    Err(Diagnostic::new(what, reason, "study run, which makes what is stale and keeps the rest"))
}

/// One line with the number and the first; none where all is up to date.
pub fn in_words(outdated: &[String]) -> Option<String> {
    let first = outdated.first()?;
    Some(format!("not up to date: {}, the first {first}; do: study run", outdated.len()))
}
