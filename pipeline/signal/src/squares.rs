//! Least squares inside this crate: linear, non-negative, and nonlinear with a covariance.
//!
//! Columns are functions of time that are added with unknown weights; a nonlinear problem gives its residuals, and its
//! Jacobian is taken by central differences.
//!
//! Stands on: nalgebra. Never knows: what the columns mean.

use nalgebra::{DMatrix, DVector};

/// Why nothing could be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{what} cannot be fitted\n  why: {why}\n  do:  {remedy}")]
pub struct FitFailed {
    /// What was to be fitted.
    pub what: &'static str,
    /// Why not.
    pub why: String,
    /// The next move.
    pub remedy: &'static str,
}

/// Weights that add columns (each as long as `target`) to the target with the least squared difference; a ridge of 1e-12
/// of each column's own square keeps columns that say the same from tearing apart.
pub(crate) fn linear(columns: &[Vec<f64>], target: &[f64]) -> Option<Vec<f64>> {
    let (gram, right) = normal(columns, target);
    Some(gram.cholesky()?.solve(&right).as_slice().to_vec())
}

/// As [`linear`], but the first weights are drawn towards zero: `stiff[i]` is added to column i's own square.
pub(crate) fn drawn_to_zero(columns: &[Vec<f64>], target: &[f64], stiff: &[f64]) -> Option<Vec<f64>> {
    let (mut gram, right) = normal(columns, target);
    stiff.iter().enumerate().for_each(|(i, s)| gram[(i, i)] += s);
    Some(gram.cholesky()?.solve(&right).as_slice().to_vec())
}

fn normal(columns: &[Vec<f64>], target: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let n = columns.len();
    let mut gram = DMatrix::from_fn(n, n, |i, j| if j <= i { dot(&columns[i], &columns[j]) } else { 0.0 });
    gram.fill_upper_triangle_with_lower_triangle();
    for i in 0..n {
        gram[(i, i)] = gram[(i, i)] * (1.0 + 1e-12) + 1e-300;
    }
    (gram, DVector::from_fn(n, |i, _| dot(&columns[i], target)))
}

/// As [`linear`], but the first `held` weights are at least zero (coordinate descent on the normal equations, to rounding).
pub(crate) fn at_least_zero(columns: &[Vec<f64>], target: &[f64], held: usize) -> Option<Vec<f64>> {
    let (gram, right) = normal(columns, target);
    let mut free = vec![true; columns.len()];
    loop {
        let kept: Vec<usize> = (0..free.len()).filter(|&i| free[i]).collect();
        let part = DMatrix::from_fn(kept.len(), kept.len(), |i, j| gram[(kept[i], kept[j])]);
        let solved = part.cholesky()?.solve(&DVector::from_fn(kept.len(), |i, _| right[kept[i]]));
        let lowest = (0..kept.len()).filter(|&i| kept[i] < held && solved[i] < 0.0);
        match lowest.min_by(|&a, &b| solved[a].total_cmp(&solved[b])) {
            Some(i) => free[kept[i]] = false,
            None => {
                let mut all = vec![0.0; free.len()];
                kept.iter().zip(solved.iter()).for_each(|(&i, &w)| all[i] = w);
                return Some(all);
            }
        }
    }
}

/// Columns that add up with weights.
pub(crate) fn sum(columns: &[Vec<f64>], weights: &[f64]) -> Vec<f64> {
    let mut total = vec![0.0; columns.first().map_or(0, Vec::len)];
    for (column, weight) in columns.iter().zip(weights) {
        total.iter_mut().zip(column).for_each(|(t, c)| *t += weight * c);
    }
    total
}

/// Columns 1, τ, … τ^degree with τ from −1 to 1 over `samples`: how a zero drifts.
pub(crate) fn drift(samples: usize, degree: usize) -> Vec<Vec<f64>> {
    let tau = |i: usize| 2.0 * i as f64 / (samples.max(2) - 1) as f64 - 1.0;
    (0..=degree).map(|d| (0..samples).map(|i| tau(i).powi(d as i32)).collect()).collect()
}

/// A nonlinear fit: parameters and their standard deviations.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fitted {
    pub at: Vec<f64>,
    pub sigma: Vec<f64>,
    /// Standard deviation of the residuals.
    pub noise: f64,
}

/// Rounds of Levenberg and Marquardt; from a peak of a spectrum they need six.
const ROUNDS: usize = 60;

