//! Unevenly sampled signals, and linear interpolation.
//!
//! Interpolation does not attenuate frequencies above half the new rate; [`crate::smooth`] does, before.

use si::{Hertz, Second, Series, SeriesError};

/// Values that each have their own time.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    times: Vec<Second>,
    values: Vec<f64>,
}

/// Why times and values are not a signal.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SampleError {
    /// Not as many times as values, or none.
    #[error(
        "{times} times and {values} values are not a signal\n  why: each value needs its time, and at least one is needed\n  do:  check the columns of the log"
    )]
    Lengths {
        /// Number of times.
        times: usize,
        /// Number of values.
        values: usize,
    },
    /// A time that is not after the one before.
    #[error(
        "time runs backwards at sample {sample}\n  why: it is {at} s, the sample before {before} s\n  do:  check the log there: a clock that was set back, or two logs in one file"
    )]
    Backwards {
        /// Which sample, from 0.
        sample: usize,
        /// Its time, s.
        at: Second,
        /// The time before, s.
        before: Second,
    },
    /// A time or value that is not a number.
    #[error("sample {sample} is ({at} s, {value})\n  why: that is not a number\n  do:  check the log there")]
    NotANumber {
        /// Which sample, from 0.
        sample: usize,
        /// Its time, s.
        at: Second,
        /// Its value.
        value: f64,
    },
}

/// Midpoints of a mean: of a vibration with four periods in the width it is exact to a hundredth.
const MIDPOINTS: usize = 8;

impl Samples {
    /// A signal from `times` (s, each behind the one before) and as many `values`.
    ///
    /// # Errors
    /// [`SampleError`] naming the first sample that is not a number or runs backwards.
    pub fn new(times: Vec<Second>, values: Vec<f64>) -> Result<Self, SampleError> {
        if times.len() != values.len() || times.is_empty() {
            return Err(SampleError::Lengths { times: times.len(), values: values.len() });
        }
        let is_invalid = |i: &usize| !times[*i].is_finite() || !values[*i].is_finite();
        if let Some(sample) = (0..times.len()).find(is_invalid) {
            return Err(SampleError::NotANumber { sample, at: times[sample], value: values[sample] });
        }
        match (1..times.len()).find(|&i| times[i] <= times[i - 1]) {
            Some(sample) => Err(SampleError::Backwards { sample, at: times[sample], before: times[sample - 1] }),
            None => Ok(Self { times, values }),
        }
    }

    /// The times, s.
    pub fn times(&self) -> &[Second] {
        &self.times
    }

    /// The values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The value at time `t` (s), linear between samples, held before the first and after the last.
    pub fn at(&self, t: Second) -> f64 {
        let right = self.times.partition_point(|&s| s <= t);
        if right == 0 {
            return self.values[0];
        }
        let left = right - 1;
        if right == self.times.len() {
            return self.values[left];
        }
        let fraction = (t - self.times[left]) / (self.times[right] - self.times[left]);
        self.values[left] * (1.0 - fraction) + self.values[right] * fraction
    }

    /// The mean over `width` (s) around time `t` (s): what a shutter that is open so long sees.
    pub fn mean_at(&self, t: Second, width: Second) -> f64 {
        let midpoint = |i: usize| t + width * ((i as f64 + 0.5) / MIDPOINTS as f64 - 0.5);
        (0..MIDPOINTS).map(|i| self.at(midpoint(i))).sum::<f64>() / MIDPOINTS as f64
    }

    /// The values at `times` (s).
    pub fn onto(&self, times: &[Second]) -> Vec<f64> {
        times.iter().map(|&t| self.at(t)).collect()
    }

    /// The signal at an even `rate` (Hz) from its first time to its last.
    ///
    /// # Errors
    /// [`SeriesError`] when the rate is not positive.
    pub fn even(&self, rate: Hertz) -> Result<Series, SeriesError> {
        let (start, end) = (self.times[0], self.times[self.times.len() - 1]);
        // half a millionth of a sample counts as whole, because times of a log are rounded
        let last = ((end - start) * rate + 5e-7).floor().max(0.0) as usize;
        Series::new(start, rate, (0..=last).map(|i| self.at(start + i as f64 / rate)).collect())
    }
}

