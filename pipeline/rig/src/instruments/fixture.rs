//! The load cell's fixture: a light mass on a lightly damped spring between the force and the cell.
//!
//! The cell measures the force of spring and damper, k x + b ẋ. Its transfer function is (b s + k)/(m s² + b s + k): one far below the natural
//! frequency, a resonance near it, and attenuation far above.

use si::{Newton, Second};

use super::oscillator::{Oscillator, OscillatorState};
use crate::random::RandomStream;
use crate::settings;

/// A fixture and its state.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fixture {
    /// Its mass, damping and stiffness.
    pub(crate) oscillator: Oscillator,
    state: OscillatorState,
    force: Newton,
}

/// The fixture of a bench, drawn from the settings' ranges.
pub(crate) fn draw_fixture(set: &settings::Cell, random: &mut RandomStream) -> Oscillator {
    let (mass, frequency) = (random.uniform(set.mass), random.uniform(set.frequency));
    Oscillator::tuned(mass, std::f64::consts::TAU * frequency, random.uniform(set.damping_ratio))
}

impl Fixture {
    /// At rest, with no force on it.
    pub(crate) fn at_rest(oscillator: Oscillator) -> Self {
        Self { oscillator, state: OscillatorState::default(), force: 0.0 }
    }

    /// The force on the cell (N) after `step` (s), in which the force on the fixture changes linearly to `force` (N).
    pub(crate) fn transmit_force(&mut self, force: Newton, step: Second) -> Newton {
        self.state = self.oscillator.state_after(self.state, [self.force, force], step);
        self.force = force;
        self.oscillator.stiffness * self.state.displacement + self.oscillator.damping * self.state.velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Size and phase (rad) of (b s + k)/(m s² + b s + k) at s = i ω.
    fn transfer_function(it: &Oscillator, omega: f64) -> (f64, f64) {
        let (top, low) = ([it.stiffness, it.damping * omega], it.stiffness - it.mass * omega * omega);
        let size = top[0].hypot(top[1]) / low.hypot(top[1]);
        (size, top[1].atan2(top[0]) - top[1].atan2(low))
    }

    /// Amplitude and phase of the response to cos ω t over whole cycles after the transient has decayed.
    fn response(it: Oscillator, frequency: f64) -> (f64, f64) {
        let (step, mut fixture) = (1.0 / (frequency * 2000.0), Fixture::at_rest(it));
        let settle = (20.0 / it.decay_and_frequency().0 * frequency).ceil() as usize * 2000;
        let mut parts = [0.0; 2];
        for i in 1..=settle + 2000 {
            let angle = TAU * i as f64 / 2000.0;
            let y = fixture.transmit_force(angle.cos(), step);
            if i > settle {
                parts = [parts[0] + y * angle.cos() / 1000.0, parts[1] - y * angle.sin() / 1000.0];
            }
        }
        (parts[0].hypot(parts[1]), parts[1].atan2(parts[0]))
    }

    #[test]
    fn a_sine_is_transmitted_with_the_gain_and_phase_of_the_transfer_function() {
        let it = Oscillator::tuned(0.3, TAU * 14.0, 0.03);
        for frequency in [1.0, 7.0, 13.0, 14.0, 20.0, 40.0] {
            let ((size, phase), (gain, lag)) = (transfer_function(&it, TAU * frequency), response(it, frequency));
            // linear interpolation between 2000 samples a cycle are 1e-6 from a sine
            assert!((gain / size - 1.0).abs() < 1e-5, "{frequency} Hz: {gain} for {size}");
            assert!((lag - phase).abs() < 1e-5, "{frequency} Hz: {lag} rad for {phase}");
        }
    }

    #[test]
    fn a_constant_force_is_transmitted_unchanged() {
        let mut fixture = Fixture::at_rest(Oscillator::tuned(0.3, TAU * 14.0, 0.03));
        let last = (0..20_000).map(|_| fixture.transmit_force(0.25, 1e-3)).last();
        assert!((last.unwrap() - 0.25).abs() < 1e-9);
    }

    #[test]
    fn every_fixture_has_its_natural_frequency_at_10_to_20_hz_and_is_lightly_damped() {
        let set = settings::Settings::built_in().cell;
        for seed in 0..50 {
            let it = draw_fixture(&set, &mut RandomStream::new(seed, "fixture"));
            assert!((10.0..20.0).contains(&(it.omega() / TAU)), "seed {seed}");
            assert!(it.decay_and_frequency().0 / it.omega() < 0.1, "seed {seed}");
        }
    }
}
