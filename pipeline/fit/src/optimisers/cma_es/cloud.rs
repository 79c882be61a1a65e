//! The cloud of CMA-ES: its centre, size and form, and how a generation's better half moves them.
//!
//! The (μ/μ_w, λ) strategy with cumulative step-size adaptation and rank-one and rank-μ updates; every constant is the
//! published one.      [hansen2016], table 1 and figure 6; paper, section IV
//!
//! Stands on: nalgebra. Never knows: a box, a draw.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::Evaluation;

/// Everything that the next generation depends on, beside search and settings.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Generations told so far.
    pub generation: u64,
    /// Centre of the cloud in the unit cube (parameters).
    pub mean: Vec<f64>,
    /// σ, the cloud's overall size.
    pub sigma: f64,
    /// C, the cloud's form (parameters × parameters).
    pub covariance: Vec<f64>,
    /// p_σ, the conjugate path (parameters).
    pub sigma_path: Vec<f64>,
    /// p_c, the path of the centre (parameters).
    pub form_path: Vec<f64>,
    /// The best point so far.
    pub best: Option<Evaluation>,
}

/// The strategy's published constants for n parameters and λ points.
pub(super) struct Constants {
    pub(super) weights: Vec<f64>,
    mass: f64,
    sigma_rate: f64,
    damping: f64,
    form_rate: f64,
    rank_one: f64,
    rank_many: f64,
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
        let mass = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let sigma_rate = (mass + 2.0) / (n + mass + 5.0);
        let rank_one = 2.0 / ((n + 1.3).powi(2) + mass);
        let rank_many = (2.0 * (mass - 2.0 + 1.0 / mass) / ((n + 2.0).powi(2) + mass)).min(1.0 - rank_one);
        Self {
            weights,
            mass,
            sigma_rate,
            damping: 1.0 + 2.0 * (((mass - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + sigma_rate,
            form_rate: (4.0 + mass / n) / (n + 4.0 + 2.0 * mass / n),
            rank_one,
            rank_many,
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

    /// One generation's update from the ways y = (x − m)/σ of the better points, best first.
    #[allow(non_snake_case)]
    pub(super) fn follow(&mut self, k: &Constants, ways: &[DVector<f64>]) {
        let (B, D) = self.axes();
        let n = self.mean.len();
        let y = ways.iter().zip(&k.weights).fold(DVector::zeros(n), |sum, (y, &w)| sum + w * y);
        let whitened = &B * B.tr_mul(&y).component_div(&D.map(|d| d.max(f64::MIN_POSITIVE)));
        let mean = DVector::from_column_slice(&self.mean) + self.sigma * &y;
        let ps = (1.0 - k.sigma_rate) * DVector::from_column_slice(&self.sigma_path)
            + (k.sigma_rate * (2.0 - k.sigma_rate) * k.mass).sqrt() * whitened;
        let settled = (1.0 - (1.0 - k.sigma_rate).powi(2 * (self.generation as i32 + 1))).sqrt();
        let calm = ps.norm() / settled < (1.4 + 2.0 / (n as f64 + 1.0)) * k.expected;
        let pull = if calm { (k.form_rate * (2.0 - k.form_rate) * k.mass).sqrt() } else { 0.0 };
        let pc = (1.0 - k.form_rate) * DVector::from_column_slice(&self.form_path) + pull * &y;
        let stalled = if calm { 0.0 } else { k.rank_one * k.form_rate * (2.0 - k.form_rate) };
        let many = ways.iter().zip(&k.weights).fold(DMatrix::zeros(n, n), |sum, (y, &w)| sum + w * y * y.transpose());
        let C = (1.0 + stalled - k.rank_one - k.rank_many) * DMatrix::from_column_slice(n, n, &self.covariance)
            + k.rank_one * &pc * pc.transpose()
            + k.rank_many * many;
        self.sigma *= ((k.sigma_rate / k.damping) * (ps.norm() / k.expected - 1.0)).exp();
        self.mean = mean.map(|v| v.clamp(0.0, 1.0)).as_slice().to_vec();
        self.covariance = (0.5 * (&C + C.transpose())).as_slice().to_vec();
        self.sigma_path = ps.as_slice().to_vec();
        self.form_path = pc.as_slice().to_vec();
    }
}
