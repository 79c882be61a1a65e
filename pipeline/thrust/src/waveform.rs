//! A periodic command of two sides with a Fourier series each, and the valve that follows it.
//!
//! The command of a side is A σ(s(φ)), s = a₀ + Σ aₖ cos kφ + bₖ sin kφ, φ = 2πft: it stays between zero and the highest pressure whatever the series, a₀ sets its
//! duty, and the square wave σ(k sin φ) is one of its members. The valve is of first order, with a time for filling and one for emptying.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};
use si::{Hertz, Pascal, Second};
use signal::step_response::{MOVED, Pulse};

use crate::ascent::Limits;
use crate::square_wave::SquareWave;

/// Harmonics of a side.
const HARMONICS: usize = 8;
/// Numbers of a side: amplitude, mean, and cosine and sine of each harmonic.
pub(crate) const OF_SIDE: usize = 2 + 2 * HARMONICS;
/// The frequency, and the numbers of both sides.
pub const PARAMETERS: usize = 1 + 2 * OF_SIDE;
/// Largest coefficient of a series: at 8 the edges of a wave are a twentieth of a cycle long.
pub const STEEPEST: f64 = 8.0;

/// A waveform by its numbers: the frequency from 0 to 1 between its limits; then, for each side, the amplitude over the highest pressure, a₀, and
/// a and b of each harmonic in turn.
#[derive(Debug, Clone, PartialEq)]
pub struct Waveform {
    /// [`PARAMETERS`] numbers, no unit.
    pub numbers: Vec<f64>,
}

/// First-order dynamics of a valve, as measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Valve {
    /// Time constant of a pressure that rises.
    pub filling: Second,
    /// Of one that falls.
    pub emptying: Second,
}

/// Least amplitude, over the highest pressure.
const LEAST: f64 = 0.05;

impl Waveform {
    /// The square wave, with the sides half a cycle apart.
    pub fn square(wave: &SquareWave, limits: &Limits) -> Self {
        let [amplitude, frequency] = limits.place(wave);
        let side = |sign: f64| {
            let mut side = vec![0.0; OF_SIDE];
            (side[0], side[3]) = (amplitude, sign * wave.sharpness.min(STEEPEST));
            side
        };
        Self { numbers: [vec![frequency], side(1.0), side(-1.0)].concat() }
    }

    /// The steepest square wave of this series, at normalised coordinates (0 to 1 along both limits): the Fourier series of a square. From this
    /// one on, what a waveform gains is not by its edges alone.
    pub(crate) fn steepest_square(&[amplitude, frequency]: &[f64; 2]) -> Self {
        let side = |sign: f64| {
            let mut side = vec![0.0; OF_SIDE];
            side[0] = amplitude;
            (1..=HARMONICS).step_by(2).for_each(|k| side[1 + 2 * k] = sign * STEEPEST / k as f64);
            side
        };
        Self { numbers: [vec![frequency], side(1.0), side(-1.0)].concat() }
    }

    /// f, Hz.
    pub fn frequency(&self, limits: &Limits) -> Hertz {
        let [low, high] = limits.frequency;
        low + self.numbers[0] * (high - low)
    }

    /// The command of a side at a fraction of the cycle over the highest pressure, and its derivatives by the side's numbers.
    fn command_with_slopes(&self, side: usize, cycle: f64) -> (f64, Vec<f64>) {
        let numbers = &self.numbers[1 + side * OF_SIDE..1 + (side + 1) * OF_SIDE];
        let shape = |index: usize| match index {
            1 => 1.0,
            index if index % 2 == 0 => (TAU * cycle * (index / 2) as f64).cos(),
            index => (TAU * cycle * (index / 2) as f64).sin(),
        };
        let shapes: Vec<f64> = (1..OF_SIDE).map(shape).collect();
        let series: f64 = numbers[1..].iter().zip(&shapes).map(|(a, shape)| a * shape).sum();
        let sigmoid = 1.0 / (1.0 + (-series).exp());
        let shape_slopes = shapes.iter().map(|shape| numbers[0] * sigmoid * (1.0 - sigmoid) * shape);
        (numbers[0] * sigmoid, std::iter::once(sigmoid).chain(shape_slopes).collect())
    }

    /// Commands of a side after each of `steps` steps, `per_cycle` to a cycle, over the highest pressure.
    pub(crate) fn command_series(&self, side: usize, (steps, per_cycle): (usize, usize)) -> Vec<f64> {
        (1..=steps).map(|n| self.command_with_slopes(side, n as f64 / per_cycle as f64).0).collect()
    }

    /// Adds to the derivatives by all numbers those through the commands of a side, after each step.
    pub(crate) fn add_gradient(&self, side: usize, (command_slopes, per_cycle): (&[f64], usize), gradient: &mut [f64]) {
        let side_gradient = &mut gradient[1 + side * OF_SIDE..1 + (side + 1) * OF_SIDE];
        for (n, command_slopes) in command_slopes.iter().enumerate() {
            let (_, slopes) = self.command_with_slopes(side, (n + 1) as f64 / per_cycle as f64);
            side_gradient.iter_mut().zip(slopes).for_each(|(sum, slope)| *sum += command_slopes * slope);
        }
    }

    /// The lowest and highest value of each number. Without any pressure there would be no thrust per air.
    pub fn bounds() -> [Vec<f64>; 2] {
        let side = |amplitude: f64, coefficient: f64| [vec![amplitude], vec![coefficient; OF_SIDE - 1]].concat();
        let whole_waveform = |first: f64, side: Vec<f64>| [vec![first], side.clone(), side].concat();
        [whole_waveform(0.0, side(LEAST, -STEEPEST)), whole_waveform(1.0, side(1.0, STEEPEST))]
    }
}

