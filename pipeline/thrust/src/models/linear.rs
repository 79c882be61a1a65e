//! Models that are linear in their coefficients: features of a sample, weighted by ridge regression.

use nalgebra::{DMatrix, DVector};

use super::ThrustModel;
use crate::Run;
use crate::run::TheoryTerms;

/// Weights of a model's columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Weighted {
    /// The model that gives the features.
    pub model: ThrustModel,
    /// Their weights, in the force's unit per theirs.
    pub weights: Vec<f64>,
}

/// Relative ridge: 1e-6 of a feature's square makes nearly collinear features solvable.
const RIDGE: f64 = 1e-6;
/// Times relative to the sample at which the finite impulse response reads the markers, s.
const TAPS: [f64; 7] = [-0.15, -0.1, -0.05, 0.0, 0.05, 0.1, 0.15];

impl Weighted {
    /// The weights of least squared error over runs; the last feature is constant and has no ridge.
    pub fn fit(model: ThrustModel, runs: &[&Run]) -> Self {
        let rows: Vec<Vec<f64>> =
            runs.iter().flat_map(|run| (0..run.len()).map(|i| feature_columns(model, run, i))).collect();
        let target = DVector::from_iterator(rows.len(), runs.iter().flat_map(|r| r.force.iter().copied()));
        let width = rows.first().map_or(0, Vec::len);
        let matrix = DMatrix::from_fn(rows.len(), width, |i, j| rows[i][j]);
        let mut gram = matrix.tr_mul(&matrix);
        for j in 0..width.saturating_sub(1) {
            gram[(j, j)] *= 1.0 + RIDGE;
            gram[(j, j)] += f64::MIN_POSITIVE;
        }
        let solution = gram.cholesky().map(|c| c.solve(&matrix.tr_mul(&target)));
        let weights = solution.map_or_else(|| vec![0.0; width], |w| w.as_slice().to_vec());
        Self { model, weights }
    }

    /// The force at every sample of a run, N.
    pub fn predict(&self, run: &Run) -> Vec<f64> {
        let dot = |row: Vec<f64>| row.iter().zip(&self.weights).map(|(c, w)| c * w).sum();
        (0..run.len()).map(|i| dot(feature_columns(self.model, run, i))).collect()
    }
}

/// A model's columns at one sample, the constant last.
fn feature_columns(model: ThrustModel, run: &Run, sample: usize) -> Vec<f64> {
    let mut features = match model {
        ThrustModel::Linear => {
            let speed = run.frequency * run.amplitude_of_tip();
            vec![speed, speed * speed]
        }
        ThrustModel::Pressure => {
            let bar = |p: &f64| p * 1e-5;
            run.pressure[sample].iter().map(bar).flat_map(|p| [p, p * p]).collect()
        }
        ThrustModel::Fir => impulse_columns(run, sample),
        ThrustModel::Theory => theory_columns(&run.terms[sample]),
        _ => Vec::new(),
    };
    features.push(1.0);
    features
}

/// Theory with coefficients: Lighthill's terms, drag and the tail's own inertia; the constant is added by [`feature_columns`].
///
/// F = c₁ F_edge + c₂ d/dt ∫ m w n_x da + c₃ F_drag + c₄ ẍ + c₅; c₁ = c₂ = 1 in \[lighthill1971\].
fn theory_columns(terms: &TheoryTerms) -> Vec<f64> {
    vec![terms.edge_flux, terms.momentum_rate, terms.drag, terms.tip_acceleration]
}

/// Positions and velocities of the last and of the first marker at the taps.
fn impulse_columns(run: &Run, sample: usize) -> Vec<f64> {
    let last_sample = run.len() - 1;
    let sample_at = |lag: &f64| (sample as f64 - lag * run.rate).round().clamp(0.0, last_sample as f64) as usize;
    let marker_features = |i: usize| {
        let ends = |points: &[[f64; 2]]| [points[0], points[points.len() - 1]].concat();
        [ends(&run.moved[i]), ends(&run.speed[i])].concat()
    };
    TAPS.iter().flat_map(|lag| marker_features(sample_at(lag))).collect()
}
