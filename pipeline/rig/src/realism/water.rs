//! Comparisons of flapping in water: mean forces of recordings with those measured on real tails, and the sign of forces and thrust.
//!
//! A mean force is the mean of the log over whole cycles less the zero before the first, as in the measurements; it includes the static force.
//! The thrust is that of the ground truth.

use std::path::Path;

use diagnostics::{Diagnostic, Result};
use lab::card::{Experiment, Medium, Trial};
use lab::truth::{TrueForce, TrueTrial, Truth};
use lab::{ForceLog, Specimen};
use si::{MILLIBAR, Newton, Second};

use super::{Comparison, range_of};

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
/// Tolerance of the mean forces, a factor either way.
const FACTOR: f64 = 2.0;
/// Time before the first command at which the interval for the zero ends, s.
const MARGIN: Second = 0.05;
/// Negative thrust up to this is discretisation error, N.
const ROUNDING: Newton = 1e-3;

/// One recording of flapping in water.
struct Run {
    tail: String,
    pressure: f64,
    frequency: f64,
    /// Mean of the log, N.
    mean: Newton,
    least: Newton,
    /// Least true thrust, N.
    thrust: Newton,
}

/// Comparisons of the recordings under `raw`; none where there are no recordings.
///
/// # Errors
/// When a recording of the bench cannot be read.
pub(super) fn water_comparisons(raw: &Path, names: &[&str]) -> Result<Vec<Comparison>> {
    let mut runs = Vec::new();
    for folder in names.iter().map(|name| raw.join(name)).filter(|folder| folder.is_dir()) {
        runs.extend(of_specimen(&folder)?);
    }
    let mut comparisons: Vec<Comparison> = MEANS.iter().filter_map(|row| mean_comparison(row, &runs)).collect();
    if !runs.is_empty() {
        let least_over_runs = |quantity: fn(&Run) -> Newton| range_of(runs.iter().map(quantity));
        comparisons.push(Comparison::new("least force in water (N)", [-10.0, 0.0], least_over_runs(|run| run.least)));
        let thrust = least_over_runs(|run| if run.thrust > -ROUNDING { run.thrust.max(0.0) } else { run.thrust });
        comparisons.push(Comparison::new("least thrust of the water (N)", [0.0, 10.0], thrust));
    }
    Ok(comparisons)
}

fn mean_comparison(
    (tail, pressure, frequency, mean): &(&str, f64, Option<f64>, Newton),
    runs: &[Run],
) -> Option<Comparison> {
    let same = |run: &&Run| {
        let same_frequency = frequency.is_none_or(|f| (run.frequency - f).abs() < 0.01);
        run.tail == *tail && (run.pressure - pressure).abs() < 0.5 && same_frequency
    };
    let bench = range_of(runs.iter().filter(same).map(|run| run.mean));
    let condition = frequency.map_or_else(|| "any frequency".to_owned(), |f| format!("{f} Hz"));
    let quantity = format!("{tail}: mean force in water at {pressure} mbar and {condition} (N)");
    bench[0].is_finite().then(|| Comparison::new(quantity, [mean / FACTOR, mean * FACTOR], bench))
}

fn of_specimen(folder: &Path) -> Result<Vec<Run>> {
    let of_folder = |e: Diagnostic| e.of(folder.display());
    let specimen = Specimen::open(folder).map_err(of_folder)?;
    let truth = lab::truth::read(&folder.join(lab::folder::TRUTH)).map_err(of_folder)?;
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

fn of_trial(specimen: &Specimen, truth: &Truth, trial: &Trial) -> Result<Option<Run>> {
    let in_trial = |e: Diagnostic| e.of(format!("{}/{}", specimen.card.name, trial.id));
    let Experiment::Flapping { amplitude, frequency, cycles, .. } = trial.experiment else { return Ok(None) };
    let hidden: Option<&TrueTrial> = truth.trial.iter().find(|t| t.id == trial.id);
    let cell: Option<&TrueForce> = truth.force.iter().find(|f| f.id == trial.id);
    let (Some(file), Some(hidden), Some(cell)) = (&trial.force, hidden, cell) else { return Ok(None) };
    let log = lab::force::read(&specimen.file(file)).map_err(in_trial)?;
    let parts = cell.forces.as_ref().map(|parts| lab::truth::read_forces(&specimen.file(parts))).transpose();
    let thrust = parts.map_err(in_trial)?.map_or(0.0, |parts| range_of(parts.thrust)[0]);
    let lamp_on = cell.clock_offset + cell.clock_scale * hidden.led_on;
    let (mean, least) = over_cycles(&log, lamp_on, frequency, cycles);
    let (tail, pressure) = (specimen.card.name.clone(), amplitude / MILLIBAR);
    Ok(Some(Run { tail, pressure, frequency, mean, least, thrust }))
}

/// Mean and least value of `log` over all cycles but the first, less its mean before the first command at `on` (s).
fn over_cycles(log: &ForceLog, on: Second, frequency: f64, cycles: usize) -> (Newton, Newton) {
    let within = |from: Second, to: Second| {
        let inside = log.time.iter().zip(&log.force).filter(move |(t, _)| from <= **t && **t < to);
        inside.map(|(_, force)| *force).collect::<Vec<_>>()
    };
    let mean = |forces: &[Newton]| forces.iter().sum::<f64>() / forces.len().max(1) as f64;
    let zero = mean(&within(f64::NEG_INFINITY, on - MARGIN));
    let flapping = within(on + 1.0 / frequency, on + cycles as f64 / frequency);
    (mean(&flapping) - zero, range_of(flapping)[0] - zero)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_force_is_taken_over_whole_cycles_relative_to_the_zero_before_them() {
        let time: Vec<f64> = (0..800).map(|i| 0.0125 * f64::from(i)).collect();
        let force = |t: f64| if t < 2.0 { 0.3 } else { 0.35 + 0.1 * (std::f64::consts::TAU * 2.0 * t).sin() };
        let log = ForceLog { force: time.iter().map(|t| force(*t)).collect(), time, ..ForceLog::default() };
        let (mean, least) = over_cycles(&log, 2.0, 2.0, 10);
        assert!((mean - 0.05).abs() < 1e-9 && (least + 0.05).abs() < 1e-3, "{mean} {least}");
    }

    #[test]
    fn a_mean_is_compared_over_the_runs_of_its_tail_pressure_and_frequency() {
        let run = |tail: &str, pressure, frequency, mean| Run {
            tail: tail.into(),
            pressure,
            frequency,
            mean,
            least: 0.0,
            thrust: 0.0,
        };
        let runs = [
            run("a", 200.0, 2.0, 0.02),
            run("a", 200.2, 2.0, 0.03),
            run("a", 300.0, 2.0, 9.0),
            run("b", 200.0, 2.0, 9.0),
            run("a", 200.0, 3.0, 0.5),
        ];
        let of = |frequency| mean_comparison(&("a", 200.0, frequency, 0.04), &runs).unwrap();
        assert_eq!(of(Some(2.0)).bench, [0.02, 0.03]);
        assert_eq!(of(None).bench, [0.02, 0.5]);
        assert_eq!(of(None).measured, [0.04 / FACTOR, 0.04 * FACTOR]);
        assert!(mean_comparison(&("c", 200.0, None, 0.04), &runs).is_none());
    }

    #[test]
    fn without_recordings_there_is_no_comparison() {
        assert!(
            water_comparisons(Path::new("/a folder that is not there"), &["nemo"]).is_ok_and(|found| found.is_empty())
        );
    }
}
