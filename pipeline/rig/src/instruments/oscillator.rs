//! A damped oscillator under a piecewise linear force, integrated exactly (first-order hold).
//!
//! m ẍ + b ẋ + k x = u(t). Over an interval with u = u₀ + g t the motion is the particular solution x = (u₀ + g t)/k − b g/k², ẋ = g/k, plus
//! the free decay of the difference to the initial state.

use si::{Kilogram, Newton, Second};

/// m, b and k, underdamped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Oscillator {
    /// m, kg.
    pub(crate) mass: Kilogram,
    /// b, N s/m.
    pub(crate) damping: f64,
    /// k, N/m.
    pub(crate) stiffness: f64,
}

/// Displacement (m) and velocity (m/s).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct OscillatorState {
    /// x, m.
    pub(crate) displacement: f64,
    /// ẋ, m/s.
    pub(crate) velocity: f64,
}

impl Oscillator {
    /// The oscillator of mass `mass` (kg), undamped angular frequency `omega` (rad/s) and damping ratio `ratio` < 1.
    pub(crate) fn tuned(mass: Kilogram, omega: f64, ratio: f64) -> Self {
        assert!(ratio < 1.0 && omega > 0.0 && mass > 0.0, "an underdamped oscillator");
        Self { mass, damping: 2.0 * ratio * omega * mass, stiffness: omega * omega * mass }
    }

    /// Undamped angular frequency, rad/s.
    pub(crate) fn omega(&self) -> f64 {
        (self.stiffness / self.mass).sqrt()
    }

    /// Decay rate, 1/s, and damped angular frequency, rad/s.
    pub(crate) fn decay_and_frequency(&self) -> (f64, f64) {
        let decay = 0.5 * self.damping / self.mass;
        (decay, (self.stiffness / self.mass - decay * decay).sqrt())
    }

    /// The state `step` (s) later, while the force changes linearly from `from` to `to` (N). Exact but for rounding.
    pub(crate) fn state_after(&self, state: OscillatorState, [from, to]: [Newton; 2], step: Second) -> OscillatorState {
        let slope = (to - from) / step;
        let offset = self.damping * slope / (self.stiffness * self.stiffness);
        let steady =
            |u: Newton| OscillatorState { displacement: u / self.stiffness - offset, velocity: slope / self.stiffness };
        let (begin, end) = (steady(from), steady(to));
        let deviation = OscillatorState {
            displacement: state.displacement - begin.displacement,
            velocity: state.velocity - begin.velocity,
        };
        let free = self.free_decay(deviation, step);
        OscillatorState { displacement: end.displacement + free.displacement, velocity: end.velocity + free.velocity }
    }

    /// The state `step` (s) later without a force.
    pub(crate) fn free_decay(&self, state: OscillatorState, step: Second) -> OscillatorState {
        let (decay, frequency) = self.decay_and_frequency();
        let (sin, cos) = (frequency * step).sin_cos();
        let lead = (state.velocity + decay * state.displacement) / frequency;
        let displacement = state.displacement * cos + lead * sin;
        let turned = frequency * (lead * cos - state.displacement * sin);
        let shrunk = (-decay * step).exp();
        OscillatorState { displacement: shrunk * displacement, velocity: shrunk * (turned - decay * displacement) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: Second = 1e-3;

    fn fixture() -> Oscillator {
        Oscillator::tuned(0.3, std::f64::consts::TAU * 14.0, 0.03)
    }

    #[test]
    fn the_step_response_equals_the_analytical_one() {
        let it = fixture();
        let ((decay, frequency), mut state) = (it.decay_and_frequency(), OscillatorState::default());
        for i in 1..=2000 {
            state = it.state_after(state, [1.0, 1.0], STEP);
            let t = STEP * f64::from(i);
            let ring = (-decay * t).exp() * ((frequency * t).cos() + decay / frequency * (frequency * t).sin());
            assert!((state.displacement * it.stiffness - (1.0 - ring)).abs() < 1e-10, "at {t} s");
        }
    }

    #[test]
    fn a_ramp_gives_the_same_state_in_one_step_and_in_a_thousand() {
        let it = fixture();
        let mut state = OscillatorState { displacement: 1e-4, velocity: -0.02 };
        let at_once = it.state_after(state, [0.5, 2.5], 1.0);
        for i in 0..1000 {
            let u = [f64::from(i), f64::from(i + 1)].map(|n| 0.5 + 2.0 * n * STEP);
            state = it.state_after(state, u, STEP);
        }
        assert!(
            (state.displacement - at_once.displacement).abs() < 1e-12
                && (state.velocity - at_once.velocity).abs() < 1e-10
        );
    }

    #[test]
    fn a_free_decay_has_the_decay_rate_of_its_damping_ratio() {
        let it = fixture();
        let ((decay, frequency), start) =
            (it.decay_and_frequency(), OscillatorState { displacement: 1e-3, velocity: 0.0 });
        let period = std::f64::consts::TAU / frequency;
        let later = it.free_decay(start, period);
        assert!((later.displacement / start.displacement - (-decay * period).exp()).abs() < 1e-12);
    }
}
