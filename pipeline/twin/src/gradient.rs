//! Derivatives of a loss of a recorded motion.

/// Derivatives of a loss L by the state after one step; empty: zero.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LossGradient {
    /// ∂L/∂q, r.
    pub coordinates: Vec<f64>,
    /// ∂L/∂q̇, r, in s.
    pub velocity: Vec<f64>,
}

/// Derivatives of a loss by everything that a motion depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionGradient {
    /// By the constants of each region.
    pub regions: Vec<RegionGradient>,
    /// By the pressures at the end of each step, steps × chambers, 1/Pa.
    pub pressures: Vec<Vec<f64>>,
    /// By a factor of the water's added mass and one of its drag, at factors of 1: no unit. Divided by the ratio to theory that the sections
    /// were made with, they are the derivatives by that ratio.
    pub water: [f64; 2],
}

/// Derivatives of a loss by the constants of a region.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RegionGradient {
    /// By μ, 1/Pa.
    pub mu: f64,
    /// By λ, 1/Pa.
    pub lambda: f64,
    /// By C₂₀ and C₃₀, 1/Pa.
    pub stiffening: [f64; 2],
    /// By each branch's strength (no unit) and time (1/s).
    pub branches: Vec<[f64; 2]>,
}

impl RegionGradient {
    /// By Young's modulus E (1/Pa) of a region of these constants, where μ and λ follow it at constant Poisson's ratio, and C₂₀ and C₃₀ at constant
    /// ratio to μ.
    pub fn by_youngs_modulus(&self, of: &crate::data::Region) -> f64 {
        // every modulus is proportional to E = μ (3λ + 2μ)/(λ + μ)
        let youngs_modulus = of.mu * (3.0 * of.lambda + 2.0 * of.mu) / (of.lambda + of.mu);
        let by_stiffening: f64 = self.stiffening.iter().zip(of.stiffening).map(|(by, c)| by * c).sum();
        (self.mu * of.mu + self.lambda * of.lambda + by_stiffening) / youngs_modulus
    }
}
