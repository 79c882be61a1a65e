//! Undoing the fixture: the force that makes the cell say what it said, kept smooth where the cell says little.
//!
//! F = H* Y / (|H|² + λ(f)),  λ(f) = λ₀ (1 + (f/f_s)⁴)      [tikhonov1977]: the least ‖H F − Y‖² + λ₀(‖F‖² + ‖F̈‖²/ω_s⁴).
//! H* turns no phase, so nothing is delayed. White noise of standard deviation σ in Y becomes σ √(mean |G|²) in F.
//!
//! Stands on: spectrum. Never knows: what pulled.

use si::{Hertz, Newton, Second, Series};

use super::Cell;
use crate::spectrum;

/// The signal is continued by so much at either end, turned about its end point, s.
const BEYOND: Second = 2.0;

/// How strongly the inverse is held back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regularised {
    /// λ₀: noise power over signal power, no unit.
    pub weight: f64,
    /// f_s: forces are expected to be slower, Hz.
    pub smooth: Hertz,
}

/// A force and how well it is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Inverted {
    /// N.
    pub force: Series,
    /// Standard deviation of each sample, N.
    pub sigma: Newton,
}

impl Cell {
    /// The force (N) behind `felt` (N), whose noise has the standard deviation `noise` (N).
    pub fn undo(&self, felt: &Series, noise: Newton, held: Regularised) -> Inverted {
        let values = felt.values();
        let pad = ((BEYOND * felt.rate()) as usize).min(values.len() - 1);
        let long = continued(values, pad);
        let n = long.len();
        let gain = |k: usize| {
            let f = k as f64 * felt.rate() / n as f64;
            let (h, slow) = (self.transfer(f), (f / held.smooth).powi(4));
            h.conj() / (h.norm_sqr() + held.weight * (1.0 + slow))
        };
        let bins: Vec<_> = spectrum::forward(&long).into_iter().enumerate().map(|(k, y)| gain(k) * y).collect();
        // every bin but the first and the last stands for two
        let power: f64 =
            (0..bins.len()).map(|k| gain(k).norm_sqr() * if k == 0 || 2 * k == n { 1.0 } else { 2.0 }).sum();
        let force = spectrum::back(bins, n)[pad..pad + values.len()].to_vec();
        let force = Series::new(felt.start(), felt.rate(), force).expect("finite bins");
        Inverted { force, sigma: noise * (power / n as f64).sqrt() }
    }
}

/// The values with `pad` more at either end, turned about the end points.
fn continued(values: &[f64], pad: usize) -> Vec<f64> {
    let last = values.len() - 1;
    let before = (1..=pad).rev().map(|i| 2.0 * values[0] - values[i]);
    let after = (1..=pad).map(|i| 2.0 * values[last] - values[last - i]);
    before.chain(values.iter().copied()).chain(after).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Noise;
    use std::f64::consts::TAU;

    const CELL: Cell = Cell { natural_frequency: 14.0, damping_ratio: 0.03 };
    const HELD: Regularised = Regularised { weight: 1e-4, smooth: 8.0 };

    /// Beats of thrust, never negative, with four harmonics, between rests.
    fn thrust(t: f64, beat: f64) -> f64 {
        let ramp = ((t - 1.0) / 0.5).clamp(0.0, 1.0) * ((9.0 - t) / 0.5).clamp(0.0, 1.0);
        let angle = TAU * beat * t;
        ramp * ramp * (3.0 - 2.0 * ramp) * 0.1 * (angle.sin() + 0.3 * (2.0 * angle).cos()).powi(2)
    }

    fn felt(beat: f64, noise: &mut Noise, sigma: f64) -> (Vec<f64>, Series) {
        let fine =
            Series::new(0.0, 2000.0, (0..20_000).map(|i| thrust(f64::from(i) / 2000.0, beat)).collect()).unwrap();
        let times: Vec<f64> = (0..800).map(|i| f64::from(i) / 80.0).collect();
        let values = CELL.feels(&fine, &times).iter().map(|v| v + sigma * noise.normal()).collect();
        (times.iter().map(|&t| thrust(t, beat)).collect(), Series::new(0.0, 80.0, values).unwrap())
    }

    fn rms(values: impl Iterator<Item = f64>) -> f64 {
        let all: Vec<f64> = values.collect();
        (all.iter().map(|v| v * v).sum::<f64>() / all.len() as f64).sqrt()
    }

    #[test]
    fn the_round_trip_comes_back_within_5_percent_at_40_decibel() {
        for (seed, beat) in [(1, 1.0), (2, 2.0), (3, 3.0), (4, 4.0)] {
            let (clean, _) = felt(beat, &mut Noise::new(seed), 0.0);
            let mean = clean.iter().sum::<f64>() / clean.len() as f64;
            let spread = rms(clean.iter().map(|v| v - mean));
            let sigma = 0.01 * spread;
            let (thrust, felt) = felt(beat, &mut Noise::new(seed), sigma);
            let made = CELL.undo(&felt, sigma, HELD);
            let off = rms(made.force.values().iter().zip(&thrust).map(|(a, b)| a - b)) / spread;
            let raw = rms(felt.values().iter().zip(&thrust).map(|(a, b)| a - b)) / spread;
            assert!(off < 0.05 && off < raw, "{beat} Hz: {off}, and {raw} before");
        }
    }

    #[test]
    fn the_stated_spread_is_the_spread_that_noise_makes() {
        let mut noise = Noise::new(9);
        let only = Series::new(0.0, 80.0, (0..8000).map(|_| 1e-3 * noise.normal()).collect()).unwrap();
        let made = CELL.undo(&only, 1e-3, HELD);
        let found = rms(made.force.values().iter().copied());
        // 8000 samples tell a spread to 1 %; reflected ends and neighbours that move together take some more
        assert!((found / made.sigma - 1.0).abs() < 0.06, "{found} for {}", made.sigma);
    }

    #[test]
    fn a_constant_force_comes_back_but_for_the_weight() {
        let still = Series::new(0.0, 80.0, vec![0.3; 400]).unwrap();
        let made = CELL.undo(&still, 0.0, HELD);
        assert!(made.force.values().iter().all(|f| (f - 0.3 / (1.0 + HELD.weight)).abs() < 1e-12));
    }
}
