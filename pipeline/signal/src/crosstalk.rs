//! Static cross-talk of pressure into force: a monotone curve and a delay.
//!
//! Force = Σ over chambers of C(p(t − τ)) + drift. C rises from (0, 0) and is linear between knots; its increments are estimated by
//! non-negative least squares for each τ of a list, and the τ with the least residual is kept. Paper, section IV, spurious forces.

use nalgebra::{DMatrix, DVector};
use si::{Newton, Pascal, Second, Series};

use crate::polynomial::{self, EstimationError};
use crate::resample::Samples;
use optimize::linear;

/// Degree of the drift of the zero in one recording.
const DRIFT: usize = 3;

/// Force as a function of pressure without motion.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossTalk {
    /// Pressures of the knots, rising, the first is 0, Pa.
    pub pressures: Vec<Pascal>,
    /// Force at each knot, N; the first is 0 and none is lower than the one before.
    pub forces: Vec<Newton>,
    /// Delay of the force behind the pressure, s.
    pub lag: Second,
    /// Its 95 % interval, s: within the delays that were tried.
    pub lag_interval: [Second; 2],
    /// Standard deviation of the residuals, N.
    pub residual: Newton,
    /// Standard deviation of the force at the last knot, by the noise, N.
    pub sigma: Newton,
}

/// One quasi-static recording: force and pressures on one clock.
#[derive(Debug, Clone)]
pub struct Staircase {
    /// N.
    pub force: Series,
    /// One a chamber, Pa.
    pub pressures: Vec<Samples>,
}

impl CrossTalk {
    /// No cross-talk.
    pub fn none() -> Self {
        Self { pressures: vec![0.0], forces: vec![0.0], lag: 0.0, lag_interval: [0.0; 2], residual: 0.0, sigma: 0.0 }
    }

    /// C(p), N; held beyond the last knot, zero below the first.
    pub fn at(&self, pressure: Pascal) -> Newton {
        let rises = self.forces.windows(2).map(|f| f[1] - f[0]);
        self.pressures.windows(2).zip(rises).map(|(knots, rise)| rise * step_fraction(pressure, knots)).sum()
    }

    /// The force (N) at time `t` (s) of chambers with these pressures (Pa).
    pub fn of(&self, pressures: &[Samples], t: Second) -> Newton {
        pressures.iter().map(|p| self.at(p.at(t - self.lag))).sum()
    }
}

/// Position of a pressure between two knots, 0 to 1.
fn step_fraction(pressure: Pascal, knots: &[Pascal]) -> f64 {
    ((pressure - knots[0]) / (knots[1] - knots[0])).clamp(0.0, 1.0)
}

/// The cross-talk of quasi-static recordings, with `knots` (Pa, rising, beginning at 0) and the best of `lags` (s).
///
/// # Errors
/// [`EstimationError`] when there is no recording, knots do not rise from 0, or no lag was given.
pub fn fit(runs: &[Staircase], knots: &[Pascal], lags: &[Second]) -> Result<CrossTalk, EstimationError> {
    let is_rising = knots.first() == Some(&0.0) && knots.windows(2).all(|w| w[1] > w[0]);
    if runs.is_empty() || !is_rising || knots.len() < 2 {
        return Err(estimation_error(format!("there are {} recordings and the knots are {knots:?} Pa", runs.len())));
    }
    let candidates: Vec<(CrossTalk, f64)> = lags.iter().filter_map(|&lag| fit_with_lag(runs, knots, lag)).collect();
    let best = candidates.iter().min_by(|a, b| a.0.residual.total_cmp(&b.0.residual));
    let (best, independent) = best.ok_or_else(|| estimation_error("no lag gives a solution".into()))?;
    Ok(CrossTalk { lag_interval: lag_interval(&candidates, best, *independent), ..best.clone() })
}

/// The 0.95 quantile of χ² with one degree of freedom.
const CHI_SQUARE: f64 = 3.841;

/// The delays whose likelihood ratio to the best is not significant: n ln(r²/r²_min) ≤ χ², n the number of independent residuals. Between
/// two delays that were tried the ratio is taken as linear.
fn lag_interval(candidates: &[(CrossTalk, f64)], best: &CrossTalk, independent: f64) -> [Second; 2] {
    let excess = |talk: &CrossTalk| {
        let ratio = talk.residual / best.residual.max(f64::MIN_POSITIVE);
        2.0 * independent * ratio.ln() - CHI_SQUARE
    };
    let mut curve: Vec<[f64; 2]> = candidates.iter().map(|(talk, _)| [talk.lag, excess(talk)]).collect();
    curve.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let crossing =
        |below: [f64; 2], above: [f64; 2]| below[0] + (above[0] - below[0]) * -below[1] / (above[1] - below[1]);
    let best_index = curve.iter().position(|point| point[0] == best.lag).unwrap_or(0);
    let limit_crossing = |path: &mut dyn Iterator<Item = &[f64; 2]>| {
        let mut below = curve[best_index];
        for point in path {
            if point[1] > 0.0 {
                return crossing(below, *point);
            }
            below = *point;
        }
        below[0]
    };
    [limit_crossing(&mut curve[..best_index].iter().rev()), limit_crossing(&mut curve[best_index + 1..].iter())]
}

/// Number of independent values among residuals that are correlated from one to the next.
fn independent_samples(residuals: &[f64]) -> f64 {
    let variance_sum: f64 = residuals.iter().map(|r| r * r).sum();
    let lagged_sum: f64 = residuals.windows(2).map(|r| r[0] * r[1]).sum();
    // A first-order autoregressive process has n (1 − ρ)/(1 + ρ) independent values. Below 0 there would be more than
    // were measured, and at 1 none.
    let correlation = (lagged_sum / variance_sum.max(f64::MIN_POSITIVE)).clamp(0.0, 0.99);
    residuals.len() as f64 * (1.0 - correlation) / (1.0 + correlation)
}

