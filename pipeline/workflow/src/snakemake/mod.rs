//! The study as a workflow for Snakemake: one rule a stage, figure or table, and jobs that make one record each.
//!
//! A job is `study make`, so that records lie in the same store and are the same to the byte as those of `study run`. Snakemake decides by
//! dates what may be stale and runs a job for it; the store decides by content, and keeps a record whose inputs have not changed.
//! Resources are those that were measured where records exist.

mod profiles;
mod resources;
mod rules;

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::runner::{Folders, Goal, Job, Runner, write_atomically};
use crate::subject::Universe;
use diagnostics::{Diagnostic, Result};

/// What is exported, and where to.
#[derive(Debug, Clone)]
pub struct Export {
    /// Its folder; without one, `workflow` among the profile's folders.
    pub folder: Option<PathBuf>,
    /// The program whose `make` makes a record.
    pub program: PathBuf,
    /// The file in a group's folder of recordings that describes it.
    pub card: &'static str,
    /// What is to be made.
    pub goal: Goal,
}

/// Writes the workflow, and profiles for one machine and for Slurm; returns its folder.
///
/// # Errors
/// A [`Diagnostic`] when the goal is unknown, the inputs of a record cannot be determined, or a file cannot be written.
pub fn export<U: Universe>(runner: &Runner<U>, export: &Export) -> Result<PathBuf> {
    let jobs = runner.jobs_of(&export.goal)?;
    let folder = export.folder.clone().unwrap_or_else(|| runner.folders.base().join("workflow"));
    let paths = Paths::of(&runner.folders, &folder, &export.program)?;
    let records = records(runner, &jobs, export)?;
    write_workflow(&folder, [("Snakefile", &rules::snakefile(runner, &jobs, &paths)), ("records.json", &records)])?;
    Ok(folder)
}

/// Writes the files of a workflow into `folder`, and the profiles for one machine and for Slurm beside them.
///
/// # Errors
/// A [`Diagnostic`] when a file cannot be written.
pub fn write_workflow(folder: &Path, files: [(&str, &str); 2]) -> Result<()> {
    for (name, text) in files.into_iter().chain(profiles::ALL) {
        let path = folder.join(name);
        let action = "choose another folder or correct its permissions";
        write_atomically(&path, text.as_bytes()).map_err(|e| Diagnostic::io(&path, e, action))?;
    }
    Ok(())
}

/// The places that a Snakefile names.
struct Paths {
    /// The profile's folders, from the workflow's folder where they lie around it.
    base: String,
    /// The project's folder, in the same way.
    project: String,
    /// The program, from the project's folder where it lies inside.
    program: String,
}

impl Paths {
    fn of(folders: &Folders, workflow: &Path, program: &Path) -> Result<Self> {
        std::fs::create_dir_all(workflow).map_err(|e| Diagnostic::io(workflow, e, "choose another folder"))?;
        let whole = |path: &Path| path.canonicalize().map_err(|e| Diagnostic::io(path, e, "report it"));
        let (workflow, base, project) = (whole(workflow)?, whole(folders.base())?, whole(folders.project())?);
        let program = program.canonicalize().unwrap_or_else(|_| program.to_owned());
        let inside = program.strip_prefix(&project).unwrap_or(&program);
        Ok(Self {
            base: path_to(&base, &workflow),
            project: path_to(&project, &workflow),
            program: inside.display().to_string(),
        })
    }
}

/// The path to the folder `outer` from `inner`; its whole path where `inner` lies elsewhere.
pub fn path_to(outer: &Path, inner: &Path) -> String {
    match inner.strip_prefix(outer) {
        Ok(below) if below.as_os_str().is_empty() => ".".into(),
        Ok(below) => vec![".."; below.components().count()].join("/"),
        Err(_) => outer.display().to_string(),
    }
}

