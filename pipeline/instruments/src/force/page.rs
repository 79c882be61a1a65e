//! The page of `study force`: logs of a load cell, without a film.

use std::path::Path;

use diagnostics::{Diagnostic, Result, input};
use lab::card::{Log, Tank, check_log, check_tank};
use lab::range::{Checked, violation, within};
use lab::table;
use serde::Deserialize;
use si::{Hertz, Newton, Pascal, Second};

/// The contents of a page.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Page {
    /// Name of the results.
    pub name: String,
    /// The channels of the pressure logs.
    #[serde(default = "default_channels")]
    pub channels: Vec<String>,
    /// How the instruments write their logs, as on a card.
    #[serde(default)]
    pub log: Log,
    /// The tank, where there is a recording of still water.
    pub tank: Option<Tank>,
    /// How the logs are evaluated.
    #[serde(default)]
    pub settings: Settings,
    /// The recordings.
    pub recording: Vec<Recording>,
}

/// The channels of a page that names none.
fn default_channels() -> Vec<String> {
    ["left", "right"].map(str::to_owned).to_vec()
}

/// `[settings]`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Settings {
    /// Lowest and highest frequency of the fixture's fitted response, Hz.
    pub band: [Hertz; 2],
    /// Number of standing waves that are looked for.
    pub modes: u32,
    /// Level of significance at which any wave is reported.
    pub level: f64,
    /// Largest amplitude of a line in water that is still, N.
    pub still_limit: Newton,
    /// Harmonics of the beat that are fitted beside the waves.
    pub harmonics: usize,
    /// Cycles at the start of a run that are left out.
    pub settling_cycles: f64,
    /// Time after a run before the zero is read, s.
    pub settling_time: Second,
    /// Longest lag of the force behind the pressure that is tried, s.
    pub longest_lag: Second,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            band: [3.0, 30.0],
            modes: 2,
            level: 0.005,
            still_limit: 0.02,
            harmonics: 12,
            settling_cycles: 1.0,
            settling_time: 1.0,
            longest_lag: 0.6,
        }
    }
}

/// `[[recording]]`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Recording {
    /// Its name.
    pub id: String,
    /// What was done.
    pub kind: Kind,
    /// The load cell's log, relative to the page.
    pub force: String,
    /// The hammer's log, of taps.
    pub hammer: Option<String>,
    /// The pressure log: needed of a staircase.
    pub pressure: Option<String>,
    /// The pressures that were held in a staircase, Pa.
    #[serde(default)]
    pub levels: Vec<Pascal>,
    /// Full cycles a second of a run, Hz.
    pub frequency: Option<Hertz>,
    /// First and last second of a run on the clock of the force, where no pressure log shows them.
    pub seconds: Option<[Second; 2]>,
}

/// What was done in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Kind {
    /// An instrumented hammer tapped the fixture.
    Taps,
    /// Nothing, after a run.
    StillWater,
    /// Pressures were held, one after another.
    Staircase,
    /// Something flapped.
    Flapping,
}