fn estimation_error(why: String) -> EstimationError {
    EstimationError {
        what: "the cross-talk of pressure into force",
        why,
        action: "record staircases of pressure with a force log",
    }
}

fn fit_with_lag(runs: &[Staircase], knots: &[Pascal], lag: Second) -> Option<(CrossTalk, f64)> {
    let (rise_count, total) = (knots.len() - 1, runs.iter().map(|r| r.force.values().len()).sum::<usize>());
    let mut columns = vec![Vec::with_capacity(total); rise_count];
    let mut target = Vec::with_capacity(total);
    let mut first_sample = 0;
    let mut drifts = Vec::new();
    for run in runs {
        let run_samples = run.force.values().len();
        for i in 0..run_samples {
            let t = run.force.time(i) - lag;
            let gauges: Vec<Pascal> = run.pressures.iter().map(|p| p.at(t)).collect();
            for (column, pair) in columns.iter_mut().zip(knots.windows(2)) {
                column.push(gauges.iter().map(|&p| step_fraction(p, pair)).sum());
            }
        }
        target.extend(run.force.values());
        for column in polynomial::basis_columns(run_samples, DRIFT) {
            let mut column_over_all = vec![0.0; total];
            column_over_all[first_sample..first_sample + run_samples].copy_from_slice(&column);
            drifts.push(column_over_all);
        }
        first_sample += run_samples;
    }
    // Non-negative increments make C monotone, as an inflated volume is: free increments could fall between knots through noise and drift.
    columns.extend(drifts);
    let weights = linear::nnls(&columns, &target, rise_count)?;
    let sum = linear::weighted_sum(&columns, &weights);
    let residuals: Vec<f64> = sum.iter().zip(&target).map(|(s, t)| s - t).collect();
    let residual = (residuals.iter().map(|r| r * r).sum::<f64>() / total as f64).sqrt();
    let mut forces = vec![0.0];
    weights[..rise_count].iter().for_each(|rise| forces.push(forces[forces.len() - 1] + rise));
    let sample_count = independent_samples(&residuals);
    // (AᵀA)⁻¹ alone counts each sample as independent, and would be too small by √(n/n_independent) where the log
    // drifts or lags.
    let sigma = residual * (total as f64 / sample_count).sqrt() * sigma_of_sum(&columns, rise_count)?;
    let talk = CrossTalk { pressures: knots.to_vec(), forces, lag, lag_interval: [lag; 2], residual, sigma };
    Some((talk, sample_count))
}

/// Standard deviation of the sum of the first so many weights for noise of 1: √(eᵀ (AᵀA)⁻¹ e), e one for each of them.
fn sigma_of_sum(columns: &[Vec<f64>], summed_count: usize) -> Option<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let gram = DMatrix::from_fn(columns.len(), columns.len(), |i, j| dot(&columns[i], &columns[j]));
    let ones = DVector::from_fn(columns.len(), |i, _| if i < summed_count { 1.0 } else { 0.0 });
    Some(ones.dot(&gram.cholesky()?.solve(&ones)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Noise;

    fn steps(t: f64) -> f64 {
        // 50, 100 … 250 mbar, 5 s each with 3 s between
        let (n, within) = ((t / 8.0).floor(), t % 8.0);
        if within < 5.0 && n < 5.0 { 5000.0 * (n + 1.0) } else { 0.0 }
    }

    fn curve(p: f64) -> f64 {
        0.056 * (p / 2e4).powi(2)
    }

    fn recorded(seed: u64) -> Staircase {
        let mut noise = Noise::new(seed);
        let times: Vec<f64> = (0..8200).map(|i| f64::from(i) / 200.0 - 0.5).collect();
        let values = times.iter().map(|&t| if t < 0.0 { 0.0 } else { steps(t) }).collect();
        let force = (0..3200).map(|i| f64::from(i) / 80.0);
        let force = force.map(|t| {
            let p = if t < 0.28 { 0.0 } else { steps(t - 0.28) };
            curve(p) + 2e-3 * noise.normal() + 0.02 - 0.02 * (t / 40.0).powi(2)
        });
        let force = Series::new(0.0, 80.0, force.collect()).unwrap();
        Staircase { force, pressures: vec![Samples::new(times, values).unwrap()] }
    }

    #[test]
    fn curve_and_lag_are_recovered_from_noise_and_drift() {
        let knots: Vec<f64> = (0..=5).map(|i| 5000.0 * f64::from(i)).collect();
        let lags: Vec<f64> = (0..=30).map(|i| 0.02 * f64::from(i)).collect();
        let found = fit(&[recorded(1), recorded(2)], &knots, &lags).unwrap();
        assert!((found.lag - 0.28).abs() < 0.011, "{}", found.lag);
        let [low, high] = found.lag_interval;
        assert!(low < 0.28 && 0.28 < high && high - low < 0.04, "{low} {high}");
        for p in &knots {
            // 400 samples of 2 mN a level; the drift takes a part
            assert!((found.at(*p) - curve(*p)).abs() < 1e-3, "{p} Pa: {}", found.at(*p));
        }
        assert!(found.forces.windows(2).all(|f| f[1] >= f[0]));
        // of some 800 samples of 2 mN at the last level
        assert!((5e-5..1e-3).contains(&found.sigma), "{}", found.sigma);
        assert!((found.at(2.5e4) - curve(2.5e4)).abs() < 4.0 * found.sigma);
    }

    #[test]
    fn knots_that_do_not_begin_at_zero_are_refused() {
        assert!(fit(&[recorded(1)], &[1.0, 2.0], &[0.0]).is_err());
    }
}
