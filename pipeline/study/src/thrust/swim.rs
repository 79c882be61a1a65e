//! Swimming: the reduced model flaps in still water under a wave of pressure, and its motion becomes a run, so that every rung of
//! the ladder can tell its thrust.
//!
//! Stands on: the reduced model, hydro, run. Never knows: which rung is asked, how moduli were found.

use fem::{March, Scheme};
use hydro::{Coefficients, Tail};
use lab::card::Side;
use nalgebra::DMatrix;
use si::{Hertz, Newton, Pascal, Point2, Second};

use super::climb::{Hill, Limits};
use super::simulated::Wave;
use super::water::Water;
use super::{Fitted, Run, run};
use crate::fault::Outcome;
use crate::model::Small;

/// A model in water.
pub struct Swimmer<'a> {
    /// It in its coordinates.
    pub small: &'a Small,
    /// The tail as theory sees it.
    pub tail: &'a Tail,
    /// Rows of the marks from the head to the fin, (marks × 2) × coordinates, m.
    pub rows: &'a DMatrix<f64>,
    /// The tail as the water feels it, and the rows of its own places.
    pub wet: (&'a Tail, &'a DMatrix<f64>),
    /// The side of each chamber.
    pub sides: Vec<Side>,
    /// The water's.
    pub by: Coefficients,
    /// Whether half of the body is modelled.
    pub half: bool,
    /// β, s.
    pub stiffness_damping: Second,
    /// Steps of one beat.
    pub per_beat: usize,
    /// Beats before the mean begins, and beats of it.
    pub beats: [usize; 2],
}

/// Places and velocities of the marks after each step, m and m/s: steps × marks.
type Motion = (Vec<Vec<Point2>>, Vec<Vec<Point2>>);

impl Swimmer<'_> {
    /// The beats of a wave that count, as a run without a measured force.
    ///
    /// # Errors
    /// A [`crate::fault::Fault`] when a step finds no motion.
    pub fn run(&self, wave: &Wave) -> Outcome<Run> {
        let pressures = |t: Second| {
            let both = wave.at(t);
            self.sides.iter().map(|side| both[usize::from(*side == Side::Right)]).collect()
        };
        self.flap(wave.frequency, wave.amplitude, &pressures)
    }

    /// The same under any `pressures` (one a chamber, Pa, at a time in s) that beat at `frequency` (Hz).
    ///
    /// # Errors
    /// As [`Swimmer::run`].
    pub fn flap(&self, frequency: Hertz, amplitude: Pascal, pressures: &dyn Fn(Second) -> Vec<Pascal>) -> Outcome<Run> {
        let rate = frequency * self.per_beat as f64;
        let [settle, counted] = self.beats;
        let (moved, speed) = self.motion(rate, (settle + counted) * self.per_beat, pressures)?;
        let time: Vec<Second> = (1..=moved.len()).map(|i| i as f64 / rate).collect();
        let pressure: Vec<Vec<Pascal>> = time.iter().map(|&t| pressures(t)).collect();
        let rates: Vec<Vec<f64>> = (0..self.sides.len())
            .map(|c| run::rates(&pressure.iter().map(|p| p[c]).collect::<Vec<_>>(), rate))
            .collect();
        let pressure_rate: Vec<Vec<f64>> = (0..time.len()).map(|i| rates.iter().map(|c| c[i]).collect()).collect();
        let terms = run::parts(self.tail, &moved, &speed, rate);
        let from = settle * self.per_beat;
        Ok(Run {
            id: format!("{amplitude:.0} Pa at {frequency:.2} Hz"),
            amplitude,
            frequency,
            split: None,
            rate,
            force: vec![0.0; time.len() - from],
            time: time[from..].to_vec(),
            moved: moved[from..].to_vec(),
            speed: speed[from..].to_vec(),
            pressure: pressure[from..].to_vec(),
            pressure_rate: pressure_rate[from..].to_vec(),
            terms: terms[from..].to_vec(),
        })
    }

    fn motion(&self, rate: Hertz, steps: usize, pressures: &dyn Fn(Second) -> Vec<Pascal>) -> Outcome<Motion> {
        let march = March {
            step: 1.0 / rate,
            scheme: Scheme::Bdf2,
            stiffness_damping: self.stiffness_damping,
            ..March::default()
        };
        let mut water = Water::around(self.wet.0, self.wet.1, self.by, self.half);
        let (mut moved, mut speed) = (Vec::with_capacity(steps), Vec::with_capacity(steps));
        self.small.swim(&march, &mut water, pressures, steps, &mut |q, v| {
            moved.push(super::water::points(self.rows * q));
            speed.push(super::water::points(self.rows * v));
        })?;
        Ok((moved, speed))
    }
}

/// A swimmer and who tells its thrust: a hill to climb; counts its marches.
pub struct Asked<'a> {
    /// Who flaps.
    pub swimmer: &'a Swimmer<'a>,
    /// Who tells.
    pub model: &'a Fitted,
    /// Between what.
    pub limits: Limits,
    /// Marches so far.
    pub marches: usize,
}

/// Half the width of a difference, of the limits' width: four digits of a mean that marches to nine.
const NUDGE: f64 = 5e-3;

/// The mean of what a model tells of a run, N.
pub fn mean(model: &Fitted, run: &Run) -> Newton {
    let told = model.tell(run);
    told.iter().sum::<f64>() / told.len().max(1) as f64
}

impl Hill for Asked<'_> {
    fn height(&mut self, wave: &Wave) -> Outcome<Newton> {
        self.marches += 1;
        Ok(mean(self.model, &self.swimmer.run(wave)?))
    }

    fn slope(&mut self, wave: &Wave) -> Outcome<[f64; 2]> {
        let place = self.limits.place(wave);
        let mut along = |k: usize| -> Outcome<f64> {
            let (mut low, mut high) = (place, place);
            (low[k], high[k]) = ((place[k] - NUDGE).max(0.0), (place[k] + NUDGE).min(1.0));
            let (from, to) = (self.limits.wave(low, *wave), self.limits.wave(high, *wave));
            let width = [to.amplitude - from.amplitude, to.frequency - from.frequency][k];
            let rise = self.height(&to)? - self.height(&from)?;
            Ok(if width > 0.0 { rise / width } else { 0.0 })
        };
        Ok([along(0)?, along(1)?])
    }
}
