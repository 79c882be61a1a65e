//! Checks of logs: readable, as long as the trial, and consistent with the card.

use diagnostics::{Result, input};
use lab::card::{Card, Fixture, FixtureOf, LogKind};
use lab::log::StampReport;
use lab::pressure::Layout;
use lab::{ForceLog, PressureLog};
use si::{Second, Series};
use signal::edge::{self, Window};

use super::finding::Finding;
use super::{Look, sense, stamps};
use study::stages::load_cell::LoadCell;
use study::stages::tank::Tank;
use study::subject::{Specimen, Trial};
use workflow::record::Record;
use workflow::runner::inspection_context;
use workflow::stage::Stage;
use workflow::subject::Part;

/// The pressure log of a trial where it can be read, and the findings on it.
pub fn pressure(look: &Look, of: &Trial) -> (Option<PressureLog>, Vec<Finding>) {
    let file = &of.trial.pressure;
    let place = look.place(&of.card.name, file);
    let channels = of.card.channels();
    let layout = Layout { channels: &channels, lamp: of.trial.video.is_some(), log: &of.card.log };
    let reader = Reader {
        stamps: &|text| lab::pressure::stamps(text, place.as_ref(), layout),
        parse: &|text| lab::pressure::parse_as(text, place.as_ref(), layout).map(|logged| logged.log),
    };
    let (log, mut found) = read(look, &of.card.name, file, &reader);
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
    let (log, mut found) = forces(look, &of.card, (LogKind::Force, file));
    if let Some(log) = &log {
        found.extend(short(&place, &log.time, of));
        found.extend(stamps::slow(&place, log.rate(), &of.trial.experiment));
        found.extend(of.trial.video.as_ref().and_then(|_| lamp(&place, log, of)));
    }
    found
}

/// The logs of the load cell's fixture: readable, and with all taps and the water at rest, as the stages find them.
///
/// # Errors
/// A diagnostic when the settings of a stage are invalid.
pub fn fixtures(look: &Look, of: &Specimen) -> Result<Vec<Finding>> {
    let mut found = fixture_logs(look, of);
    if found.iter().any(|finding| finding.must()) || of.card.fixture.is_empty() {
        return Ok(found);
    }
    found.extend(refused::<LoadCell>(look, of)?);
    found.extend(refused::<Tank>(look, of)?);
    Ok(found)
}

/// What a stage that reads fixtures alone refuses.
fn refused<S: Stage<Needs = ()>>(look: &Look, of: &Specimen) -> Result<Option<Finding>>
where
    S::Makes: Record<Of = Specimen>,
    S::Card: Part<Specimen>,
{
    let raw = S::raw(of);
    // A stage without recordings has nothing to do here; a missing file is reported with the card.
    if raw.is_empty() || raw.iter().any(|file| !look.folders.raw_file(&file.path).exists()) {
        return Ok(None);
    }
    let set = look.settings.section::<S::Settings>(<S::Makes as Record>::STAGE)?;
    let context = inspection_context(look.folders, &raw);
    Ok(S::run(&Part::part_of(of), &set, (), &context).err().map(Finding::from))
}

fn fixture_logs(look: &Look, of: &Specimen) -> Vec<Finding> {
    let logs = |fixture: &Fixture| match &fixture.of {
        FixtureOf::Taps { hammer, .. } => {
            let struck = forces(look, &of.card, (LogKind::Hammer, hammer)).1;
            taps(look, &of.card, &fixture.force).into_iter().chain(struck).collect()
        }
        FixtureOf::StillWater => forces(look, &of.card, (LogKind::Force, &fixture.force)).1,
    };
    of.card.fixture.iter().flat_map(logs).collect()
}

fn taps(look: &Look, card: &Card, file: &str) -> Vec<Finding> {
    let place = look.place(&card.name, file);
    let reader = Reader {
        stamps: &|text| lab::force::stamps_of_taps(text, place.as_ref(), &card.log),
        parse: &|text| lab::force::parse_taps(text, place.as_ref(), &card.log),
    };
    read(look, &card.name, file, &reader).1
}

