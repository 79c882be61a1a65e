//! Logs: readable, as long as what was done, and in keeping with the card.
//!
//! Stands on: the readers of `lab`, `sense`. Never knows: a film.

use lab::card::{Experiment, FixtureOf};
use lab::{ForceLog, PressureLog, Refusal};
use si::{Second, Series};
use signal::edge::{self, Window};

use super::finding::Finding;
use super::{Look, sense};
use crate::subject::{Specimen, Trial};

/// How long what was done in a trial lasts, s.
pub fn span(experiment: &Experiment) -> Second {
    match experiment {
        Experiment::Staircase { levels, hold, pause, .. } => levels.len() as f64 * (hold + pause) - pause,
        Experiment::Flapping { frequency, cycles, .. } => *cycles as f64 / frequency,
    }
}

/// The pressure log of a trial where it can be read, and what was found in it.
pub fn pressure(look: &Look, of: &Trial) -> (Option<PressureLog>, Vec<Finding>) {
    let file = &of.trial.pressure;
    let place = look.place(&of.card.name, file);
    let (log, mut found) = read(look, &of.card.name, file, |text| lab::pressure::parse(text, place.as_ref()));
    if let Some(log) = &log {
        found.extend(short(&place, &log.time, of));
        found.extend(sense::look(&place, log, &of.trial.experiment));
    }
    (log, found)
}

/// The force log of a trial, where there is one.
pub fn force(look: &Look, of: &Trial) -> Vec<Finding> {
    let Some(file) = &of.trial.force else { return Vec::new() };
    let place = look.place(&of.card.name, file);
    let (log, mut found) = forces(look, &of.card.name, file);
    if let Some(log) = &log {
        found.extend(short(&place, &log.time, of));
        found.extend(lamp(&place, log));
    }
    found
}

/// The logs of the load cell's fixture.
pub fn fixtures(look: &Look, of: &Specimen) -> Vec<Finding> {
    let logs = of.card.fixture.iter().flat_map(|fixture| match &fixture.of {
        FixtureOf::Taps { hammer } => vec![&fixture.force, hammer],
        FixtureOf::StillWater => vec![&fixture.force],
    });
    logs.flat_map(|file| forces(look, &of.card.name, file).1).collect()
}

fn forces(look: &Look, name: &str, file: &str) -> (Option<ForceLog>, Vec<Finding>) {
    let place = look.place(name, file);
    read(look, name, file, |text| lab::force::parse(text, place.as_ref()))
}

/// A log through its reader; a file that is not there was named with the card.
fn read<T>(
    look: &Look,
    name: &str,
    file: &str,
    parse: impl FnOnce(&str) -> Result<T, Refusal>,
) -> (Option<T>, Vec<Finding>) {
    let place = look.place(name, file);
    let Ok(bytes) = std::fs::read(look.path(name, file)) else { return (None, Vec::new()) };
    let Ok(text) = String::from_utf8(bytes) else {
        let act = "export it again as CSV in UTF-8";
        return (None, vec![Finding::mend(format!("{place}: the file is no text"), "a log is UTF-8 text", act)]);
    };
    let mut found = oddities(&place, &text);
    match parse(&text) {
        Ok(log) => (Some(log), found),
        Err(refusal) => {
            found.push(refusal.into());
            (None, found)
        }
    }
}

/// What a text holds that is read past, and that other programs may stumble over.
pub fn oddities(place: &str, text: &str) -> Vec<Finding> {
    let note = |what: &str, why: &str, act: &str| Finding::note(format!("{place} {what}"), why, act);
    let mark = text.starts_with('\u{feff}').then(|| {
        note(
            "begins with a byte-order mark",
            "it is read past",
            "leave it, or save as UTF-8 without BOM for other programs",
        )
    });
    let ends = text.contains("\r\n").then(|| {
        note(
            "has lines that end in CRLF",
            "they are read as any other",
            "leave them, or save with LF for other programs",
        )
    });
    mark.into_iter().chain(ends).collect()
}

/// A log that ends before what was done in the trial does.
fn short(place: &str, time: &[Second], of: &Trial) -> Option<Finding> {
    let (lasts, wanted) = (time[time.len() - 1] - time[0], span(&of.trial.experiment));
    (lasts < wanted).then(|| {
        let why = format!("what the card says was done lasts {wanted:.2} s");
        let act = "check that time_s is in seconds, or correct the trial on the card";
        Finding::mend(format!("{place} lasts {lasts:.4} s"), why, act)
    })
}

/// A force log of a filmed trial is tied to the film by the lamp.
fn lamp(place: &str, log: &ForceLog) -> Option<Finding> {
    if log.led.is_empty() {
        let act = "log the lamp's drive (0 to 1) beside the force, as a column `led`";
        return Some(Finding::mend(
            format!("{place} has no column led"),
            "nothing else ties its clock to the film's",
            act,
        ));
    }
    let series = Series::new(log.time[0], log.rate(), log.led.clone()).ok()?;
    let edges = edge::edges(&series, Window::INSTANT);
    edges.err().map(|e| Finding::said(&format!("{place}, column led: {e}")))
}
