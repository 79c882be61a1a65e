//! A load cell on a compliant fixture: its transfer function, identified from hammer taps, and its inverse.
//!
//! m ẍ + b ẋ + k x = f, and the cell measures k x + b ẋ:  f_m / f = (b s + k)/(m s² + b s + k). A tap determines only b/m and k/m
//! (a heavier mass on a stiffer spring has the same response), so the parameters are the natural frequency f₀ = √(k/m)/2π
//! and the damping ratio ζ = b/(2√(km)). Paper, appendix, load cell dynamics.

mod deconvolution;
mod example;
mod tap_test;

use si::{Hertz, Newton, Second, Series};
use std::f64::consts::TAU;

use crate::spectrum::Phasor;

pub use deconvolution::{Deconvolved, Regularisation};
pub use example::{DeconvolutionExample, ExampleThrust};
pub use tap_test::{Estimate, FrequencyResponse, TapTest, identify_from_taps};

/// A load cell on its fixture, as a second-order system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// f₀, Hz.
    pub natural_frequency: Hertz,
    /// ζ, no unit, under 1.
    pub damping_ratio: f64,
}

impl Cell {
    /// f_m / f at `frequency` (Hz); no unit.
    pub fn transfer(&self, frequency: Hertz) -> Phasor {
        let r = frequency / self.natural_frequency;
        let numerator = Phasor::new(1.0, 2.0 * self.damping_ratio * r);
        numerator / Phasor::new(1.0 - r * r, 2.0 * self.damping_ratio * r)
    }

    /// The measured force (N) at rising `times` (s) of a force that is linear between its samples and constant before the first;
    /// the fixture begins at rest. Exact but for rounding.
    pub fn simulate(&self, force: &Series, times: &[Second]) -> Vec<Newton> {
        let mut motion = Motion { place: force.values()[0], speed: 0.0 };
        let (mut current_time, mut current_force, mut next) = (force.start(), force.values()[0], 1);
        let mut measured = Vec::with_capacity(times.len());
        let damping_time = 2.0 * self.damping_ratio / (TAU * self.natural_frequency);
        for &t in times {
            while next < force.values().len() && force.time(next) <= t {
                let next_force = force.values()[next];
                motion = self.stepped_motion(motion, [current_force, next_force], force.time(next) - current_time);
                (current_time, current_force, next) = (force.time(next), next_force, next + 1);
            }
            if t > current_time {
                let next_force = force.at(t);
                motion = self.stepped_motion(motion, [current_force, next_force], t - current_time);
                (current_time, current_force) = (t, next_force);
            }
            measured.push(motion.place + damping_time * motion.speed);
        }
        measured
    }

    /// ÿ + 2ζω ẏ + ω² y = ω² u over `step` (s) while u is linear from `start_force` to `end_force`: the particular solution plus the decaying
    /// homogeneous one. The closed form is exact for any step, so the hammer's pulse of milliseconds needs no finer integration.
    fn stepped_motion(&self, motion: Motion, [start_force, end_force]: [f64; 2], step: Second) -> Motion {
        if step <= 0.0 {
            return motion;
        }
        let (omega, zeta) = (TAU * self.natural_frequency, self.damping_ratio);
        let slope = (end_force - start_force) / step;
        let lag_force = 2.0 * zeta / omega * slope;
        let (place, speed) = (motion.place - (start_force - lag_force), motion.speed - slope);
        let (decay, damped_frequency) = (zeta * omega, omega * (1.0 - zeta * zeta).sqrt());
        let (sin, cos) = (damped_frequency * step).sin_cos();
        let sine_part = (speed + decay * place) / damped_frequency;
        let decay_factor = (-decay * step).exp();
        let free_motion = place * cos + sine_part * sin;
        let free_speed = damped_frequency * (sine_part * cos - place * sin);
        Motion {
            place: end_force - lag_force + decay_factor * free_motion,
            speed: slope + decay_factor * (free_speed - decay * free_motion),
        }
    }
}

/// Place as force on the spring (N), and its rate (N/s).
#[derive(Debug, Clone, Copy)]
struct Motion {
    place: f64,
    speed: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELL: Cell = Cell { natural_frequency: 14.0, damping_ratio: 0.03 };

    #[test]
    fn the_response_to_a_sine_is_that_of_the_transfer_function() {
        for f in [1.0, 7.0, 14.0, 20.0] {
            // straight lines between 200 samples a cycle are 1e-4 from a sine
            let rate = 200.0 * f;
            let sine =
                Series::new(0.0, rate, (0..60_000).map(|i| (TAU * f * f64::from(i) / rate).sin()).collect()).unwrap();
            let times: Vec<f64> = (59_000..59_200).map(|i| f64::from(i) / rate).collect();
            let measured = CELL.simulate(&sine, &times);
            let h = CELL.transfer(f);
            for (t, y) in times.iter().zip(measured) {
                let expected = h.norm() * (TAU * f * t + h.arg()).sin();
                assert!((y - expected).abs() < 3e-4 * h.norm().max(1.0), "{f} Hz: {y} for {expected}");
            }
        }
    }

    #[test]
    fn the_response_to_a_step_does_not_depend_on_the_sampling() {
        let step = Series::new(0.0, 50.0, (0..100).map(|i| if i < 5 { 0.0 } else { 1.0 }).collect()).unwrap();
        let coarse: Vec<f64> = (0..40).map(|i| 0.045 * f64::from(i)).collect();
        let fine: Vec<f64> = (0..400).map(|i| 0.0045 * f64::from(i)).collect();
        let (a, b) = (CELL.simulate(&step, &coarse), CELL.simulate(&step, &fine));
        assert!(a.iter().enumerate().all(|(i, y)| (y - b[10 * i]).abs() < 1e-9));
        assert!(a.iter().any(|y| *y > 1.5), "a light fixture overshoots");
    }

    #[test]
    fn a_non_negative_thrust_has_a_response_below_zero() {
        let pushes = |t: f64| if (t * 2.0).fract() < 0.1 { 0.2 } else { 0.0 };
        let thrust = Series::new(0.0, 1000.0, (0..4000).map(|i| pushes(f64::from(i) * 1e-3)).collect()).unwrap();
        let times: Vec<f64> = (0..320).map(|i| f64::from(i) / 80.0).collect();
        assert!(CELL.simulate(&thrust, &times).iter().any(|y| *y < -0.05));
    }
}
