//! Chance: numbers that look random and are the same in every run, a stream for each purpose.
//!
//! A stream is named by a seed and a label, so that a new draw somewhere never shifts the draws elsewhere.
//!
//! Stands on: `rand_chacha`, `blake3`. Never knows: what the numbers are for.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A stream of draws.
pub struct Draw(ChaCha8Rng);

impl Draw {
    /// The stream of `label` under `seed`.
    pub fn new(seed: u64, label: &str) -> Self {
        let mut hash = blake3::Hasher::new();
        hash.update(&seed.to_le_bytes()).update(label.as_bytes());
        Self(ChaCha8Rng::from_seed(*hash.finalize().as_bytes()))
    }

    /// Evenly between 0 and 1.
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Evenly between two ends.
    pub fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Normal with mean 0 and deviation 1, by Box and Muller.
    pub fn normal(&mut self) -> f64 {
        let (radius, angle) = (1.0 - self.unit(), self.unit());
        (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
    }

    /// Random bytes.
    pub fn bytes(&mut self, into: &mut [u8]) {
        self.0.fill_bytes(into);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_is_the_same_again_and_another_label_is_another_stream() {
        let first = |label| Draw::new(7, label).unit();
        assert_eq!(first("valve"), first("valve"));
        assert_ne!(first("valve"), first("camera"));
    }

    #[test]
    fn normal_draws_have_deviation_one() {
        let mut draw = Draw::new(7, "noise");
        let draws: Vec<f64> = (0..40_000).map(|_| draw.normal()).collect();
        let mean = draws.iter().sum::<f64>() / draws.len() as f64;
        let spread = draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / draws.len() as f64;
        assert!(mean.abs() < 0.02 && (spread - 1.0).abs() < 0.03, "mean {mean}, variance {spread}");
    }
}
