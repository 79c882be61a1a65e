//! An affine map between two clocks that recorded the same events.

use si::Second;

/// Maps times of one clock to times of another: t' = offset + scale · t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Time of the other clock when this one is 0, s.
    pub offset: Second,
    /// Seconds of the other clock in a second of this one, no unit.
    pub scale: f64,
}

/// Why two lists of events do not define a map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ClockError {
    /// Nothing to match.
    #[error(
        "two clocks have no common edge\n  why: neither recorded one\n  do:  check that the lamp is in the picture and the log has its column"
    )]
    NoEdge,
    /// One clock recorded events that the other did not.
    #[error(
        "two clocks recorded different edges\n  why: one recorded {} at {}, the other {} at {}\n  do:  keep the edges that both recorded, or correct the recording that missed one", .here.len(), listed_times(.here), .there.len(), listed_times(.there)
    )]
    Counts {
        /// Times on this clock, s.
        here: Vec<Second>,
        /// Times on the other clock, s.
        there: Vec<Second>,
    },
    /// Edges that do not follow each other in time, or a drift that no clock has.
    #[error(
        "the edges of two clocks do not belong together\n  why: a second here would be {scale:.4} s there; clocks differ by less than {limit} s\n  do:  check that both lists hold the same edges in the same order"
    )]
    Drift {
        /// Scale that the edges ask for, no unit.
        scale: f64,
        /// Largest departure from 1 that is accepted.
        limit: f64,
    },
}

/// Largest drift that is accepted, s a second: a poor crystal drifts by 1e-4.
// A hundred times as wide as a poor crystal: a nominal frame rate of 60 for 60/1.001 is off by 1e-3 and must pass. What
// is refused is a list with a missed and a spurious edge, whose counts agree.
pub(crate) const DRIFT_LIMIT: f64 = 0.01;

impl Clock {
    /// The identity.
    pub const SAME: Self = Self { offset: 0.0, scale: 1.0 };

    /// Matches the times `here` with the times `there` (s) of the same edges in the same order.
    ///
    /// One edge gives the offset alone, two or more the drift too, by least squares.
    ///
    /// # Errors
    /// [`ClockError`] when the numbers differ, there is no edge, or the drift is not one of a clock.
    pub fn from_edges(here: &[Second], there: &[Second]) -> Result<Self, ClockError> {
        if here.len() != there.len() {
            return Err(ClockError::Counts { here: here.into(), there: there.into() });
        }
        if here.is_empty() {
            return Err(ClockError::NoEdge);
        }
        let count = here.len() as f64;
        // About the means: n Σ t² − (Σ t)² of times of day or of an epoch would cancel to nothing.
        let (mean_here, mean_there) = (here.iter().sum::<f64>() / count, there.iter().sum::<f64>() / count);
        let sum_of_squares: f64 = here.iter().map(|t| (t - mean_here).powi(2)).sum();
        let sum_of_products: f64 = here.iter().zip(there).map(|(t, u)| (t - mean_here) * (u - mean_there)).sum();
        let scale = if here.len() > 1 { sum_of_products / sum_of_squares } else { 1.0 };
        if scale.is_nan() || (scale - 1.0).abs() > DRIFT_LIMIT {
            return Err(ClockError::Drift { scale, limit: DRIFT_LIMIT });
        }
        Ok(Self { offset: mean_there - scale * mean_here, scale })
    }

    /// Standard deviation of [`Clock::there`] at the time `instant` (s), s: the edges `here` (s) are each known to
    /// `sigma` (s), both clocks together. Of one edge's offset; one edge does not determine the drift.
    pub fn sigma(here: &[Second], sigma: &[Second], instant: Second) -> Second {
        let count = here.len() as f64;
        let mean_here = here.iter().sum::<f64>() / count;
        let sum_of_squares: f64 = here.iter().map(|t| (t - mean_here).powi(2)).sum();
        let lever_arm = |t: Second| {
            if sum_of_squares > 0.0 { (instant - mean_here) * (t - mean_here) / sum_of_squares } else { 0.0 }
        };
        here.iter().zip(sigma).map(|(t, s)| ((1.0 / count + lever_arm(*t)) * s).powi(2)).sum::<f64>().sqrt()
    }

    /// A time of this clock on the other one, s.
    pub fn there(&self, here: Second) -> Second {
        self.offset + self.scale * here
    }

    /// A time of the other clock on this one, s.
    pub fn here(&self, there: Second) -> Second {
        (there - self.offset) / self.scale
    }

    /// Root of the mean squared residual over matched edges, s.
    pub fn rms_error(&self, here: &[Second], there: &[Second]) -> Second {
        let sum_of_squares: f64 = here.iter().zip(there).map(|(&t, u)| (self.there(t) - u).powi(2)).sum();
        (sum_of_squares / here.len().min(there.len()).max(1) as f64).sqrt()
    }
}

fn listed_times(times: &[Second]) -> String {
    let shown: Vec<_> = times.iter().take(6).map(|t| format!("{t:.3}")).collect();
    let ellipsis = if times.len() > 6 { ", …" } else { "" };
    format!("[{}{ellipsis}] s", shown.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_edge_gives_the_offset_alone() {
        let clock = Clock::from_edges(&[1.25], &[11.0]).unwrap();
        assert_eq!(clock, Clock { offset: 9.75, scale: 1.0 });
        assert_eq!(clock.here(clock.there(3.0)), 3.0);
    }

    #[test]
    fn two_edges_give_the_drift_too() {
        let truth = Clock { offset: -3.2, scale: 1.0 + 80e-6 };
        let here = [2.0, 61.0];
        let found = Clock::from_edges(&here, &here.map(|t| truth.there(t))).unwrap();
        assert!((found.scale - truth.scale).abs() < 1e-14);
        assert!((found.there(200.0) - truth.there(200.0)).abs() < 1e-12);
    }

    #[test]
    fn the_uncertainty_of_a_clock_is_that_of_its_edges_and_grows_beyond_them() {
        let (here, sigma) = ([2.0, 12.0], [1e-3, 2e-3]);
        for (at, truth) in [(2.0, 1e-3), (12.0, 2e-3), (7.0, 0.5 * 5e-6_f64.sqrt()), (22.0, 17e-6_f64.sqrt())] {
            assert!((Clock::sigma(&here, &sigma, at) - truth).abs() < 1e-12, "at {at}");
        }
        assert_eq!(Clock::sigma(&[3.0], &[1e-3], 50.0), 1e-3);
    }

    #[test]
    fn the_noise_of_many_edges_averages_out() {
        let here: Vec<_> = (0..20).map(f64::from).collect();
        let there: Vec<_> = here.iter().map(|t| t + 5.0 + 1e-3 * (t * 7.7).sin()).collect();
        let clock = Clock::from_edges(&here, &there).unwrap();
        assert!((clock.there(10.0) - 15.0).abs() < 3e-4);
        assert!(clock.rms_error(&here, &there) < 1e-3);
    }

    #[test]
    fn a_missed_edge_is_refused_with_the_counts_and_times_of_both() {
        let text = Clock::from_edges(&[1.0, 2.0], &[1.0]).unwrap_err().to_string();
        assert!(text.contains("2 at [1.000, 2.000] s") && text.contains("1 at [1.000] s"), "{text}");
    }

    #[test]
    fn edges_of_different_events_are_refused() {
        assert!(matches!(Clock::from_edges(&[1.0, 2.0], &[1.0, 2.5]), Err(ClockError::Drift { .. })));
        assert!(matches!(Clock::from_edges(&[1.0, 1.0], &[1.0, 2.5]), Err(ClockError::Drift { .. })));
    }
}
