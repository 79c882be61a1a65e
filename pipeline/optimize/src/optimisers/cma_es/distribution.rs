//! The search distribution of CMA-ES: mean, step size and covariance, and their adaptation from a ranked generation.
//!
//! The (μ/μ_w, λ) strategy with cumulative step-size adaptation, rank-one and active rank-μ updates: the better half of a generation
//! draws the mean and adds variance along its steps, the worse half removes variance along its own. Paper, section IV.

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

/// The strategy's constants for n parameters and λ points, as published [hansen2016, table 1].
pub(super) struct Constants {
    /// Positive weights of the better half, in all 1, and negative ones of the others, by rank.
    weights: Vec<f64>,
    effective_mass: f64,
    sigma_rate: f64,
    damping: f64,
    covariance_rate: f64,
    rank_one: f64,
    rank_mu: f64,
    /// E‖N(0, I)‖.
    expected: f64,
}

/// (Σ w)² / Σ w², the number of equal weights that average as well as these.
fn effective_mass(weights: &[f64]) -> f64 {
    weights.iter().sum::<f64>().powi(2) / weights.iter().map(|w| w * w).sum::<f64>()
}

impl Constants {
    pub(super) fn new(parameters: usize, population: usize) -> Self {
        let n = parameters as f64;
        let half = (population as f64 + 1.0) / 2.0;
        let raw_weights: Vec<f64> = (1..=population).map(|i| half.ln() - (i as f64).ln()).collect();
        let effective_mass = effective_mass(&raw_weights[..population / 2]);
        // 3 as in pycma and not 5 as in the tutorial: it takes 2 % fewer evaluations of Rosenbrock's function.
        let sigma_rate = (effective_mass + 2.0) / (n + effective_mass + 3.0);
        let mut constants = Self {
            weights: raw_weights,
            effective_mass,
            sigma_rate,
            damping: 1.0 + 2.0 * (((effective_mass - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + sigma_rate,
            covariance_rate: (4.0 + effective_mass / n) / (n + 4.0 + 2.0 * effective_mass / n),
            rank_one: 2.0 / ((n + 1.3).powi(2) + effective_mass),
            rank_mu: 2.0 * (effective_mass - 1.75 + 1.0 / effective_mass) / ((n + 2.0).powi(2) + effective_mass),
            expected: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        };
        constants.rank_mu = constants.rank_mu.min(1.0 - constants.rank_one);
        constants.scale_weights(n);
        constants
    }

    /// Scales the positive weights to a sum of 1, and the negative ones to the least of three bounds [hansen2016, eqs. 49–53].
    fn scale_weights(&mut self, n: f64) {
        let half = self.weights.len() / 2;
        let (positive, negative) = self.weights.split_at_mut(half);
        let unchanged = 1.0 + self.rank_one / self.rank_mu; // C keeps its size when every step is as long as expected
        let noise = 1.0 + 2.0 * effective_mass(negative) / (self.effective_mass + 2.0);
        let definite = (1.0 - self.rank_one - self.rank_mu) / (n * self.rank_mu); // C stays positive definite
        for (weights, target) in [(positive, 1.0), (negative, unchanged.min(noise).min(definite))] {
            let sum: f64 = weights.iter().map(|w| w.abs()).sum();
            weights.iter_mut().for_each(|w| *w *= target / sum);
        }
    }
}

impl State {
    /// B and D of C = B D² Bᵀ.
    pub(super) fn principal_axes(&self) -> (DMatrix<f64>, DVector<f64>) {
        let n = self.mean.len();
        let decomposition = SymmetricEigen::new(DMatrix::from_column_slice(n, n, &self.covariance));
        (decomposition.eigenvectors, decomposition.eigenvalues.map(|v| v.max(0.0).sqrt()))
    }

    /// One generation's adaptation from the steps y = (x − m)/σ of its points, best first [hansen2016, figure 6].
    #[allow(non_snake_case)]
    pub(super) fn adapt_distribution(&mut self, k: &Constants, steps: &[DVector<f64>]) {
        let (B, D) = self.principal_axes();
        let n = self.mean.len();
        let whitened = |y: &DVector<f64>| &B * B.tr_mul(y).component_div(&D.map(|d| d.max(f64::MIN_POSITIVE)));
        let selected = steps.iter().zip(&k.weights).take(steps.len() / 2);
        let y = selected.fold(DVector::zeros(n), |sum, (y, &w)| sum + w * y);
        let mean = DVector::from_column_slice(&self.mean) + self.sigma * &y;
        let ps = (1.0 - k.sigma_rate) * DVector::from_column_slice(&self.sigma_path)
            + (k.sigma_rate * (2.0 - k.sigma_rate) * k.effective_mass).sqrt() * whitened(&y);
        let warm_up = (1.0 - (1.0 - k.sigma_rate).powi(2 * (self.generation as i32 + 1))).sqrt();
        let stationary = ps.norm() / warm_up < (1.4 + 2.0 / (n as f64 + 1.0)) * k.expected;
        // While the path is long, σ is growing and C must not grow in the same direction too: p_c stops and C is corrected.
        let path_factor =
            if stationary { (k.covariance_rate * (2.0 - k.covariance_rate) * k.effective_mass).sqrt() } else { 0.0 };
        let pc = (1.0 - k.covariance_rate) * DVector::from_column_slice(&self.covariance_path) + path_factor * &y;
        let correction = if stationary { 0.0 } else { k.rank_one * k.covariance_rate * (2.0 - k.covariance_rate) };
        // A worse point shows a direction that is too long, not how much: its step counts with its expected length, √n after whitening,
        // so that no far point can remove more than all of the variance.
        let active_weight =
            |y, w: f64| if w < 0.0 { w * n as f64 / whitened(y).norm_squared().max(f64::MIN_POSITIVE) } else { w };
        let rank_mu_sum = steps
            .iter()
            .zip(&k.weights)
            .fold(DMatrix::zeros(n, n), |sum, (y, &w)| sum + active_weight(y, w) * y * y.transpose());
        let decay = k.rank_one + k.rank_mu * k.weights.iter().sum::<f64>();
        let C = (1.0 + correction - decay) * DMatrix::from_column_slice(n, n, &self.covariance)
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

    fn state(generation: u64, parameters: usize) -> State {
        let covariance = DMatrix::identity(parameters, parameters).as_slice().to_vec();
        let path = |value| vec![value; parameters];
        let (mean, sigma_path, covariance_path) = (path(0.5), path(0.3), path(0.4));
        State { generation, mean, sigma: 0.1, covariance, sigma_path, covariance_path, best: None }
    }

    /// σ, C and p_c after a generation whose better point lies a step of `y` from the mean: the active update leaves a single variance.
    fn adapted(generation: u64, y: f64) -> [f64; 3] {
        let mut state = state(generation, 1);
        let steps = [y, -2.0].map(|y| DVector::from_element(1, y));
        state.adapt_distribution(&Constants { weights: vec![1.0, -0.5], ..ONE_AXIS }, &steps);
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

    #[test]
    fn the_variance_along_a_worse_step_shrinks_however_long_it_is() {
        for far in [0.1, 3.0, 1e6] {
            let mut state = state(1, 2);
            state.covariance_path = vec![0.0; 2];
            let steps = [[0.0, 0.0], [0.0, far]].map(|y| DVector::from_row_slice(&y));
            state.adapt_distribution(&Constants { weights: vec![1.0, -0.5], ..ONE_AXIS }, &steps);
            // 1 − c₁ − c_μ (1 − 0.5), and along the step 2 × 0.5 c_μ less
            let off = state.covariance.iter().zip([0.75, 0.0, 0.0, 0.65]).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-12, "{:?}", state.covariance);
        }
    }

    #[test]
    fn weights_and_rates_are_those_of_pycma() {
        // pycma 4.5: of negative weights the first bound holds for 2 parameters and 10 points, the second for 12 and 6
        let ten = Constants::new(2, 10);
        let expected = [
            0.45627264690340597,
            0.2707530970017852,
            0.16223111715866978,
            0.08523354710016448,
            0.025509591835974777,
            -0.08670087226006841,
            -0.2403014571824138,
            -0.37335633592577155,
            -0.49071905655096415,
            -0.5957035876013446,
        ];
        assert!(ten.weights.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{:?}", ten.weights);
        assert!(
            (ten.rank_one - 0.14227483956643008).abs() < 1e-14 && (ten.rank_mu - 0.18083149389139339).abs() < 1e-14
        );
        let six = Constants::new(12, 6);
        let expected = [
            0.6370425712412168,
            0.28457025743803294,
            0.07838717132075033,
            -0.28638378259655295,
            -0.7649580940851277,
            -1.1559817781589212,
        ];
        assert!(six.weights.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{:?}", six.weights);
        assert!((six.sigma_rate - 0.236578976094591).abs() < 1e-14 && (six.damping - 1.236578976094591).abs() < 1e-14);
    }

    /// In each generation all worse points lie along one axis: without the third bound of the negative weights, C turns indefinite.
    #[test]
    fn the_covariance_stays_positive_definite() {
        for (n, population) in [(2, 4), (2, 10), (2, 40), (6, 60)] {
            let constants = Constants::new(n, population);
            let mut state = state(0, n);
            for generation in 0..200 {
                let along = |k: usize| (generation + 2 * k / population) % n;
                let axis = |k: usize| DVector::from_fn(n, |i, _| f64::from(u8::from(i == along(k))));
                state.adapt_distribution(&constants, &(0..population).map(axis).collect::<Vec<_>>());
                state.sigma = 0.1;
                let least = SymmetricEigen::new(DMatrix::from_column_slice(n, n, &state.covariance)).eigenvalues.min();
                assert!(least > 0.0, "{n} parameters, {population} points: {least:e} after {generation}");
                state.generation += 1;
            }
        }
    }
}
