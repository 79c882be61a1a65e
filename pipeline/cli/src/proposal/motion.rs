//! The lag of a log by the motion in a film without a lamp: where the pressures change, the picture does.
//!
//! The rate of change of the pressures is correlated with that of the picture at every lag; a periodic experiment has several that are nearly as
//! good. The body follows its pressure by some hundredths of a second, which the lag contains.

use super::columns::Role;
use super::guess::{Confidence, Guess};
use super::lag::Lag;
use super::lamp::Blocks;
use super::logs::Log;

/// A lag by motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MotionLag {
    pub(super) lag: Lag,
    /// Correlation at it, and the largest at another lag.
    pub(super) correlation: f64,
    pub(super) second: f64,
}

/// Steps of a log's time in which its changes are collected, at most: longer logs have longer steps.
const MOST_STEPS: usize = 20_000;
/// Part of the film that the log covers, at least.
const LEAST_OVERLAP: f64 = 0.8;
/// Lags within so many steps of the best are the same.
const SAME: usize = 8;
/// Least correlation that is a guess, and that of a likely one.
const LEAST: f64 = 0.4;
const LIKELY: f64 = 0.6;
/// A likely lag is better than every other by this factor.
const BETTER: f64 = 1.15;
/// By how much a body may follow its pressure, s.
const DELAY: f64 = 0.1;

/// The lag of a log against a film by the motion in it; none where they do not overlap or nothing moves.
pub(super) fn lag_by_motion(film: &Blocks, log: &Log) -> Option<MotionLag> {
    let stamps = log.stamps();
    let (first, last) = (*stamps.first()?, *stamps.last()?);
    let step = film.step()?.max((last - first) / MOST_STEPS as f64);
    let motion = binned(&film.times, &picture_changes(film), step);
    let pressure = binned(&stamps, &pressure_changes(log), step);
    let least = (LEAST_OVERLAP * motion.len() as f64).ceil() as usize;
    // shift: steps by which the film's first lies after the log's first
    let shifts = least as i64 - motion.len() as i64..=pressure.len() as i64 - least as i64;
    let correlations: Vec<(i64, f64)> = shifts.map(|shift| (shift, correlation(&motion, &pressure, shift))).collect();
    let best = correlations.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    let others = correlations.iter().filter(|(shift, _)| shift.abs_diff(best.0) as usize > SAME);
    let second = others.map(|(_, correlation)| *correlation).fold(0.0, f64::max);
    let seconds = first - film.times[0] + best.0 as f64 * step;
    Some(MotionLag { lag: Lag { seconds, bound: step + DELAY }, correlation: best.1, second })
}

/// Mean absolute change of the blocks from the frame before.
fn picture_changes(film: &Blocks) -> Vec<f64> {
    let change = |pair: &[Vec<u8>]| {
        // length: the frames of a film have as many blocks
        let sum: u32 = pair[0].iter().zip(&pair[1]).map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        f64::from(sum) / pair[0].len().max(1) as f64
    };
    std::iter::once(0.0).chain(film.frames.windows(2).map(change)).collect()
}

/// Sum of the absolute changes of the measured pressures, or of the commands where none is measured.
fn pressure_changes(log: &Log) -> Vec<f64> {
    let role = if log.of_role(Role::Pressure).next().is_some() { Role::Pressure } else { Role::Command };
    let mut changes = vec![0.0; log.stamps().len()];
    for column in log.of_role(role) {
        for (k, pair) in column.values.windows(2).enumerate() {
            let change = (pair[1] - pair[0]).abs();
            changes[k + 1] += if change.is_finite() { change } else { 0.0 };
        }
    }
    changes
}

/// Sums of `values` over even steps from the first time on.
fn binned(times: &[f64], values: &[f64], step: f64) -> Vec<f64> {
    let mut sums = vec![0.0; ((times[times.len() - 1] - times[0]) / step) as usize + 1];
    // length: a time for each value
    for (time, value) in times.iter().zip(values) {
        let last = sums.len() - 1;
        sums[(((time - times[0]) / step) as usize).min(last)] += value;
    }
    sums
}

/// Pearson's correlation of `motion` with the part of `pressure` that begins at `shift`, over their overlap.
fn correlation(motion: &[f64], pressure: &[f64], shift: i64) -> f64 {
    let (skipped, begin) = (usize::try_from(-shift).unwrap_or(0), usize::try_from(shift).unwrap_or(0));
    let (motion, pressure) = (&motion[skipped.min(motion.len())..], &pressure[begin.min(pressure.len())..]);
    let count = motion.len().min(pressure.len());
    let (motion, pressure) = (&motion[..count], &pressure[..count]);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count.max(1) as f64;
    let (mean_motion, mean_pressure) = (mean(motion), mean(pressure));
    let (mut both, mut squares) = (0.0, [0.0; 2]);
    for (m, p) in motion.iter().zip(pressure) {
        let (m, p) = (m - mean_motion, p - mean_pressure);
        both += m * p;
        squares = [squares[0] + m * m, squares[1] + p * p];
    }
    let scale = (squares[0] * squares[1]).sqrt();
    if scale > 0.0 { both / scale } else { 0.0 }
}

impl MotionLag {
    /// Whether it is a guess at all.
    pub(super) fn is_guess(&self) -> bool {
        self.correlation >= LEAST
    }

    /// How sure it is: never certain.
    pub(super) fn confidence(&self) -> Confidence {
        let is_likely = self.correlation >= LIKELY && self.correlation >= BETTER * self.second;
        if is_likely { Confidence::Likely } else { Confidence::Unsure }
    }

    /// The guess about `about`; `pairing` is how sure the log belongs to the film.
    pub(super) fn guess(&self, about: &str, pairing: Confidence) -> Guess {
        let evidence = format!(
            "s, within {:.3}; the log's clock is ahead: no lamp is seen, but picture and pressures change together then, with a correlation of \
             {:.2}, and of {:.2} at the next best; the body's delay is in it",
            self.lag.bound, self.correlation, self.second
        );
        Guess::new(self.confidence().max(pairing), about, format!("{:.3}", self.lag.seconds), evidence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_is_found_where_it_lies_and_a_period_is_seen() {
        let pulse = |k: usize, places: &[usize]| f64::from(u8::from(places.contains(&k)));
        let pressure: Vec<f64> = (0..200).map(|k| pulse(k, &[60, 75, 100, 130])).collect();
        let motion: Vec<f64> = (0..120).map(|k| 3.0 * pulse(k, &[20, 35, 60, 90]) + 1.0).collect();
        assert!((correlation(&motion, &pressure, 40) - 1.0).abs() < 1e-12);
        assert!(correlation(&motion, &pressure, 25) < 0.5);
        assert_eq!(correlation(&[1.0; 20], &pressure, 0), 0.0);
        let sums = binned(&[0.0, 0.004, 0.011, 0.02], &[1.0, 2.0, 4.0, 8.0], 0.01);
        assert_eq!(sums, [3.0, 4.0, 8.0]);
    }
}
