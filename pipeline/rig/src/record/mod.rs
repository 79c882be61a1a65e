//! Recording a specimen: from its shape and hidden properties to a folder such as a laboratory could have filled.
//!
//! This module alone chooses paths, keeps finished recordings and replaces stale ones. A recording is made whole, or part by part: the
//! equilibria and the reduced model, the calibration film, and each trial. Parts may be made by several processes and machines at once,
//! in any order; whoever makes the whole recording makes what is left of them.

mod in_progress;
mod setup;
mod statics;
mod truth;

use std::path::Path;

use diagnostics::{Diagnostic, Result};
use lab::card::{Card, Trial};
use lab::truth::{TrueForce, TrueTrial};
use rayon::prelude::*;
use si::{MILLIMETRE, Metre};
use tail_cad::Tail;

use crate::bench::Bench;
use crate::card::{self, CardContent};
use crate::checkpoint;
use crate::folder;
use crate::force_log;
use crate::progress::Progress;
use crate::settings::Settings;
use crate::specimen::Specimen;
use crate::stamp::{self, FolderState};
use crate::trial::{self, TrialTruth};
use in_progress::InProgress;
use setup::Setup;
use statics::Statics;

/// What is recorded of a specimen, and where.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// The settings of the bench.
    pub set: &'a Settings,
    /// Name of the profile: extent and resolution.
    pub profile: &'a str,
    /// The folder that will hold the specimen's folder.
    pub into: &'a Path,
    /// Where progress is reported.
    pub progress: &'a Progress,
}

/// Result of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The recording was up to date.
    UpToDate,
    /// The recording, or the part that was asked for, was made.
    Recorded,
}

/// The part that holds the equilibria and the reduced model: every trial needs it.
pub const STATICS: &str = "statics";
/// The part that is the calibration film.
pub(crate) const CALIBRATION: &str = "calibration";
/// The lock of whoever makes the whole recording.
const WHOLE: &str = "whole";