impl Page {
    /// The page in a file, checked.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it cannot be read, or has an unknown, missing or mistyped key or a number out of range.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let text = input::read_text(path, input::PAGE)
            .map_err(|e| Diagnostic::io(path, e, "write a page there; study force --help lists its keys"))?;
        Self::parse(&text, path)
    }

    /// The page in `text`; `path` appears only in diagnostics.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it has an unknown, missing or mistyped key or a number out of range.
    pub(super) fn parse(text: &str, path: &Path) -> Result<Self> {
        table::parse(text, path, "study force --help lists the keys", Self::check_entries)
    }

    fn check_entries(&self) -> Checked {
        check_log(&self.log, &self.channels)?;
        self.tank.map_or(Ok(()), |tank| check_tank(&tank))?;
        self.settings.check_ranges()?;
        if self.recording.is_empty() {
            return violation("recording", "the page has no recording", "at least one is needed", "add [[recording]]");
        }
        self.recording.iter().enumerate().try_for_each(|(i, recording)| {
            let key = format!("recording.{i}");
            self.check_id(&key, recording, &self.recording[..i])?;
            check_numbers(&key, recording)?;
            self.check_recording(&key, recording)
        })
    }

    /// Results are named by their recording: two of one name could not be told apart.
    fn check_id(&self, key: &str, recording: &Recording, previous: &[Recording]) -> Checked {
        let key = format!("{key}.id");
        if recording.id.trim().is_empty() {
            return violation(&key, "a recording has an empty `id`", "results are named by it", "give it a name");
        }
        if previous.iter().any(|other| other.id == recording.id) {
            let defect = format!("two recordings have the id `{}`", recording.id);
            return violation(&key, defect, "results are named by it", "give each recording its own");
        }
        Ok(())
    }

    fn check_recording(&self, key: &str, recording: &Recording) -> Checked {
        let needs = |missing: &str, action: &str| {
            let defect = format!("recording `{}` has no {missing}", recording.id);
            violation(key, defect, "its kind cannot be evaluated without", action)
        };
        match recording.kind {
            Kind::Taps if recording.hammer.is_none() => needs("`hammer`", "name the hammer's log"),
            Kind::StillWater if self.tank.is_none() => {
                needs("[tank]", "add [tank] with length and depth (m) to the page")
            }
            Kind::Staircase if recording.pressure.is_none() => needs("`pressure`", "name its pressure log"),
            Kind::Staircase if recording.levels.is_empty() => {
                needs("`levels`", "give the pressures that were held, Pa")
            }
            Kind::Flapping if recording.frequency.is_none() => needs("`frequency`", "give the full cycles a second"),
            Kind::Flapping if recording.pressure.is_none() && recording.seconds.is_none() => {
                needs("`pressure` or `seconds`", "name its pressure log, or say from when to when it flapped")
            }
            _ => Ok(()),
        }
    }
}

impl Settings {
    /// Holds every number to its range: a slip of a unit lies outside, and so does a count that no recording can have.
    fn check_ranges(&self) -> Checked {
        let [low, high] = self.band;
        self.band.iter().try_for_each(|f| within("settings.band", *f, 0.01..=1e4, "Hz"))?;
        if low >= high {
            let defect = format!("settings.band = [{low}, {high}] does not rise");
            return violation(
                "settings.band",
                defect,
                "it is the lowest and the highest frequency, Hz",
                "swap the two",
            );
        }
        within("settings.modes", f64::from(self.modes), 1.0..=10.0, "")?;
        within("settings.level", self.level, 1e-9..=0.5, "")?;
        within("settings.still_limit", self.still_limit, 1e-6..=50.0, "N")?;
        within("settings.harmonics", self.harmonics as f64, 0.0..=100.0, "")?;
        within("settings.settling_cycles", self.settling_cycles, 0.0..=1000.0, "")?;
        within("settings.settling_time", self.settling_time, 0.0..=3600.0, "s")?;
        within("settings.longest_lag", self.longest_lag, 0.02..=5.0, "s")
    }
}

/// Levels of a staircase at most: each is a knot of the fitted curve.
const MOST_LEVELS: usize = 100;

/// Holds every number of a recording to its range.
fn check_numbers(key: &str, recording: &Recording) -> Checked {
    recording.frequency.map_or(Ok(()), |f| within(&format!("{key}.frequency"), f, 0.05..=50.0, "Hz"))?;
    let levels = format!("{key}.levels");
    within(&levels, recording.levels.len() as f64, 0.0..=MOST_LEVELS as f64, "numbers")?;
    for (j, level) in recording.levels.iter().enumerate() {
        within(&format!("{levels}.{j}"), *level, 0.0..=5e5, "Pa")?;
        if recording.levels[..j].contains(level) {
            let defect = format!("recording `{}` has the level {level} Pa twice", recording.id);
            return violation(
                &format!("{levels}.{j}"),
                defect,
                "a level is held once in a list",
                "take one of them out",
            );
        }
    }
    let Some([from, to]) = recording.seconds else { return Ok(()) };
    let seconds = format!("{key}.seconds");
    [from, to].iter().try_for_each(|time| within(&seconds, *time, -1e10..=1e10, "s"))?;
    match from < to {
        true => Ok(()),
        false => {
            let defect = format!("{seconds} = [{from}, {to}] does not rise");
            violation(&seconds, defect, "it is the first and the last second of a run", "swap the two, or correct them")
        }
    }
}

/// The keys of a page with what they are, as `study force --help` prints them.
pub(super) const KEYS: &str = include_str!("keys.txt");
