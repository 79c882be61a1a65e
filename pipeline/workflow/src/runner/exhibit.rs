//! Copies of figures and tables from their records into the folders for readers.

use super::Runner;
use super::atomic::write_atomically;
use super::graph::Job;
use super::manifest::Manifest;
use crate::subject::Universe;
use diagnostics::{Diagnostic, Result, input};

/// Copies a figure's or table's files into its folder unless they are there already.
///
/// # Errors
/// A [`Diagnostic`] when the folder cannot be written.
pub(crate) fn copy_exhibit<U: Universe>(runner: &Runner<U>, job: &Job<U>, manifest: &Manifest) -> Result<()> {
    let Some(folder) = runner.folders.shown(job.entry.kind) else {
        return Ok(());
    };
    let record = runner.folders.record(&job.id);
    for name in manifest.files.keys() {
        let lay = || {
            let bytes = input::read(&record.join(name), input::MESH)?;
            let path = folder.join(name);
            if input::read(&path, input::MESH).is_ok_and(|old| old == bytes) {
                Ok(())
            } else {
                write_atomically(&path, &bytes)
            }
        };
        lay().map_err(|e: std::io::Error| {
            let problem = format!("{} cannot be written to {}", name, runner.folders.display(&folder));
            Diagnostic::new(problem, e, "free some disk space or correct the folder's permissions")
        })?;
    }
    Ok(())
}
