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
mod side;
mod solid;
mod space;
mod stamps;

use std::fmt;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

pub use finding::Finding;

use diagnostics::{Diagnostic, Result};
use finding::{Severity, all_findings};
use records::subject::{Specimen, Trial};
use study::Runner;
use study::stages;
use workflow::runner::Folders;
use workflow::settings::Settings;

/// The project whose recordings are checked: its folders and settings.
struct Project<'a> {
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
        self.findings.iter().all(|finding| !finding.must_fix())
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
    let project = Project { folders: &runner.folders, settings: &runner.settings };
    let folders = lab::folder::list(&runner.folders.raw())?;
    let is_chosen = |folder: &&PathBuf| name.is_none_or(|name| folder_name(folder) == name);
    let chosen: Vec<&PathBuf> = folders.iter().filter(is_chosen).collect();
    if chosen.is_empty() {
        let names: Vec<String> = folders.iter().map(|folder| folder_name(folder)).collect();
        let defect = format!("there is no specimen `{}`", name.unwrap_or_default());
        return Err(Diagnostic::new(
            defect,
            format!("there are: {}", names.join(", ")),
            "correct the name, or study init it",
        ));
    }
    let mut evaluated = Evaluated::default();
    for folder in chosen {
        project.check_specimen(folder, &mut evaluated)?;
    }
    evaluated.findings.extend(disk::disk_finding(&project));
    Ok(evaluated)
}

fn folder_name(folder: &Path) -> String {
    folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

impl Project<'_> {
    /// The findings on one specimen.
    fn check_specimen(&self, folder: &Path, evaluated: &mut Evaluated) -> Result<()> {
        evaluated.specimens.push(folder_name(folder));
        let (opened, card_findings) = card::card_findings(self, folder);
        evaluated.findings.extend(card_findings);
        let Some(opened) = opened else { return Ok(()) };
        let specimen = Specimen { card: opened.card.into() };
        let (camera, board_findings) = board::board_findings(self, &specimen);
        evaluated.findings.extend(all_findings([
            solid::surface_findings(self, &specimen)?,
            board_findings,
            log::fixture_findings(self, &specimen)?,
        ]));
        let trials = specimen.trials();
        evaluated.trials += trials.len();
        let trial_findings: Result<Vec<Vec<Finding>>> =
            trials.par_iter().map(|trial| self.check_trial(trial, camera.as_ref())).collect();
        evaluated.findings.extend(all_findings(trial_findings?));
        Ok(())
    }

    /// Film, logs and clocks of one trial; clocks where both can be read.
    fn check_trial(&self, subject: &Trial, camera: Option<&board::RoughCamera>) -> Result<Vec<Finding>> {
        let track = self.settings.section::<stages::track::Settings>("track")?;
        let clocks = self.settings.section::<stages::clock::Settings>("clock")?;
        let (log, log_findings) = log::pressure_log(self, subject);
        let (decoded, film_findings) = film::film_findings(self, subject, &track, camera);
        let (filmed_motion, clock_findings) = match (&log, &decoded) {
            (Some(_), Some(decoded)) => clock::clock_findings(self, subject, decoded, &clocks),
            _ => (None, Vec::new()),
        };
        let (space_motion, space_findings) = space::space_findings(self, subject, (log.is_some(), decoded.as_ref()))?;
        let force_findings = log::force_findings(self, subject);
        let mut findings = all_findings([log_findings, force_findings, film_findings, space_findings, clock_findings]);
        // what is wrong with a log has been reported with its line
        if let (Some(motion), true) = (filmed_motion.or(space_motion), findings.iter().all(|f| !f.must_fix())) {
            findings.extend(log::corrected_force_finding(self, subject, motion)?);
        }
        Ok(findings)
    }

    /// The path of a specimen's file relative to the project's folder.
    fn display_path(&self, specimen: &str, file: &str) -> String {
        self.folders.display(&self.folders.raw_file(&format!("{specimen}/{file}")))
    }

    /// The path of a specimen's file.
    fn file_path(&self, specimen: &str, file: &str) -> PathBuf {
        self.folders.raw_file(&format!("{specimen}/{file}"))
    }
}
