//! The tank: standing waves that a run leaves behind, and that the cell feels long after the tail is still.
//!
//! Mode n of a tank of length L and depth h has k = n π / L and ω² = g k tanh(k h), the dispersion relation of water
//! waves. The run's force drives each mode, which sets its phase; how strongly a wave comes back on the cell depends on
//! where the tail hangs and is not modelled: the amplitude a second after the run is drawn from what was measured.
//!
//! Stands on: the oscillator, chance. Never knows: a tail.

use std::f64::consts::{PI, TAU};

use lab::truth::TrueWave;
use si::{Hertz, Newton, Second};

use super::oscillator::{Oscillator, Swing};
use crate::draw::Draw;
use crate::settings;

/// m/s².
const GRAVITY: f64 = 9.81;
/// The waves that are felt.
pub const MODES: [u32; 2] = [1, 2];
/// Amplitudes are drawn for so long after the run, s.
pub const AFTER: Second = 1.0;
/// The force is taken as straight over such intervals, s.
const STEP: Second = 2e-3;

/// Frequency of a mode, Hz.
pub fn frequency(set: &settings::Tank, mode: u32) -> Hertz {
    let k = f64::from(mode) * PI / set.length;
    (GRAVITY * k * (k * set.depth).tanh()).sqrt() / TAU
}

/// What is left of a run.
#[derive(Debug, Clone)]
pub struct Waves(Vec<(Oscillator, Swing)>);

impl Waves {
    /// No waves.
    pub fn none() -> Self {
        Self(Vec::new())
    }

    /// The waves as a run of `length` (s) leaves them, whose force (N) at time t (s) is `force`.
    pub fn left_by(set: &settings::Tank, length: Second, force: &dyn Fn(Second) -> Newton, draw: &mut Draw) -> Self {
        let left = |mode: &u32| {
            let it = Oscillator::tuned(1.0, TAU * frequency(set, *mode), set.damping_ratio);
            let end = driven(&it, length, force);
            let swing = it.free(end, AFTER);
            (it, scaled(end, draw.between(set.amplitude) / amplitude(&it, swing)))
        };
        Self(MODES.iter().map(left).collect())
    }

    /// Force on the cell at `t` (s) after the run, N.
    pub fn at(&self, t: Second) -> Newton {
        self.0.iter().map(|(it, swing)| it.free(*swing, t).place).sum()
    }

    /// Each wave at `t` (s) after the run.
    pub fn true_at(&self, t: Second) -> Vec<TrueWave> {
        let wave = |(it, swing): &(Oscillator, Swing)| {
            let (swing, (decay, beat)) = (it.free(*swing, t), it.decay_and_beat());
            let lead = (swing.speed + decay * swing.place) / beat;
            let (amplitude, phase) = (swing.place.hypot(lead), (-lead).atan2(swing.place));
            TrueWave { frequency: beat / TAU, amplitude, phase }
        };
        self.0.iter().map(wave).collect()
    }
}

/// The waves of a run, while it lasts and afterwards.
#[derive(Debug, Clone)]
pub struct Swell {
    start: Second,
    /// Σ of the waves every [`STEP`] of the run, N.
    during: Vec<Newton>,
    left: Waves,
}

impl Swell {
    /// Nothing ever.
    pub fn none() -> Self {
        Self { start: 0.0, during: Vec::new(), left: Waves::none() }
    }

    /// The waves that a run from `start` to `end` (s) drives, whose force (N) at time t (s) is `force`.
    pub fn of(
        set: &settings::Tank,
        [start, end]: [Second; 2],
        force: &dyn Fn(Second) -> Newton,
        draw: &mut Draw,
    ) -> Self {
        let steps = ((end - start) / STEP).round() as usize;
        let (mut during, mut left) = (vec![0.0; steps + 1], Vec::new());
        for mode in MODES {
            let it = Oscillator::tuned(1.0, TAU * frequency(set, mode), set.damping_ratio);
            let at = |i: usize| force(start + i as f64 * STEP);
            let mut swings = vec![Swing::default()];
            (0..steps).for_each(|i| swings.push(it.after(swings[i], [at(i), at(i + 1)], STEP)));
            let last = swings[steps];
            let by = draw.between(set.amplitude) / amplitude(&it, it.free(last, AFTER)).max(f64::MIN_POSITIVE);
            during.iter_mut().zip(&swings).for_each(|(sum, swing)| *sum += by * swing.place);
            left.push((it, scaled(last, by)));
        }
        Self { start, during, left: Waves(left) }
    }

