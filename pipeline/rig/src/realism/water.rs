//! Flapping in water: mean forces, thrust and recoil of recordings that lie there, beside those measured on real tails.
//!
//! A mean force is that of the log over whole beats less the zero before the first: as it was measured, with what follows
//! pressure in it. The water's own thrust is told by the truth.
//!
//! Stands on: `lab` (cards, logs, truth). Never knows: how a recording is made.

use std::path::Path;

use lab::card::{Experiment, Medium, Trial};
use lab::truth::{TrueForce, TrueTrial, Truth};
use lab::{ForceLog, Specimen};
use si::{MILLIBAR, Newton, Second};

use super::{Figure, range};
use crate::fault::Fault;

/// Tail, mbar, Hz, mean force in water (N). The twelve-chambered and the stiffer tail were measured once for all frequencies.
const MEANS: [(&str, f64, Option<f64>, Newton); 11] = [
    ("nemo", 200.0, Some(1.0), 0.050),
    ("nemo", 200.0, Some(2.0), 0.049),
    ("nemo", 200.0, Some(4.0), 0.041),
    ("nemo", 300.0, Some(1.0), 0.209),
    ("nemo", 300.0, Some(2.0), 0.133),
    ("nemo", 300.0, Some(3.0), 0.104),
    ("nemo", 300.0, Some(4.0), 0.079),
    ("dory", 350.0, None, 0.067),
    ("dory", 500.0, None, 0.130),
    ("bruce", 500.0, None, 0.066),
    ("bruce", 750.0, None, 0.134),
];
/// Ours may be this many times more or less.
const FACTOR: f64 = 2.0;
/// A log is looked at for its zero until this long before the first command, s.
const SETTLED: Second = 0.05;
/// Thrust that is told as negative by less than this is rounding of a step, N.
const ROUNDING: Newton = 1e-3;

/// What one recording of flapping in water shows.
struct Run {
    tail: String,
    pressure: f64,
    frequency: f64,
    /// Of the log, N.
    mean: Newton,
    least: Newton,
    /// Least thrust of the truth, N.
    thrust: Newton,
}

/// Figures of the recordings under `raw`; none where nothing was recorded.
///
/// # Errors
/// [`Fault`] when a recording of the bench cannot be read.
pub(super) fn figures(raw: &Path, names: &[&str]) -> Result<Vec<Figure>, Fault> {
    let mut runs = Vec::new();
    for folder in names.iter().map(|name| raw.join(name)).filter(|folder| folder.is_dir()) {
        runs.extend(of_specimen(&folder)?);
    }
    let mut figures: Vec<Figure> = MEANS.iter().filter_map(|row| mean_figure(row, &runs)).collect();
    if !runs.is_empty() {
        let least = |of: fn(&Run) -> Newton| range(runs.iter().map(of));
        figures.push(Figure::new("least of a log in water (N)", [-10.0, 0.0], least(|run| run.least)));
        let thrust = least(|run| if run.thrust > -ROUNDING { run.thrust.max(0.0) } else { run.thrust });
        figures.push(Figure::new("least thrust of the water (N)", [0.0, 10.0], thrust));
    }
    Ok(figures)
}

fn mean_figure((tail, pressure, frequency, mean): &(&str, f64, Option<f64>, Newton), runs: &[Run]) -> Option<Figure> {
    let same = |run: &&Run| {
        let beat = frequency.is_none_or(|f| (run.frequency - f).abs() < 0.01);
        run.tail == *tail && (run.pressure - pressure).abs() < 0.5 && beat
    };
    let ours = range(runs.iter().filter(same).map(|run| run.mean));
    let at = frequency.map_or_else(|| "any beat".to_owned(), |f| format!("{f} Hz"));
    let quantity = format!("{tail} mean in water at {pressure} mbar and {at} (N)");
    ours[0].is_finite().then(|| Figure::new(quantity, [mean / FACTOR, mean * FACTOR], ours))
}

fn of_specimen(folder: &Path) -> Result<Vec<Run>, Fault> {
    let said = |e| Fault::at(folder.display().to_string(), e);
    let specimen = Specimen::open(folder).map_err(said)?;
    let truth = lab::truth::read(&folder.join(lab::folder::TRUTH)).map_err(said)?;
    let flaps =
        |trial: &&Trial| trial.medium == Medium::Water && matches!(trial.experiment, Experiment::Flapping { .. });
    specimen
        .card
        .trial
        .iter()
        .filter(flaps)
        .filter_map(|trial| of_trial(&specimen, &truth, trial).transpose())
        .collect()
}

fn of_trial(specimen: &Specimen, truth: &Truth, trial: &Trial) -> Result<Option<Run>, Fault> {
    let said = |e| Fault::at(format!("{}/{}", specimen.card.name, trial.id), e);
    let Experiment::Flapping { amplitude, frequency, cycles, .. } = trial.experiment else { return Ok(None) };
    let hidden: Option<&TrueTrial> = truth.trial.iter().find(|t| t.id == trial.id);
    let cell: Option<&TrueForce> = truth.force.iter().find(|f| f.id == trial.id);
    let (Some(file), Some(hidden), Some(cell)) = (&trial.force, hidden, cell) else { return Ok(None) };
    let log = lab::force::read(&specimen.file(file)).map_err(said)?;
    let parts = cell.forces.as_ref().map(|parts| lab::truth::read_forces(&specimen.file(parts))).transpose();
    let thrust = parts.map_err(said)?.map_or(0.0, |parts| range(parts.thrust)[0]);
    let on = cell.clock_offset + cell.clock_scale * hidden.led_on;
    let (mean, least) = over_beats(&log, on, frequency, cycles);
    let (tail, pressure) = (specimen.card.name.clone(), amplitude / MILLIBAR);
    Ok(Some(Run { tail, pressure, frequency, mean, least, thrust }))
}

/// Mean and least of `log` over all beats but the first, less its mean before the first command at `on` (s).
fn over_beats(log: &ForceLog, on: Second, frequency: f64, cycles: usize) -> (Newton, Newton) {
    let within = |from: Second, to: Second| {
        let inside = log.time.iter().zip(&log.force).filter(move |(t, _)| from <= **t && **t < to);
        inside.map(|(_, force)| *force).collect::<Vec<_>>()
    };
    let mean = |forces: &[Newton]| forces.iter().sum::<f64>() / forces.len().max(1) as f64;
    let zero = mean(&within(f64::NEG_INFINITY, on - SETTLED));
    let beats = within(on + 1.0 / frequency, on + cycles as f64 / frequency);
    (mean(&beats) - zero, range(beats)[0] - zero)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_is_taken_over_whole_beats_from_the_zero_before_them() {
        let time: Vec<f64> = (0..800).map(|i| 0.0125 * f64::from(i)).collect();
        let force = |t: f64| if t < 2.0 { 0.3 } else { 0.35 + 0.1 * (std::f64::consts::TAU * 2.0 * t).sin() };
        let log = ForceLog { force: time.iter().map(|t| force(*t)).collect(), time, ..ForceLog::default() };
        let (mean, least) = over_beats(&log, 2.0, 2.0, 10);
        assert!((mean - 0.05).abs() < 1e-9 && (least + 0.05).abs() < 1e-3, "{mean} {least}");
    }

    #[test]
    fn where_nothing_was_recorded_there_is_no_figure() {
        assert!(figures(Path::new("/a folder that is not there"), &["nemo"]).is_ok_and(|found| found.is_empty()));
    }
}