/// Of each record: its manifest, the recordings, settings and cards that it reads, and the records that it reads.
fn records<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>], export: &Export) -> Result<String> {
    let mut all = Map::new();
    for job in jobs {
        let inputs = job.inputs.as_ref().map_err(|diagnostic| diagnostic.clone().of(&job.id))?;
        let present = inputs.raw.iter().filter(|file| !file.optional || runner.folders.raw_file(&file.path).exists());
        let raw = present.map(|file| below(&runner.folders, &runner.folders.raw_file(&file.path)));
        let settings = std::iter::once(json!("settings")).filter(|_| !inputs.settings.is_null());
        let cards = cards(runner, job, export.card).into_iter().filter(|_| !inputs.card.is_null());
        let files: Vec<Value> = settings.chain(raw.chain(cards).map(Value::from)).collect();
        let reads: Vec<String> = inputs.records.iter().map(ToString::to_string).collect();
        let manifest = below(&runner.folders, &runner.folders.manifest(&job.id));
        all.insert(job.id.to_string(), json!({ "manifest": manifest, "files": files, "records": reads }));
    }
    Ok(serde_json::to_string_pretty(&all)? + "\n")
}

/// The cards of a record's group; of the whole project, all of them.
fn cards<U: Universe>(runner: &Runner<U>, job: &Job<U>, card: &str) -> Vec<String> {
    let mut groups = runner.universe.groups();
    let own = job.id.subject.split('/').next().unwrap_or_default();
    if groups.iter().any(|group| group == own) {
        groups.retain(|group| group == own);
    }
    groups.iter().map(|group| below(&runner.folders, &runner.folders.raw_file(&format!("{group}/{card}")))).collect()
}

/// A path below the profile's folders, with `/` between them.
fn below(folders: &Folders, path: &Path) -> String {
    let path = path.strip_prefix(folders.base()).unwrap_or(path);
    path.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Whole, job, runner};

    #[test]
    fn a_folder_is_reached_from_inside_by_its_parents_and_from_elsewhere_by_its_path() {
        let reached = |inner: &str, outer: &str| path_to(Path::new(outer), Path::new(inner));
        assert_eq!(reached("/p/target/quick/workflow", "/p"), "../../..");
        assert_eq!(reached("/p", "/p"), ".");
        assert_eq!(reached("/elsewhere", "/p"), "/p");
    }

    /// The table of records of these jobs, in a project whose group `a` has the recording `a/lit.csv`.
    fn table(jobs: &[Job<Whole>]) -> Value {
        let root = std::env::temp_dir().join(format!("records-{}-{}", std::process::id(), jobs.len()));
        let runner = runner(&root);
        let lit = runner.folders.raw_file("a/lit.csv");
        std::fs::create_dir_all(lit.parent().unwrap()).unwrap();
        std::fs::write(&lit, "1").unwrap();
        let export = Export { folder: None, program: "study".into(), card: "card.toml", goal: Goal::default() };
        let text = records(&runner, jobs, &export).unwrap();
        std::fs::remove_dir_all(&root).unwrap();
        serde_json::from_str(&text).unwrap()
    }

    #[test]
    fn a_record_s_files_are_what_it_needs_what_is_there_of_the_rest_and_its_own_card() {
        let raw = [("a/needed.csv", false), ("a/lit.csv", true), ("a/absent.csv", true)];
        let table = table(&[job("a", &raw, &[])]);
        let files = json!(["settings", "data/raw/a/needed.csv", "data/raw/a/lit.csv", "data/raw/a/card.toml"]);
        assert_eq!(table["nothing/a"]["files"], files);
    }

    #[test]
    fn a_record_of_the_whole_project_reads_the_cards_of_all_groups() {
        let table = table(&[job("b/first", &[], &[]), job("all", &[], &["b/first"])]);
        assert_eq!(table["nothing/b/first"]["files"], json!(["data/raw/b/card.toml"]));
        assert_eq!(table["nothing/all"]["files"], json!(["data/raw/a/card.toml", "data/raw/b/card.toml"]));
        assert_eq!(table["nothing/all"]["records"], json!(["nothing/b/first"]));
    }
}
