//! The square wave of greatest mean thrust in the simulator by each thrust model, and the simulator beside a recorded flap.
//!
//! A coarse scan is followed by gradient ascent with finite differences from its best point.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use si::{Hertz, Metre, Newton, Pascal, Second};

use crate::ascent::{Limits, ascend};
use crate::flapping::{FlappingModel, MeanThrust, mean};
use crate::square_wave::SquareWave;
use crate::{Fitted, Run, ThrustModel};
use diagnostics::{Diagnostic, Result};

/// The optimum of one thrust model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Best {
    /// The model's name.
    pub model: String,
    /// The iterates of the ascent, the optimum last.
    pub iterates: Vec<ActuationPoint>,
    /// Prediction of every model at the optimum, N, in the order of the scan.
    pub predicted_n: Vec<Newton>,
    /// Lateral amplitude of the last marker at the optimum over the largest filmed one, no unit: above 1 the models extrapolate.
    pub amplitude_ratio: f64,
    /// Simulated motions, the scan included.
    pub simulations: usize,
}

/// An actuation and its mean thrust.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ActuationPoint {
    /// Pa.
    pub amplitude_pa: Pascal,
    /// Hz.
    pub frequency_hz: Hertz,
    /// One an evaluated model, N.
    pub thrust_n: Vec<Newton>,
}

/// A run with measured force beside its simulation under the measured pressures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// The run's id: the one of greatest mean force within the limit.
    pub run: String,
    /// Lateral amplitude of the last marker, simulated and measured, m.
    pub amplitude_m: [Metre; 2],
    /// Mean force predicted by fitted theory from the simulated and from the measured motion, and the measured mean force, N.
    pub mean_n: [Newton; 3],
}

impl Best {
    /// The optimal actuation.
    pub fn wave(&self) -> Option<&ActuationPoint> {
        self.iterates.last()
    }
}

impl Check {
    /// Relative error of the simulated amplitude, %.
    pub fn amplitude_error_percent(&self) -> f64 {
        100.0 * (self.amplitude_m[0] / self.amplitude_m[1] - 1.0)
    }
}

/// The search of the optimal actuation.
#[derive(Clone, Copy)]
pub struct Search<'a> {
    /// The tail in water.
    pub flapping: &'a FlappingModel<'a>,
    /// The fitted thrust models.
    pub models: &'a [(ThrustModel, Fitted)],
    /// Highest pressure and the frequencies.
    pub limits: Limits,
    /// Sharpness of the wave, no unit.
    pub sharpness: f64,
    /// Amplitudes and frequencies of the scan.
    pub scan: [usize; 2],
}

impl Search<'_> {
    /// An even grid over the limits: amplitudes from half the highest, all frequencies; and how many of its waves the reduced model does not follow.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it follows none.
    pub fn scan(&self, progress: &(dyn Fn(f64) + Sync)) -> Result<(Vec<ActuationPoint>, usize)> {
        let Self { flapping, models, limits, .. } = *self;
        let [amplitudes, frequencies] = self.scan.map(|n| n.max(1));
        let frequencies = if limits.frequency[1] > limits.frequency[0] { frequencies } else { 1 };
        let even_fraction = |i: usize, n: usize, first: f64| first + (1.0 - first) * i as f64 / (n.max(2) - 1) as f64;
        let grid_points: Vec<[f64; 2]> = (0..amplitudes)
            .flat_map(|a| {
                (0..frequencies).map(move |f| {
                    [even_fraction(amplitudes - 1 - a, amplitudes, 0.5), even_fraction(f, frequencies, 0.0)]
                })
            })
            .collect();
        let template = SquareWave { amplitude: 0.0, frequency: 0.0, sharpness: self.sharpness };
        let scan_point = |(number, coordinates): (usize, &[f64; 2])| {
            let wave = limits.wave(*coordinates, template);
            let run = flapping.run(&wave)?;
            progress(number as f64 / grid_points.len() as f64);
            Ok(actuation_point(&wave, models.iter().map(|(_, model)| mean(model, &run)).collect()))
        };
        solved_points(grid_points.par_iter().enumerate().map(scan_point).collect())
    }

    /// Gradient ascent from the best point of the scan by the model at `model_index`; `filmed` is the amplitude of the tip in films, m.
    ///
    /// # Errors
    /// As [`Search::scan`], when nothing was scanned, and when the best wave is not followed a second time.
    pub fn ascend_from(&self, scan: &[ActuationPoint], model_index: usize, filmed: Metre) -> Result<Best> {
        let Self { flapping, models, limits, .. } = *self;
        let (kind, model) = &models[model_index];
        let start = scan.iter().max_by(|a, b| a.thrust_n[model_index].total_cmp(&b.thrust_n[model_index]));
        let start = start.ok_or_else(|| {
            Diagnostic::new("no actuation was scanned", "`[optimal_actuation] scan` has no points", "set at least one")
        })?;
        let start =
            SquareWave { amplitude: start.amplitude_pa, frequency: start.frequency_hz, sharpness: self.sharpness };
        let mut objective = MeanThrust { flapping, model, limits, simulations: scan.len() };
        let iterates = ascend(&mut objective, start, &limits)?;
        let simulations = objective.simulations;
        let run = flapping.run(&iterates[iterates.len() - 1].0)?;
        Ok(Best {
            model: kind.name().into(),
            iterates: iterates.iter().map(|(wave, thrust)| actuation_point(wave, vec![*thrust])).collect(),
            predicted_n: models.iter().map(|(_, model)| mean(model, &run)).collect(),
            amplitude_ratio: run.amplitude_of_tip() / filmed,
            simulations,
        })
    }
}

