//! Checks of logs: readable, as long as the trial, and consistent with the card.

use diagnostics::{Result, input};
use lab::card::{Card, Fixture, FixtureOf, LogKind};
use lab::log::StampReport;
use lab::pressure::Layout;
use lab::{ForceLog, PressureLog};
use si::{Second, Series};
use signal::edge::{self, Window};

use super::finding::Finding;
use super::{Project, sense, stamps};
use records::subject::{Specimen, Trial};
use records::{CorrectedForce, Motion};
use study::stages::load_cell::LoadCell;
use study::stages::tank::Tank;
use study::stages::wave::Wave;
use workflow::needs::Maybe;
use workflow::record::Record;
use workflow::runner::inspection_context;
use workflow::stage::Stage;
use workflow::subject::Part;

/// The pressure log of a trial where it can be read, and the findings on it.
pub(crate) fn pressure_log(project: &Project, subject: &Trial) -> (Option<PressureLog>, Vec<Finding>) {
    let file = &subject.trial.pressure;
    let log_path = project.display_path(&subject.card.name, file);
    let channels = subject.card.channels();
    let layout = Layout { channels: &channels, lamp: subject.trial.video.is_some(), log: &subject.card.log };
    let reader = Reader {
        stamps: &|text| lab::pressure::stamps(text, log_path.as_ref(), layout),
        parse: &|text| lab::pressure::parse_as(text, log_path.as_ref(), layout).map(|logged| logged.log),
    };
    let (log, mut findings) = read_log(project, &subject.card.name, file, &reader);
    if let Some(log) = &log {
        findings.extend(short_log(&log_path, &log.time, subject));
        findings.extend(sense::consistency_findings(&log_path, log, &subject.trial.experiment));
    }
    (log, findings)
}

/// The force log of a trial, where there is one.
pub(crate) fn force_findings(project: &Project, subject: &Trial) -> Vec<Finding> {
    let Some(file) = &subject.trial.force else { return Vec::new() };
    let log_path = project.display_path(&subject.card.name, file);
    let (log, mut findings) = force_log(project, &subject.card, (LogKind::Force, file));
    if let Some(log) = &log {
        findings.extend(short_log(&log_path, &log.time, subject));
        findings.extend(stamps::slow_amplifier(&log_path, log.rate(), &subject.trial.experiment));
        findings.extend(subject.trial.video.as_ref().and_then(|_| lamp_finding(&log_path, log, subject)));
    }
    findings
}

/// What the stage that corrects a force refuses, on the clock of the trial's `motion`; the tank's waves are left in.
///
/// # Errors
/// A diagnostic when the settings of the stage are invalid.
pub(crate) fn corrected_force_finding(project: &Project, subject: &Trial, motion: Motion) -> Result<Option<Finding>> {
    if !CorrectedForce::is_made_for(subject) {
        return Ok(None);
    }
    let settings = project.settings.section(CorrectedForce::STAGE)?;
    let raw = Wave::raw(subject);
    let context = inspection_context(project.folders, &raw);
    let corrected = Wave::run(&Part::part_of(subject), &settings, (Maybe(None), motion), &context);
    Ok(corrected.err().map(Finding::from))
}

/// The logs of the load cell's fixture: readable, and with all taps and the water at rest, as the stages find them.
///
/// # Errors
/// A diagnostic when the settings of a stage are invalid.
pub(crate) fn fixture_findings(project: &Project, specimen: &Specimen) -> Result<Vec<Finding>> {
    let mut findings = fixture_logs(project, specimen);
    if findings.iter().any(|finding| finding.must_fix()) || specimen.card.fixture.is_empty() {
        return Ok(findings);
    }
    findings.extend(stage_finding::<LoadCell>(project, specimen)?);
    findings.extend(stage_finding::<Tank>(project, specimen)?);
    Ok(findings)
}

/// What a stage that reads fixtures alone refuses.
fn stage_finding<S: Stage<Needs = ()>>(project: &Project, specimen: &Specimen) -> Result<Option<Finding>>
where
    S::Makes: Record<Of = Specimen>,
    S::Card: Part<Specimen>,
{
    let files = S::raw(specimen);
    // A stage without recordings has nothing to do here; a missing file is reported with the card.
    if files.is_empty() || files.iter().any(|file| !project.folders.raw_file(&file.path).exists()) {
        return Ok(None);
    }
    let settings = project.settings.section::<S::Settings>(<S::Makes as Record>::STAGE)?;
    let context = inspection_context(project.folders, &files);
    Ok(S::run(&Part::part_of(specimen), &settings, (), &context).err().map(Finding::from))
}

fn fixture_logs(project: &Project, specimen: &Specimen) -> Vec<Finding> {
    let logs = |fixture: &Fixture| match &fixture.of {
        FixtureOf::Taps { hammer, .. } => {
            let hammer_findings = force_log(project, &specimen.card, (LogKind::Hammer, hammer)).1;
            tap_findings(project, &specimen.card, &fixture.force).into_iter().chain(hammer_findings).collect()
        }
        FixtureOf::StillWater => force_log(project, &specimen.card, (LogKind::Force, &fixture.force)).1,
    };
    specimen.card.fixture.iter().flat_map(logs).collect()
}

