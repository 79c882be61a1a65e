//! The bridge amplifier: its zero drifts, it is noisy, and it stores whole millinewtons.
//!
//! The zero goes straight from where it is at the start to where it is at the end, and wanders about that line like a
//! bounded random walk. Noise is white at the rate that is set; the converter's own filter is in its figure already.
//!
//! Stands on: chance. Never knows: what force it is given.

use si::Newton;

use crate::draw::Draw;
use crate::settings;

/// Steps of the wandering in a whole run together deviate by this share of the wandering that is allowed.
const WALK: f64 = 1.0 / 3.0;

/// An amplifier through one run.
#[derive(Debug, Clone)]
pub struct Amplifier {
    /// Zero at each sample, N.
    pub zero: Vec<Newton>,
    /// Standard deviation of a sample, N.
    pub noise: Newton,
    quantum: Newton,
}

impl Amplifier {
    /// An amplifier for `samples` samples, whose noise (N) is drawn from `noise`.
    pub fn drawn(set: &settings::Cell, noise: [Newton; 2], samples: usize, draw: &mut Draw) -> Self {
        let [start, ramp] = [set.ramp; 2].map(|most| draw.between([-most, most]));
        let step = WALK * set.wander / (samples.max(1) as f64).sqrt();
        let (noise, mut walk) = (draw.between(noise), 0.0);
        let mut zero = |i: usize| {
            let here = start + ramp * i as f64 / samples.max(1) as f64 + walk;
            walk = (walk + step * draw.normal()).clamp(-set.wander, set.wander);
            here
        };
        Self { zero: (0..samples).map(&mut zero).collect(), noise, quantum: set.quantum }
    }

    /// What is stored for sample `i` when the cell feels `force` (N).
    pub fn store(&self, i: usize, force: Newton, draw: &mut Draw) -> Newton {
        ((force + self.zero[i] + self.noise * draw.normal()) / self.quantum).round() * self.quantum
    }

    /// How far the zero goes from the first sample to the last, N.
    pub fn drift(&self) -> Newton {
        self.zero.last().zip(self.zero.first()).map_or(0.0, |(last, first)| last - first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    #[test]
    fn the_zero_of_200_runs_drifts_up_to_45_mn_and_often_by_more_than_10() {
        let set = Settings::built_in().cell;
        let drift = |seed| Amplifier::drawn(&set, set.noise_in_air, 1600, &mut Draw::new(seed, "zero")).drift().abs();
        let drifts: Vec<f64> = (0..200).map(drift).collect();
        assert!(drifts.iter().all(|d| *d < 0.045));
        assert!(drifts.iter().filter(|d| **d > 0.010).count() > 80);
    }

    #[test]
    fn noise_deviates_as_drawn_about_the_zero_and_steps_are_millinewtons() {
        let set = Settings::built_in().cell;
        let mut draw = Draw::new(11, "noise");
        let amplifier = Amplifier::drawn(&set, [2e-3, 2e-3], 20_000, &mut draw);
        let stored: Vec<f64> = (0..20_000).map(|i| amplifier.store(i, 0.1, &mut draw)).collect();
        assert!(stored.iter().all(|f| (f * 1e3 - (f * 1e3).round()).abs() < 1e-9));
        let square = |(f, zero): (&f64, &f64)| (f - 0.1 - zero).powi(2);
        let deviation = (stored.iter().zip(&amplifier.zero).map(square).sum::<f64>() / 20_000.0).sqrt();
        // steps of q add q²/12; 20 000 samples tell a deviation to half a percent
        let expected = (4e-6_f64 + 1e-6 / 12.0).sqrt();
        assert!((deviation / expected - 1.0).abs() < 0.02, "{deviation} N");
    }
}
