//! `study doctor`: recordings are looked at before anything is made of them.
//!
//! The readers of `lab` and the first steps of the stages say what they would refuse; beside them stands what a stage would
//! take and a person would not mean: a log in another unit, the sides' columns swapped, a film too dark or too short.
//!
//! Stands on: the stages mesh, camera, track and clock, the readers of `lab`. Never knows: a record.

mod card;
mod clock;
mod disk;
mod film;
mod finding;
mod log;
mod sense;
mod solid;

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

pub use finding::Finding;

use crate::fault::{Fault, Outcome};
use crate::runner::{Folders, Runner};
use crate::settings::Settings;
use crate::stages;
use crate::subject::{Specimen, Trial};
use finding::findings;

/// What every look at a specimen needs.
struct Look<'a> {
    folders: &'a Folders,
    settings: &'a Settings,
}

/// What was looked at, and what was found.
#[derive(Debug, Default)]
pub struct Told {
    /// Names of the specimens.
    pub specimens: Vec<String>,
    /// Trials on their cards.
    pub trials: usize,
    /// In the order of the specimens, of their cards within each.
    pub findings: Vec<Finding>,
}

impl Told {
    /// Whether nothing must be mended.
    pub fn is_well(&self) -> bool {
        self.findings.iter().all(|finding| !finding.must)
    }
}

impl fmt::Display for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.findings.iter().try_for_each(|finding| writeln!(f, "{finding}"))?;
        let must = self.findings.iter().filter(|finding| finding.must).count();
        let (names, trials, notes) = (self.specimens.join(", "), self.trials, self.findings.len() - must);
        writeln!(f, "{names}: {trials} trials looked at, {must} to mend, {notes} to know")
    }
}

/// Looks at one specimen, or at all of them.
///
/// # Errors
/// A [`Fault`] when there is no such specimen or the settings of a stage cannot be understood.
pub fn run(runner: &Runner, name: Option<&str>) -> Outcome<Told> {
    let look = Look { folders: &runner.folders, settings: &runner.settings };
    let all = lab::folder::list(&runner.folders.raw()).map_err(Fault::from_tool)?;
    let named = |folder: &&PathBuf| name.is_none_or(|name| called(folder) == name);
    let chosen: Vec<&PathBuf> = all.iter().filter(named).collect();
    if chosen.is_empty() {
        let there: Vec<String> = all.iter().map(|folder| called(folder)).collect();
        let what = format!("there is no specimen `{}`", name.unwrap_or_default());
        return Err(Fault::new(what, format!("there are: {}", there.join(", ")), "correct the name, or study init it"));
    }
    let mut told = Told::default();
    for folder in chosen {
        look.specimen(folder, &mut told)?;
    }
    told.findings.extend(disk::look(&look));
    Ok(told)
}

fn called(folder: &Path) -> String {
    folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

impl Look<'_> {
    /// Everything of one specimen.
    fn specimen(&self, folder: &Path, told: &mut Told) -> Outcome<()> {
        told.specimens.push(called(folder));
        let (opened, found) = card::look(self, folder);
        told.findings.extend(found);
        let Some(opened) = opened else { return Ok(()) };
        let of = Specimen { card: Arc::new(opened.card) };
        told.findings.extend(findings([
            solid::look(self, &of)?,
            film::calibration(self, &of),
            log::fixtures(self, &of),
        ]));
        let trials = of.trials();
        told.trials += trials.len();
        let each: Outcome<Vec<Vec<Finding>>> = trials.par_iter().map(|trial| self.trial(trial)).collect();
        told.findings.extend(findings(each?));
        Ok(())
    }

    /// Film, logs and clocks of one trial; clocks where both can be read.
    fn trial(&self, of: &Trial) -> Outcome<Vec<Finding>> {
        let track = self.settings.section::<stages::track::Settings>("track")?;
        let clocks = self.settings.section::<stages::clock::Settings>("clock")?;
        let (log, of_log) = log::pressure(self, of);
        let (seen, of_film) = film::trial(self, of, &track);
        let of_clock = match (&log, &seen) {
            (Some(_), Some(seen)) => clock::look(self, of, seen, &clocks),
            _ => Vec::new(),
        };
        Ok(findings([of_log, log::force(self, of), of_film, of_clock]))
    }

    /// A file of a specimen as a person in the project's folder would type it.
    fn place(&self, specimen: &str, file: &str) -> String {
        self.folders.tell(&self.folders.raw_file(&format!("{specimen}/{file}")))
    }

    /// A file of a specimen as a path.
    fn path(&self, specimen: &str, file: &str) -> PathBuf {
        self.folders.raw_file(&format!("{specimen}/{file}"))
    }
}
