//! Plateaus: intervals of constant pressure in a quasi-static trial, and the mean shape in each.
//!
//! A tail that was filled fast still vibrates about that shape. Means are weighted by Hann's window, which suppresses vibrations
//! of two and more periods.

use std::f64::consts::PI;
use std::ops::Range;

use si::{Pascal, Point2, Second};

use diagnostics::{Diagnostic, Result};
use records::{Covariance2, CovarianceParts, Markers, Motion, Path};
use sysid::PressureLevel;

/// The shape at each held pressure: weighted means over the last `settled` (0 … 1) of each hold that lasts at least `shortest` (s).
///
/// # Errors
/// A [`Diagnostic`] when the log holds no pressure or the film ends before the first hold.
pub(crate) fn pressure_levels(
    motion: &Motion,
    markers: &Markers,
    settled: f64,
    shortest: Second,
) -> Result<Vec<PressureLevel>> {
    let levels: Vec<PressureLevel> =
        long_holds(motion, shortest).filter_map(|hold| level_of_hold(motion, markers, hold, settled)).collect();
    if levels.is_empty() {
        return Err(Diagnostic::new(
            "the trial holds no pressure that was filmed",
            format!("a hold lasts at least {shortest} s at one command (study.toml, [identify] shortest_hold)"),
            "identify from a staircase, or correct the role of the trial on the card",
        ));
    }
    Ok(levels)
}

/// Time from the change of the command to the middle of what counts as settled, of each hold, s.
pub(super) fn held_times(motion: &Motion, settled: f64, shortest: Second) -> Vec<Second> {
    let length = |hold: Range<usize>| motion.log_time[hold.end - 1] - motion.log_time[hold.start];
    long_holds(motion, shortest).map(|hold| (1.0 - 0.5 * settled) * length(hold)).collect()
}

/// The holds that last at least `shortest` (s).
fn long_holds(motion: &Motion, shortest: Second) -> impl Iterator<Item = Range<usize>> {
    let length = |hold: &Range<usize>| motion.log_time[hold.end - 1] - motion.log_time[hold.start];
    command_holds(motion).into_iter().filter(move |hold| length(hold) >= shortest)
}

/// Runs of samples with a constant command, at least one chamber's above zero.
pub(super) fn command_holds(motion: &Motion) -> Vec<Range<usize>> {
    let command = |i: usize| -> Vec<Pascal> { motion.gauges.iter().map(|g| g.command[i]).collect() };
    let samples = motion.log_time.len();
    let ends = (1..=samples).filter(|&i| i == samples || command(i) != command(i - 1));
    let mut start = 0;
    let runs = ends.map(|end| std::mem::replace(&mut start, end)..end);
    runs.filter(|run| command(run.start).iter().any(|&p| p > 0.0)).collect()
}

fn level_of_hold(motion: &Motion, markers: &Markers, hold: Range<usize>, settled: f64) -> Option<PressureLevel> {
    let (begin, end) = (motion.log_time[hold.start], motion.log_time[hold.end - 1]);
    let settled_from = end - settled * (end - begin);
    let samples: Vec<usize> = hold.filter(|&i| motion.log_time[i] >= settled_from).collect();
    let frames = motion.time.partition_point(|&t| t < settled_from)..motion.time.partition_point(|&t| t <= end);
    if frames.is_empty() || samples.is_empty() {
        return None;
    }
    let (sample_weights, frame_weights) = (hann_weights(samples.len()), hann_weights(frames.len()));
    let pressure = |measured: &[Pascal]| samples.iter().zip(&sample_weights).map(|(&i, w)| w * measured[i]).sum();
    let mean_position =
        |m: &Path| [0, 1].map(|k| frames.clone().zip(&frame_weights).map(|(i, w)| w * m.at[i][k]).sum());
    let measured: Vec<Point2> = motion.markers.iter().map(mean_position).collect();
    let spreads = markers.parts.iter().map(|parts| mean_covariance(parts, frames.start, &frame_weights));
    let (covariance, shared) = spreads.unzip();
    Some(PressureLevel {
        pressures: motion.gauges.iter().map(|g| pressure(&g.measured)).collect(),
        measured,
        covariance,
        shared,
        rest: motion.rest.clone(),
    })
}