/// The value of an even series at time `t` (s): the cubic through the four nearest samples, linear in the first and the last interval, held
/// outside. Of a signal at a tenth of the rate it loses 0.5 % where linear interpolation loses 5 %.
pub fn cubic(series: &Series, t: Second) -> f64 {
    let position = (t - series.start()) * series.rate();
    let values = series.values();
    let left = position.floor();
    if left < 1.0 || left + 2.0 > (values.len() - 1) as f64 {
        return series.at(t);
    }
    let (fraction, neighbours) = (position - left, &values[left as usize - 1..]);
    let weights = [
        -fraction * (fraction - 1.0) * (fraction - 2.0) / 6.0,
        (fraction + 1.0) * (fraction - 1.0) * (fraction - 2.0) / 2.0,
        -(fraction + 1.0) * fraction * (fraction - 2.0) / 2.0,
        (fraction + 1.0) * fraction * (fraction - 1.0) / 6.0,
    ];
    weights.iter().zip(neighbours).map(|(weight, value)| weight * value).sum()
}

/// The values of an even series at `times` (s), linear between samples, held outside.
pub fn onto(series: &Series, times: &[Second]) -> Vec<f64> {
    times.iter().map(|&t| series.at(t)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_over_a_shutter_shrinks_a_vibration_by_its_sinc() {
        let times: Vec<f64> = (0..4000).map(|i| f64::from(i) * 1e-3).collect();
        let turn = std::f64::consts::TAU * 8.0;
        let samples = Samples::new(times.clone(), times.iter().map(|t| (turn * t).cos()).collect()).unwrap();
        let half = 0.5 * turn * 0.016;
        let expected = half.sin() / half;
        assert!((samples.mean_at(2.0, 0.016) - expected).abs() < 1e-3, "{} {expected}", samples.mean_at(2.0, 0.016));
        assert!((samples.mean_at(2.0, 0.0) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_straight_line_is_interpolated_between_uneven_samples_and_held_outside() {
        let line = Samples::new(vec![0.0, 0.1, 0.4, 1.0], vec![0.0, 0.2, 0.8, 2.0]).unwrap();
        for (t, value) in line.onto(&[0.05, 0.3, 0.99]).iter().zip([0.1, 0.6, 1.98]) {
            assert!((t - value).abs() < 1e-15);
        }
        assert_eq!(line.onto(&[-1.0, 0.0, 1.0, 5.0]), [0.0, 0.0, 2.0, 2.0]);
    }

    #[test]
    fn a_cubic_is_interpolated_as_it_is_and_a_sine_at_a_tenth_of_the_rate_to_half_a_per_cent() {
        let of =
            |f: &dyn Fn(f64) -> f64| Series::new(1.0, 10.0, (0..50).map(|i| f(1.0 + 0.1 * f64::from(i))).collect());
        let third = |t: f64| t.powi(3) - 2.0 * t;
        let series = of(&third).unwrap();
        assert!((cubic(&series, 3.337) - third(3.337)).abs() < 1e-10);
        assert!((cubic(&series, 9.0) - third(5.9)).abs() < 1e-9, "held outside");
        let sine = |t: f64| (std::f64::consts::TAU * t).cos();
        let series = of(&sine).unwrap();
        let off = |value: &dyn Fn(f64) -> f64| {
            (200..400).map(|i| 0.01 * f64::from(i)).map(|t| (value(t) - sine(t)).abs()).fold(0.0, f64::max)
        };
        let (by_cubic, linear) = (off(&|t| cubic(&series, t)), off(&|t| series.at(t)));
        assert!(by_cubic < 0.006 && linear > 0.04, "{by_cubic} {linear}");
    }

    #[test]
    fn an_even_log_is_unchanged_at_its_own_rate() {
        let times: Vec<_> = (0..100).map(|i| 3.0 + f64::from(i) / 200.0).collect();
        let values: Vec<_> = times.iter().map(|t| t.sin()).collect();
        let series = Samples::new(times.clone(), values.clone()).unwrap().even(200.0).unwrap();
        assert_eq!(series.values().len(), 100);
        assert!(onto(&series, &times).iter().zip(&values).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn times_that_run_backwards_are_refused_with_their_sample() {
        let error = Samples::new(vec![0.0, 0.1, 0.1, 0.3], vec![1.0; 4]).unwrap_err();
        assert_eq!(error, SampleError::Backwards { sample: 2, at: 0.1, before: 0.1 });
    }

    #[test]
    fn a_hole_in_a_log_is_refused_with_its_sample() {
        let error = Samples::new(vec![0.0, 0.1], vec![1.0, f64::NAN]).unwrap_err();
        assert!(matches!(error, SampleError::NotANumber { sample: 1, .. }));
    }
}
