//! The search distribution of CMA-ES: mean, step size and covariance, and their adaptation from the better half of a generation.
//!
//! The (μ/μ_w, λ) strategy with cumulative step-size adaptation and rank-one and rank-μ updates; every constant is the published
//! one [hansen2016, table 1 and figure 6]. Paper, section IV.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::Evaluation;

/// What the next generation depends on, beside problem and settings.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Generations evaluated so far.
    pub generation: u64,
    /// Mean in the unit cube (parameters).
    pub mean: Vec<f64>,
    /// Step size σ.
    pub sigma: f64,
    /// Covariance C (parameters × parameters).
    pub covariance: Vec<f64>,
    /// Conjugate evolution path p_σ (parameters).
    pub sigma_path: Vec<f64>,
    /// Evolution path p_c (parameters).
    pub covariance_path: Vec<f64>,
    /// The best point so far.
    pub best: Option<Evaluation>,
}

/// The strategy's published constants for n parameters and λ points.
pub(super) struct Constants {
    pub(super) weights: Vec<f64>,
    effective_mass: f64,
    sigma_rate: f64,
    damping: f64,
    covariance_rate: f64,
    rank_one: f64,
    rank_mu: f64,
    /// E‖N(0, I)‖.
    expected: f64,
}

impl Constants {
    pub(super) fn new(parameters: usize, population: usize) -> Self {
        let n = parameters as f64;
        let half = (population as f64 + 1.0) / 2.0;
        let raw: Vec<f64> = (1..=population / 2).map(|i| half.ln() - (i as f64).ln()).collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / sum).collect();
        let effective_mass = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let sigma_rate = (effective_mass + 2.0) / (n + effective_mass + 5.0);
        let rank_one = 2.0 / ((n + 1.3).powi(2) + effective_mass);
        let rank_mu = (2.0 * (effective_mass - 2.0 + 1.0 / effective_mass) / ((n + 2.0).powi(2) + effective_mass))
            .min(1.0 - rank_one);
        Self {
            weights,
            effective_mass,
            sigma_rate,
            damping: 1.0 + 2.0 * (((effective_mass - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + sigma_rate,
            covariance_rate: (4.0 + effective_mass / n) / (n + 4.0 + 2.0 * effective_mass / n),
            rank_one,
            rank_mu,
            expected: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        }
    }
}

impl State {
    /// B and D of C = B D² Bᵀ.
    pub(super) fn axes(&self) -> (DMatrix<f64>, DVector<f64>) {
        let n = self.mean.len();
        let split = SymmetricEigen::new(DMatrix::from_column_slice(n, n, &self.covariance));
        (split.eigenvectors, split.eigenvalues.map(|v| v.max(0.0).sqrt()))
    }

    /// One generation's adaptation from the steps y = (x − m)/σ of the better points, best first.
    #[allow(non_snake_case)]
    pub(super) fn adapt(&mut self, k: &Constants, steps: &[DVector<f64>]) {
        let (B, D) = self.axes();
        let n = self.mean.len();
        let y = steps.iter().zip(&k.weights).fold(DVector::zeros(n), |sum, (y, &w)| sum + w * y);
        let whitened = &B * B.tr_mul(&y).component_div(&D.map(|d| d.max(f64::MIN_POSITIVE)));
        let mean = DVector::from_column_slice(&self.mean) + self.sigma * &y;
        let ps = (1.0 - k.sigma_rate) * DVector::from_column_slice(&self.sigma_path)
            + (k.sigma_rate * (2.0 - k.sigma_rate) * k.effective_mass).sqrt() * whitened;
        let warm_up = (1.0 - (1.0 - k.sigma_rate).powi(2 * (self.generation as i32 + 1))).sqrt();
        let stationary = ps.norm() / warm_up < (1.4 + 2.0 / (n as f64 + 1.0)) * k.expected;
        // While the path is long, σ is growing and C must not grow in the same direction too: p_c stops and C is corrected.
        let pull =
            if stationary { (k.covariance_rate * (2.0 - k.covariance_rate) * k.effective_mass).sqrt() } else { 0.0 };
        let pc = (1.0 - k.covariance_rate) * DVector::from_column_slice(&self.covariance_path) + pull * &y;
        let correction = if stationary { 0.0 } else { k.rank_one * k.covariance_rate * (2.0 - k.covariance_rate) };
        let rank_mu_sum =
            steps.iter().zip(&k.weights).fold(DMatrix::zeros(n, n), |sum, (y, &w)| sum + w * y * y.transpose());
        let C = (1.0 + correction - k.rank_one - k.rank_mu) * DMatrix::from_column_slice(n, n, &self.covariance)
            + k.rank_one * &pc * pc.transpose()
            + k.rank_mu * rank_mu_sum;
        self.sigma *= ((k.sigma_rate / k.damping) * (ps.norm() / k.expected - 1.0)).exp();
        // Clamped, because a mean of clamped points may leave the cube by round-off.
        self.mean = mean.map(|v| v.clamp(0.0, 1.0)).as_slice().to_vec();
        self.covariance = (0.5 * (&C + C.transpose())).as_slice().to_vec();
        self.sigma_path = ps.as_slice().to_vec();
        self.covariance_path = pc.as_slice().to_vec();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE_AXIS: Constants = Constants {
        weights: Vec::new(),
        effective_mass: 1.5,
        sigma_rate: 0.5,
        damping: 2.0,
        covariance_rate: 0.25,
        rank_one: 0.2,
        rank_mu: 0.1,
        expected: 0.8,
    };

    /// σ, C and p_c after a generation whose one better point lies a step of `y` from the mean.
    fn adapted(generation: u64, y: f64) -> [f64; 3] {
        let mut state = State {
            generation,
            mean: vec![0.5],
            sigma: 0.1,
            covariance: vec![1.0],
            sigma_path: vec![0.3],
            covariance_path: vec![0.4],
            best: None,
        };
        state.adapt(&Constants { weights: vec![1.0], ..ONE_AXIS }, &[DVector::from_element(1, y)]);
        [state.sigma, state.covariance[0], state.covariance_path[0]]
    }

    #[test]
    fn one_generation_adapts_as_worked_out_by_hand() {
        let near = |found: [f64; 3], by_hand: [f64; 3]| found.iter().zip(by_hand).all(|(a, b)| (a - b).abs() < 1e-12);
        // p_σ = 0.5 × 0.3 + √1.125 y; after two generations its expected square has reached 15/16
        assert!(near(adapted(1, 1.2), [0.121_485_237_143_380_98, 1.167_653_332_571_341_4, 1.272_111_104_761_179]));
        // a long path stops p_c, and C gets back what p_c would have added
        assert!(near(adapted(1, 1.9), [0.153_210_403_502_767_6, 1.1665, 0.3]));
        // after one generation it has reached 3/4 alone: the same path counts as longer
        assert!((adapted(0, 1.5)[2] - 0.3).abs() < 1e-12 && adapted(1, 1.5)[2] > 1.0);
    }
}