/// What was found, and how much was not: a reduced tail of thin walls does not follow every wave at the edge of the limits, and none of the others is
/// lost for it.
///
/// # Errors
/// The first [`Diagnostic`] when nothing was found.
pub(crate) fn solved_points<T>(attempts: Vec<Result<T>>) -> Result<(Vec<T>, usize)> {
    let (mut solved, mut failures) = (Vec::new(), Vec::new());
    for attempt in attempts {
        match attempt {
            Ok(point) => solved.push(point),
            Err(failure) => failures.push(failure),
        }
    }
    let count = failures.len();
    match failures.into_iter().next() {
        Some(failure) if solved.is_empty() => Err(failure),
        _ => Ok((solved, count)),
    }
}

fn actuation_point(wave: &SquareWave, thrust_n: Vec<f64>) -> ActuationPoint {
    ActuationPoint { amplitude_pa: wave.amplitude, frequency_hz: wave.frequency, thrust_n }
}

/// A square wave overshoots the pressure of a held step: a run counts as within the limits up to this factor.
const NEAR: f64 = 1.05;

/// Of the runs within the limits, the one of greatest mean force.
///
/// # Errors
/// A [`Diagnostic`] when every run was at a higher pressure.
pub fn best_recorded<'a>(runs: &'a [Run], limits: &Limits) -> Result<&'a Run> {
    let candidates = runs.iter().filter(|r| highest_pressure(r) <= NEAR * limits.amplitude);
    candidates.max_by(|a, b| a.mean_force().total_cmp(&b.mean_force())).ok_or_else(|| {
        let limit = format!("moduli were identified up to {:.0} Pa", limits.amplitude);
        Diagnostic::new(
            "no run can be compared with the simulator",
            limit,
            "record a trial with a force log at a lower pressure",
        )
    })
}

/// A recorded run beside its simulation under its measured pressures, repeated periodically.
///
/// # Errors
/// As [`Search::scan`].
pub fn check(flapping: &FlappingModel, theory: &Fitted, run: &Run) -> Result<Check> {
    let pressures = run.periodic_pressures()?;
    let pressures_at = |t: Second| pressures.iter().map(|p| p(t)).collect();
    let simulated = flapping.run_under(run.frequency, run.amplitude, &pressures_at)?;
    Ok(Check {
        run: run.id.clone(),
        amplitude_m: [simulated.amplitude_of_tip(), run.amplitude_of_tip()],
        mean_n: [mean(theory, &simulated), mean(theory, run), run.mean_force()],
    })
}

/// The highest measured pressure of a run, Pa: below the command where a half cycle is too short to fill the chamber.
pub fn highest_pressure(run: &Run) -> Pascal {
    run.pressure.iter().flatten().copied().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_found_is_counted_and_is_an_error_where_nothing_is() {
        let failure = || Err(Diagnostic::new("no step is found", "why", "do"));
        assert_eq!(solved_points(vec![Ok(1), failure(), Ok(3)]).unwrap(), (vec![1, 3], 1));
        assert_eq!(solved_points::<i32>(vec![failure(), failure()]).unwrap_err().what, "no step is found");
    }
}
