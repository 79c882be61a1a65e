//! Scores: how far what a model says is from what was measured, over time, on the mean, in phase; and how sure that is.
//!
//! Stands on: run. Never knows: which model spoke.

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
    /// Its interval of 95 % by bootstrap over beats.
    pub nrmse_interval: [f64; 2],
    /// 1 − squared error / variance; no unit.
    pub r2: f64,
    /// Mean over runs of |mean told − mean measured|, over the mean of |mean measured|, %.
    pub mean_error_percent: f64,
    /// Its interval of 95 %.
    pub mean_interval_percent: [f64; 2],
    /// Mean lead of what is told at twice the beat, weighted by its size, degrees.
    pub phase_deg: f64,
}

/// Resamplings of the bootstrap.
const DRAWS: usize = 400;
/// Of the bootstrap; another moves the intervals by a hundredth.
const SEED: u64 = 20_211_122;

/// One beat of one run: samples, sums of squared error, of force and of its square, and of what is told.
#[derive(Debug, Clone, Copy, Default)]
struct Beat {
    run: usize,
    count: f64,
    error: f64,
    force: f64,
    square: f64,
    told: f64,
}

/// The score of `told` (runs × samples) over `runs`.
pub fn score(runs: &[&Run], told: &[Vec<f64>]) -> Score {
    let beats = beats(runs, told);
    let (nrmse, mean) = errors(&beats, runs.len());
    let mut draw = ChaCha8Rng::seed_from_u64(SEED);
    let mut tried: Vec<(f64, f64)> = Vec::with_capacity(DRAWS);
    for _ in 0..DRAWS {
        let chosen: Vec<Beat> =
            (0..beats.len()).map(|_| beats[(draw.next_u64() % beats.len() as u64) as usize]).collect();
        tried.push(errors(&chosen, runs.len()));
    }
    let interval = |of: fn(&(f64, f64)) -> f64| {
        let mut all: Vec<f64> = tried.iter().map(of).collect();
        all.sort_by(f64::total_cmp);
        [all[DRAWS / 40], all[DRAWS - 1 - DRAWS / 40]]
    };
    Score {
        nrmse,
        nrmse_interval: interval(|t| t.0),
        r2: 1.0 - nrmse * nrmse,
        mean_error_percent: mean,
        mean_interval_percent: interval(|t| t.1),
        phase_deg: phase(runs, told),
    }
}

fn beats(runs: &[&Run], told: &[Vec<f64>]) -> Vec<Beat> {
    let mut all = Vec::new();
    for (index, (run, told)) in runs.iter().zip(told).enumerate() {
        for (force, told) in run.force.chunks(run.beat()).zip(told.chunks(run.beat())) {
            let mut beat = Beat { run: index, ..Beat::default() };
            for (f, t) in force.iter().zip(told) {
                beat.count += 1.0;
                beat.error += (f - t).powi(2);
                beat.force += f;
                beat.square += f * f;
                beat.told += t;
            }
            all.push(beat);
        }
    }
    all
}

/// NRMSE, and the error of the mean in per cent.
fn errors(beats: &[Beat], runs: usize) -> (f64, f64) {
    let sum = |of: fn(&Beat) -> f64| beats.iter().map(of).sum::<f64>();
    let count = sum(|b| b.count).max(1.0);
    let mean = sum(|b| b.force) / count;
    let variance = sum(|b| b.square) / count - mean * mean;
    let mut by_run = vec![[0.0; 3]; runs];
    for beat in beats {
        let of = &mut by_run[beat.run];
        *of = [of[0] + beat.count, of[1] + beat.force, of[2] + beat.told];
    }
    let means: Vec<[f64; 2]> = by_run.iter().filter(|r| r[0] > 0.0).map(|r| [r[1] / r[0], r[2] / r[0]]).collect();
    let off: f64 = means.iter().map(|[f, t]| (t - f).abs()).sum();
    let size: f64 = means.iter().map(|[f, _]| f.abs()).sum();
    ((sum(|b| b.error) / count / variance.max(1e-30)).sqrt(), 100.0 * off / size.max(1e-30))
}

/// Lead at twice the beat: the angle of Σ told · measured* over runs.
fn phase(runs: &[&Run], told: &[Vec<f64>]) -> f64 {
    let line = |run: &Run, values: &[f64]| {
        values.iter().enumerate().fold([0.0; 2], |[re, im], (i, v)| {
            let angle = TAU * 2.0 * run.frequency * i as f64 / run.rate;
            [re + v * angle.cos(), im - v * angle.sin()]
        })
    };
    let sum = runs.iter().zip(told).fold([0.0; 2], |sum, (run, told)| {
        let ([a, b], [c, d]) = (line(run, told), line(run, &run.force));
        [sum[0] + a * c + b * d, sum[1] + b * c - a * d]
    });
    sum[1].atan2(sum[0]).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thrust::rungs::testing::run;

    #[test]
    fn the_truth_has_no_error_and_the_mean_has_one_of_one() {
        let run = run(2.0, 2e4, 1);
        let mean = run.force.iter().sum::<f64>() / run.len() as f64;
        let right = score(&[&run], std::slice::from_ref(&run.force));
        assert!(right.nrmse < 1e-12 && right.mean_error_percent < 1e-9 && right.phase_deg.abs() < 1e-9);
        let flat = score(&[&run], &[vec![mean; run.len()]]);
        assert!((flat.nrmse - 1.0).abs() < 1e-9 && flat.r2.abs() < 1e-9);
    }

    #[test]
    fn a_force_told_too_early_leads_by_its_angle() {
        let run = run(2.0, 2e4, 1);
        let shift = 2; // samples of 1/80 s at twice 2 Hz: 36 degrees
        let early = (0..run.len()).map(|i| run.force[(i + shift) % run.len()]).collect();
        let found = score(&[&run], &[early]).phase_deg;
        assert!((found - 36.0).abs() < 2.0, "{found}");
    }

    #[test]
    fn the_interval_holds_the_error_and_shrinks_with_more_beats() {
        let run = run(2.0, 2e4, 1);
        let off: Vec<f64> = run.force.iter().enumerate().map(|(i, f)| f + 0.01 * (i as f64 * 0.917).sin()).collect();
        let width = |s: Score| s.nrmse_interval[1] - s.nrmse_interval[0];
        let one = score(&[&run], std::slice::from_ref(&off));
        assert!(one.nrmse_interval[0] <= one.nrmse && one.nrmse <= one.nrmse_interval[1]);
        let many = score(&[&run; 9], &vec![off; 9]);
        assert!(width(many) < width(one));
    }
}
