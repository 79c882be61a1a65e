//! The tank: standing waves that a run excites and that act on the cell long after the tail has stopped.
//!
//! Mode n of a tank of length L and depth h has k = n π / L and ω² = g k tanh(k h), the dispersion relation of water waves. The force of the run
//! excites each mode, which determines its phase. The force of a wave on the cell depends on the position of the tail and is not modelled:
//! the amplitude one second after the run is drawn from the measured range.

use std::f64::consts::{PI, TAU};

use lab::truth::TrueWave;
use si::{Hertz, Newton, Second};

use super::oscillator::{Oscillator, OscillatorState};
use crate::random::RandomStream;
use crate::settings;

/// m/s².
const GRAVITY: f64 = 9.81;
/// The modes with a measurable force.
pub(crate) const MODES: [u32; 2] = [1, 2];
/// Time after the run for which amplitudes are drawn, s.
pub(crate) const AFTER: Second = 1.0;
/// Interval over which the force is linear, s.
const STEP: Second = 2e-3;

/// Frequency of a mode, Hz.
pub(crate) fn mode_frequency(set: &settings::Tank, mode: u32) -> Hertz {
    let k = f64::from(mode) * PI / set.length;
    (GRAVITY * k * (k * set.depth).tanh()).sqrt() / TAU
}

/// The waves after a run.
#[derive(Debug, Clone)]
pub(crate) struct FreeWaves(Vec<(Oscillator, OscillatorState)>);

impl FreeWaves {
    /// No waves.
    pub(crate) fn no_waves() -> Self {
        Self(Vec::new())
    }

    /// The waves after a run of `length` (s) whose force (N) at time t (s) is `force`.
    pub(crate) fn after_run(
        set: &settings::Tank,
        length: Second,
        force: &dyn Fn(Second) -> Newton,
        random: &mut RandomStream,
    ) -> Self {
        let remaining_wave = |mode: &u32| {
            let oscillator = Oscillator::tuned(1.0, TAU * mode_frequency(set, *mode), set.damping_ratio);
            let end = driven_state(&oscillator, length, force);
            let state = oscillator.free_decay(end, AFTER);
            (oscillator, scaled_state(end, random.uniform(set.amplitude) / free_amplitude(&oscillator, state)))
        };
        Self(MODES.iter().map(remaining_wave).collect())
    }

    /// Force on the cell at `t` (s) after the run, N.
    pub(crate) fn force_at(&self, t: Second) -> Newton {
        self.0.iter().map(|(oscillator, state)| oscillator.free_decay(*state, t).displacement).sum()
    }

    /// Each wave at `t` (s) after the run.
    pub(crate) fn truth_at(&self, t: Second) -> Vec<TrueWave> {
        let wave = |(it, state): &(Oscillator, OscillatorState)| {
            let (state, (decay, angular_frequency)) = (it.free_decay(*state, t), it.decay_and_frequency());
            let lead = (state.velocity + decay * state.displacement) / angular_frequency;
            let (amplitude, phase) = (state.displacement.hypot(lead), (-lead).atan2(state.displacement));
            TrueWave { frequency: angular_frequency / TAU, amplitude, phase }
        };
        self.0.iter().map(wave).collect()
    }
}

/// The waves during a run and after it.
#[derive(Debug, Clone)]
pub(crate) struct DrivenWaves {
    start: Second,
    /// Σ of the waves every [`STEP`] of the run, N.
    during: Vec<Newton>,
    after: FreeWaves,
}

impl DrivenWaves {
    /// No waves.
    pub(crate) fn no_waves() -> Self {
        Self { start: 0.0, during: Vec::new(), after: FreeWaves::no_waves() }
    }

    /// The waves of a run from `start` to `end` (s) whose force (N) at time t (s) is `force`.
    pub(crate) fn of_run(
        set: &settings::Tank,
        [start, end]: [Second; 2],
        force: &dyn Fn(Second) -> Newton,
        random: &mut RandomStream,
    ) -> Self {
        let steps = ((end - start) / STEP).round() as usize;
        let (mut during, mut remaining) = (vec![0.0; steps + 1], Vec::new());
        for mode in MODES {
            let oscillator = Oscillator::tuned(1.0, TAU * mode_frequency(set, mode), set.damping_ratio);
            let force_at_step = |i: usize| force(start + i as f64 * STEP);
            let mut states = vec![OscillatorState::default()];
            (0..steps).for_each(|i| {
                states.push(oscillator.state_after(states[i], [force_at_step(i), force_at_step(i + 1)], STEP))
            });
            let last = states[steps];
            let factor = random.uniform(set.amplitude)
                / free_amplitude(&oscillator, oscillator.free_decay(last, AFTER)).max(f64::MIN_POSITIVE);
            during.iter_mut().zip(&states).for_each(|(sum, state)| *sum += factor * state.displacement);
            remaining.push((oscillator, scaled_state(last, factor)));
        }
        Self { start, during, after: FreeWaves(remaining) }
    }

