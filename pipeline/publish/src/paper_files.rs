//! The paper's files: the source is read, resolved by [`crate::paper`], and written beside the records for a typesetter. The paper profile takes its
//! numbers from `paper/numbers.csv`, which is written anew where there are records.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::claims;
use crate::claims_file;
use crate::expected::Expected;
use crate::expected::MetricEntry;
use crate::metrics_file;
use crate::numbers_file::{self, Numbers};
use crate::outdated;
use crate::paper::{self, Facts, Made, Origin, Page, Problem};
use crate::real_tables;
use crate::results_file;
use diagnostics::{Diagnostic, Result, input};
use workflow::entry::{Entry, Kind};
use workflow::runner::write_atomically;
use workflow::runner::{Folders, Runner};
use workflow::settings::Profile;
use workflow::subject::Universe;

/// Figures and tables of specimens drawn at random, by `just calibration`.
const OF_A_POPULATION: [&str; 2] = ["calibration", "coverage"];
/// Figures that no stage of the profile makes and the paper shows: those of real recordings, by `just real`.
const MADE_ELSEWHERE: [&str; 3] = ["real_beam", "real_arm", "real_scoreboard"];

/// Figures that stand on the front page, and need not be shown in the paper.
const OF_THE_FRONT_PAGE: [&str; 1] = ["inflation"];

/// The resolved source, or its problems.
///
/// # Errors
/// A [`Diagnostic`] when a file of the project cannot be read.
pub fn resolve<U: Universe>(runner: &Runner<U>) -> Result<Result<Vec<Page>, Vec<Problem>>> {
    let computed = metrics_file::read_or_none(runner)?;
    let facts = paper_facts(&runner.folders, runner.lists, runner.profile, computed)?;
    Ok(paper::resolve(&source_pages(&runner.folders.paper_source())?, &facts))
}

/// The source, and the names that it may use before anything was computed, for tests.
///
/// # Errors
/// A [`Diagnostic`] when a file of the project cannot be read.
pub fn unresolved<U: Universe>(folders: &Folders, lists: &[&[Entry<U>]]) -> Result<(Vec<Page>, Facts)> {
    Ok((source_pages(&folders.paper_source())?, paper_facts(folders, lists, Profile::Quick, Vec::new())?))
}

/// Writes the resolved source atomically and returns its path.
///
/// # Errors
/// A [`Diagnostic`] with every problem of the source, when a record is not up to date, or when a file cannot be read or written.
pub fn write<U: Universe>(runner: &Runner<U>) -> Result<PathBuf> {
    if runner.profile != Profile::Paper {
        metrics_file::read(runner)?;
    }
    outdated::refuse("the paper cannot be built", &outdated::records_and_numbers(runner)?)?;
    let diagnostic = |problems: Vec<Problem>| {
        let defect = format!("the paper cannot be built: {} problems", problems.len());
        let reason = problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("\n       ");
        Diagnostic::new(defect, reason, "correct the lines named, or make what is missing with study run")
    };
    let facts = tracked_facts(runner)?;
    if runner.profile == Profile::Paper {
        results_file::write(&runner.folders.paper_source(), &facts)?;
        claims_file::write(&runner.folders.paper_source(), &facts)?;
    }
    let pages = source_pages(&runner.folders.paper_source())?;
    let resolved = paper::resolve(&pages, &facts).map_err(diagnostic)?;
    let folder_of_paper = runner.folders.paper_in_place();
    let references = read_source(&runner.folders.paper_source().join("refs.bib"))?;
    let pages = resolved.into_iter().chain([Page { name: "refs.bib".into(), text: references }]);
    for page in pages {
        let path = page.name.split('/').fold(folder_of_paper.clone(), |path, part| path.join(part));
        let folder = path.parent().unwrap_or(&folder_of_paper);
        let written = fs::create_dir_all(folder).and_then(|()| write_atomically(&path, page.text.as_bytes()));
        written.map_err(|e| {
            Diagnostic::new(format!("{} cannot be written", runner.folders.display(&path)), e, "free some disk space")
        })?;
    }
    Ok(folder_of_paper)
}

/// The facts of a paper that is written: of the paper profile with the numbers that are tracked, where there are records those of the records.
fn tracked_facts<U: Universe>(runner: &Runner<U>) -> Result<Facts> {
    let (folders, computed) = (&runner.folders, metrics_file::read_or_none(runner)?);
    let has_records = !computed.is_empty();
    let facts = paper_facts(folders, runner.lists, runner.profile, computed)?;
    if runner.profile != Profile::Paper {
        return Ok(facts);
    }
    if has_records {
        numbers_file::write(&folders.paper_source(), &facts.metrics, &named_numbers(folders)?)?;
    }
    Ok(Facts { strict: has_records, ..with_tracked_numbers(folders, facts)? })
}

/// The facts with the numbers that are tracked.
fn with_tracked_numbers(folders: &Folders, facts: Facts) -> Result<Facts> {
    let expected = Expected::read(&folders.expected(), Profile::Paper)?;
    let Numbers { entries, sources } = numbers_file::read(&folders.paper_source(), &expected)?;
    let metrics = entries.into_iter().chain(real_numbers(folders, &expected)?).collect();
    Ok(Facts { metrics, origin: Origin::Tracked(sources), ..facts })
}

