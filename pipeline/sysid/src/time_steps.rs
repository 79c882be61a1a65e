//! Uneven time steps: short after each change of the command, long while a pressure is held.

use si::Second;

/// A step may grow by this factor: BDF2 is stable up to 2.4.
const GROWTH: f64 = 1.3;

/// Time steps of a simulated film, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeSteps {
    /// After each change of the command.
    pub step: Second,
    /// How long that step is kept.
    pub vibration: Second,
    /// The longest, of a hold.
    pub longest: Second,
}

impl TimeSteps {
    /// Ends of time steps up to `end` (s): each event but the first is the end of one; after it steps are short for a while, then grow
    /// to the longest.
    pub fn ends(self, events: &[Second], end: Second) -> Vec<Second> {
        let Self { step, vibration, longest } = self;
        let mut times = Vec::new();
        let stops = events.iter().skip(1).copied().filter(|&e| e < end).chain([end]);
        for (&begin, stop) in events.iter().zip(stops) {
            let (mut t, mut length) = (begin, step);
            while stop - t > 1e-9 {
                if t - begin > vibration {
                    length = (GROWTH * length).min(longest);
                }
                // two halves in place of a whole and a sliver: a following step must not be much longer than the one before it
                let remaining = stop - t;
                let taken = if remaining <= length {
                    remaining
                } else if remaining < 2.0 * length {
                    0.5 * remaining
                } else {
                    length
                };
                t = if taken == remaining { stop } else { t + taken };
                times.push(t);
            }
        }
        times
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_at_every_event_and_never_grow_too_fast() {
        let events = [0.0, 1.7, 2.003];
        let times = TimeSteps { step: 0.004, vibration: 0.5, longest: 0.05 }.ends(&events, 4.0);
        assert!(events[1..].iter().chain(&[4.0]).all(|e| times.iter().any(|t| (t - e).abs() < 1e-12)));
        let lengths: Vec<f64> = std::iter::once(times[0]).chain(times.windows(2).map(|w| w[1] - w[0])).collect();
        assert!(lengths.iter().all(|l| *l > 1e-3 && *l < 0.0501), "{lengths:?}");
        assert!(lengths.windows(2).all(|w| w[1] / w[0] < 2.4), "{lengths:?}");
    }
}