    /// Force on the cell at time `t` (s), N.
    pub(crate) fn force_at(&self, t: Second) -> Newton {
        let index = (t - self.start) / STEP;
        match self.during.len().checked_sub(1) {
            Some(last) if index >= last as f64 => self.after.force_at((index - last as f64) * STEP),
            Some(_) if index >= 0.0 => {
                let (first, fraction) = (index as usize, index.fract());
                self.during[first] * (1.0 - fraction) + self.during[first + 1] * fraction
            }
            _ => 0.0,
        }
    }
}

fn driven_state(oscillator: &Oscillator, length: Second, force: &dyn Fn(Second) -> Newton) -> OscillatorState {
    let steps = (length / STEP).round() as usize;
    let force_at_step = |i: usize| force(i as f64 * STEP);
    (0..steps).fold(OscillatorState::default(), |state, i| {
        oscillator.state_after(state, [force_at_step(i), force_at_step(i + 1)], STEP)
    })
}

fn scaled_state(state: OscillatorState, factor: f64) -> OscillatorState {
    OscillatorState { displacement: factor * state.displacement, velocity: factor * state.velocity }
}

/// Amplitude of a free oscillation without its decay.
fn free_amplitude(oscillator: &Oscillator, state: OscillatorState) -> f64 {
    let (decay, angular_frequency) = oscillator.decay_and_frequency();
    state.displacement.hypot((state.velocity + decay * state.displacement) / angular_frequency)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    fn tank() -> settings::Tank {
        Settings::built_in().tank
    }

    fn waves(seed: u64, length: Second) -> FreeWaves {
        let run = |t: Second| 0.11 * (TAU * 2.0 * t).sin();
        FreeWaves::after_run(&tank(), length, &run, &mut RandomStream::new(seed, "tank"))
    }

    #[test]
    fn the_waves_of_a_run_continue_as_its_free_waves() {
        let run = |t: Second| 0.11 * (TAU * 2.0 * (t - 1.0)).sin();
        let driven = DrivenWaves::of_run(&tank(), [1.0, 8.5], &run, &mut RandomStream::new(5, "tank"));
        let left = waves(5, 7.5);
        for after in [0.0, 0.3, 1.0, 2.5] {
            assert!((driven.force_at(8.5 + after) - left.force_at(after)).abs() < 1e-6, "{after} s after the run");
        }
        assert!((driven.force_at(8.5 - 1e-9) - driven.force_at(8.5)).abs() < 1e-7 && driven.force_at(0.5) == 0.0);
    }

    #[test]
    fn shallow_and_deep_tanks_have_the_limits_of_the_dispersion_relation() {
        let of = |length, depth| settings::Tank { length, depth, ..tank() };
        let shallow = (GRAVITY * 1e-3_f64).sqrt() / (2.0 * 10.0);
        assert!((mode_frequency(&of(10.0, 1e-3), 1) / shallow - 1.0).abs() < 1e-6);
        let deep = (GRAVITY * PI / 0.45).sqrt() / TAU;
        assert!((mode_frequency(&of(0.45, 10.0), 1) / deep - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_first_two_waves_have_the_measured_frequencies() {
        assert!((1.0..1.2).contains(&mode_frequency(&tank(), 1)) && (1.8..2.0).contains(&mode_frequency(&tank(), 2)));
    }

    #[test]
    fn each_wave_is_1_to_3_mn_a_second_after_a_run_whatever_the_seed() {
        for seed in 0..40 {
            for wave in waves(seed, 5.0 + 0.01 * seed as f64).truth_at(AFTER) {
                assert!((1e-3..3e-3).contains(&wave.amplitude), "seed {seed}: {wave:?}");
            }
        }
    }

    #[test]
    fn the_phase_depends_on_the_run() {
        let phases = [5.0, 5.1, 5.2].map(|length| waves(7, length).truth_at(AFTER)[0].phase);
        assert!((phases[0] - phases[1]).abs() > 0.05 && (phases[1] - phases[2]).abs() > 0.05, "{phases:?}");
    }

    #[test]
    fn waves_have_their_amplitude_and_phase_and_decay() {
        let waves = waves(7, 5.0);
        let sum: f64 = waves.truth_at(AFTER).iter().map(|w| w.amplitude * w.phase.cos()).sum();
        assert!((waves.force_at(AFTER) - sum).abs() < 1e-12);
        assert!(waves.truth_at(20.0)[1].amplitude < 0.5 * waves.truth_at(0.0)[1].amplitude);
    }
}