/// The parts of a recording besides the trials, in the order in which they are needed, and the names of the trials.
pub fn parts(specimen: &Specimen, request: &Request) -> ([&'static str; 2], Vec<String>) {
    let specimen_settings = &request.set.specimen[&*specimen.name];
    let trials = card::planned_trials(specimen_settings, &request.set.profile[request.profile]);
    ([STATICS, CALIBRATION], trials.into_iter().map(|trial| trial.id).collect())
}

/// Records `specimen` into `into/<name>`, unless an up-to-date recording is there. Parts that were made are kept.
///
/// # Errors
/// When the folder was not made by the bench, a solve does not converge, or a file cannot be written.
pub fn record(specimen: &Specimen, request: &Request) -> Result<Status> {
    if is_current(specimen, request)? {
        // it still has them where it was killed after its last step
        checkpoint::clear_all(&request.into.join(&*specimen.name))?;
        return Ok(Status::UpToDate);
    }
    let recording = InProgress::of_specimen(specimen, request)?;
    let _whole = recording.lock_part(WHOLE)?;
    if !recording.begin_recording()? {
        return Ok(Status::UpToDate);
    }
    let record_all_parts = || record_parts(&Setup::new(specimen, request)?, &recording);
    record_all_parts().map_err(|e| e.of(&*specimen.name))?;
    recording.finish_recording()?;
    Ok(Status::Recorded)
}

/// Records some parts of `specimen` into `into/<name>`: trials and fixture's logs by their names, and `calibration`; with any of them the calibration
/// and all the fixture's logs, which take seconds. The card and the solids are always written. What a figure needs is recorded so; [`record`] makes what
/// is left. An up-to-date recording is kept.
///
/// # Errors
/// As [`record`]; also when there is no such part.
pub fn record_some(specimen: &Specimen, request: &Request, names: &[String]) -> Result<Status> {
    let chosen = chosen_trials(specimen, request, names)?;
    if is_current(specimen, request)? {
        return Ok(Status::UpToDate);
    }
    let recording = InProgress::of_specimen(specimen, request)?;
    let _whole = recording.lock_part(WHOLE)?;
    if recording.shows(&chosen, !names.is_empty()) || !recording.begin_recording()? {
        return Ok(Status::UpToDate);
    }
    let record_chosen = || {
        let setup = Setup::new(specimen, request)?;
        write_solids(setup.name, &setup.tail, setup.request.set.cad.fineness, &recording.folder)?;
        let card = write_card(&setup, &recording)?;
        if names.is_empty() { Ok(()) } else { fill_trials(&setup, &recording, (&card, &chosen)) }
    };
    record_chosen().map_err(|e| e.of(&*specimen.name))?;
    recording.show_parts()?;
    Ok(Status::Recorded)
}

/// The trials among the names of parts.
fn chosen_trials(specimen: &Specimen, request: &Request, names: &[String]) -> Result<Vec<String>> {
    let (_, trials) = parts(specimen, request);
    let fixtures: Vec<String> = card::fixture_recordings(request.set).into_iter().map(|fixture| fixture.id).collect();
    let is_known = |id: &String| id == CALIBRATION || trials.contains(id) || fixtures.contains(id);
    if let Some(unknown) = names.iter().find(|id| !is_known(id)) {
        let message = format!("the recording of `{}` has no part `{unknown}`", specimen.name);
        let why = format!("it has {CALIBRATION}, {}, {}", fixtures.join(", "), trials.join(", "));
        return Err(Diagnostic::new(message, why, "name one of these"));
    }
    Ok(trials.into_iter().filter(|id| names.contains(id)).collect())
}

/// Makes one part of a recording: `STATICS`, `CALIBRATION`, or a trial by its name. The recording stays in progress until [`record`]
/// makes what is left of it.
///
/// # Errors
/// As [`record`]; also when there is no such part.
pub fn record_part(specimen: &Specimen, request: &Request, part: &str) -> Result<Status> {
    let (other_parts, trials) = parts(specimen, request);
    if !other_parts.contains(&part) && !trials.iter().any(|id| id == part) {
        let known_parts = format!("it has {}, {}", other_parts.join(", "), trials.join(", "));
        let message = format!("the recording of `{}` has no part `{part}`", specimen.name);
        return Err(Diagnostic::new(message, known_parts, "name one of these"));
    }
    if is_current(specimen, request)? {
        return Ok(Status::UpToDate);
    }
    let recording = InProgress::of_specimen(specimen, request)?;
    if !recording.begin_recording()? {
        return Ok(Status::UpToDate);
    }
    let record_chosen_part = || fill_part(&Setup::new(specimen, request)?, &recording, part);
    record_chosen_part().map_err(|e| e.of(&*specimen.name))?;
    Ok(Status::Recorded)
}

fn is_current(specimen: &Specimen, request: &Request) -> Result<bool> {
    let stamp = stamp::stamp_text(specimen, request.profile);
    Ok(stamp::inspect_folder(&request.into.join(&*specimen.name), &stamp)? == FolderState::Current)
}

fn fill_part(setup: &Setup, recording: &InProgress, part: &str) -> Result<()> {
    match part {
        CALIBRATION => record_calibration(setup, recording),
        STATICS => Statics::of_setup(setup, recording).map(|_| ()),
        id => {
            let trial = setup.trials.iter().find(|trial| trial.id == id).expect("the part was found among the trials");
            let Statics { sweeps, reduced } = Statics::of_setup(setup, recording)?;
            setup.on_bench((&sweeps, &reduced), &|bench| trial_once(bench, trial, recording).map(|_| ()))
        }
    }
}

fn record_parts(setup: &Setup, recording: &InProgress) -> Result<()> {
    write_solids(setup.name, &setup.tail, setup.request.set.cad.fineness, &recording.folder)?;
    let Statics { sweeps, reduced } = Statics::of_setup(setup, recording)?;
    setup.on_bench((&sweeps, &reduced), &|bench| fill_with(setup, recording, bench))
}

fn fill_with(setup: &Setup, recording: &InProgress, bench: &Bench) -> Result<()> {
    let (set, folder) = (bench.set, &recording.folder);
    let card = write_card(setup, recording)?;
    let (trial, mut force) = record_all(setup, recording, bench)?;
    for fixture in &card.fixture {
        force.push(force_log::record_fixture(set, bench.seed, fixture, folder)?);
    }
    let truth = truth::recording_truth(setup, bench, (trial, force));
    folder::write_file(folder, lab::folder::TRUTH, lab::truth::write(&truth).as_bytes())
}

/// Writes the card of all trials.
fn write_card(setup: &Setup, recording: &InProgress) -> Result<Card> {
    let Setup { name, tail, trials, request, .. } = setup;
    let observed = setup.observe_at_rest()?;
    let card =
        card::write_card(&CardContent { name, set: request.set, tail, trials }, &observed, &setup.calibration_film());
    folder::write_file(&recording.folder, lab::folder::CARD, lab::card::write(&card).as_bytes())?;
    Ok(card)
}

/// Records the calibration, the fixture's logs, and some trials in parallel.
fn fill_trials(setup: &Setup, recording: &InProgress, (card, chosen): (&Card, &[String])) -> Result<()> {
    record_calibration(setup, recording)?;
    for fixture in &card.fixture {
        force_log::record_fixture(setup.request.set, setup.seed(), fixture, &recording.folder)?;
    }
    if chosen.is_empty() {
        return Ok(());
    }
    let Statics { sweeps, reduced } = Statics::of_setup(setup, recording)?;
    let trials: Vec<&Trial> = setup.trials.iter().filter(|trial| chosen.contains(&trial.id)).collect();
    setup.on_bench((&sweeps, &reduced), &|bench| {
        trials.par_iter().try_for_each(|trial| trial_once(bench, trial, recording).map(|_| ()))
    })
}

/// Records the calibration and every trial in parallel; results are in the card's order.
fn record_all(setup: &Setup, recording: &InProgress, bench: &Bench) -> Result<(Vec<TrueTrial>, Vec<TrueForce>)> {
    let record_one = |trial: &Trial| trial_once(bench, trial, recording);
    let record_trials = || setup.trials.par_iter().map(record_one).collect::<Result<Vec<_>>>();
    let (calibrated, recorded) = rayon::join(|| record_calibration(setup, recording), record_trials);
    let (trials, forces): (Vec<_>, Vec<_>) = calibrated.and(recorded)?.into_iter().map(|t| (t.trial, t.force)).unzip();
    Ok((trials, forces.into_iter().flatten().collect()))
}

/// Records a trial, unless it has a checkpoint.
fn trial_once(bench: &Bench, trial: &Trial, recording: &InProgress) -> Result<TrialTruth> {
    let id = &trial.id;
    recording.make_once(
        id,
        &|| checkpoint::load_trial(&recording.folder, id),
        &|| trial::record_trial(bench, trial, &recording.folder),
        &|truth| checkpoint::save_trial(&recording.folder, id, truth),
    )
}

fn record_calibration(setup: &Setup, recording: &InProgress) -> Result<()> {
    let (folder, film) = (&recording.folder, setup.calibration_film());
    let make = || {
        let request = setup.request;
        let task = request.progress.begin_step("film", format!("{}/{CALIBRATION}", setup.name), film.frame_count());
        let path = folder::prepared_path(folder, card::CALIBRATION_FILE)?;
        film.write_film(&path, request.set, &setup.renderer, &|| task.count_part())?;
        task.end_step(&format!("{} frames", film.frame_count()));
        Ok(())
    };
    let is_made = || checkpoint::load_bytes(folder, CALIBRATION).map(|_| ());
    recording.make_once(CALIBRATION, &is_made, &make, &|()| checkpoint::save_bytes(folder, CALIBRATION, &[]))
}

fn write_solids(name: &str, tail: &Tail, fineness: Metre, folder: &Path) -> Result<()> {
    let (body, spine) = tail.solids(fineness).map_err(|e| Diagnostic::from(e).while_doing("the STL files"))?;
    for (file, part, surface) in [(card::BODY_FILE, "body", body), (card::SPINE_FILE, "spine", spine)] {
        let title = format!("{}: {part} of {name}", lab::VIRTUAL_BENCH);
        folder::write_file(folder, file, &mesh::stl::write(&surface, MILLIMETRE, &title))?;
    }
    Ok(())
}