/// Parameters with the least squared residuals, from `start`, by the damped steps of Levenberg and Marquardt.
/// `turns` are the steps of the differences. `others` counts parameters fitted inside of `residuals`.
pub(crate) fn nonlinear(
    start: &[f64],
    turns: &[f64],
    others: usize,
    residuals: &dyn Fn(&[f64]) -> Option<Vec<f64>>,
) -> Option<Fitted> {
    let square = |r: &[f64]| r.iter().map(|v| v * v).sum::<f64>();
    let (mut at, mut damping) = (start.to_vec(), 1e-3);
    let mut now = residuals(&at)?;
    for _ in 0..ROUNDS {
        let slope = jacobian(&at, turns, residuals)?;
        let (gram, pull) = (slope.tr_mul(&slope), slope.tr_mul(&DVector::from_column_slice(&now)));
        let before = square(&now);
        let mut step = None;
        while damping < 1e9 {
            let mut damped = gram.clone();
            (0..at.len()).for_each(|i| damped[(i, i)] *= 1.0 + damping);
            let by = damped.cholesky()?.solve(&pull);
            let next: Vec<f64> = at.iter().zip(by.iter()).map(|(a, b)| a - b).collect();
            match residuals(&next) {
                Some(r) if square(&r) <= before => {
                    step = Some((next, r));
                    damping = (0.1 * damping).max(1e-12);
                    break;
                }
                _ => damping *= 10.0,
            }
        }
        let Some((next, r)) = step else { break };
        (at, now) = (next, r);
        if before - square(&now) <= 1e-13 * before {
            break;
        }
    }
    let slope = jacobian(&at, turns, residuals)?;
    let free = now.len().checked_sub(at.len() + others).filter(|&n| n > 0)?;
    let variance = square(&now) / free as f64;
    let spread = slope.tr_mul(&slope).cholesky()?.inverse() * variance;
    Some(Fitted { sigma: (0..at.len()).map(|i| spread[(i, i)].sqrt()).collect(), at, noise: variance.sqrt() })
}

fn jacobian(at: &[f64], turns: &[f64], residuals: &dyn Fn(&[f64]) -> Option<Vec<f64>>) -> Option<DMatrix<f64>> {
    let mut columns = Vec::new();
    for (i, turn) in turns.iter().enumerate() {
        let moved = |by: f64| {
            let mut other = at.to_vec();
            other[i] += by;
            residuals(&other)
        };
        let (up, down) = (moved(*turn)?, moved(-turn)?);
        columns.push(DVector::from_iterator(up.len(), up.iter().zip(&down).map(|(u, d)| (u - d) / (2.0 * turn))));
    }
    Some(DMatrix::from_columns(&columns))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_columns_come_back() {
        let columns = [drift(50, 2), vec![(0..50).map(|i| (0.4 * f64::from(i)).sin()).collect()]].concat();
        let target = sum(&columns, &[1.0, -2.0, 0.5, 3.0]);
        let found = linear(&columns, &target).unwrap();
        assert!(found.iter().zip([1.0, -2.0, 0.5, 3.0]).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    #[test]
    fn a_weight_that_would_be_negative_is_zero_and_the_others_are_best_without_it() {
        let columns = drift(50, 1);
        let target = sum(&columns, &[-1.0, 2.0]);
        let found = at_least_zero(&columns, &target, 1).unwrap();
        assert_eq!(found[0], 0.0);
        assert!((found[1] - linear(&columns[1..], &target).unwrap()[0]).abs() < 1e-12);
    }

    #[test]
    fn a_decay_is_found_with_the_spread_that_its_noise_gives() {
        // noise of known size with a period that no decay can follow
        let noise = |i: usize| if i.is_multiple_of(2) { 1e-3 } else { -1e-3 };
        let data: Vec<f64> = (0..200).map(|i| 2.0 * (-0.02 * i as f64).exp() + noise(i)).collect();
        let residuals = |p: &[f64]| {
            Some(data.iter().enumerate().map(|(i, d)| p[0] * (-p[1] * i as f64).exp() - d).collect::<Vec<f64>>())
        };
        let fit = nonlinear(&[1.0, 0.05], &[1e-5, 1e-7], 0, &residuals).unwrap();
        assert!((fit.at[0] - 2.0).abs() < 4.0 * fit.sigma[0] && (fit.at[1] - 0.02).abs() < 4.0 * fit.sigma[1]);
        assert!((fit.noise - 1e-3).abs() < 1e-4);
    }
}
