//! The waveform of greatest mean thrust, or of greatest thrust per air, by the adjoint of the reduced motion.
//!
//! A [`Twin`] flaps in still water under the pressures of a valve that follows the waveform; fitted theory gives the thrust of its motion. One
//! adjoint gives the derivatives by every pressure, and with them those by all harmonics; the frequency, which changes the
//! length of every step, is differentiated by two further motions. Adam \[kingma2015\] climbs from the best square wave.

use hydro::Tail;
use nalgebra::{DMatrix, DVector};
use optimize::optimisers::adam::{Adam, Settings};
use optimize::{Bounds, Evaluation, Needs, Problem, minimise};
use si::{Hertz, Metre, Newton, Pascal, Point2, Second};
use twin::{Chamber, LossGradient, Recording, Twin};

use crate::ascent::Limits;
use crate::simulated::{Weights, theory_contribution};
use crate::waveform::{OF_SIDE, PARAMETERS, Valve, Waveform};
use diagnostics::Result;
use sysid::Interrupted;

/// Ambient pressure, Pa.
const AMBIENT: Pascal = 101_325.0;
/// Half the width of the difference by frequency, relative to its limits.
const NUDGE: f64 = 5e-3;
/// Length of a step of Adam, a part of the interval of each number: an amplitude, whose interval is a sixteenth of a coefficient's, would otherwise leap.
const STEP: f64 = 0.0125;
/// How fast steps shrink, 1/iterations.
const STEP_DECAY: f64 = 0.05;

/// What is maximised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    /// Mean thrust, N.
    Thrust,
    /// Mean thrust over the flow of air, N s/m³ at ambient pressure.
    ThrustPerAir,
}

/// A tail that flaps under a waveform.
#[derive(Clone, Copy)]
pub struct WaveformModel<'a> {
    /// The reduced tail in water.
    pub twin: &'a Twin,
    /// Its chambers.
    pub chambers: &'a [Chamber],
    /// The side that fills each chamber, 0 or 1; none of a chamber that stays vented.
    pub halves: &'a [Option<usize>],
    /// Rows of the markers of theory, (markers × 2) × coordinates, m.
    pub rows: &'a DMatrix<f64>,
    /// The tail in theory, and its five coefficients.
    pub theory: (&'a Tail, [f64; 5]),
    /// Modelled fraction of the tail: ½ of a half model.
    pub share: f64,
    /// The valve.
    pub valve: Valve,
    /// Highest pressure and the frequencies; iterations of Adam.
    pub limits: Limits,
    /// Time steps of one cycle.
    pub steps_per_cycle: usize,
    /// Settling cycles, and cycles over which thrust and air are averaged.
    pub cycles: [usize; 2],
}

/// Mean thrust and flow of air of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Performance {
    /// N.
    pub thrust: Newton,
    /// m³/s at ambient pressure, drawn by all chambers.
    pub air: f64,
    /// Lateral amplitude of the last marker, m.
    pub amplitude: Metre,
}

/// The last cycle of a motion.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cycle {
    pub(crate) performance: Performance,
    /// Commands and pressures of both sides, Pa.
    pub(crate) commands: [Vec<Pascal>; 2],
    pub(crate) pressures: [Vec<Pascal>; 2],
}

/// The maximum.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimum {
    /// The best waveform.
    pub waveform: Waveform,
    /// Its performance.
    pub performance: Performance,
    /// Value of the goal at every evaluation, in its unit; none where the reduced tail could not follow.
    pub values: Vec<Option<f64>>,
}

/// A simulated motion.
struct Flapping {
    recording: Recording,
    /// Of both sides, after each step: commands over the highest pressure, and pressures, Pa.
    commands: [Vec<f64>; 2],
    pressures: [Vec<Pascal>; 2],
    /// s.
    step: f64,
}

/// Derivatives of a goal by the thrust and by the flow of air.
type ByPerformance = [f64; 2];

impl Goal {
    /// Its name.
    pub(crate) fn goal_name(self) -> &'static str {
        match self {
            Self::Thrust => "thrust",
            Self::ThrustPerAir => "thrust_per_air",
        }
    }

    /// Its value.
    pub fn value(self, performance: &Performance) -> f64 {
        match self {
            Self::Thrust => performance.thrust,
            Self::ThrustPerAir => performance.thrust / performance.air.max(f64::MIN_POSITIVE),
        }
    }

    fn slope_by_performance(self, performance: &Performance) -> ByPerformance {
        match self {
            Self::Thrust => [1.0, 0.0],
            Self::ThrustPerAir => {
                [1.0, -self.value(performance)].map(|slope| slope / performance.air.max(f64::MIN_POSITIVE))
            }
        }
    }
}

