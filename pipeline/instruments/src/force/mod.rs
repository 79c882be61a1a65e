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
    let report = Report::of(Page::read(path)?, path.parent().unwrap_or(Path::new(".")))
        .map_err(|refused| refused.in_file_unless_named(path))?;
    let folder = out.map_or_else(|| path.with_extension("out"), Path::to_owned);
    shown::write(&report, &folder)?;
    Ok((report, folder))
}

/// Step of the lags that are tried, s.
const LAG_STEP: Second = 0.02;

impl Report {
    fn of(page: Page, folder: &Path) -> Result<Self> {
        let mut report = Self {
            page,
            taps: None,
            waves: None,
            talk: None,
            runs: Vec::new(),
            samplings: Vec::new(),
            notes: Vec::new(),
        };
        report.taps = report.first(Kind::Taps).map(|one| report.tapped(&one, folder)).transpose()?;
        report.waves = report.first(Kind::StillWater).map(|one| report.still(&one, folder)).transpose()?;
        report.talk = report.crosstalk(folder)?;
        let by = Corrections {
            waves: report.waves.as_ref().map_or(Vec::new(), |fit| fit.waves.clone()),
            talk: report.talk.clone(),
        };
        for one in report.of_kind(Kind::Flapping) {
            let log = report.read(&one, folder)?;
            report.runs.push(run::evaluated(&one, &log, &by, &report.page.settings)?);
        }
        Ok(report)
    }

    fn of_kind(&self, kind: Kind) -> Vec<Recording> {
        self.page.recording.iter().filter(|one| one.kind == kind).cloned().collect()
    }

    fn first(&self, kind: Kind) -> Option<Recording> {
        self.of_kind(kind).into_iter().next()
    }

    /// The logs of a recording; keeps how they were sampled.
    fn read(&mut self, one: &Recording, folder: &Path) -> Result<Recorded> {
        let log = Recorded::read(&self.page, one, folder)?;
        self.note_spikes(&one.force, &log.sampling);
        self.samplings.push((one.id.clone(), log.sampling.clone()));
        Ok(log)
    }

    fn note_spikes(&mut self, file: &str, sampling: &Sampling) {
        self.notes.extend(sampling.spikes.iter().map(|spike| format!("{file}, {spike}")));
    }

    fn tapped(&mut self, one: &Recording, folder: &Path) -> Result<TapTest> {
        let file = one.hammer.as_deref().unwrap_or_default();
        let hammer = recorded::force(&self.page, &folder.join(file), LogKind::Hammer)?;
        self.note_spikes(file, &hammer.sampling);
        let place = folder.join(&one.force);
        let measured = recorded::taps(&self.page, &place)?;
        self.note_spikes(&one.force, &measured.sampling);
        identify_from_taps(&hammer.log.series(), &measured.log.series(), self.page.settings.band)
            .map_err(|e| Diagnostic::from(e).in_file(&place))
    }

    fn still(&mut self, one: &Recording, folder: &Path) -> Result<WaveFit> {
        let place = folder.join(&one.force);
        let read = recorded::force(&self.page, &place, LogKind::Force)?;
        self.note_spikes(&one.force, &read.sampling);
        let (log, set) = (read.log.series(), &self.page.settings);
        let size = self.page.tank.iter();
        let expected: Vec<Hertz> =
            size.flat_map(|t| (1..=set.modes).map(|n| wave::natural_frequency(t.length, t.depth, n))).collect();
        let still = StillWater { expected: &expected, level: set.level, limit: set.still_limit };
        wave::identify(&log, &still).map_err(|e| Diagnostic::from(e).in_file(&place))
    }

    /// The cross-talk of all staircases.
    fn crosstalk(&mut self, folder: &Path) -> Result<Option<CrossTalk>> {
        let (mut runs, mut knots) = (Vec::new(), vec![0.0]);
        for one in self.of_kind(Kind::Staircase) {
            let log = self.read(&one, folder)?;
            knots.extend(one.levels);
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
