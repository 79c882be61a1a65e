//! Deconvolution of the fixture by Tikhonov regularisation in the frequency domain \[tikhonov1977\].
//!
//! F = H* Y / (|H|² + λ(f)) with λ(f) = λ₀ (1 + (f/f_s)⁴) minimises ‖H F − Y‖² + λ₀ (‖F‖² + ‖F̈‖²/ω_s⁴). The phase of H* cancels that of
//! H, so nothing is delayed. White noise of standard deviation σ in Y becomes σ √(mean |G|²) in F.

use si::{Hertz, Newton, Second, Series};

use super::Cell;
use crate::spectrum;

/// Length of the continuation at either end by point reflection, s.
///
/// The transform is periodic; without a continuation a step between the two ends would ring through the inverse. The fixture's ringing
/// decays well within it. A log that is cut while the fixture still rings cannot be corrected near the cut.
const CONTINUATION: Second = 2.0;

/// Weight of the regularisation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regularisation {
    /// λ₀: noise power over signal power, no unit.
    pub weight: f64,
    /// f_s: above it forces are increasingly penalised, Hz.
    pub corner: Hertz,
}

/// A force with its uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct Deconvolved {
    /// N.
    pub force: Series,
    /// Standard deviation of each sample, N.
    pub sigma: Newton,
}

impl Cell {
    /// The force (N) that caused the `measured` one (N), whose noise has the standard deviation `noise` (N).
    pub fn deconvolve(&self, measured: &Series, noise: Newton, regularisation: Regularisation) -> Deconvolved {
        let values = measured.values();
        let pad = ((CONTINUATION * measured.rate()) as usize).min(values.len() - 1);
        let padded = reflected_values(values, pad);
        let n = padded.len();
        let gain = |k: usize| {
            let f = k as f64 * measured.rate() / n as f64;
            let (h, high_frequency_penalty) = (self.transfer(f), (f / regularisation.corner).powi(4));
            h.conj() / (h.norm_sqr() + regularisation.weight * (1.0 + high_frequency_penalty))
        };
        let bins: Vec<_> = spectrum::forward(&padded).into_iter().enumerate().map(|(k, y)| gain(k) * y).collect();
        // every bin but the first and the last counts for two
        let power: f64 =
            (0..bins.len()).map(|k| gain(k).norm_sqr() * if k == 0 || 2 * k == n { 1.0 } else { 2.0 }).sum();
        let force = spectrum::inverse(bins, n)[pad..pad + values.len()].to_vec();
        let force = Series::new(measured.start(), measured.rate(), force).expect("finite bins");
        Deconvolved { force, sigma: noise * (power / n as f64).sqrt() }
    }
}

/// The values with `pad` more at either end, by point reflection.
fn reflected_values(values: &[f64], pad: usize) -> Vec<f64> {
    let last = values.len() - 1;
    let leading = (1..=pad).rev().map(|i| 2.0 * values[0] - values[i]);
    let trailing = (1..=pad).map(|i| 2.0 * values[last] - values[last - i]);
    leading.chain(values.iter().copied()).chain(trailing).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Noise;
    use std::f64::consts::TAU;

    const CELL: Cell = Cell { natural_frequency: 14.0, damping_ratio: 0.03 };
    const HELD: Regularisation = Regularisation { weight: 1e-4, corner: 8.0 };

    /// Non-negative periodic thrust with four harmonics, between rests.
    fn thrust(t: f64, beat: f64) -> f64 {
        let ramp = ((t - 1.0) / 0.5).clamp(0.0, 1.0) * ((9.0 - t) / 0.5).clamp(0.0, 1.0);
        let angle = TAU * beat * t;
        ramp * ramp * (3.0 - 2.0 * ramp) * 0.1 * (angle.sin() + 0.3 * (2.0 * angle).cos()).powi(2)
    }

    fn measured(beat: f64, noise: &mut Noise, sigma: f64) -> (Vec<f64>, Series) {
        let fine =
            Series::new(0.0, 2000.0, (0..20_000).map(|i| thrust(f64::from(i) / 2000.0, beat)).collect()).unwrap();
        let times: Vec<f64> = (0..800).map(|i| f64::from(i) / 80.0).collect();
        let values = CELL.simulate(&fine, &times).iter().map(|v| v + sigma * noise.normal()).collect();
        (times.iter().map(|&t| thrust(t, beat)).collect(), Series::new(0.0, 80.0, values).unwrap())
    }

    fn rms(values: impl Iterator<Item = f64>) -> f64 {
        let all: Vec<f64> = values.collect();
        (all.iter().map(|v| v * v).sum::<f64>() / all.len() as f64).sqrt()
    }

    #[test]
    fn a_simulated_response_is_inverted_within_5_percent_at_40_decibel() {
        for (seed, beat) in [(1, 1.0), (2, 2.0), (3, 3.0), (4, 4.0)] {
            let (clean, _) = measured(beat, &mut Noise::new(seed), 0.0);
            let mean = clean.iter().sum::<f64>() / clean.len() as f64;
            let spread = rms(clean.iter().map(|v| v - mean));
            let sigma = 0.01 * spread;
            let (thrust, measured) = measured(beat, &mut Noise::new(seed), sigma);
            let made = CELL.deconvolve(&measured, sigma, HELD);
            let off = rms(made.force.values().iter().zip(&thrust).map(|(a, b)| a - b)) / spread;
            let raw = rms(measured.values().iter().zip(&thrust).map(|(a, b)| a - b)) / spread;
            assert!(off < 0.05 && off < raw, "{beat} Hz: {off}, and {raw} before");
        }
    }

    #[test]
    fn the_stated_deviation_is_that_of_propagated_noise() {
        let mut noise = Noise::new(9);
        let only = Series::new(0.0, 80.0, (0..8000).map(|_| 1e-3 * noise.normal()).collect()).unwrap();
        let made = CELL.deconvolve(&only, 1e-3, HELD);
        let found = rms(made.force.values().iter().copied());
        // 8000 samples give a standard deviation to 1 %; reflected ends and correlated neighbours add some more
        assert!((found / made.sigma - 1.0).abs() < 0.06, "{found} for {}", made.sigma);
    }

    #[test]
    fn a_constant_force_is_recovered_but_for_the_weight() {
        let still = Series::new(0.0, 80.0, vec![0.3; 400]).unwrap();
        let made = CELL.deconvolve(&still, 0.0, HELD);
        assert!(made.force.values().iter().all(|f| (f - 0.3 / (1.0 + HELD.weight)).abs() < 1e-12));
    }
}