impl WaveformModel<'_> {
    /// Thrust and air of a waveform.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when a step finds no motion.
    pub fn performance(&self, waveform: &Waveform) -> Result<Performance> {
        Ok(self.mean_performance(&self.flapping_under(waveform)?))
    }

    /// The last cycle under a waveform.
    pub(crate) fn last_cycle(&self, waveform: &Waveform) -> Result<Cycle> {
        Ok(self.last_cycle_of(&self.flapping_under(waveform)?))
    }

    /// The last cycle under any pressure of a side (Pa, at a time in s) of this frequency.
    pub(crate) fn cycle_under(
        &self,
        frequency: Hertz,
        side_pressure: &dyn Fn(usize, Second) -> Pascal,
    ) -> Result<Cycle> {
        let step = 1.0 / (frequency * self.steps_per_cycle as f64);
        let pressures = [0, 1]
            .map(|side| (1..=self.step_count()).map(|n| side_pressure(side, n as f64 * step)).collect::<Vec<_>>());
        let commands =
            pressures.clone().map(|side_pressure| side_pressure.iter().map(|p| p / self.limits.amplitude).collect());
        Ok(self.last_cycle_of(&self.simulated_flapping(commands, pressures, step)?))
    }

    fn last_cycle_of(&self, flapping: &Flapping) -> Cycle {
        let last_start = self.step_count() - self.steps_per_cycle;
        Cycle {
            performance: self.mean_performance(flapping),
            commands: flapping
                .commands
                .each_ref()
                .map(|series| series[last_start..].iter().map(|c| c * self.limits.amplitude).collect()),
            pressures: flapping.pressures.each_ref().map(|series| series[last_start..].to_vec()),
        }
    }

    /// The goal's value and its derivatives by the waveform's numbers.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when a step finds no motion or has no adjoint.
    pub fn gradient(&self, goal: Goal, waveform: &Waveform) -> Result<(f64, Vec<f64>)> {
        let flapping = self.flapping_under(waveform)?;
        let performance = self.mean_performance(&flapping);
        let weights = goal.slope_by_performance(&performance);
        let mut loss = |n: usize| self.loss_gradient(&flapping, n, weights);
        let adjoint = self.twin.adjoint(&flapping.recording, &mut loss)?.pressures;
        let mut gradient = vec![0.0; PARAMETERS];
        for side in 0..2 {
            let slope_by_pressure = |(n, step): (usize, &Vec<f64>)| -> f64 {
                let chamber_slope =
                    |chamber: usize| step[chamber] + weights[1] * self.air_by_pressure(&flapping, n, chamber);
                self.chambers_of(side).map(chamber_slope).sum::<f64>() * self.limits.amplitude
            };
            let by_pressure: Vec<f64> = adjoint.iter().enumerate().map(slope_by_pressure).collect();
            let relative_pressures: Vec<f64> =
                flapping.pressures[side].iter().map(|p| p / self.limits.amplitude).collect();
            let by_command =
                self.valve.adjoint([&flapping.commands[side], &relative_pressures, &by_pressure], flapping.step);
            waveform.add_gradient(side, (&by_command, self.steps_per_cycle), &mut gradient);
        }
        gradient[0] = self.slope_by_frequency(goal, waveform)?;
        Ok((goal.value(&performance), gradient))
    }

    /// The waveform of the greatest value, from `start`.
    ///
    /// # Errors
    /// As [`WaveformModel::gradient`].
    pub fn maximise(&self, goal: Goal, start: &Waveform) -> Result<Optimum> {
        let [low, high] = Waveform::bounds();
        let indices = self.free_numbers();
        let waveform = |point: &[f64]| {
            let mut numbers = start.numbers.clone();
            indices
                .iter()
                .zip(point)
                .for_each(|(n, coordinate)| numbers[*n] = low[*n] + coordinate * (high[*n] - low[*n]));
            Waveform { numbers }
        };
        let start_point: Vec<f64> =
            indices.iter().map(|n| (start.numbers[*n] - low[*n]) / (high[*n] - low[*n])).collect();
        let names: Vec<String> = indices.iter().map(|n| format!("number {n} of the waveform")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let bounds = Bounds { low: vec![0.0; indices.len()], high: vec![1.0; indices.len()] };
        let problem = Problem::new(&names, start_point, bounds)?;
        let iterations = self.limits.iterations.max(1);
        let settings = Settings { step: STEP, step_decay: STEP_DECAY, iterations, ..Settings::default() };
        let evaluation = |point: &Vec<f64>| -> Result<Evaluation> {
            // a waveform that the reduced tail cannot follow is worth nothing, and ends no ascent
            let Ok((value, gradient)) = self.gradient(goal, &waveform(point)) else {
                return Ok(Evaluation::of_loss(point.clone(), f64::INFINITY));
            };
            let gradient = Some(indices.iter().map(|n| -gradient[*n] * (high[*n] - low[*n])).collect());
            Ok(Evaluation { gradient, ..Evaluation::of_loss(point.clone(), -value) })
        };
        let mut objective = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, Interrupted> {
            batch.iter().map(|point| evaluation(point).map_err(Interrupted)).collect()
        };
        let log = minimise(&mut Adam::new(&problem, &settings)?, &mut objective).map_err(|stop| stop.0)?;
        let best_waveform = waveform(&log.best.at);
        let losses = log.entries.iter().map(|entry| entry.evaluation.loss);
        let values = losses.map(|loss| loss.is_finite().then_some(-loss)).collect();
        Ok(Optimum { performance: self.performance(&best_waveform)?, waveform: best_waveform, values })
    }

    /// The numbers that thrust depends on: the frequency where its limits differ, and those of a side that fills a chamber.
    fn free_numbers(&self) -> Vec<usize> {
        let [low, high] = self.limits.frequency;
        let has_chamber = [0, 1].map(|side| self.chambers_of(side).next().is_some());
        let is_free = |n: &usize| n.checked_sub(1).map_or(high > low, |side_number| has_chamber[side_number / OF_SIDE]);
        (0..PARAMETERS).filter(is_free).collect()
    }

    fn slope_by_frequency(&self, goal: Goal, waveform: &Waveform) -> Result<f64> {
        let [low, high] = self.limits.frequency;
        let centre = waveform.numbers[0];
        let [lower, upper] = [(centre - NUDGE).max(0.0), (centre + NUDGE).min(1.0)];
        if high <= low {
            return Ok(0.0);
        }
        let value_at = |frequency: f64| {
            let mut shifted = waveform.clone();
            shifted.numbers[0] = frequency;
            self.performance(&shifted).map(|performance| goal.value(&performance))
        };
        Ok((value_at(upper)? - value_at(lower)?) / (upper - lower))
    }

    /// Steps of all cycles.
    fn step_count(&self) -> usize {
        self.steps_per_cycle * self.cycles.iter().sum::<usize>()
    }

    fn flapping_under(&self, waveform: &Waveform) -> Result<Flapping> {
        let step = 1.0 / (waveform.frequency(&self.limits) * self.steps_per_cycle as f64);
        let commands = [0, 1].map(|side| waveform.command_series(side, (self.step_count(), self.steps_per_cycle)));
        let pressures = [0, 1].map(|side: usize| -> Vec<Pascal> {
            self.valve
                .follow(&commands[side], step)
                .iter()
                .map(|relative_pressure| relative_pressure * self.limits.amplitude)
                .collect()
        });
        self.simulated_flapping(commands, pressures, step)
    }

    fn simulated_flapping(
        &self,
        commands: [Vec<f64>; 2],
        pressures: [Vec<Pascal>; 2],
        step: Second,
    ) -> Result<Flapping> {
        let mut recording = self.twin.recording();
        let chamber_pressures = |n: usize| -> Vec<Pascal> {
            self.halves.iter().map(|half| half.map_or(0.0, |side| pressures[side][n])).collect()
        };
        (0..self.step_count()).try_for_each(|n| self.twin.record(&mut recording, &chamber_pressures(n), step))?;
        Ok(Flapping { recording, commands, pressures, step })
    }

    /// First step of the averages, and their number.
    fn averaged_steps(&self) -> (usize, usize) {
        (self.cycles[0] * self.steps_per_cycle, self.cycles[1] * self.steps_per_cycle)
    }

    fn mean_performance(&self, flapping: &Flapping) -> Performance {
        let (first, count) = self.averaged_steps();
        let thrust =
            (0..first + count).map(|n| self.thrust_contribution(flapping, n).map_or(0.0, |(value, ..)| value)).sum();
        let drawn: f64 = (0..self.chambers.len())
            .map(|chamber| (first..first + count).map(|n| self.drawn_air(flapping, n, chamber).max(0.0)).sum::<f64>())
            .sum();
        let air = drawn / (count as f64 * flapping.step * self.share);
        Performance { thrust, air, amplitude: self.tip_amplitude(flapping) }
    }

    fn tip_amplitude(&self, flapping: &Flapping) -> Metre {
        let (first, count) = self.averaged_steps();
        let tip_row = self.rows.row(self.rows.nrows() - 1);
        let lateral =
            |n: usize| tip_row.iter().zip(flapping.recording.coordinates(n)).map(|(row, q)| row * q).sum::<f64>();
        let widened = |[low, high]: [f64; 2], y: f64| [low.min(y), high.max(y)];
        let [low, high] = (first..first + count).map(lateral).fold([f64::INFINITY, f64::NEG_INFINITY], widened);
        0.5 * (high - low).max(0.0)
    }

    /// The share of step `n` in the mean thrust, and its derivatives by the markers' displacements and velocities, flat.
    fn thrust_contribution(&self, flapping: &Flapping, n: usize) -> Option<(f64, DVector<f64>, DVector<f64>)> {
        let (first, count) = self.averaged_steps();
        let end_weight = |end: bool| f64::from(u8::from(end)) / (count as f64 * flapping.step);
        let ends = end_weight(n + 1 == first + count) - end_weight(n + 1 == first);
        let part = f64::from(u8::from(n >= first)) / count as f64;
        if part == 0.0 && ends == 0.0 {
            return None;
        }
        let marker_points = |values: &[f64]| super::water::points(self.rows * DVector::from_column_slice(values));
        let (moved, speed) =
            (marker_points(flapping.recording.coordinates(n)), marker_points(flapping.recording.velocity(n)));
        let (tail, coefficients) = &self.theory;
        let instant = theory_contribution(&tail.terms(&moved, &speed), coefficients, Weights { part, ends }, &speed);
        let flattened = |values: &[Point2]| DVector::from_iterator(2 * values.len(), values.iter().flatten().copied());
        Some((instant.value, flattened(&instant.by_place), flattened(&instant.by_velocity)))
    }

    /// Derivatives of the goal by the state after step `n`.
    fn loss_gradient(&self, flapping: &Flapping, n: usize, [by_thrust, by_air]: ByPerformance) -> LossGradient {
        let mut coordinates = DVector::zeros(self.twin.coordinates());
        let mut velocity = DVector::zeros(self.twin.coordinates());
        if let Some((_, by_place, by_velocity)) = self.thrust_contribution(flapping, n) {
            coordinates += self.rows.tr_mul(&by_place) * by_thrust;
            velocity += self.rows.tr_mul(&by_velocity) * by_thrust;
        }
        for chamber in (0..self.chambers.len()).filter(|_| by_air != 0.0) {
            let weight = by_air * self.air_weight(flapping, n, chamber);
            let volume_weight = weight * (1.0 + self.chamber_pressure(flapping, n, chamber) / AMBIENT);
            if volume_weight != 0.0 {
                let volume_slope = self.chambers[chamber].volume_gradient(flapping.recording.coordinates(n));
                coordinates += DVector::from_vec(volume_slope) * volume_weight;
            }
        }
        LossGradient { coordinates: coordinates.as_slice().to_vec(), velocity: velocity.as_slice().to_vec() }
    }

    fn chambers_of(&self, side: usize) -> impl Iterator<Item = usize> {
        self.halves.iter().enumerate().filter(move |(_, half)| **half == Some(side)).map(|(chamber, _)| chamber)
    }

    fn chamber_pressure(&self, flapping: &Flapping, n: usize, chamber: usize) -> Pascal {
        self.halves[chamber].map_or(0.0, |side| flapping.pressures[side][n])
    }

    /// Air in a chamber after step `n`, m³ at ambient pressure.
    fn air_content(&self, flapping: &Flapping, n: usize, chamber: usize) -> f64 {
        let volume = self.chambers[chamber].volume(flapping.recording.coordinates(n));
        (1.0 + self.chamber_pressure(flapping, n, chamber) / AMBIENT) * volume
    }

    /// Air that a chamber draws in step `n`, m³; negative when it loses air, and nothing of a vented chamber, which breathes ambient air.
    fn drawn_air(&self, flapping: &Flapping, n: usize, chamber: usize) -> f64 {
        let previous_content = |n: usize| self.air_content(flapping, n - 1, chamber);
        match self.halves[chamber] {
            Some(_) if n > 0 => self.air_content(flapping, n, chamber) - previous_content(n),
            _ => 0.0,
        }
    }

    /// Derivative of the flow of air by a chamber's content after step `n`, 1/s: what it draws in that step less what it draws in the next.
    fn air_weight(&self, flapping: &Flapping, n: usize, chamber: usize) -> f64 {
        let (first, count) = self.averaged_steps();
        let draws_air = |n: usize| {
            let counts = (first..first + count).contains(&n) && self.drawn_air(flapping, n, chamber) > 0.0;
            f64::from(u8::from(counts))
        };
        (draws_air(n) - draws_air(n + 1)) / (count as f64 * flapping.step * self.share)
    }

    /// Derivative of the flow of air by the pressure of a chamber in step `n` at a fixed shape, m³/(s Pa).
    fn air_by_pressure(&self, flapping: &Flapping, n: usize, chamber: usize) -> f64 {
        let weight = self.air_weight(flapping, n, chamber);
        if weight == 0.0 {
            return 0.0;
        }
        weight * self.chambers[chamber].volume(flapping.recording.coordinates(n)) / AMBIENT
    }
}
