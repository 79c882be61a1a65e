//! The study: recordings in; tracks, identified materials, validation, figures and tables out.
//!
//! `stages/` holds the pipeline in the order of the data, `figures/` and `tables/` what the paper shows.
//! The study reads `data/raw` alone; the hidden truth of a virtual bench is read by the stage `recovery` only.
//!
//! ```
//! // the stages in the order of the data, each with what becomes what
//! assert!(study::description().lines().next().is_some_and(|line| line.starts_with("mesh")));
//! ```
//!
//! Depends on every tool crate, on `records`, `workflow`, `sysid`, `thrust`, `simulate` and `publish`; never on the virtual bench.

pub mod figures;
pub mod live;
mod page;
mod renamed;
pub mod stages;
pub mod tables;

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result, input};
use publish::check::{Checked, Results};
use publish::expected::Expected;
use publish::{metrics_file, outdated, page_file, paper, paper_files, ro_crate, stand_in};
use records::subject::{Specimen, Study};
use workflow::entry::Entry;
use workflow::ranges::Ranges;
use workflow::runner::{Folders, Goal, Options, RunSummary};
use workflow::settings::{Profile, Schema, Settings};

/// A runner over the study's stages, figures and tables.
pub type Runner = workflow::runner::Runner<Study>;

/// Everything that the study makes: stages in the order of the data, then figures, then tables.
pub const LISTS: &[&[Entry<Study>]] = &[stages::ALL, figures::ALL, tables::ALL];

/// The ranges of the settings, a line a key.
pub const RANGES: &str = include_str!("ranges.toml");

/// Free memory required before a further record is started, GiB: the peak of the largest record.
pub const MIN_FREE_MEMORY: f64 = 2.0;

/// Opens a project: its settings, and the card of each specimen. Cards that cannot be read are returned as diagnostics; the other
/// specimens are not affected.
///
/// # Errors
/// A [`Diagnostic`] when the settings cannot be read or there is no specimen at all.
pub fn open(root: &Path, profile: Profile, options: Options) -> Result<(Runner, Vec<Diagnostic>)> {
    let (runner, unreadable) = open_without_specimens(root, profile, options)?;
    if runner.universe.specimens.is_empty() && unreadable.is_empty() {
        return Err(Diagnostic::new(
            format!("there is no specimen in {}", runner.folders.display(&runner.folders.raw())),
            "no folder there holds a specimen.toml",
            "rig record, or add your own actuator",
        ));
    }
    Ok((runner, unreadable))
}

/// The same of a project that may have no specimen: what was expected of it can be listed.
///
/// # Errors
/// A [`Diagnostic`] when the settings cannot be read.
pub fn open_without_specimens(root: &Path, profile: Profile, options: Options) -> Result<(Runner, Vec<Diagnostic>)> {
    let folders = Folders::new(root, profile);
    let text = input::read_text(&folders.settings(), input::PAGE).map_err(|e| {
        let failure = format!("{} cannot be read", folders.settings().display());
        Diagnostic::new(failure, &e, "run in the project's folder, or name it with --root").caused_by(e)
    })?;
    let settings = settings(&text, profile)?;
    let (specimens, unreadable) = read_specimens(&folders)?;
    Ok((Runner { lists: LISTS, universe: Study { specimens }, settings, profile, folders, options }, unreadable))
}

/// The settings in the text of a `study.toml`, with every number in its range.
///
/// # Errors
/// A [`Diagnostic`] that names file, key and line.
pub fn settings(text: &str, profile: Profile) -> Result<Settings> {
    let names: Vec<&str> = stages::ALL.iter().filter_map(|entry| entry.section).collect();
    let settings = Settings::read(text, profile, Schema { sections: &names, renamed: renamed::RENAMED })?;
    Ranges::parse(RANGES).check(text).map(|()| settings)
}

/// Holds that the card of a specimen that was asked for could be read: its own diagnostic says more than that there is no specimen.
///
/// # Errors
/// The [`Diagnostic`] of its card.
pub fn readable(diagnostics: &[Diagnostic], specimen: Option<&str>) -> Result<()> {
    let folder = |d: &Diagnostic| Some(d.location.as_ref()?.file.parent()?.file_name()?.to_owned());
    let card_diagnostic =
        diagnostics.iter().find(|d| specimen.is_some_and(|name| folder(d).is_some_and(|folder| folder == name)));
    card_diagnostic.map_or(Ok(()), |diagnostic| Err(diagnostic.clone()))
}

/// Makes every stale record that the goal needs, then the numbers, the archive's description and the page.
///
/// # Errors
/// A [`Diagnostic`] when the goal is unknown or a file cannot be written.
pub fn run(runner: &Runner, goal: &Goal, fresh: bool) -> Result<RunSummary> {
    runner.run(goal, fresh, &|runner| metrics_file::write(runner).and_then(|()| ro_crate::write(runner)))
}

/// Writes the numbers, the archive's description and the page of the records that are up to date; returns the page's path.
///
/// # Errors
/// A [`Diagnostic`] when a record that the goal needs is in the store and not up to date, or when a file cannot be written.
pub fn publish(runner: &Runner, goal: &Goal) -> Result<PathBuf> {
    outdated::refuse("nothing is published", &outdated::records(runner, goal)?)?;
    runner.publish(&|runner| metrics_file::write(runner).and_then(|()| ro_crate::write(runner)))?;
    page(runner)
}

