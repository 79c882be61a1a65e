//! A load cell behind a compliant fixture: what it hands on of a force, found from taps, and undone.
//!
//! m ẍ + b ẋ + k x = f, and the cell feels k x + b ẋ:  f_m / f = (b s + k)/(m s² + b s + k). A tap tells b/m and k/m only
//! (a heavier mass on a stiffer spring rings the same), so the fixture is known by its natural frequency f₀ = √(k/m)/2π
//! and its damping ratio ζ = b/(2√(km)).
//!
//! Stands on: `si`, spectrum, squares. Never knows: what pulls. Paper: appendix, load cell dynamics.

mod inverse;
mod taps;

use si::{Hertz, Newton, Second, Series};
use std::f64::consts::TAU;

use crate::spectrum::Phasor;

pub use inverse::{Inverted, Regularised};
pub use taps::{Estimate, Identified, Response, from_taps};

/// A fixture by its natural frequency and damping ratio.
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
        let top = Phasor::new(1.0, 2.0 * self.damping_ratio * r);
        top / Phasor::new(1.0 - r * r, 2.0 * self.damping_ratio * r)
    }

    /// b/m, 1/s, and k/m, 1/s².
    pub fn per_mass(&self) -> [f64; 2] {
        let omega = TAU * self.natural_frequency;
        [2.0 * self.damping_ratio * omega, omega * omega]
    }

    /// What the cell feels (N) at rising `times` (s) of a force that is straight between its samples and constant before
    /// the first; the fixture begins at rest. Exact but for rounding.
    pub fn feels(&self, force: &Series, times: &[Second]) -> Vec<Newton> {
        let mut swing = Swing { place: force.values()[0], speed: 0.0 };
        let (mut now, mut pull, mut next) = (force.start(), force.values()[0], 1);
        let mut felt = Vec::with_capacity(times.len());
        let slack = 2.0 * self.damping_ratio / (TAU * self.natural_frequency);
        for &t in times {
            while next < force.values().len() && force.time(next) <= t {
                let to = force.values()[next];
                swing = self.after(swing, [pull, to], force.time(next) - now);
                (now, pull, next) = (force.time(next), to, next + 1);
            }
            if t > now {
                let to = force.at(t);
                swing = self.after(swing, [pull, to], t - now);
                (now, pull) = (t, to);
            }
            felt.push(swing.place + slack * swing.speed);
        }
        felt
    }

    /// ÿ + 2ζω ẏ + ω² y = ω² u over `step` (s) while u goes straight from `from` to `to`: the particular motion, and what
    /// of the start is not on it, which rings down.
    fn after(&self, swing: Swing, [from, to]: [f64; 2], step: Second) -> Swing {
        if step <= 0.0 {
            return swing;
        }
        let (omega, zeta) = (TAU * self.natural_frequency, self.damping_ratio);
        let slope = (to - from) / step;
        let late = 2.0 * zeta / omega * slope;
        let (place, speed) = (swing.place - (from - late), swing.speed - slope);
        let (decay, beat) = (zeta * omega, omega * (1.0 - zeta * zeta).sqrt());
        let (sin, cos) = (beat * step).sin_cos();
        let lead = (speed + decay * place) / beat;
        let shrunk = (-decay * step).exp();
        let free = place * cos + lead * sin;
        let turned = beat * (lead * cos - place * sin);
        Swing { place: to - late + shrunk * free, speed: slope + shrunk * (turned - decay * free) }
    }
}

/// Place as force on the spring (N), and its rate (N/s).
#[derive(Debug, Clone, Copy)]
struct Swing {
    place: f64,
    speed: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELL: Cell = Cell { natural_frequency: 14.0, damping_ratio: 0.03 };

    #[test]
    fn a_sine_is_handed_on_as_the_transfer_function_says() {
        for f in [1.0, 7.0, 14.0, 20.0] {
            // straight lines between 200 samples a cycle are 1e-4 from a sine
            let rate = 200.0 * f;
            let sine =
                Series::new(0.0, rate, (0..60_000).map(|i| (TAU * f * f64::from(i) / rate).sin()).collect()).unwrap();
            let times: Vec<f64> = (59_000..59_200).map(|i| f64::from(i) / rate).collect();
            let felt = CELL.feels(&sine, &times);
            let h = CELL.transfer(f);
            for (t, y) in times.iter().zip(felt) {
                let expected = h.norm() * (TAU * f * t + h.arg()).sin();
                assert!((y - expected).abs() < 3e-4 * h.norm().max(1.0), "{f} Hz: {y} for {expected}");
            }
        }
    }

    #[test]
    fn a_step_is_answered_the_same_however_finely_it_is_read() {
        let step = Series::new(0.0, 50.0, (0..100).map(|i| if i < 5 { 0.0 } else { 1.0 }).collect()).unwrap();
        let coarse: Vec<f64> = (0..40).map(|i| 0.045 * f64::from(i)).collect();
        let fine: Vec<f64> = (0..400).map(|i| 0.0045 * f64::from(i)).collect();
        let (a, b) = (CELL.feels(&step, &coarse), CELL.feels(&step, &fine));
        assert!(a.iter().enumerate().all(|(i, y)| (y - b[10 * i]).abs() < 1e-9));
        assert!(a.iter().any(|y| *y > 1.5), "a light fixture overshoots");
    }

    #[test]
    fn a_thrust_that_is_never_negative_is_felt_as_one_that_is() {
        let pushes = |t: f64| if (t * 2.0).fract() < 0.1 { 0.2 } else { 0.0 };
        let thrust = Series::new(0.0, 1000.0, (0..4000).map(|i| pushes(f64::from(i) * 1e-3)).collect()).unwrap();
        let times: Vec<f64> = (0..320).map(|i| f64::from(i) / 80.0).collect();
        assert!(CELL.feels(&thrust, &times).iter().any(|y| *y < -0.05));
    }
}
