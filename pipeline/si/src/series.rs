//! A quantity sampled at an even rate.

use crate::{Hertz, Second};

/// Evenly sampled values: sample i was taken at `start + i / rate`.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    start: Second,
    rate: Hertz,
    values: Vec<f64>,
}

/// Why a list of numbers is not a series.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SeriesError {
    /// A rate that is not a positive number.
    #[error(
        "the sampling rate is {0} Hz\n  why: it must be positive and finite\n  do:  correct the rate, or the times that it is computed from"
    )]
    Rate(f64),
    /// No samples at all.
    #[error("the series has no sample\n  why: at least one is needed\n  do:  check that the recording is not empty")]
    Empty,
    /// A sample that is not a number.
    #[error(
        "sample {index} of the series is {value}\n  why: every sample must be finite\n  do:  check the recording there"
    )]
    NotANumber {
        /// Which sample.
        index: usize,
        /// Its value.
        value: f64,
    },
}

impl Series {
    /// A series from its first time (s), its rate (Hz) and its values (any one unit).
    ///
    /// # Errors
    /// [`SeriesError`] when the rate is not positive, there is no sample, or one is NaN or infinite.
    pub fn new(start: Second, rate: Hertz, values: Vec<f64>) -> Result<Self, SeriesError> {
        if !(rate.is_finite() && rate > 0.0) {
            return Err(SeriesError::Rate(rate));
        }
        if values.is_empty() {
            return Err(SeriesError::Empty);
        }
        match values.iter().position(|v| !v.is_finite()) {
            Some(index) => Err(SeriesError::NotANumber { index, value: values[index] }),
            None => Ok(Self { start, rate, values }),
        }
    }

    /// Time of the first sample, s.
    pub fn start(&self) -> Second {
        self.start
    }

    /// Time of the last sample, s.
    pub fn end(&self) -> Second {
        self.time(self.values.len() - 1)
    }

    /// Samples a second.
    pub fn rate(&self) -> Hertz {
        self.rate
    }

    /// The samples, in order.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Time of sample `index`, s.
    pub fn time(&self, index: usize) -> Second {
        self.start + index as f64 / self.rate
    }

    /// The value at time `t` (s), linear between samples, held before the first and after the last.
    pub fn at(&self, t: Second) -> f64 {
        let position = ((t - self.start) * self.rate).clamp(0.0, (self.values.len() - 1) as f64);
        let lower = position.floor() as usize;
        let upper = (lower + 1).min(self.values.len() - 1);
        let fraction = position - lower as f64;
        self.values[lower] * (1.0 - fraction) + self.values[upper] * fraction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_is_interpolated_between_samples_and_held_outside() {
        let line = Series::new(1.0, 10.0, vec![0.0, 1.0, 2.0]).unwrap();
        assert!((line.at(1.15) - 1.5).abs() < 1e-12);
        assert_eq!((line.at(0.0), line.at(9.0)), (0.0, 2.0));
        assert!((line.end() - 1.2).abs() < 1e-15);
    }

    #[test]
    fn samples_keep_their_order_and_count_from_the_start() {
        let pressures = Series::new(2.5, 4.0, vec![3.0, 1.0]).unwrap();
        assert_eq!((pressures.start(), pressures.rate(), pressures.values()), (2.5, 4.0, &[3.0, 1.0][..]));
        assert_eq!((pressures.time(0), pressures.time(1)), (2.5, 2.75));
    }

    #[test]
    fn a_series_with_a_nan_is_refused_with_its_place() {
        let bad = Series::new(0.0, 1.0, vec![0.0, f64::NAN]).unwrap_err();
        assert!(matches!(bad, SeriesError::NotANumber { index: 1, .. }));
    }
}
