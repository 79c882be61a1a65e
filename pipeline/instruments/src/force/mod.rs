//! Force and pressure logs without a film.
//!
//! `page` describes the recordings, `recorded` reads their logs, `run` evaluates a run, `shown` writes table, record and figure.

mod page;
mod recorded;
mod run;
mod shown;

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};
use lab::Sampling;
use lab::card::LogKind;
use si::{Hertz, Second};
use signal::cell::{TapTest, identify_from_taps};
use signal::crosstalk::{self, CrossTalk, Staircase};
use signal::wave::{self, StillWater, WaveFit};

use page::{Kind, Page, Recording};
use recorded::Recorded;
use run::{Corrections, Run};

/// The results of a page.
pub struct Report {
    page: Page,
    /// The fixture, where it was tapped.
    taps: Option<TapTest>,
    /// The tank's waves, where there is a recording of still water.
    waves: Option<WaveFit>,
    /// The cross-talk and its lag, where there is a staircase.
    talk: Option<CrossTalk>,
    runs: Vec<Run>,
    /// How each force log was sampled.
    samplings: Vec<(String, Sampling)>,
    /// What is left out of which log, and what else its user should know.
    notes: Vec<String>,
}

/// The keys of a page, for the help of the command.
pub fn keys() -> &'static str {
    page::KEYS
}

/// Reads a page from its `text`, with nothing beside it; `path` appears only in diagnostics.
///
/// # Errors
/// A [`Diagnostic`] when it has an unknown, missing or mistyped key or a number out of range.
pub fn check_page(text: &str, path: &Path) -> Result<()> {
    Page::parse(text, path).map(drop)
}

/// Evaluates the page in the file `path`; writes a table, a record and a figure into `out`, or `<page>.out` beside it.
///
/// # Errors
/// A [`Diagnostic`]: the page, a log or a recording is refused.
pub fn run(path: &Path, out: Option<&Path>) -> Result<(Report, PathBuf)> {
    let report = Report::from_page(Page::read(path)?, path.parent().unwrap_or(Path::new(".")))
        .map_err(|diagnostic| diagnostic.in_file_unless_named(path))?;
    let folder = out.map_or_else(|| path.with_extension("out"), Path::to_owned);
    shown::write_results(&report, &folder)?;
    Ok((report, folder))
}

/// Step of the lags that are tried, s.
const LAG_STEP: Second = 0.02;

impl Report {
    fn from_page(page: Page, folder: &Path) -> Result<Self> {
        let mut report = Self {
            page,
            taps: None,
            waves: None,
            talk: None,
            runs: Vec::new(),
            samplings: Vec::new(),
            notes: Vec::new(),
        };
        report.taps = report
            .first_recording(Kind::Taps)
            .map(|recording| report.identify_fixture(&recording, folder))
            .transpose()?;
        report.waves = report
            .first_recording(Kind::StillWater)
            .map(|recording| report.identify_waves(&recording, folder))
            .transpose()?;
        report.talk = report.fit_crosstalk(folder)?;
        let corrections = Corrections {
            waves: report.waves.as_ref().map_or(Vec::new(), |fit| fit.waves.clone()),
            talk: report.talk.clone(),
        };
        for recording in report.of_kind(Kind::Flapping) {
            let log = report.read_logs(&recording, folder)?;
            report.runs.push(run::evaluate_run(&recording, &log, &corrections, &report.page.settings)?);
        }
        Ok(report)
    }

    fn of_kind(&self, kind: Kind) -> Vec<Recording> {
        self.page.recording.iter().filter(|recording| recording.kind == kind).cloned().collect()
    }

    fn first_recording(&self, kind: Kind) -> Option<Recording> {
        self.of_kind(kind).into_iter().next()
    }

    /// The logs of a recording; keeps how they were sampled.
    fn read_logs(&mut self, recording: &Recording, folder: &Path) -> Result<Recorded> {
        let log = Recorded::read(&self.page, recording, folder)?;
        self.note_spikes(&recording.force, &log.sampling);
        self.samplings.push((recording.id.clone(), log.sampling.clone()));
        Ok(log)
    }

    fn note_spikes(&mut self, file: &str, sampling: &Sampling) {
        self.notes.extend(sampling.spikes.iter().map(|spike| format!("{file}, {spike}")));
    }

    fn identify_fixture(&mut self, recording: &Recording, folder: &Path) -> Result<TapTest> {
        let file = recording.hammer.as_deref().unwrap_or_default();
        let hammer = recorded::force_log(&self.page, &folder.join(file), LogKind::Hammer)?;
        self.note_spikes(file, &hammer.sampling);
        let log_path = folder.join(&recording.force);
        let measured = recorded::tap_log(&self.page, &log_path)?;
        self.note_spikes(&recording.force, &measured.sampling);
        identify_from_taps(&hammer.log.series(), &measured.log.series(), self.page.settings.band)
            .map_err(|e| Diagnostic::from(e).in_file(&log_path))
    }

    fn identify_waves(&mut self, recording: &Recording, folder: &Path) -> Result<WaveFit> {
        let log_path = folder.join(&recording.force);
        let measured = recorded::force_log(&self.page, &log_path, LogKind::Force)?;
        self.note_spikes(&recording.force, &measured.sampling);
        let (log, settings) = (measured.log.series(), &self.page.settings);
        let tank = self.page.tank.iter();
        let expected: Vec<Hertz> =
            tank.flat_map(|t| (1..=settings.modes).map(|n| wave::natural_frequency(t.length, t.depth, n))).collect();
        let still_water = StillWater { expected: &expected, level: settings.level, limit: settings.still_limit };
        wave::identify(&log, &still_water).map_err(|e| Diagnostic::from(e).in_file(&log_path))
    }

    /// The cross-talk of all staircases.
    fn fit_crosstalk(&mut self, folder: &Path) -> Result<Option<CrossTalk>> {
        let (mut runs, mut knots) = (Vec::new(), vec![0.0]);
        for recording in self.of_kind(Kind::Staircase) {
            let log = self.read_logs(&recording, folder)?;
            knots.extend(recording.levels);
            runs.push(Staircase { force: log.force, pressures: log.pressures });
        }
        if runs.is_empty() {
            return Ok(None);
        }
        knots.sort_by(f64::total_cmp);
        knots.dedup();
        let count = (self.page.settings.longest_lag / LAG_STEP).round() as usize;
        let lags: Vec<Second> = (0..=count).map(|k| k as f64 * LAG_STEP).collect();
        Ok(Some(crosstalk::fit(&runs, &knots, &lags)?))
    }
}