fn forces(look: &Look, card: &Card, (kind, file): (LogKind, &str)) -> (Option<ForceLog>, Vec<Finding>) {
    let place = look.place(&card.name, file);
    let reader = Reader {
        stamps: &|text| lab::force::stamps(text, place.as_ref(), (kind, &card.log)),
        parse: &|text| lab::force::parse_as(text, place.as_ref(), (kind, &card.log)).map(|logged| logged.log),
    };
    read(look, &card.name, file, &reader)
}

/// The two ways to read a log: its stamps alone, and all of it.
struct Reader<'a, T> {
    stamps: &'a dyn Fn(&str) -> Result<StampReport>,
    parse: &'a dyn Fn(&str) -> Result<T>,
}

/// A log through its reader; a missing file is reported with the card.
fn read<T>(look: &Look, name: &str, file: &str, reader: &Reader<T>) -> (Option<T>, Vec<Finding>) {
    let place = look.place(name, file);
    let Ok(bytes) = input::read(&look.path(name, file), input::LOG) else { return (None, Vec::new()) };
    let letters = lab::log::encoding::is_windows_1252(&bytes).then(|| {
        let why = "its letters beyond A to Z are taken for those of Windows-1252";
        Finding::note(format!("{place} is not in UTF-8"), why, "leave it, or save as UTF-8 for other programs")
    });
    let text = match lab::log::decoded(bytes, place.as_ref()) {
        Ok(text) => text,
        Err(diagnostic) => return (None, vec![diagnostic.into()]),
    };
    let mut found = oddities(&place, &text);
    found.extend(letters);
    let report = match (reader.stamps)(&text) {
        Ok(report) => report,
        Err(diagnostic) => {
            found.push(diagnostic.into());
            return (None, found);
        }
    };
    found.extend(stamps::look(&place, &report));
    let log = (reader.parse)(&text);
    // A fault of the stamps has been reported with its line, and with all others.
    if let (Err(diagnostic), true) = (&log, report.faults.is_empty()) {
        found.push(diagnostic.clone().into());
    }
    (log.ok(), found)
}

/// Notes on parts of a text that are skipped here but may fail in other programs.
pub(crate) fn oddities(place: &str, text: &str) -> Vec<Finding> {
    let note = |what: &str, why: &str, act: &str| Finding::note(format!("{place} {what}"), why, act);
    let mark = text.starts_with('\u{feff}').then(|| {
        note(
            "begins with a byte-order mark",
            "it is skipped",
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

/// A log that ends before the trial does.
fn short(place: &str, time: &[Second], of: &Trial) -> Option<Finding> {
    let (lasts, wanted) = (time[time.len() - 1] - time[0], of.trial.experiment.duration());
    (lasts < wanted).then(|| {
        let why = format!("the trial on the card lasts {wanted:.2} s");
        let act = "check that time_s is in seconds, or correct the trial on the card";
        Finding::fix(format!("{place} lasts {lasts:.4} s"), why, act)
    })
}

/// A force log of a filmed trial needs the lamp for synchronisation.
fn lamp(place: &str, log: &ForceLog, of: &Trial) -> Option<Finding> {
    if log.led.is_empty() {
        let act = "log the lamp's state (0 to 1) beside the force, as a column `led`";
        return Some(Finding::fix(
            format!("{place} has no column led"),
            "its clock is synchronised with the film's by the lamp alone",
            act,
        ));
    }
    let series = Series::new(log.time[0], log.rate(), log.led.clone()).ok()?;
    match edge::edges(&series, Window::INSTANT) {
        Err(e) => Some(Finding::message(&format!("{place}, column led: {e}"))),
        Ok(edges) => ends_early(place, log, edges.first()?.time, of),
    }
}

/// A force log that ends before the trial does, which begins when the lamp lights.
fn ends_early(place: &str, log: &ForceLog, lit: Second, of: &Trial) -> Option<Finding> {
    let (lasts, wanted) = (log.time[log.time.len() - 1] - lit, of.trial.experiment.duration());
    (lasts < wanted).then(|| {
        let what = format!("{place} ends {lasts:.3} s after the lamp has lit");
        let why = format!("the trial on the card lasts {wanted:.2} s from then on");
        Finding::fix(what, why, "copy the log again, or correct the trial on the card")
    })
}
