//! Scores: error of a prediction over time, of its mean and of its phase, with bootstrap intervals.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use super::Run;

/// Errors of one model over some runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Root of the mean squared error over the standard deviation of the measured force; no unit.
    pub nrmse: f64,
    /// Its interval of 95 % by bootstrap over cycles.
    pub nrmse_interval: [f64; 2],
    /// 1 − squared error / variance; no unit.
    pub r2: f64,
    /// Mean over runs of |mean predicted − mean measured|, over the mean of |mean measured|, %.
    pub mean_error_percent: f64,
    /// Its interval of 95 %.
    pub mean_interval_percent: [f64; 2],
    /// Mean phase lead of the prediction at twice the flapping frequency, weighted by its size, degrees.
    pub phase_deg: f64,
}

/// Resamplings of the bootstrap.
const DRAWS: usize = 400;
/// Seed of the bootstrap; another changes the intervals by about a hundredth.
const SEED: u64 = 20_211_122;

/// One cycle of one run: number of samples; sums of squared error, force, squared force and prediction.
#[derive(Debug, Clone, Copy, Default)]
struct Cycle {
    run: usize,
    count: f64,
    error: f64,
    force: f64,
    square: f64,
    predicted: f64,
}

/// The score of `predicted` (runs × samples) over `runs`.
pub fn score(runs: &[&Run], predicted: &[Vec<f64>]) -> Score {
    let cycles = cycle_sums(runs, predicted);
    let (nrmse, mean) = score_errors(&cycles, runs.len());
    let mut draw = ChaCha8Rng::seed_from_u64(SEED);
    let mut resampled_errors: Vec<(f64, f64)> = Vec::with_capacity(DRAWS);
    for _ in 0..DRAWS {
        let resample: Vec<Cycle> =
            (0..cycles.len()).map(|_| cycles[(draw.next_u64() % cycles.len() as u64) as usize]).collect();
        resampled_errors.push(score_errors(&resample, runs.len()));
    }
    let interval = |component: fn(&(f64, f64)) -> f64| {
        let mut sorted: Vec<f64> = resampled_errors.iter().map(component).collect();
        sorted.sort_by(f64::total_cmp);
        [sorted[DRAWS / 40], sorted[DRAWS - 1 - DRAWS / 40]]
    };
    Score {
        nrmse,
        nrmse_interval: interval(|t| t.0),
        r2: 1.0 - nrmse * nrmse,
        mean_error_percent: mean,
        mean_interval_percent: interval(|t| t.1),
        phase_deg: phase_lead(runs, predicted),
    }
}

fn cycle_sums(runs: &[&Run], predicted: &[Vec<f64>]) -> Vec<Cycle> {
    let mut sums = Vec::new();
    for (index, (run, predicted)) in runs.iter().zip(predicted).enumerate() {
        for (force, predicted) in
            run.force.chunks(run.samples_per_cycle()).zip(predicted.chunks(run.samples_per_cycle()))
        {
            let mut cycle = Cycle { run: index, ..Cycle::default() };
            for (f, t) in force.iter().zip(predicted) {
                cycle.count += 1.0;
                cycle.error += (f - t).powi(2);
                cycle.force += f;
                cycle.square += f * f;
                cycle.predicted += t;
            }
            sums.push(cycle);
        }
    }
    sums
}

/// NRMSE, and the error of the mean in per cent.
fn score_errors(cycles: &[Cycle], runs: usize) -> (f64, f64) {
    let sum = |term: fn(&Cycle) -> f64| cycles.iter().map(term).sum::<f64>();
    let count = sum(|b| b.count).max(1.0);
    let mean = sum(|b| b.force) / count;
    let variance = sum(|b| b.square) / count - mean * mean;
    let mut by_run = vec![[0.0; 3]; runs];
    for cycle in cycles {
        let run_sums = &mut by_run[cycle.run];
        *run_sums = [run_sums[0] + cycle.count, run_sums[1] + cycle.force, run_sums[2] + cycle.predicted];
    }
    let means: Vec<[f64; 2]> = by_run.iter().filter(|r| r[0] > 0.0).map(|r| [r[1] / r[0], r[2] / r[0]]).collect();
    let mean_deviation: f64 = means.iter().map(|[f, t]| (t - f).abs()).sum();
    let mean_magnitude: f64 = means.iter().map(|[f, _]| f.abs()).sum();
    ((sum(|b| b.error) / count / variance.max(1e-30)).sqrt(), 100.0 * mean_deviation / mean_magnitude.max(1e-30))
}

/// Lead at twice the flapping frequency: the angle of Σ predicted · measured* over runs.
fn phase_lead(runs: &[&Run], predicted: &[Vec<f64>]) -> f64 {
    let fourier_component = |run: &Run, values: &[f64]| {
        values.iter().enumerate().fold([0.0; 2], |[re, im], (i, v)| {
            let angle = TAU * 2.0 * run.frequency * i as f64 / run.rate;
            [re + v * angle.cos(), im - v * angle.sin()]
        })
    };
    let cross_spectrum = runs.iter().zip(predicted).fold([0.0; 2], |cross_spectrum, (run, predicted)| {
        let ([a, b], [c, d]) = (fourier_component(run, predicted), fourier_component(run, &run.force));
        [cross_spectrum[0] + a * c + b * d, cross_spectrum[1] + b * c - a * d]
    });
    cross_spectrum[1].atan2(cross_spectrum[0]).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::testing::run;

    #[test]
    fn the_truth_has_no_error_and_the_mean_has_one_of_one() {
        let run = run(2.0, 2e4, 1);
        let mean = run.force.iter().sum::<f64>() / run.len() as f64;
        let right = score(&[&run], std::slice::from_ref(&run.force));
        assert!(right.nrmse < 1e-12 && right.mean_error_percent < 1e-9 && right.phase_deg.abs() < 1e-9);
        let flat = score(&[&run], &[vec![mean; run.len()]]);
        assert!((flat.nrmse - 1.0).abs() < 1e-9 && flat.r2.abs() < 1e-9);
        let half = score(&[&run], &[run.force.iter().map(|f| 0.5 * (f + mean)).collect()]);
        assert!((half.nrmse - 0.5).abs() < 1e-9 && (half.r2 - 0.75).abs() < 1e-9);
    }

    #[test]
    fn a_force_predicted_too_early_leads_by_its_angle() {
        let run = run(2.0, 2e4, 1);
        let shift = 2; // samples of 1/80 s at twice 2 Hz: 36 degrees
        let early = (0..run.len()).map(|i| run.force[(i + shift) % run.len()]).collect();
        let found = score(&[&run], &[early]).phase_deg;
        assert!((found - 36.0).abs() < 2.0, "{found}");
    }

    #[test]
    fn the_interval_contains_the_error_and_shrinks_with_more_cycles() {
        let run = run(2.0, 2e4, 1);
        let off: Vec<f64> = run.force.iter().enumerate().map(|(i, f)| f + 0.01 * (i as f64 * 0.917).sin()).collect();
        let width = |s: Score| s.nrmse_interval[1] - s.nrmse_interval[0];
        let one = score(&[&run], std::slice::from_ref(&off));
        assert!(one.nrmse_interval[0] <= one.nrmse && one.nrmse <= one.nrmse_interval[1]);
        let many = score(&[&run; 9], &vec![off; 9]);
        assert!(width(many) < width(one));
    }
}
