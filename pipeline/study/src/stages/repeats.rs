//! Repeats: several films of one experiment, aligned at their first command.

use si::{Metre, Point2, Second};
use signal::resample::Samples;

use super::simulation;
use diagnostics::{Diagnostic, Result};
use records::Motion;
use sysid::actuated::resample_path;

/// Mean and deviation of the repeats of one experiment.
pub struct AlignedRepeats {
    /// Times of the first film's frames that all films cover, s on its clock.
    pub time: Vec<Second>,
    /// Mean displacement of the observed marker, m.
    pub mean: Vec<Point2>,
    /// Standard deviation over the repeats, m; nothing where there is one.
    pub deviation: Vec<Point2>,
    /// Time of the first command, s.
    pub moves: Second,
    /// Mean measured pressure of each chamber, Pa, on the first film's clock.
    pub gauges: Vec<Samples>,
}

/// Aligns films; `marker` is observed.
///
/// # Errors
/// A [`Diagnostic`] when there is no film, or one commands nothing.
pub(crate) fn align_repeats(films: &[Motion], marker: usize) -> Result<AlignedRepeats> {
    let begins: Vec<Second> = films.iter().map(first_command).collect::<Result<_>>()?;
    let Some((first, begin)) = films.first().zip(begins.first()) else {
        return Err(Diagnostic::new("there is no film to compare with", "the trial has no repeats", "record one"));
    };
    let late: Vec<Second> = begins.iter().map(|b| b - begin).collect();
    let covered =
        |t: &&Second| films.iter().zip(&late).all(|(f, l)| f.time[0] <= **t + l && **t + l <= f.time[f.time.len() - 1]);
    let time: Vec<Second> = first.time.iter().filter(covered).copied().collect();
    let mut paths = Vec::new();
    for (film, late) in films.iter().zip(&late) {
        let frame_times: Vec<Second> = time.iter().map(|t| t + late).collect();
        let axis = |k: usize| {
            let coordinate = film.markers[marker].at.iter().map(|p| p[k]).collect();
            Samples::new(film.time.clone(), coordinate).map_err(Diagnostic::from)
        };
        paths.push(resample_path(&[axis(0)?, axis(1)?], &frame_times));
    }
    let (mean, deviation) = (0..time.len()).map(|i| mean_and_deviation(&paths, i)).unzip();
    Ok(AlignedRepeats { gauges: mean_gauges(films, &late)?, moves: *begin, time, mean, deviation })
}

/// Time of the first command above zero, s.
fn first_command(film: &Motion) -> Result<Second> {
    let asked = |i: &usize| film.gauges.iter().any(|g| g.command[*i] > 0.0);
    (0..film.log_time.len()).find(asked).map(|i| film.log_time[i]).ok_or_else(|| {
        Diagnostic::new("a film to be compared commands nothing", "its log holds no command above 0", "check its log")
    })
}

/// Mean and standard deviation over the repeats at one frame.
fn mean_and_deviation(paths: &[Vec<Point2>], frame: usize) -> (Point2, Point2) {
    let count = paths.len() as f64;
    let mean = [0, 1].map(|k| paths.iter().map(|p| p[frame][k]).sum::<f64>() / count);
    let square = |k: usize| paths.iter().map(|p| (p[frame][k] - mean[k]).powi(2)).sum::<f64>();
    let deviation = [0, 1].map(|k| (square(k) / (count - 1.0).max(1.0)).sqrt());
    (mean, deviation)
}

fn mean_gauges(films: &[Motion], late: &[Second]) -> Result<Vec<Samples>> {
    let gauges_of_films: Vec<Vec<Samples>> = films.iter().map(simulation::gauge_samples).collect::<Result<_>>()?;
    let (times, count) = (&films[0].log_time, films.len() as f64);
    let mean = |chamber: usize| {
        let mean_pressure =
            |t: Second| gauges_of_films.iter().zip(late).map(|(g, l)| g[chamber].at(t + l)).sum::<f64>() / count;
        Samples::new(times.clone(), times.iter().map(|&t| mean_pressure(t)).collect()).map_err(Diagnostic::from)
    };
    (0..films[0].gauges.len()).map(mean).collect()
}

/// Root of the mean squared distance of two paths, m.
pub fn rms(a: &[Point2], b: &[Point2]) -> Metre {
    let squares: f64 = a.iter().zip(b).map(|(p, q)| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)).sum();
    (squares / a.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A marker that follows a command `late` s after 1 s, scaled by `by`.
    fn film(late: f64, by: f64) -> Motion {
        let time: Vec<f64> = (0..300).map(|i| 0.01 * f64::from(i)).collect();
        let command: Vec<f64> = time.iter().map(|t| f64::from(u8::from(*t >= 1.0 + late - 1e-9))).collect();
        let at = time.iter().map(|t| [0.0, by * (t - 1.0 - late).max(0.0)]).collect();
        Motion::of_one_marker(time, command, at)
    }

    #[test]
    fn repeats_that_begin_at_other_times_are_aligned() {
        let seen = align_repeats(&[film(0.0, 1.0), film(0.2, 1.2)], 0).unwrap();
        let last = seen.time.len() - 1;
        let after = seen.time[last] - 1.0;
        assert!((seen.mean[last][1] - 1.1 * after).abs() < 1e-9, "{:?}", seen.mean[last]);
        // two values apart by d have the deviation d/√2
        assert!((seen.deviation[last][1] - 0.2 * after / 2f64.sqrt()).abs() < 1e-9);
        assert!((seen.gauges[0].at(1.5) - 1.0).abs() < 1e-12);
    }
}
