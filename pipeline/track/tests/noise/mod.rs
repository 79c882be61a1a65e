//! Noise for the tests of this folder: the same numbers each time.

/// Deviates of mean 0 and standard deviation 1: sums of uniform numbers from a fixed linear congruence.
pub struct Noise(pub u64);

impl Noise {
    /// The next deviate.
    pub fn next(&mut self) -> f64 {
        let sum: f64 = (0..6).map(|_| self.uniform()).sum();
        (sum - 3.0) * 2.0_f64.sqrt()
    }

    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}
