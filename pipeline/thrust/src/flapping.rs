//! The reduced model flapping in still water under a square wave of pressure. Its motion is a [`Run`], so that every thrust model can
//! be evaluated on it.

use fem::{DynamicSettings, Scheme};
use hydro::{Coefficients, Tail};
use nalgebra::DMatrix;
use si::{Hertz, Newton, Pascal, Point2, Second};

use super::{Fitted, Run, run};
use crate::ascent::{Limits, Objective};
use crate::real_time::Surroundings;
use crate::square_wave::SquareWave;
use diagnostics::Result;
use sysid::{ForcedMotion, ReducedBody, even_times};

/// A reduced model in water.
pub struct FlappingModel<'a> {
    /// The reduced model.
    pub reduced_body: &'a ReducedBody,
    /// The tail in elongated-body theory.
    pub tail: &'a Tail,
    /// Rows of the markers from the head to the fin, (markers × 2) × coordinates, m.
    pub rows: &'a DMatrix<f64>,
    /// The tail for the hydrodynamic force, and the rows of its stations.
    pub wet: (&'a Tail, &'a DMatrix<f64>),
    /// The half of the cycle in which each chamber is filled, 0 or 1; none of a chamber that stays vented.
    pub halves: Vec<Option<usize>>,
    /// Hydrodynamic coefficients.
    pub by: Coefficients,
    /// Whether half of the body is modelled.
    pub half: bool,
    /// Time steps of one cycle.
    pub steps_per_cycle: usize,
    /// Settling cycles, and cycles over which thrust is averaged.
    pub cycles: [usize; 2],
}

/// Places and velocities of the markers after each step, m and m/s: steps × markers.
type Motion = (Vec<Vec<Point2>>, Vec<Vec<Point2>>);

impl FlappingModel<'_> {
    /// The averaged cycles of a wave, as a run without a measured force.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when a step finds no motion.
    pub fn run(&self, wave: &SquareWave) -> Result<Run> {
        let pressures = |t: Second| {
            let side_pressures = wave.at(t);
            self.halves.iter().map(|half| half.map_or(0.0, |half| side_pressures[half])).collect()
        };
        self.run_under(wave.frequency, wave.amplitude, &pressures)
    }

    /// The same under any `pressures` (one a chamber, Pa, at a time in s) of period 1/`frequency` (Hz).
    ///
    /// # Errors
    /// As [`FlappingModel::run`].
    pub fn run_under(
        &self,
        frequency: Hertz,
        amplitude: Pascal,
        pressures: &dyn Fn(Second) -> Vec<Pascal>,
    ) -> Result<Run> {
        let rate = frequency * self.steps_per_cycle as f64;
        let [settle, counted] = self.cycles;
        let (moved, speed) = self.simulated_motion(rate, (settle + counted) * self.steps_per_cycle, pressures)?;
        let time: Vec<Second> = (1..=moved.len()).map(|i| i as f64 / rate).collect();
        let pressure: Vec<Vec<Pascal>> = time.iter().map(|&t| pressures(t)).collect();
        let rates: Vec<Vec<f64>> = (0..self.halves.len())
            .map(|chamber| run::central_rates(&pressure.iter().map(|p| p[chamber]).collect::<Vec<_>>(), rate))
            .collect();
        let pressure_rate: Vec<Vec<f64>> =
            (0..time.len()).map(|i| rates.iter().map(|chamber| chamber[i]).collect()).collect();
        let terms = run::theory_terms(self.tail, &moved, &speed, rate);
        let first_counted = settle * self.steps_per_cycle;
        Ok(Run {
            id: format!("{amplitude:.0} Pa at {frequency:.2} Hz"),
            amplitude,
            frequency,
            split: None,
            rate,
            force: vec![0.0; time.len() - first_counted],
            time: time[first_counted..].to_vec(),
            moved: moved[first_counted..].to_vec(),
            speed: speed[first_counted..].to_vec(),
            pressure: pressure[first_counted..].to_vec(),
            pressure_rate: pressure_rate[first_counted..].to_vec(),
            terms: terms[first_counted..].to_vec(),
        })
    }

    fn simulated_motion(&self, rate: Hertz, steps: usize, pressures: &dyn Fn(Second) -> Vec<Pascal>) -> Result<Motion> {
        let settings = DynamicSettings { step: 1.0 / rate, scheme: Scheme::Bdf2, ..DynamicSettings::default() };
        let water = Surroundings { tail: self.wet.0, rows: self.wet.1, by: self.by, half: self.half };
        let (mut moved, mut speed) = (Vec::with_capacity(steps), Vec::with_capacity(steps));
        let times = even_times(settings.step, steps);
        let motion = ForcedMotion { settings: &settings, pressures, times: &times };
        water.integrate(self.reduced_body, &motion, &mut |q, v| {
            moved.push(super::water::points(self.rows * q));
            speed.push(super::water::points(self.rows * v));
        })?;
        Ok((moved, speed))
    }
}

/// Mean thrust of a flapping model by a fitted thrust model; counts its simulations.
pub struct MeanThrust<'a> {
    /// The flapping model.
    pub flapping: &'a FlappingModel<'a>,
    /// The thrust model.
    pub model: &'a Fitted,
    /// Limits of the search.
    pub limits: Limits,
    /// Number of simulations so far.
    pub simulations: usize,
}

/// Half the width of a central difference, relative to the width of the limits.
const NUDGE: f64 = 5e-3;

/// The mean thrust of a run predicted by a model, N.
pub fn mean(model: &Fitted, run: &Run) -> Newton {
    let predicted = model.predict(run);
    predicted.iter().sum::<f64>() / predicted.len().max(1) as f64
}

impl Objective for MeanThrust<'_> {
    // A wave that the reduced model does not follow is worth less than any: the ascent turns back from it.
    fn value(&mut self, wave: &SquareWave) -> Result<Newton> {
        self.simulations += 1;
        Ok(self.flapping.run(wave).map_or(f64::NEG_INFINITY, |run| mean(self.model, &run)))
    }

    fn gradient(&mut self, wave: &SquareWave) -> Result<[f64; 2]> {
        let coordinates = self.limits.place(wave);
        let mut slope_along = |k: usize| -> Result<f64> {
            let (mut lower, mut upper) = (coordinates, coordinates);
            (lower[k], upper[k]) = ((coordinates[k] - NUDGE).max(0.0), (coordinates[k] + NUDGE).min(1.0));
            let (lower_wave, upper_wave) = (self.limits.wave(lower, *wave), self.limits.wave(upper, *wave));
            let width = [upper_wave.amplitude - lower_wave.amplitude, upper_wave.frequency - lower_wave.frequency][k];
            let rise = self.value(&upper_wave)? - self.value(&lower_wave)?;
            // beside a wave that is not followed there is no slope
            Ok(if width > 0.0 && rise.is_finite() { rise / width } else { 0.0 })
        };
        Ok([slope_along(0)?, slope_along(1)?])
    }
}
