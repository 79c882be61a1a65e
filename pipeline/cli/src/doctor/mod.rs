//! `study doctor`: checks of recordings before anything is computed.
//!
//! The readers of `lab` and the first steps of the stages report what they would refuse; further checks find input that is
//! valid but probably not intended: a log in another unit, swapped columns of the sides, a film too dark or too short.

mod board;
mod card;
mod clock;
mod disk;
mod film;
mod finding;
mod log;
mod rest;
mod sense;
mod solid;
mod space;
mod stamps;

use std::fmt;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

pub use finding::Finding;

use diagnostics::{Diagnostic, Result};
use finding::{Severity, findings};
use study::Runner;
use study::stages;
use study::subject::{Specimen, Trial};
use workflow::runner::Folders;
use workflow::settings::Settings;

/// Data shared by all checks of a specimen.
struct Look<'a> {
    folders: &'a Folders,
    settings: &'a Settings,
}

/// The checked specimens and the findings.
#[derive(Debug, Default)]
pub struct Evaluated {
    /// Names of the specimens.
    pub specimens: Vec<String>,
    /// Trials on their cards.
    pub trials: usize,
    /// In the order of the specimens, of their cards within each.
    pub findings: Vec<Finding>,
}

impl Evaluated {
    /// Whether nothing must be fixed.
    pub fn is_well(&self) -> bool {
        self.findings.iter().all(|finding| !finding.must())
    }
}

impl fmt::Display for Evaluated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.findings.iter().try_for_each(|finding| writeln!(f, "{finding}"))?;
        let count = |severity| self.findings.iter().filter(|finding| finding.severity == severity).count();
        let (must, notes) = (count(Severity::Fix), count(Severity::Note));
        let (names, trials) = (self.specimens.join(", "), self.trials);
        writeln!(f, "{names}: {trials} trials checked, {must} to fix, {notes} notes")
    }
}

/// Checks one specimen, or all of them.
///
/// # Errors
/// A [`Diagnostic`] when there is no such specimen or the settings of a stage cannot be understood.
pub fn run(runner: &Runner, name: Option<&str>) -> Result<Evaluated> {
    let look = Look { folders: &runner.folders, settings: &runner.settings };
    let all = lab::folder::list(&runner.folders.raw())?;
    let named = |folder: &&PathBuf| name.is_none_or(|name| called(folder) == name);
    let chosen: Vec<&PathBuf> = all.iter().filter(named).collect();
    if chosen.is_empty() {
        let there: Vec<String> = all.iter().map(|folder| called(folder)).collect();
        let what = format!("there is no specimen `{}`", name.unwrap_or_default());
        return Err(Diagnostic::new(
            what,
            format!("there are: {}", there.join(", ")),
            "correct the name, or study init it",
        ));
    }
    let mut evaluated = Evaluated::default();
    for folder in chosen {
        look.specimen(folder, &mut evaluated)?;
    }
    evaluated.findings.extend(disk::look(&look));
    Ok(evaluated)
}

fn called(folder: &Path) -> String {
    folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

impl Look<'_> {
    /// The findings on one specimen.
    fn specimen(&self, folder: &Path, evaluated: &mut Evaluated) -> Result<()> {
        evaluated.specimens.push(called(folder));
        let (opened, found) = card::look(self, folder);
        evaluated.findings.extend(found);
        let Some(opened) = opened else { return Ok(()) };
        let of = Specimen { card: opened.card.into() };
        let (camera, of_board) = board::look(self, &of);
        evaluated.findings.extend(findings([solid::look(self, &of)?, of_board, log::fixtures(self, &of)?]));
        let trials = of.trials();
        evaluated.trials += trials.len();
        let each: Result<Vec<Vec<Finding>>> =
            trials.par_iter().map(|trial| self.trial(trial, camera.as_ref())).collect();
        evaluated.findings.extend(findings(each?));
        Ok(())
    }

    /// Film, logs and clocks of one trial; clocks where both can be read.
    fn trial(&self, of: &Trial, camera: Option<&board::RoughCamera>) -> Result<Vec<Finding>> {
        let track = self.settings.section::<stages::track::Settings>("track")?;
        let clocks = self.settings.section::<stages::clock::Settings>("clock")?;
        let (log, of_log) = log::pressure(self, of);
        let (seen, of_film) = film::trial(self, of, &track, camera);
        let of_clock = match (&log, &seen) {
            (Some(_), Some(seen)) => clock::look(self, of, seen, &clocks),
            _ => Vec::new(),
        };
        let of_space = space::look(self, of, log.is_some())?;
        Ok(findings([of_log, log::force(self, of), of_film, of_space, of_clock]))
    }

    /// The path of a specimen's file relative to the project's folder.
    fn place(&self, specimen: &str, file: &str) -> String {
        self.folders.display(&self.folders.raw_file(&format!("{specimen}/{file}")))
    }

    /// The path of a specimen's file.
    fn path(&self, specimen: &str, file: &str) -> PathBuf {
        self.folders.raw_file(&format!("{specimen}/{file}"))
    }
}