fn tap_findings(project: &Project, card: &Card, file: &str) -> Vec<Finding> {
    let log_path = project.display_path(&card.name, file);
    let reader = Reader {
        stamps: &|text| lab::force::stamps_of_taps(text, log_path.as_ref(), &card.log),
        parse: &|text| lab::force::parse_taps(text, log_path.as_ref(), &card.log),
    };
    read_log(project, &card.name, file, &reader).1
}

fn force_log(project: &Project, card: &Card, (kind, file): (LogKind, &str)) -> (Option<ForceLog>, Vec<Finding>) {
    let log_path = project.display_path(&card.name, file);
    let reader = Reader {
        stamps: &|text| lab::force::stamps(text, log_path.as_ref(), (kind, &card.log)),
        parse: &|text| lab::force::parse_as(text, log_path.as_ref(), (kind, &card.log)).map(|logged| logged.log),
    };
    read_log(project, &card.name, file, &reader)
}

/// The two ways to read a log: its stamps alone, and all of it.
struct Reader<'a, T> {
    stamps: &'a dyn Fn(&str) -> Result<StampReport>,
    parse: &'a dyn Fn(&str) -> Result<T>,
}

/// A log through its reader; a missing file is reported with the card.
fn read_log<T>(project: &Project, name: &str, file: &str, reader: &Reader<T>) -> (Option<T>, Vec<Finding>) {
    let log_path = project.display_path(name, file);
    let Ok(bytes) = input::read(&project.file_path(name, file), input::LOG) else { return (None, Vec::new()) };
    let encoding_note = lab::log::encoding::is_windows_1252(&bytes).then(|| {
        let reason = "its letters beyond A to Z are taken for those of Windows-1252";
        Finding::note(format!("{log_path} is not in UTF-8"), reason, "leave it, or save as UTF-8 for other programs")
    });
    let text = match lab::log::decoded(bytes, log_path.as_ref()) {
        Ok(text) => text,
        Err(diagnostic) => return (None, vec![diagnostic.into()]),
    };
    let mut findings = encoding_notes(&log_path, &text);
    findings.extend(encoding_note);
    let report = match (reader.stamps)(&text) {
        Ok(report) => report,
        Err(diagnostic) => {
            findings.push(diagnostic.into());
            return (None, findings);
        }
    };
    findings.extend(stamps::stamp_findings(&log_path, &report));
    let log = (reader.parse)(&text);
    // A fault of the stamps has been reported with its line, and with all others.
    if let (Err(diagnostic), true) = (&log, report.faults.is_empty()) {
        findings.push(diagnostic.clone().into());
    }
    (log.ok(), findings)
}

/// Notes on parts of a text that are skipped here but may fail in other programs.
pub(crate) fn encoding_notes(file_path: &str, text: &str) -> Vec<Finding> {
    let note =
        |defect: &str, reason: &str, action: &str| Finding::note(format!("{file_path} {defect}"), reason, action);
    let byte_order_mark = text.starts_with('\u{feff}').then(|| {
        note(
            "begins with a byte-order mark",
            "it is skipped",
            "leave it, or save as UTF-8 without BOM for other programs",
        )
    });
    let line_ends = text.contains("\r\n").then(|| {
        note(
            "has lines that end in CRLF",
            "they are read as any other",
            "leave them, or save with LF for other programs",
        )
    });
    byte_order_mark.into_iter().chain(line_ends).collect()
}

/// A log that ends before the trial does.
fn short_log(log_path: &str, time: &[Second], subject: &Trial) -> Option<Finding> {
    let (duration, required) = (time[time.len() - 1] - time[0], subject.trial.experiment.duration());
    (duration < required).then(|| {
        let reason = format!("the trial on the card lasts {required:.2} s");
        let action = "check that time_s is in seconds, or correct the trial on the card";
        Finding::fix(format!("{log_path} lasts {duration:.4} s"), reason, action)
    })
}

/// A force log of a filmed trial needs the lamp for synchronisation.
fn lamp_finding(log_path: &str, log: &ForceLog, subject: &Trial) -> Option<Finding> {
    if log.led.is_empty() {
        let action = "log the lamp's state (0 to 1) beside the force, as a column `led`";
        return Some(Finding::fix(
            format!("{log_path} has no column led"),
            "its clock is synchronised with the film's by the lamp alone",
            action,
        ));
    }
    let series = Series::new(log.time[0], log.rate(), log.led.clone()).ok()?;
    match edge::edges(&series, Window::INSTANT) {
        Err(e) => Some(Finding::message(&format!("{log_path}, column led: {e}"))),
        Ok(edges) => ends_early(log_path, log, edges.first()?.time, subject),
    }
}

/// A force log that ends before the trial does, which begins when the lamp lights.
fn ends_early(log_path: &str, log: &ForceLog, start: Second, subject: &Trial) -> Option<Finding> {
    let (duration, required) = (log.time[log.time.len() - 1] - start, subject.trial.experiment.duration());
    (duration < required).then(|| {
        let defect = format!("{log_path} ends {duration:.3} s after the lamp has lit");
        let reason = format!("the trial on the card lasts {required:.2} s from then on");
        Finding::fix(defect, reason, "copy the log again, or correct the trial on the card")
    })
}
