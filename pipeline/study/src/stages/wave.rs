//! Wave: the force log comes onto the film's clock, and loses the tank's standing waves and the drift of its zero.
//! Paper: section IV, the standing wave.
//!
//! Beat and waves are fitted together and only the waves are subtracted, so the beat keeps amplitude and phase; where the
//! beat lies in a wave's line that cannot be, and the record says so.
//!
//! Stands on: signal. Never knows: a mesh, a model of thrust.

use lab::card::Experiment;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Second, Series};
use signal::edge::{self, Window};
use signal::wave::{self, Beat};

use super::tank::read_force;
use crate::fault::{Fault, Outcome};
use crate::needs::Maybe;
use crate::records::{Motion, Pull, Tank};
use crate::stage::{Desk, RawFile, Stage};
use crate::subject::Trial;

/// The stage.
pub struct Wave;

/// `[wave]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Harmonics of the beat that are fitted beside the waves.
    harmonics: usize,
    /// Harmonics of the beat that must not lie in a wave's line without a warning.
    guarded: usize,
    /// After the last command, the zero is read from so much later on, s.
    settle: Second,
}

impl Stage for Wave {
    type Settings = Settings;
    type Needs = (Maybe<Tank>, Motion);
    type Makes = Pull;
    const STORY: &'static str = "the force log loses the tank's waves and its zero's drift";
    const EDITION: u32 = 1;

    fn raw(of: &Trial) -> Vec<RawFile> {
        of.trial.force.iter().map(|file| RawFile::new("force", &of.card.name, file)).collect()
    }

    fn card(of: &Trial) -> Value {
        json!(beat(&of.trial.experiment))
    }

    fn run(of: &Trial, set: &Settings, (Maybe(tank), motion): Self::Needs, desk: &dyn Desk) -> Outcome<Pull> {
        let log = read_force("force", desk)?;
        let offset = lamp(&log, desk)? - motion.clock.lamp;
        let on_film = Series::new(log.time[0] - offset, log.rate(), log.force.clone()).map_err(Fault::from_tool)?;
        let commanded = commanded(&motion).unwrap_or([on_film.start(), on_film.end()]);
        let beat =
            beat(&of.trial.experiment).map(|frequency| Beat { frequency, harmonics: set.harmonics, within: commanded });
        let waves = tank.map_or(Vec::new(), |t| t.waves);
        let length = on_film.end() - on_film.start();
        let near = beat.map_or(Vec::new(), |b| wave::near(b.frequency, set.guarded, &waves, length));
        let onsets = [on_film.start()];
        // a staircase is no beat: what it pushes would be taken for a wave
        let (rest, found) = match beat {
            None => (on_film.clone(), vec![0.0; on_film.values().len()]),
            Some(_) => {
                let parted = wave::remove(&on_film, &waves, &onsets, beat, 2).map_err(|e| named(desk, &e))?;
                (parted.rest, parted.waves)
            }
        };
        let time: Vec<Second> = (0..rest.values().len()).map(|i| rest.time(i)).collect();
        let zero = zero(&rest, commanded, set.settle);
        let warnings = near.iter().map(ToString::to_string).collect();
        Ok(Pull { time, raw: log.force, waves: found, zero, offset, commanded, warnings })
    }
}

/// Beats a second of a trial that beats.
fn beat(experiment: &Experiment) -> Option<f64> {
    match experiment {
        Experiment::Flapping { frequency, .. } => Some(*frequency),
        Experiment::Staircase { .. } => None,
    }
}

/// When the lamp lights, s on the log's clock.
fn lamp(log: &lab::ForceLog, desk: &dyn Desk) -> Outcome<Second> {
    let place = desk.place("force");
    if log.led.is_empty() {
        let why = "its clock is tied to the film's by the lamp alone";
        return Err(Fault::new(format!("{place} has no column `led`"), why, "record the lamp on the amplifier too"));
    }
    let width = 1.0 / log.rate();
    let series = Series::new(log.time[0], log.rate(), log.led.clone()).map_err(Fault::from_tool)?;
    let edges = edge::edges(&series, Window { lead: 0.5 * width, width })
        .map_err(|e| Fault::from_tool(format!("{place}, the lamp: {e}")))?;
    Ok(edges[0].time)
}

/// First and last time at which pressure is commanded.
fn commanded(motion: &Motion) -> Option<[Second; 2]> {
    let asked = |i: &usize| motion.gauges.iter().any(|g| g.command[*i] > 0.0);
    let first = (0..motion.log_time.len()).find(asked)?;
    let last = (0..motion.log_time.len()).rev().find(asked)?;
    Some([motion.log_time[first], motion.log_time[last]])
}

/// A line through what rests before the first command and after the last has settled; a level where only the first does.
fn zero(rest: &Series, [first, last]: [Second; 2], settle: Second) -> Vec<f64> {
    let mean = |from: Second, to: Second| {
        let of: Vec<usize> = (0..rest.values().len()).filter(|&i| (from..to).contains(&rest.time(i))).collect();
        let count = of.len() as f64;
        let sum = |value: &dyn Fn(usize) -> f64| of.iter().map(|&i| value(i)).sum::<f64>() / count;
        // a tenth of a second is eight samples, enough for a mean of a millinewton
        (to - from > 0.1 && of.len() >= 8).then(|| [sum(&|i| rest.time(i)), sum(&|i| rest.values()[i])])
    };
    let (before, after) = (mean(rest.start(), first), mean(last + settle, rest.end()));
    let line = |t: Second| match (before, after) {
        (Some([t0, f0]), Some([t1, f1])) => f0 + (f1 - f0) * (t - t0) / (t1 - t0),
        (Some([_, f]), None) | (None, Some([_, f])) => f,
        (None, None) => 0.0,
    };
    (0..rest.values().len()).map(|i| line(rest.time(i))).collect()
}

fn named(desk: &dyn Desk, error: &signal::FitFailed) -> Fault {
    Fault::from_tool(format!("{}: {error}", desk.place("force")))
}
