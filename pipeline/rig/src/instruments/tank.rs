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
pub(crate) fn frequency(set: &settings::Tank, mode: u32) -> Hertz {
    let k = f64::from(mode) * PI / set.length;
    (GRAVITY * k * (k * set.depth).tanh()).sqrt() / TAU
}

/// The waves after a run.
#[derive(Debug, Clone)]
pub(crate) struct FreeWaves(Vec<(Oscillator, OscillatorState)>);

impl FreeWaves {
    /// No waves.
    pub(crate) fn none() -> Self {
        Self(Vec::new())
    }

    /// The waves after a run of `length` (s) whose force (N) at time t (s) is `force`.
    pub(crate) fn after_run(
        set: &settings::Tank,
        length: Second,
        force: &dyn Fn(Second) -> Newton,
        random: &mut RandomStream,
    ) -> Self {
        let left = |mode: &u32| {
            let it = Oscillator::tuned(1.0, TAU * frequency(set, *mode), set.damping_ratio);
            let end = driven(&it, length, force);
            let state = it.free_decay(end, AFTER);
            (it, scaled(end, random.uniform(set.amplitude) / amplitude(&it, state)))
        };
        Self(MODES.iter().map(left).collect())
    }

    /// Force on the cell at `t` (s) after the run, N.
    pub(crate) fn at(&self, t: Second) -> Newton {
        self.0.iter().map(|(it, state)| it.free_decay(*state, t).displacement).sum()
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
    pub(crate) fn none() -> Self {
        Self { start: 0.0, during: Vec::new(), after: FreeWaves::none() }
    }

    /// The waves of a run from `start` to `end` (s) whose force (N) at time t (s) is `force`.
    pub(crate) fn of(
        set: &settings::Tank,
        [start, end]: [Second; 2],
        force: &dyn Fn(Second) -> Newton,
        random: &mut RandomStream,
    ) -> Self {
        let steps = ((end - start) / STEP).round() as usize;
        let (mut during, mut left) = (vec![0.0; steps + 1], Vec::new());
        for mode in MODES {
            let it = Oscillator::tuned(1.0, TAU * frequency(set, mode), set.damping_ratio);
            let at = |i: usize| force(start + i as f64 * STEP);
            let mut states = vec![OscillatorState::default()];
            (0..steps).for_each(|i| states.push(it.step(states[i], [at(i), at(i + 1)], STEP)));
            let last = states[steps];
            let by = random.uniform(set.amplitude) / amplitude(&it, it.free_decay(last, AFTER)).max(f64::MIN_POSITIVE);
            during.iter_mut().zip(&states).for_each(|(sum, state)| *sum += by * state.displacement);
            left.push((it, scaled(last, by)));
        }
        Self { start, during, after: FreeWaves(left) }
    }

    /// Force on the cell at time `t` (s), N.
    pub(crate) fn at(&self, t: Second) -> Newton {
        let place = (t - self.start) / STEP;
        match self.during.len().checked_sub(1) {
            Some(last) if place >= last as f64 => self.after.at((place - last as f64) * STEP),
            Some(_) if place >= 0.0 => {
                let (first, fraction) = (place as usize, place.fract());
                self.during[first] * (1.0 - fraction) + self.during[first + 1] * fraction
            }
            _ => 0.0,
        }
    }
}

fn driven(it: &Oscillator, length: Second, force: &dyn Fn(Second) -> Newton) -> OscillatorState {
    let steps = (length / STEP).round() as usize;
    let at = |i: usize| force(i as f64 * STEP);
    (0..steps).fold(OscillatorState::default(), |state, i| it.step(state, [at(i), at(i + 1)], STEP))
}

fn scaled(state: OscillatorState, by: f64) -> OscillatorState {
    OscillatorState { displacement: by * state.displacement, velocity: by * state.velocity }
}

/// Amplitude of a free oscillation without its decay.
fn amplitude(it: &Oscillator, state: OscillatorState) -> f64 {
    let (decay, angular_frequency) = it.decay_and_frequency();
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
        let driven = DrivenWaves::of(&tank(), [1.0, 8.5], &run, &mut RandomStream::new(5, "tank"));
        let left = waves(5, 7.5);
        for after in [0.0, 0.3, 1.0, 2.5] {
            assert!((driven.at(8.5 + after) - left.at(after)).abs() < 1e-6, "{after} s after the run");
        }
        assert!((driven.at(8.5 - 1e-9) - driven.at(8.5)).abs() < 1e-7 && driven.at(0.5) == 0.0);
    }

    #[test]
    fn shallow_and_deep_tanks_have_the_limits_of_the_dispersion_relation() {
        let of = |length, depth| settings::Tank { length, depth, ..tank() };
        let shallow = (GRAVITY * 1e-3_f64).sqrt() / (2.0 * 10.0);
        assert!((frequency(&of(10.0, 1e-3), 1) / shallow - 1.0).abs() < 1e-6);
        let deep = (GRAVITY * PI / 0.45).sqrt() / TAU;
        assert!((frequency(&of(0.45, 10.0), 1) / deep - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_first_two_waves_have_the_measured_frequencies() {
        assert!((1.0..1.2).contains(&frequency(&tank(), 1)) && (1.8..2.0).contains(&frequency(&tank(), 2)));
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
        assert!((waves.at(AFTER) - sum).abs() < 1e-12);
        assert!(waves.truth_at(20.0)[1].amplitude < 0.5 * waves.truth_at(0.0)[1].amplitude);
    }
}