/// Hann's window over `count` even samples; they sum to 1.
fn hann_weights(count: usize) -> Vec<f64> {
    let weight = |k: usize| (PI * (k as f64 + 0.5) / count as f64).sin().powi(2);
    let sum: f64 = (0..count).map(weight).sum();
    (0..count).map(|k| weight(k) / sum).collect()
}

/// Covariance of the weighted mean over the frames from `first` on, and its part that a film shares: noise is averaged, that part is not.
fn mean_covariance(parts: &CovarianceParts, first: usize, weights: &[f64]) -> (Covariance2, Covariance2) {
    let sum = |covariances: &[Covariance2], k: usize, power: i32| {
        covariances[first..].iter().zip(weights).map(|(s, w)| w.powi(power) * s[k]).sum::<f64>()
    };
    let shared = [0, 1, 2].map(|k| sum(&parts.shared, k, 1));
    ([0, 1, 2].map(|k| sum(&parts.noise, k, 2) + shared[k]), shared)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One chamber: off for 1 s, held at 100 Pa for 1 s, off, held at 200 Pa for 1 s; the marker follows at 1e-5 m/Pa.
    fn motion() -> Motion {
        let time: Vec<f64> = (0..400).map(|i| 0.01 * f64::from(i)).collect();
        let command: Vec<f64> = time.iter().map(|&t| [0.0, 100.0, 0.0, 200.0][(t + 1e-9) as usize]).collect();
        let at = command.iter().map(|p| [0.0, 1e-5 * p]).collect();
        Motion::of_one_marker(time, command, at)
    }

    /// Noise of 1e-10 m² a frame and a shared error of 1e-12 m².
    fn markers() -> Markers {
        let parts = vec![CovarianceParts { noise: vec![[1e-10; 3]; 400], shared: vec![[1e-12; 3]; 400] }];
        Markers { time: Vec::new(), markers: Vec::new(), parts, left_out: Vec::new(), stand: None }
    }

    #[test]
    fn each_held_pressure_becomes_one_level() {
        let levels = pressure_levels(&motion(), &markers(), 0.4, 0.5).unwrap();
        assert_eq!(levels.len(), 2);
        assert!((levels[1].pressures[0] - 200.0).abs() < 1e-9);
        assert!((levels[1].measured[0][1] - 2e-3).abs() < 1e-12);
        // some forty of a hundred frames; Hann's window has the effective number of two thirds of them
        assert!(
            (levels[1].covariance[0][0] - (1e-12 + 1.5 * 1e-10 / 40.0)).abs() < 3e-13,
            "{:?}",
            levels[1].covariance
        );
    }

    #[test]
    fn a_vibration_about_the_held_shape_does_not_change_its_mean() {
        let mut vibrating = motion();
        let vibration = |t: f64| 1e-3 * (-2.5 * (t - 1.0)).exp() * (50.0 * t).sin();
        let times = vibrating.time.clone();
        vibrating.markers[0]
            .at
            .iter_mut()
            .zip(times)
            .filter(|(_, t)| *t >= 1.0)
            .for_each(|(at, t)| at[1] += vibration(t));
        let (held, still) =
            (pressure_levels(&vibrating, &markers(), 0.5, 0.5).unwrap(), vibration(1.5 + 0.03).abs().max(2e-4));
        assert!((held[0].measured[0][1] - 1e-3).abs() < 0.02 * still, "{:?}", held[0].measured);
    }

    #[test]
    fn a_trial_without_a_long_hold_is_refused() {
        assert!(pressure_levels(&motion(), &markers(), 0.4, 5.0).unwrap_err().what.contains("holds no pressure"));
    }
}
