//! The zero of an amplifier over a run: a line through its means at rest before and after.

use si::{Second, Series};

/// When nothing but the zero is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zero {
    /// First and last time of the run, s.
    pub moves: [Second; 2],
    /// Time after the run until rest, s.
    pub settling: Second,
}

/// The zero of a signal.
#[derive(Debug, Clone, PartialEq)]
pub struct ZeroLine {
    /// At each sample, unit of the signal.
    pub values: Vec<f64>,
    /// Standard deviation of the zero in the middle of the run by the noise at rest; 0 where no rest is known.
    pub sigma: f64,
    /// Change from before the run to after it; none where it is known at one end alone.
    pub change: Option<f64>,
}

/// A mean at rest.
#[derive(Debug, Clone, Copy)]
struct Rest {
    time: Second,
    mean: f64,
    sigma: f64,
}

/// A tenth of a second is eight samples, enough for a mean of a millinewton.
const SHORTEST: Second = 0.1;
const FEWEST: usize = 8;

impl Zero {
    /// The zero of `signal`: a line where it is known at both ends, a constant where at one, 0 where at none.
    pub fn of(&self, signal: &Series) -> ZeroLine {
        let rest_before = rest_level(signal, [signal.start(), self.moves[0]]);
        let rest_after = rest_level(signal, [self.moves[1] + self.settling, signal.end()]);
        let zero_at = |t: Second| match (rest_before, rest_after) {
            (Some(a), Some(b)) => a.mean + (b.mean - a.mean) * (t - a.time) / (b.time - a.time),
            (Some(level), None) | (None, Some(level)) => level.mean,
            (None, None) => 0.0,
        };
        let sigma = match (rest_before, rest_after) {
            (Some(a), Some(b)) => 0.5 * a.sigma.hypot(b.sigma),
            (Some(level), None) | (None, Some(level)) => level.sigma,
            (None, None) => 0.0,
        };
        let values = (0..signal.values().len()).map(|i| zero_at(signal.time(i))).collect();
        ZeroLine { values, sigma, change: rest_before.zip(rest_after).map(|(a, b)| b.mean - a.mean) }
    }
}

/// The mean between two times; none of too few samples.
fn rest_level(signal: &Series, [start, end]: [Second; 2]) -> Option<Rest> {
    let indices: Vec<usize> = (0..signal.values().len()).filter(|&i| (start..end).contains(&signal.time(i))).collect();
    if end - start <= SHORTEST || indices.len() < FEWEST {
        return None;
    }
    let count = indices.len() as f64;
    let average = |value: &dyn Fn(usize) -> f64| indices.iter().map(|&i| value(i)).sum::<f64>() / count;
    let mean = average(&|i| signal.values()[i]);
    let variance = average(&|i| (signal.values()[i] - mean).powi(2));
    Some(Rest { time: average(&|i| signal.time(i)), mean, sigma: (variance / (count - 1.0)).sqrt() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drifting(rate: f64) -> Series {
        let force = |t: f64| 0.01 + 2e-3 * t + if (2.0..8.0).contains(&t) { 0.1 } else { 0.0 };
        Series::new(0.0, rate, (0..(10.0 * rate) as usize).map(|i| force(i as f64 / rate)).collect()).unwrap()
    }

    #[test]
    fn a_drift_is_the_line_through_both_rests() {
        let signal = drifting(80.0);
        let zero = Zero { moves: [2.0, 8.0], settling: 0.5 }.of(&signal);
        let off = zero.values.iter().enumerate().map(|(i, z)| (z - 0.01 - 2e-3 * signal.time(i)).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9);
        // from the middle of the first rest to that of the last
        assert!((zero.change.unwrap() - 2e-3 * 8.24).abs() < 1e-4, "{:?}", zero.change);
    }

    #[test]
    fn one_rest_gives_a_constant_and_none_gives_zero() {
        let signal = drifting(80.0);
        let one = Zero { moves: [2.0, 10.0], settling: 0.5 }.of(&signal);
        assert!(one.change.is_none() && one.values[0] == one.values[799] && (one.values[0] - 0.012).abs() < 1e-4);
        assert!(Zero { moves: [0.0, 10.0], settling: 0.5 }.of(&signal).values.iter().all(|z| *z == 0.0));
    }
}
