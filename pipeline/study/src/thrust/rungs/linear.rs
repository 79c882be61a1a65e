//! Rungs that are linear in their coefficients: columns of numbers a sample, weighted by ridge least squares.
//!
//! Stands on: run, nalgebra. Never knows: the network.

use nalgebra::{DMatrix, DVector};

use super::{Rung, theory};
use crate::thrust::Run;

/// Weights of a rung's columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Weighted {
    /// Which columns.
    pub rung: Rung,
    /// Their weights, in the force's unit per theirs.
    pub weights: Vec<f64>,
}

/// How much of a column's own square is added to it: 1e-6 settles columns that say nearly the same.
const RIDGE: f64 = 1e-6;
/// Times before now at which the finite response reads the marks, s: it sees a tenth of a second and more back and forth.
const TAPS: [f64; 7] = [-0.15, -0.1, -0.05, 0.0, 0.05, 0.1, 0.15];

impl Weighted {
    /// The weights with the least squared error over runs; the last column is constant and bears no ridge.
    pub fn fit(rung: Rung, runs: &[&Run]) -> Self {
        let rows: Vec<Vec<f64>> = runs.iter().flat_map(|run| (0..run.len()).map(|i| columns(rung, run, i))).collect();
        let target = DVector::from_iterator(rows.len(), runs.iter().flat_map(|r| r.force.iter().copied()));
        let width = rows.first().map_or(0, Vec::len);
        let matrix = DMatrix::from_fn(rows.len(), width, |i, j| rows[i][j]);
        let mut gram = matrix.tr_mul(&matrix);
        for j in 0..width.saturating_sub(1) {
            gram[(j, j)] *= 1.0 + RIDGE;
            gram[(j, j)] += f64::MIN_POSITIVE;
        }
        let solved = gram.cholesky().map(|c| c.solve(&matrix.tr_mul(&target)));
        let weights = solved.map_or_else(|| vec![0.0; width], |w| w.as_slice().to_vec());
        Self { rung, weights }
    }

    /// The force at every sample of a run, N.
    pub fn tell(&self, run: &Run) -> Vec<f64> {
        let dot = |row: Vec<f64>| row.iter().zip(&self.weights).map(|(c, w)| c * w).sum();
        (0..run.len()).map(|i| dot(columns(self.rung, run, i))).collect()
    }
}

/// A rung's columns at one sample, the constant last.
fn columns(rung: Rung, run: &Run, sample: usize) -> Vec<f64> {
    let mut all = match rung {
        Rung::Linear => {
            let speed = run.frequency * run.swing();
            vec![speed, speed * speed]
        }
        Rung::Pressure => {
            let bar = |p: &f64| p * 1e-5;
            run.pressure[sample].iter().map(bar).flat_map(|p| [p, p * p]).collect()
        }
        Rung::Fir => fir(run, sample),
        Rung::Theory => theory::columns(&run.terms[sample]),
        _ => Vec::new(),
    };
    all.push(1.0);
    all
}

/// Every component of the last mark and of the first, place and velocity, at the taps.
fn fir(run: &Run, sample: usize) -> Vec<f64> {
    let last = run.len() - 1;
    let at = |lag: &f64| (sample as f64 - lag * run.rate).round().clamp(0.0, last as f64) as usize;
    let read = |i: usize| {
        let ends = |of: &[[f64; 2]]| [of[0], of[of.len() - 1]].concat();
        [ends(&run.moved[i]), ends(&run.speed[i])].concat()
    };
    TAPS.iter().flat_map(|lag| read(at(lag))).collect()
}
