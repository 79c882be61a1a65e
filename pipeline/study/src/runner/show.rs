//! Showing: figures and tables are laid out of their records into the folders that readers open.
//!
//! Stands on: store, folders. Never knows: what is in a picture.

use std::fs;

use super::Runner;
use super::graph::Job;
use super::manifest::Manifest;
use super::store::write_at_once;
use crate::fault::{Fault, Outcome};

/// Lays a figure's or table's files into its folder unless they lie there already.
///
/// # Errors
/// A [`Fault`] when the folder cannot be written.
pub fn lay_out(runner: &Runner, job: &Job, manifest: &Manifest) -> Outcome<()> {
    let Some(folder) = runner.folders.shown(job.entry.kind) else {
        return Ok(());
    };
    let record = runner.folders.record(&job.id);
    for name in manifest.files.keys() {
        let lay = || {
            let bytes = fs::read(record.join(name))?;
            let place = folder.join(name);
            if fs::read(&place).is_ok_and(|old| old == bytes) { Ok(()) } else { write_at_once(&place, &bytes) }
        };
        lay().map_err(|e: std::io::Error| {
            let what = format!("{} cannot be laid into {}", name, runner.folders.tell(&folder));
            Fault::new(what, e, "free some disk space or mend the folder's permissions")
        })?;
    }
    Ok(())
}