/// The results as they stand on the project's front page, and as the tracked numbers give them, for tests; nothing where it has no place for them.
///
/// # Errors
/// A [`Diagnostic`] when a file of the project cannot be read.
pub fn front_page_results<U: Universe>(folders: &Folders, lists: &[&[Entry<U>]]) -> Result<Option<[String; 2]>> {
    let facts = with_tracked_numbers(folders, paper_facts(folders, lists, Profile::Paper, Vec::new())?)?;
    results_file::compared(&folders.paper_source(), &facts)
}

/// The numbers that the text and the claims may name.
fn named_numbers(folders: &Folders) -> Result<BTreeSet<String>> {
    let (expected, claims) = (Expected::read(&folders.expected(), Profile::Paper)?, claims::read(&folders.claims())?);
    let claim_metrics = claims.iter().flat_map(|claim| claim.metrics().chain(claim.others())).cloned();
    let results = results_file::named(&folders.paper_source())?;
    Ok(expected.named().iter().cloned().chain(claim_metrics).chain(results).collect())
}

fn real_numbers(folders: &Folders, expected: &Expected) -> Result<Vec<MetricEntry>> {
    let numbers = real_tables::read(&folders.paper_source().join("tables"))?;
    Ok(numbers.into_iter().map(|number| expected.judge(number)).collect())
}

/// Every page of typst in the folder and in `sections`, by name.
fn source_pages(folder: &Path) -> Result<Vec<Page>> {
    let mut pages = Vec::new();
    for (subfolder, prefix) in [(folder.to_path_buf(), ""), (folder.join("sections"), "sections/")] {
        for name in file_names(&subfolder)?.into_iter().filter(|name| name.ends_with(".typ")) {
            pages.push(Page { text: read_source(&subfolder.join(&name))?, name: format!("{prefix}{name}") });
        }
    }
    Ok(pages)
}

fn paper_facts<U: Universe>(
    folders: &Folders,
    lists: &[&[Entry<U>]],
    profile: Profile,
    metrics: Vec<MetricEntry>,
) -> Result<Facts> {
    let expected = Expected::read(&folders.expected(), profile)?;
    let claims = claims::read(&folders.claims())?;
    let made_entries = |kind: Kind, suffix: &str| -> Vec<Made> {
        let is_of_paper = |entry: &&Entry<U>| entry.kind == kind && !OF_THE_FRONT_PAGE.contains(&entry.name);
        let entries = lists.iter().flat_map(|list| list.iter()).filter(is_of_paper);
        let text = |entry: &Entry<U>| {
            input::read_text(&folders.shown(kind)?.join(format!("{}.{suffix}", entry.name)), input::LOG).ok()
        };
        let elsewhere = |entry: &Entry<U>| OF_A_POPULATION.contains(&entry.name);
        entries.map(|entry| Made { name: entry.name.into(), text: text(entry), elsewhere: elsewhere(entry) }).collect()
    };
    let real_figures = MADE_ELSEWHERE.map(|name| {
        let path = folders.shown(Kind::Figure).map(|shown| shown.join(format!("{name}.svg")));
        Made {
            name: name.into(),
            text: path.and_then(|path| input::read_text(&path, input::LOG).ok()),
            elsewhere: true,
        }
    });
    Ok(Facts {
        known: named_numbers(folders)?,
        metrics: metrics.into_iter().chain(real_numbers(folders, &expected)?).collect(),
        claims,
        figures: made_entries(Kind::Figure, "svg").into_iter().chain(real_figures).collect(),
        tables: made_entries(Kind::Table, "csv"),
        cited: paper::cited_keys(&read_source(&folders.paper_source().join("refs.bib"))?),
        tests: Some(folders.crates())
            .filter(|crates| crates.exists())
            .map(|crates| tests_in_folder(&crates))
            .transpose()?,
        strict: profile == Profile::Paper,
        origin: Origin::OtherProfile,
    })
}

/// The names of all tests in the Rust sources below a folder.
fn tests_in_folder(folder: &Path) -> Result<BTreeSet<String>> {
    let mut tests = BTreeSet::new();
    for name in file_names(folder)? {
        let path = folder.join(&name);
        if path.is_dir() {
            tests.extend(tests_in_folder(&path)?);
        } else if name.ends_with(".rs") {
            tests.extend(paper::test_names(&read_source(&path)?));
        }
    }
    Ok(tests)
}

/// In alphabetical order.
fn file_names(folder: &Path) -> Result<Vec<String>> {
    let entries = fs::read_dir(folder).map_err(|e| read_error(folder, &e))?;
    let mut names: Vec<String> = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    Ok(names)
}

fn read_source(path: &Path) -> Result<String> {
    input::read_text(path, input::LOG).map_err(|e| read_error(path, &e))
}

fn read_error(path: &Path, error: &std::io::Error) -> Diagnostic {
    Diagnostic::new(
        format!("{} cannot be read", path.display()),
        error,
        "run in the project's folder, or name it with --root",
    )
}