    /// Force on the cell at time `t` (s), N.
    pub fn at(&self, t: Second) -> Newton {
        let place = (t - self.start) / STEP;
        match self.during.len().checked_sub(1) {
            Some(last) if place >= last as f64 => self.left.at((place - last as f64) * STEP),
            Some(_) if place >= 0.0 => {
                let (first, share) = (place as usize, place.fract());
                self.during[first] * (1.0 - share) + self.during[first + 1] * share
            }
            _ => 0.0,
        }
    }
}

fn driven(it: &Oscillator, length: Second, force: &dyn Fn(Second) -> Newton) -> Swing {
    let steps = (length / STEP).round() as usize;
    let at = |i: usize| force(i as f64 * STEP);
    (0..steps).fold(Swing::default(), |swing, i| it.after(swing, [at(i), at(i + 1)], STEP))
}

fn scaled(swing: Swing, by: f64) -> Swing {
    Swing { place: by * swing.place, speed: by * swing.speed }
}

/// How far a free swing reaches, were it not to decay.
fn amplitude(it: &Oscillator, swing: Swing) -> f64 {
    let (decay, beat) = it.decay_and_beat();
    swing.place.hypot((swing.speed + decay * swing.place) / beat)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    fn tank() -> settings::Tank {
        Settings::built_in().tank
    }

    fn waves(seed: u64, length: Second) -> Waves {
        let run = |t: Second| 0.11 * (TAU * 2.0 * t).sin();
        Waves::left_by(&tank(), length, &run, &mut Draw::new(seed, "tank"))
    }

    #[test]
    fn a_swell_goes_over_into_what_the_run_leaves() {
        let run = |t: Second| 0.11 * (TAU * 2.0 * (t - 1.0)).sin();
        let swell = Swell::of(&tank(), [1.0, 8.5], &run, &mut Draw::new(5, "tank"));
        let left = waves(5, 7.5);
        for after in [0.0, 0.3, 1.0, 2.5] {
            assert!((swell.at(8.5 + after) - left.at(after)).abs() < 1e-6, "{after} s after the run");
        }
        assert!((swell.at(8.5 - 1e-9) - swell.at(8.5)).abs() < 1e-7 && swell.at(0.5) == 0.0);
    }

    #[test]
    fn shallow_and_deep_tanks_swing_as_the_limits_of_the_relation_say() {
        let of = |length, depth| settings::Tank { length, depth, ..tank() };
        let shallow = (GRAVITY * 1e-3_f64).sqrt() / (2.0 * 10.0);
        assert!((frequency(&of(10.0, 1e-3), 1) / shallow - 1.0).abs() < 1e-6);
        let deep = (GRAVITY * PI / 0.45).sqrt() / TAU;
        assert!((frequency(&of(0.45, 10.0), 1) / deep - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_first_two_waves_have_the_frequencies_that_were_measured() {
        assert!((1.0..1.2).contains(&frequency(&tank(), 1)) && (1.8..2.0).contains(&frequency(&tank(), 2)));
    }

    #[test]
    fn each_wave_is_1_to_3_mn_a_second_after_a_run_whatever_the_seed() {
        for seed in 0..40 {
            for wave in waves(seed, 5.0 + 0.01 * seed as f64).true_at(AFTER) {
                assert!((1e-3..3e-3).contains(&wave.amplitude), "seed {seed}: {wave:?}");
            }
        }
    }

    #[test]
    fn the_phase_is_the_run_s() {
        let phases = [5.0, 5.1, 5.2].map(|length| waves(7, length).true_at(AFTER)[0].phase);
        assert!((phases[0] - phases[1]).abs() > 0.05 && (phases[1] - phases[2]).abs() > 0.05, "{phases:?}");
    }

    #[test]
    fn waves_follow_their_amplitude_and_phase_for_an_instant_and_decay() {
        let waves = waves(7, 5.0);
        let sum: f64 = waves.true_at(AFTER).iter().map(|w| w.amplitude * w.phase.cos()).sum();
        assert!((waves.at(AFTER) - sum).abs() < 1e-12);
        assert!(waves.true_at(20.0)[1].amplitude < 0.5 * waves.true_at(0.0)[1].amplitude);
    }
}