impl Valve {
    /// Medians over fillings; none without any. Dead times shift the whole cycle and are left out. A lag needs ln((1 − m)/m) of its time constants
    /// from the part m of its step to all but m.
    pub fn of(pulses: &[Pulse]) -> Option<Self> {
        let filling =
            upper_median(pulses.iter().map(|p| (p.fill - p.fill_dead) / ((1.0 - MOVED) / MOVED).ln()).collect())?;
        Some(Self { filling, emptying: upper_median(pulses.iter().map(|p| p.empty).collect())? })
    }

    /// The part of its distance from the command that a pressure makes good in a step.
    fn step_gain(&self, rises: bool, step: Second) -> f64 {
        -(-step / if rises { self.filling } else { self.emptying }).exp_m1()
    }

    /// The pressures after steps of `step` seconds with these commands (Pa), from none.
    pub fn follow(&self, commands: &[Pascal], step: Second) -> Vec<Pascal> {
        let next_pressure = |pressure: &mut f64, command: &f64| {
            *pressure += self.step_gain(command > pressure, step) * (command - *pressure);
            Some(*pressure)
        };
        commands.iter().scan(0.0, next_pressure).collect()
    }

    /// The derivatives by the commands from those by the `pressures` that followed them.
    pub fn adjoint(&self, [commands, pressures, pressure_slopes]: [&[f64]; 3], step: Second) -> Vec<f64> {
        let (mut carried, mut command_slopes) = (0.0, vec![0.0; pressure_slopes.len()]);
        for n in (0..pressure_slopes.len()).rev() {
            let previous = if n == 0 { 0.0 } else { pressures[n - 1] };
            let (slope, gain) = (pressure_slopes[n] + carried, self.step_gain(commands[n] > previous, step));
            command_slopes[n] = gain * slope;
            carried = (1.0 - gain) * slope;
        }
        command_slopes
    }
}

fn upper_median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { amplitude: 3e4, frequency: [1.0, 3.0], iterations: 1 };

    #[test]
    fn the_square_wave_is_a_waveform() {
        let square = SquareWave { amplitude: 2e4, frequency: 1.5, sharpness: 6.0 };
        let waveform = Waveform::square(&square, &LIMITS);
        assert!((waveform.frequency(&LIMITS) - 1.5).abs() < 1e-12 && waveform.numbers.len() == PARAMETERS);
        for side in 0..2 {
            let commands = waveform.command_series(side, (30, 60));
            for (n, command) in commands.iter().enumerate() {
                let exact = square.at((n + 1) as f64 / 60.0 / 1.5)[side];
                assert!((command * LIMITS.amplitude - exact).abs() < 1e-9 * LIMITS.amplitude);
            }
        }
    }

    #[test]
    fn the_steepest_square_wave_is_full_and_empty_but_for_a_tenth_of_a_cycle() {
        let commands = Waveform::steepest_square(&[0.5, 0.0]).command_series(1, (1000, 1000));
        let between = commands.iter().filter(|c| (0.005..0.495).contains(*c)).count();
        // the logistic function of 8 (1 − 1/3 + 1/5 − 1/7) is 0.997
        assert!(commands[250] < 2e-3 && commands[750] > 0.498 && between < 100, "{between}");
    }

    #[test]
    fn a_valve_is_read_off_a_log_of_its_own() {
        let valve = Valve { filling: 0.06, emptying: 0.09 };
        let command: Vec<f64> = (0..6000).map(|n| if n % 2000 < 1000 { 2e4 } else { 0.0 }).collect();
        let measured = valve.follow(&command, 1e-3);
        let time: Vec<f64> = (0..6000).map(|n| 1e-3 * f64::from(n)).collect();
        let gauge = signal::step_response::Gauge { command: &command, measured: &measured };
        let found = Valve::of(&signal::step_response::pulses(&time, gauge)).unwrap();
        assert!((found.filling / 0.06 - 1.0).abs() < 0.02 && (found.emptying / 0.09 - 1.0).abs() < 0.02, "{found:?}");
        assert!(Valve::of(&[]).is_none());
    }

    #[test]
    fn a_valve_fills_and_empties_by_its_times_and_its_adjoint_is_its_transpose() {
        let valve = Valve { filling: 0.1, emptying: 0.05 };
        let commands: Vec<f64> = (0..100).map(|n| if n < 50 { 1.0 } else { 0.0 }).collect();
        let pressures = valve.follow(&commands, 0.01);
        assert!((pressures[9] - (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
        assert!((pressures[54] / pressures[49] - (-1.0_f64).exp()).abs() < 1e-12);
        let weights: Vec<f64> = (0..100).map(|n| f64::from(n).sin()).collect();
        let by = valve.adjoint([&commands, &pressures, &weights], 0.01);
        let loss =
            |commands: &[f64]| valve.follow(commands, 0.01).iter().zip(&weights).map(|(p, w)| p * w).sum::<f64>();
        for n in [0, 20, 49, 70] {
            let mut near = commands.clone();
            near[n] += if n < 50 { 1e-6 } else { 1e-9 };
            let difference = (loss(&near) - loss(&commands)) / (near[n] - commands[n]);
            assert!((by[n] - difference).abs() < 1e-5, "{n}: {} {difference}", by[n]);
        }
    }
}
