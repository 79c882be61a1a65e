//! The load cell's fixture: a light mass on a lightly damped spring between the force and the cell.
//!
//! The cell feels what spring and damper hand on, k x + b ẋ, so that it says (b s + k)/(m s² + b s + k) of the force: the
//! force itself far under the natural frequency, much more of it near, little far over.
//!
//! Stands on: the oscillator. Never knows: what pulls.

use si::{Newton, Second};

use super::oscillator::{Oscillator, Swing};
use crate::draw::Draw;
use crate::settings;

/// A fixture at work.
#[derive(Debug, Clone, Copy)]
pub struct Fixture {
    /// What it is.
    pub oscillator: Oscillator,
    swing: Swing,
    force: Newton,
}

/// The fixture of a bench, drawn from the settings' ranges.
pub fn drawn(set: &settings::Cell, draw: &mut Draw) -> Oscillator {
    let (mass, frequency) = (draw.between(set.mass), draw.between(set.frequency));
    Oscillator::tuned(mass, std::f64::consts::TAU * frequency, draw.between(set.damping_ratio))
}

impl Fixture {
    /// At rest, with no force on it.
    pub fn at_rest(oscillator: Oscillator) -> Self {
        Self { oscillator, swing: Swing::default(), force: 0.0 }
    }

    /// What the cell feels (N) after `step` (s), in which the force went straight from where it was to `force` (N).
    pub fn feel(&mut self, force: Newton, step: Second) -> Newton {
        self.swing = self.oscillator.after(self.swing, [self.force, force], step);
        self.force = force;
        self.oscillator.stiffness * self.swing.place + self.oscillator.damping * self.swing.speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Size and phase (rad) of (b s + k)/(m s² + b s + k) at s = i ω.
    fn handed_on(it: &Oscillator, omega: f64) -> (f64, f64) {
        let (top, low) = ([it.stiffness, it.damping * omega], it.stiffness - it.mass * omega * omega);
        let size = top[0].hypot(top[1]) / low.hypot(top[1]);
        (size, top[1].atan2(top[0]) - top[1].atan2(low))
    }

    /// Cosine and sine parts of what is felt of cos ω t, over whole cycles after the start has rung down.
    fn felt(it: Oscillator, frequency: f64) -> (f64, f64) {
        let (step, mut fixture) = (1.0 / (frequency * 2000.0), Fixture::at_rest(it));
        let settle = (20.0 / it.decay_and_beat().0 * frequency).ceil() as usize * 2000;
        let mut parts = [0.0; 2];
        for i in 1..=settle + 2000 {
            let angle = TAU * i as f64 / 2000.0;
            let y = fixture.feel(angle.cos(), step);
            if i > settle {
                parts = [parts[0] + y * angle.cos() / 1000.0, parts[1] - y * angle.sin() / 1000.0];
            }
        }
        (parts[0].hypot(parts[1]), parts[1].atan2(parts[0]))
    }

    #[test]
    fn a_sine_is_handed_on_as_the_transfer_function_says() {
        let it = Oscillator::tuned(0.3, TAU * 14.0, 0.03);
        for frequency in [1.0, 7.0, 13.0, 14.0, 20.0, 40.0] {
            let ((size, phase), (seen, late)) = (handed_on(&it, TAU * frequency), felt(it, frequency));
            // straight lines between 2000 samples a cycle are 1e-6 from a sine
            assert!((seen / size - 1.0).abs() < 1e-5, "{frequency} Hz: {seen} for {size}");
            assert!((late - phase).abs() < 1e-5, "{frequency} Hz: {late} rad for {phase}");
        }
    }

    #[test]
    fn a_force_that_stays_is_felt_as_it_is() {
        let mut fixture = Fixture::at_rest(Oscillator::tuned(0.3, TAU * 14.0, 0.03));
        let felt = (0..20_000).map(|_| fixture.feel(0.25, 1e-3)).last();
        assert!((felt.unwrap() - 0.25).abs() < 1e-9);
    }

    #[test]
    fn every_fixture_swings_10_to_20_times_a_second_and_rings_lightly() {
        let set = settings::Settings::built_in().cell;
        for seed in 0..50 {
            let it = drawn(&set, &mut Draw::new(seed, "fixture"));
            assert!((10.0..20.0).contains(&(it.omega() / TAU)), "seed {seed}");
            assert!(it.decay_and_beat().0 / it.omega() < 0.1, "seed {seed}");
        }
    }
}
