//! The bridge amplifier: drift of the zero, noise and quantisation to millinewtons.
//!
//! The zero follows a straight line plus a bounded random walk. Noise is white at the sampling rate; its standard deviation includes the
//! converter's filter.

use si::Newton;

use crate::random::RandomStream;
use crate::settings;

/// Standard deviation of the random walk at the end of a run, relative to its bound.
const WALK_FRACTION: f64 = 1.0 / 3.0;

/// An amplifier through one run.
#[derive(Debug, Clone)]
pub(crate) struct Amplifier {
    /// Zero at each sample, N.
    pub(crate) zero: Vec<Newton>,
    /// Standard deviation of a sample, N.
    pub(crate) noise: Newton,
    quantum: Newton,
}

impl Amplifier {
    /// An amplifier for `samples` samples, whose noise (N) is drawn from `noise`.
    pub(crate) fn draw_amplifier(
        set: &settings::Cell,
        noise: [Newton; 2],
        samples: usize,
        random: &mut RandomStream,
    ) -> Self {
        let [start, ramp] = [set.ramp; 2].map(|limit| random.uniform([-limit, limit]));
        let step = WALK_FRACTION * set.wander / (samples.max(1) as f64).sqrt();
        let (noise, mut walk) = (random.uniform(noise), 0.0);
        let mut zero = |i: usize| {
            let zero_now = start + ramp * i as f64 / samples.max(1) as f64 + walk;
            walk = (walk + step * random.normal()).clamp(-set.wander, set.wander);
            zero_now
        };
        Self { zero: (0..samples).map(&mut zero).collect(), noise, quantum: set.quantum }
    }

    /// The stored value of sample `i` for the force (N) on the cell.
    pub(crate) fn stored_value(&self, i: usize, force: Newton, random: &mut RandomStream) -> Newton {
        ((force + self.zero[i] + self.noise * random.normal()) / self.quantum).round() * self.quantum
    }

    /// Change of the zero from the first sample to the last, N.
    pub(crate) fn zero_drift(&self) -> Newton {
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
        let drift = |seed| {
            Amplifier::draw_amplifier(&set, set.noise_in_air, 1600, &mut RandomStream::new(seed, "zero"))
                .zero_drift()
                .abs()
        };
        let drifts: Vec<f64> = (0..200).map(drift).collect();
        assert!(drifts.iter().all(|d| *d < 0.045));
        assert!(drifts.iter().filter(|d| **d > 0.010).count() > 80);
    }

    #[test]
    fn noise_has_its_standard_deviation_and_values_are_whole_millinewtons() {
        let set = Settings::built_in().cell;
        let mut random = RandomStream::new(11, "noise");
        let amplifier = Amplifier::draw_amplifier(&set, [2e-3, 2e-3], 20_000, &mut random);
        let stored: Vec<f64> = (0..20_000).map(|i| amplifier.stored_value(i, 0.1, &mut random)).collect();
        assert!(stored.iter().all(|f| (f * 1e3 - (f * 1e3).round()).abs() < 1e-9));
        let square = |(f, zero): (&f64, &f64)| (f - 0.1 - zero).powi(2);
        let deviation = (stored.iter().zip(&amplifier.zero).map(square).sum::<f64>() / 20_000.0).sqrt();
        // steps of q add q²/12; 20 000 samples give the standard deviation to half a per cent
        let expected = (4e-6_f64 + 1e-6 / 12.0).sqrt();
        assert!((deviation / expected - 1.0).abs() < 0.02, "{deviation} N");
    }
}
