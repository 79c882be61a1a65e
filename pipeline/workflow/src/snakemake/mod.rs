//! The study as a workflow for Snakemake: one rule a stage, figure or table, and jobs that make one record each.
//!
//! A job is `study make`, so that records lie in the same store and are the same to the byte as those of `study run`. What is left to do
//! is decided by the store's plan, by content, and not by Snakemake's dates: each time that the workflow begins, it has the `marks` of
//! records set anew. Files of the project as inputs of rules were the alternative. They start every job of a stage when a comment of
//! `study.toml` changes, and `update()` of a manifest gives it a new date although its job was killed, so that nothing is left to do.
//!
//! Nothing from outside is interpolated into the Snakefile: places and names are read from JSON, and quoted where a shell sees them.
//! Resources are those that were measured where records exist.

mod marks;
mod profiles;
mod resources;
mod rules;

use std::path::{Path, PathBuf};

use serde_json::json;

use crate::export::{self, ExportedFile, path_as_text};
use crate::runner::{Folders, Goal, Runner};
use crate::subject::Universe;
use diagnostics::{Diagnostic, Result};

pub use marks::update;

/// What is exported, and where to.
#[derive(Debug, Clone)]
pub struct Export {
    /// Its folder; without one, `workflow` among the profile's folders.
    pub folder: Option<PathBuf>,
    /// The program whose `make` makes a record.
    pub program: PathBuf,
    /// What is to be made.
    pub goal: Goal,
}

/// A workflow that was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Workflow {
    /// Its folder.
    pub folder: PathBuf,
    /// Profiles that the user has edited, which were kept.
    pub kept: Vec<PathBuf>,
}

/// Writes the workflow, and profiles for one machine and for Slurm.
///
/// # Errors
/// A [`Diagnostic`] when the goal is unknown, the folder holds what no export wrote, or a file cannot be written.
pub fn export<U: Universe>(runner: &Runner<U>, export: &Export) -> Result<Workflow> {
    let jobs = runner.jobs_of(&export.goal)?;
    let folder = export.folder.clone().unwrap_or_else(|| runner.folders.base().join("workflow"));
    let places = relative_places(&runner.folders, &folder, &export.program)?;
    let places = json!({
        "base": places[0], "project": places[1], "program": places[2],
        "profile": runner.profile.name(), "only": export.goal.entries,
    });
    let snakefile = rules::snakefile(runner, &jobs, export.goal.entries.is_empty());
    let workflow = write_workflow(&folder, [("Snakefile", &snakefile), ("places.json", &as_text(&places)?)])?;
    update(runner, &folder, &export.goal)?;
    Ok(workflow)
}

/// Writes the files of a workflow into `folder`, and the profiles for one machine and for Slurm beside them.
///
/// # Errors
/// As [`export::write`].
pub fn write_workflow(folder: &Path, files: [(&str, &str); 2]) -> Result<Workflow> {
    let exported = files.into_iter().map(|(name, text)| ExportedFile::new(name, text));
    // partition, account and limits of a cluster are written into its profile
    let profiles = profiles::ALL.into_iter().map(|(name, text)| ExportedFile::template(name, text));
    let edited = export::write(folder, &exported.chain(profiles).collect::<Vec<_>>())?;
    Ok(Workflow { folder: folder.to_owned(), kept: edited })
}

/// A value as the text of a file.
///
/// # Errors
/// When it has no form in JSON.
pub fn as_text(value: &serde_json::Value) -> Result<String> {
    Ok(serde_json::to_string_pretty(value)? + "\n")
}

/// The profile's folders and the project's folder from the workflow's folder, where they lie around it; the program from the project's
/// folder, where it lies inside.
fn relative_places(folders: &Folders, workflow: &Path, program: &Path) -> Result<[String; 3]> {
    std::fs::create_dir_all(workflow).map_err(|e| Diagnostic::io(workflow, e, "choose another folder"))?;
    let absolute = |path: &Path| path.canonicalize().map_err(|e| Diagnostic::io(path, e, "report it"));
    let (workflow, base, project) = (absolute(workflow)?, absolute(folders.base())?, absolute(folders.project())?);
    let program = program.canonicalize().unwrap_or_else(|_| program.to_owned());
    let inside = program.strip_prefix(&project).unwrap_or(&program);
    Ok([path_to(&base, &workflow)?, path_to(&project, &workflow)?, path_as_text(inside)?])
}

/// The path to the folder `outer` from `inner`; its whole path where `inner` lies elsewhere.
///
/// # Errors
/// As [`path_as_text`].
pub fn path_to(outer: &Path, inner: &Path) -> Result<String> {
    match inner.strip_prefix(outer) {
        Ok(below) if below.as_os_str().is_empty() => Ok(".".into()),
        Ok(below) => Ok(vec![".."; below.components().count()].join("/")),
        Err(_) => path_as_text(outer),
    }
}

/// A path below the profile's folders, with `/` between them.
fn relative_path(folders: &Folders, path: &Path) -> String {
    let path = path.strip_prefix(folders.base()).unwrap_or(path);
    path.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_reached_from_inside_by_its_parents_and_from_elsewhere_by_its_path() {
        let reached = |inner: &str, outer: &str| path_to(Path::new(outer), Path::new(inner)).unwrap();
        assert_eq!(reached("/p/target/quick/workflow", "/p"), "../../..");
        assert_eq!(reached("/p", "/p"), ".");
        assert_eq!(reached("/elsewhere", "/p"), "/p");
    }
}