/// Compares the numbers of the last run with expectations and claims, and the records with their present inputs.
///
/// # Errors
/// A [`Diagnostic`] when a file of `paper/` is not understood.
pub fn check(runner: &Runner) -> Result<Checked> {
    let expected = &Expected::read(&runner.folders.expected(), runner.profile)?;
    let metrics = metrics_file::read_or_none(runner)?.into_iter().map(|m| expected.judge(m.metric));
    let problems = paper_files::resolve(runner)?.err().unwrap_or_default();
    let claims = stand_in::read(&runner.folders.claims(), runner.profile)?;
    let outdated = outdated::records_and_numbers(runner)?;
    publish::check::check(&Results {
        metrics: &metrics.collect::<Vec<_>>(),
        expected,
        claims: &claims,
        problems: &problems,
        outdated: &outdated,
    })
}

/// What is not up to date in the project, a line each with the reason.
///
/// # Errors
/// A [`Diagnostic`] when the expectations cannot be read.
pub fn outdated(runner: &Runner) -> Result<Vec<String>> {
    outdated::records_and_numbers(runner)
}

/// Writes the page that shows everything; returns its path.
///
/// # Errors
/// A [`Diagnostic`] when it cannot be written or a record is damaged.
pub fn page(runner: &Runner) -> Result<PathBuf> {
    page_file::write(runner, page::page_contents(runner)?)
}

/// The stages as a drawing (SVG) of what reads what, with how many records of each a run would keep and make.
///
/// # Errors
/// A [`Diagnostic`] when the goal is unknown or the graph cannot be drawn.
pub fn plan_svg(runner: &Runner, goal: &Goal) -> Result<String> {
    let shares = runner.shares(goal)?;
    page_file::drawn(&runner.stage_graph(), &|name: &str| Some(shares.get(name)?.in_words()))
}

/// Puts every number, verdict, figure and table of the last run into the paper's source for the typesetter; returns its path.
///
/// # Errors
/// A [`Diagnostic`] with every problem, when the source names a missing item or omits an existing one.
pub fn paper(runner: &Runner) -> Result<PathBuf> {
    paper_files::write(runner)
}

/// The paper's source in the project at `root`, with the names that it may use; nothing needs to have been computed.
///
/// # Errors
/// A [`Diagnostic`] when a file of the project cannot be read.
pub fn paper_source(root: &Path) -> Result<(Vec<paper::Page>, paper::Facts)> {
    paper_files::unresolved(&Folders::new(root, Profile::Quick), LISTS)
}

/// The results on the front page of the project at `root`, and as the tracked numbers give them; nothing where it has no place for them.
///
/// # Errors
/// A [`Diagnostic`] when a file of the project cannot be read.
pub fn front_page_results(root: &Path) -> Result<Option<[String; 2]>> {
    paper_files::front_page_results(&Folders::new(root, Profile::Paper), LISTS)
}

/// The list of stages, figures and tables, a line each.
pub fn description() -> String {
    let line = |entry: &Entry<Study>| format!("{:<18} {}\n", entry.name, entry.description);
    LISTS.iter().flat_map(|list| list.iter()).map(line).collect()
}

fn read_specimens(folders: &Folders) -> Result<(Vec<Specimen>, Vec<Diagnostic>)> {
    let (raw, mut specimens, mut unreadable) = (folders.raw(), Vec::new(), Vec::new());
    let cards = if raw.exists() { lab::folder::list(&raw)? } else { Vec::new() };
    for folder in &cards {
        match lab::Specimen::open(folder) {
            Ok(specimen) => specimens.push(Specimen { card: specimen.card.into() }),
            Err(diagnostic) => unreadable.push(diagnostic),
        }
    }
    Ok((specimens, unreadable))
}

#[cfg(test)]
mod tests {
    use super::*;
    use workflow::stage_graph::StageGraph;

    fn study() -> Study {
        let card = lab::card::parse(include_str!("../tests/card.toml"), Path::new("card.toml")).unwrap();
        Study { specimens: vec![Specimen { card: card.into() }] }
    }

    #[test]
    fn no_two_entries_make_the_same_record() {
        let study = study();
        let entries = LISTS.iter().flat_map(|list| list.iter());
        let mut ids: Vec<(&str, String)> =
            entries.flat_map(|e| (e.subjects)(&study).into_iter().map(|subject| (e.name, subject))).collect();
        let all = ids.len();
        ids.sort();
        ids.dedup();
        assert_eq!(ids.len(), all);
    }

    #[test]
    fn every_stage_reads_only_what_comes_before_it() {
        let graph = StageGraph::of(&study(), stages::ALL);
        assert!(graph.nodes.iter().enumerate().all(|(i, node)| node.reads.iter().all(|&r| r < i)), "{graph:?}");
        let stage = |name: &str| graph.nodes.iter().position(|r| r.name == name);
        let identify = stage("identify").unwrap();
        assert!(graph.nodes[identify].reads.contains(&stage("mesh").unwrap()));
    }
}
