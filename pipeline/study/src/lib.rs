//! The study: recordings in, tracks, identified materials, validation, figures and tables out.
//!
//! `stages/` tells the story in the order of the data; `figures/` and `tables/` show it; the runner makes what is stale. It
//! knows nothing but `data/raw`; the hidden truth of a virtual bench is read by the stage `recovery` alone.
//!
//! `case/` and `simulate/` stand beside that: one body under loads of one's own, without a project.
//!
//! Stands on: every tool crate. Never knows: the virtual bench.

pub mod case;
pub mod certify;
pub mod check;
pub mod claims;
pub mod cli;
pub mod columns;
pub mod doctor;
pub mod entry;
pub mod expected;
pub mod fault;
pub mod figure;
pub mod figures;
pub mod flow;
pub mod follow;
pub mod init;
pub mod metric;
pub mod model;
pub mod needs;
pub mod page;
pub mod paper;
pub mod record;
pub mod records;
pub mod released;
pub mod runner;
pub mod settings;
pub mod simulate;
pub mod stage;
pub mod stages;
pub mod subject;
pub mod table;
pub mod tables;
pub mod thrust;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use check::Checked;
use entry::Entry;
use expected::Expected;
use fault::{Fault, Outcome};
use runner::{Folders, Runner};
use settings::{Profile, Settings};
use subject::{Specimen, Study};

/// Everything that the study makes: stages in the order of the data, then figures, then tables.
pub const LISTS: &[&[Entry]] = &[stages::ALL, figures::ALL, tables::ALL];

/// Memory that stays free before a second record is begun, GiB: what the largest one takes.
pub const SPARE: f64 = 2.0;

/// Opens a project: its settings, and the card of each specimen. Cards that cannot be read are returned as faults; the other
/// specimens are not harmed.
///
/// # Errors
/// A [`Fault`] when the settings cannot be read or there is no specimen at all.
pub fn open(root: &Path, profile: Profile, quiet: bool, jobs: usize) -> Outcome<(Runner, Vec<Fault>)> {
    let folders = Folders::new(root, profile);
    let text = std::fs::read_to_string(folders.settings()).map_err(|e| {
        let what = format!("{} cannot be read", folders.settings().display());
        Fault::new(what, e, "run in the project's folder, or name it with --root")
    })?;
    let names: Vec<&str> = stages::ALL.iter().filter_map(|entry| entry.section).collect();
    let settings = Settings::read(&text, profile, &names)?;
    let (specimens, faults) = specimens(&folders)?;
    let study = Study { specimens };
    let (keep_going, spare) = (false, SPARE);
    Ok((Runner { lists: LISTS, study, settings, profile, folders, quiet, jobs, keep_going, spare }, faults))
}

/// Compares the numbers of the last run with expectations and claims.
///
/// # Errors
/// A [`Fault`] when there has been no run, or a page of `paper/` is not understood.
pub fn check(runner: &Runner) -> Outcome<Checked> {
    let expected = Expected::read(&runner.folders.expected(), runner.profile)?;
    let metrics: Vec<_> = runner::read_metrics(runner)?.into_iter().map(|m| expected.judge(m.metric)).collect();
    let problems = runner::resolve_paper(runner)?.err().unwrap_or_default();
    Ok(check::check(&metrics, &expected, &claims::read(&runner.folders.claims())?, &problems))
}

/// Puts every number, verdict, figure and table of the last run into the paper's source, and lays it where a typesetter
/// finds it; says where.
///
/// # Errors
/// A [`Fault`] with every problem, when the source names something that is not there or leaves out something that is.
pub fn paper(runner: &Runner) -> Outcome<PathBuf> {
    runner::write_paper(runner)
}

/// The paper's source in the project at `root`, and what it may name before anything was computed.
///
/// # Errors
/// A [`Fault`] when a file of the project cannot be read.
pub fn paper_source(root: &Path) -> Outcome<(Vec<paper::Page>, paper::Facts)> {
    runner::unresolved_paper(&Folders::new(root, Profile::Quick), LISTS)
}

/// The list of stages, figures and tables, a line each.
pub fn story() -> String {
    let line = |entry: &Entry| format!("{:<16} {}\n", entry.name, entry.story);
    LISTS.iter().flat_map(|list| list.iter()).map(line).collect()
}

fn specimens(folders: &Folders) -> Outcome<(Vec<Specimen>, Vec<Fault>)> {
    let raw = folders.raw();
    let found = lab::folder::list(&raw).map_err(Fault::from_tool)?;
    let (mut specimens, mut faults) = (Vec::new(), Vec::new());
    for folder in &found {
        match lab::Specimen::open(folder) {
            Ok(specimen) => specimens.push(Specimen { card: Arc::new(specimen.card) }),
            Err(refusal) => faults.push(Fault::from_tool(refusal)),
        }
    }
    if found.is_empty() {
        let what = format!("there is no specimen in {}", folders.tell(&raw));
        return Err(Fault::new(what, "no folder there holds a specimen.toml", "rig record, or add your own actuator"));
    }
    Ok((specimens, faults))
}
