//! Wave: the force log is put onto the film's clock; the tank's standing waves and the drift of its zero are removed.
//! Paper: section IV, the standing wave.
//!
//! Harmonics of the actuation and waves are fitted together and only the waves are subtracted, so the periodic force keeps amplitude
//! and phase. Where a harmonic coincides with a wave the two cannot be separated, and the record has a warning.

use std::path::Path;

use lab::Logged;
use lab::card::{Experiment, LogKind};
use serde::{Deserialize, Serialize};
use si::{Hertz, Newton, Second, Series};
use signal::edge::{self, Window};
use signal::wave::{self, Beat, Removal};
use signal::zero::Zero;

use super::tank::read_force;
use diagnostics::{Diagnostic, Result};
use records::subject::Trial;
use records::{CorrectedForce, Motion, Tank};
use workflow::needs::Maybe;
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Wave;

/// `[wave]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Harmonics of the actuation that are fitted beside the waves.
    harmonics: usize,
    /// Harmonics that are checked for coincidence with a wave.
    guarded_harmonics: usize,
    /// Settling time after the last command before the zero is read, s.
    settling_time: Second,
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    /// The commanded frequency of a flapping trial, Hz.
    frequency: Option<Hertz>,
    /// Whether nothing was filmed: the logs of force and pressure are then on one clock.
    one_clock: bool,
    /// How the logs are written, and the load cell's own lag.
    log: lab::card::Log,
}

impl Part<Trial> for Card {
    fn part_of(of: &Trial) -> Self {
        let one_clock = of.trial.video.is_none();
        Self { frequency: flapping_frequency(&of.trial.experiment), one_clock, log: of.card.log.clone() }
    }
}

impl Stage for Wave {
    type Settings = Settings;
    type Card = Card;
    type Needs = (Maybe<Tank>, Motion);
    type Makes = CorrectedForce;
    const DESCRIPTION: &'static str = "the tank's waves and the drift of zero are removed from the force";
    const VERSION: u32 = 5;

    fn raw(of: &Trial) -> Vec<RawFile> {
        of.trial.force.iter().map(|file| RawFile::new("force", &of.card.name, file)).collect()
    }

    fn run(
        card: &Self::Card,
        set: &Settings,
        (Maybe(tank), motion): Self::Needs,
        context: &dyn StageContext,
    ) -> Result<CorrectedForce> {
        let Logged { log, sampling } = read_force("force", (LogKind::Force, &card.log), context)?;
        // The lamp is read at once; the force is shown after the cell's own lag.
        let lag = [card.log.force_lag.unwrap_or(0.0), card.log.force_lag_sigma];
        let offset = if card.one_clock { 0.0 } else { lamp_time(&log, context)? - motion.clock.lamp };
        let on_film = Series::new(log.time[0] - offset - lag[0], log.rate(), log.force.clone())?;
        let commanded = command_span(&motion).unwrap_or([on_film.start(), on_film.end()]);
        check_coverage(&on_film, commanded, context)?;
        let beat = card.frequency.map(|frequency| Beat { frequency, harmonics: set.harmonics, within: commanded });
        let waves = tank.map_or(Vec::new(), |t| t.waves);
        let length = on_film.end() - on_film.start();
        let close_harmonics =
            beat.map_or(Vec::new(), |b| wave::close_harmonics(b.frequency, set.guarded_harmonics, &waves, length));
        let (without_waves, fitted_waves) =
            without_waves(&on_film, &waves, beat).map_err(|e| in_force_log(context, e))?;
        let time: Vec<Second> = (0..without_waves.values().len()).map(|i| without_waves.time(i)).collect();
        let zero = Zero { moves: commanded, settling: set.settling_time }.of(&without_waves).values;
        let warnings = close_harmonics.iter().map(ToString::to_string).collect();
        Ok(CorrectedForce {
            time,
            raw: log.force,
            waves: fitted_waves,
            zero,
            offset,
            commanded,
            lag,
            sampling,
            warnings,
        })
    }
}

/// A force log without the tank's waves, and the waves, N.
fn without_waves(
    on_film: &Series,
    waves: &[wave::Wave],
    beat: Option<Beat>,
) -> Result<(Series, Vec<Newton>), signal::EstimationError> {
    // a staircase is not periodic: its force would be taken for a wave
    if beat.is_none() {
        return Ok((on_film.clone(), vec![0.0; on_film.values().len()]));
    }
    let removal = Removal { onsets: &[on_film.start()], beat, drift_degree: 2 };
    wave::remove(on_film, waves, &removal).map(|parted| (parted.rest, parted.waves))
}

/// Holds that a force log lasts from the first command to the last: of a part of a trial the mean force is not that of the trial.
fn check_coverage(on_film: &Series, [first, last]: [Second; 2], context: &dyn StageContext) -> Result<()> {
    // Both clocks are synchronised to a fraction of the force log's step.
    let step = 1.0 / on_film.rate();
    if on_film.start() <= first + step && on_film.end() >= last - step {
        return Ok(());
    }
    let log_span = format!("the log lasts from {:.3} to {:.3} s of the film", on_film.start(), on_film.end());
    let command_span = format!("pressure is commanded from {first:.3} to {last:.3} s");
    Err(Diagnostic::file(
        Path::new(&context.display_path("force")),
        log_span,
        command_span,
        "copy the log again, or record the trial again",
    ))
}

/// The frequency of a flapping trial, Hz.
fn flapping_frequency(experiment: &Experiment) -> Option<f64> {
    match experiment {
        Experiment::Flapping { frequency, .. } => Some(*frequency),
        Experiment::Staircase { .. } => None,
    }
}

/// When the lamp lights, s on the log's clock.
fn lamp_time(log: &lab::ForceLog, context: &dyn StageContext) -> Result<Second> {
    let log_path = context.display_path("force");
    if log.led.is_empty() {
        let purpose = "its clock is synchronised with the film's by the lamp alone";
        return Err(Diagnostic::new(
            format!("{log_path} has no column `led`"),
            purpose,
            "record the lamp on the amplifier too",
        ));
    }
    let width = 1.0 / log.rate();
    let series = Series::new(log.time[0], log.rate(), log.led.clone())?;
    let edges = edge::edges(&series, Window { lead: 0.5 * width, width })
        .map_err(|e| Diagnostic::from(e).while_doing(format!("{log_path}, the lamp")))?;
    Ok(edges[0].time)
}

/// First and last time at which pressure is commanded.
fn command_span(motion: &Motion) -> Option<[Second; 2]> {
    let is_commanded = |i: &usize| motion.gauges.iter().any(|g| g.command[*i] > 0.0);
    let first = (0..motion.log_time.len()).find(is_commanded)?;
    let last = (0..motion.log_time.len()).rev().find(is_commanded)?;
    Some([motion.log_time[first], motion.log_time[last]])
}

fn in_force_log(context: &dyn StageContext, error: signal::EstimationError) -> Diagnostic {
    Diagnostic::from(error).while_doing(context.display_path("force"))
}
