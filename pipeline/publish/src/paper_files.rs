//! The paper's files: the source is read, resolved by [`crate::paper`], and written beside the records for a typesetter.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::claims;
use crate::expected::Expected;
use crate::expected::MetricEntry;
use crate::metrics_file;
use crate::outdated;
use crate::paper::{self, Facts, Made, Page, Problem};
use diagnostics::{Diagnostic, Result, input};
use workflow::entry::{Entry, Kind};
use workflow::runner::write_atomically;
use workflow::runner::{Folders, Runner};
use workflow::settings::Profile;
use workflow::subject::Universe;

/// Figures and tables of specimens drawn at random, by `just calibration`.
const OF_A_POPULATION: [&str; 2] = ["calibration", "coverage"];
/// Figures that no stage of the profile makes and the paper shows: those of real recordings, by `just real`.
const MADE_ELSEWHERE: [&str; 2] = ["real_beam", "real_arm"];

/// The resolved source, or its problems.
///
/// # Errors
/// A [`Diagnostic`] when a file of the project cannot be read.
pub fn resolve<U: Universe>(runner: &Runner<U>) -> Result<Result<Vec<Page>, Vec<Problem>>> {
    let facts = facts(&runner.folders, runner.lists, runner.profile, metrics_file::read_or_none(runner)?)?;
    Ok(paper::resolve(&pages(&runner.folders.paper_source())?, &facts))
}

/// The source, and the names that it may use before anything was computed, for tests.
///
/// # Errors
/// A [`Diagnostic`] when a file of the project cannot be read.
pub fn unresolved<U: Universe>(folders: &Folders, lists: &[&[Entry<U>]]) -> Result<(Vec<Page>, Facts)> {
    Ok((pages(&folders.paper_source())?, facts(folders, lists, Profile::Quick, Vec::new())?))
}

/// Writes the resolved source atomically and returns its path.
///
/// # Errors
/// A [`Diagnostic`] with every problem of the source, when a record is not up to date, or when a file cannot be read or written.
pub fn write<U: Universe>(runner: &Runner<U>) -> Result<PathBuf> {
    metrics_file::read(runner)?;
    outdated::refuse("the paper cannot be built", &outdated::records_and_numbers(runner)?)?;
    let problems = |all: Vec<Problem>| {
        let what = format!("the paper cannot be built: {} problems", all.len());
        let why = all.iter().map(Problem::to_string).collect::<Vec<_>>().join("\n       ");
        Diagnostic::new(what, why, "correct the lines named, or make what is missing with study run")
    };
    let resolved = resolve(runner)?.map_err(problems)?;
    let to = runner.folders.paper_in_place();
    let bib = read(&runner.folders.paper_source().join("refs.bib"))?;
    let all = resolved.into_iter().chain([Page { name: "refs.bib".into(), text: bib }]);
    for page in all {
        let place = page.name.split('/').fold(to.clone(), |path, part| path.join(part));
        let folder = place.parent().unwrap_or(&to);
        let written = fs::create_dir_all(folder).and_then(|()| write_atomically(&place, page.text.as_bytes()));
        written.map_err(|e| {
            Diagnostic::new(format!("{} cannot be written", runner.folders.display(&place)), e, "free some disk space")
        })?;
    }
    Ok(to)
}

/// Every page of typst in the folder and in `sections`, by name.
fn pages(folder: &Path) -> Result<Vec<Page>> {
    let mut all = Vec::new();
    for (place, prefix) in [(folder.to_path_buf(), ""), (folder.join("sections"), "sections/")] {
        for name in names(&place)?.into_iter().filter(|name| name.ends_with(".typ")) {
            all.push(Page { text: read(&place.join(&name))?, name: format!("{prefix}{name}") });
        }
    }
    Ok(all)
}

fn facts<U: Universe>(
    folders: &Folders,
    lists: &[&[Entry<U>]],
    profile: Profile,
    metrics: Vec<MetricEntry>,
) -> Result<Facts> {
    let expected = Expected::read(&folders.expected(), profile)?;
    let claims = claims::read(&folders.claims())?;
    let of_claims = claims.iter().flat_map(|c| c.metrics().chain(c.rule.others())).cloned();
    let made = |kind: Kind, suffix: &str| -> Vec<Made> {
        let entries = lists.iter().flat_map(|list| list.iter()).filter(|entry| entry.kind == kind);
        let text = |entry: &Entry<U>| {
            input::read_text(&folders.shown(kind)?.join(format!("{}.{suffix}", entry.name)), input::LOG).ok()
        };
        let elsewhere = |entry: &Entry<U>| OF_A_POPULATION.contains(&entry.name);
        entries.map(|entry| Made { name: entry.name.into(), text: text(entry), elsewhere: elsewhere(entry) }).collect()
    };
    let real = MADE_ELSEWHERE.map(|name| {
        let place = folders.shown(Kind::Figure).map(|shown| shown.join(format!("{name}.svg")));
        Made {
            name: name.into(),
            text: place.and_then(|place| input::read_text(&place, input::LOG).ok()),
            elsewhere: true,
        }
    });
    Ok(Facts {
        known: expected.named().iter().cloned().chain(of_claims).collect(),
        metrics,
        claims,
        figures: made(Kind::Figure, "svg").into_iter().chain(real).collect(),
        tables: made(Kind::Table, "csv"),
        cited: paper::cited_keys(&read(&folders.paper_source().join("refs.bib"))?),
        tests: Some(folders.crates())
            .filter(|crates| crates.exists())
            .map(|crates| tests_below(&crates))
            .transpose()?,
        strict: profile == Profile::Paper,
    })
}

/// The names of all tests in the Rust sources below a folder.
fn tests_below(folder: &Path) -> Result<BTreeSet<String>> {
    let mut found = BTreeSet::new();
    for name in names(folder)? {
        let place = folder.join(&name);
        if place.is_dir() {
            found.extend(tests_below(&place)?);
        } else if name.ends_with(".rs") {
            found.extend(paper::test_names(&read(&place)?));
        }
    }
    Ok(found)
}

/// In alphabetical order.
fn names(folder: &Path) -> Result<Vec<String>> {
    let entries = fs::read_dir(folder).map_err(|e| unreadable(folder, &e))?;
    let mut names: Vec<String> = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    Ok(names)
}

fn read(place: &Path) -> Result<String> {
    input::read_text(place, input::LOG).map_err(|e| unreadable(place, &e))
}

fn unreadable(place: &Path, error: &std::io::Error) -> Diagnostic {
    Diagnostic::new(
        format!("{} cannot be read", place.display()),
        error,
        "run in the project's folder, or name it with --root",
    )
}
