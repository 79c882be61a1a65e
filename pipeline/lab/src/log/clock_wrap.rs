//! Clocks that begin anew: a counter that overflows, a time of day at midnight.

use si::Second;

/// After what time a clock begins anew, s: a counter of 32 bits in microseconds or milliseconds, one of 16 bits in milliseconds, and the day.
const PERIODS: [Second; 4] = [4_294.967_296, 4_294_967.296, 65.536, 86_400.0];
/// The step over an overflow against the longest other step before it, at most.
const LONGER: f64 = 3.0;

/// Counts times (s) on where their clock began anew: where a time falls back, and with a whole period added follows the one before as the
/// others do. A clock that was set back does not meet that by chance.
pub(super) fn unwrap_times(times: &mut [Second]) {
    let mut offset = 0.0;
    // the clock may overflow at the second sample already, before any other step is known
    let mut steps: Vec<Second> = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let mut longest_step = steps.get(steps.len() / 2).copied().unwrap_or_default();
    for i in 1..times.len() {
        let previous = times[i - 1];
        let step = times[i] + offset - previous;
        if step < 0.0 {
            let is_period =
                |period: &&Second| (0.0..=LONGER * longest_step).contains(&(step + **period)) && step + **period > 0.0;
            offset += PERIODS.iter().find(is_period).copied().unwrap_or_default();
        } else {
            longest_step = longest_step.max(step);
        }
        times[i] += offset;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_and_days_that_begin_anew_go_on() {
        for period in PERIODS {
            let step = 1e-3 * period;
            let even: Vec<Second> = (0..40).map(|i| 0.99 * period + step * f64::from(i)).collect();
            let mut times: Vec<Second> = even.iter().map(|t| t % period).collect();
            unwrap_times(&mut times);
            let off = times.iter().zip(&even).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9 * period, "{period}: {off}");
        }
    }

    #[test]
    fn a_counter_may_overflow_at_the_second_sample() {
        let mut times = vec![4_294.96];
        times.extend((0..20).map(|i| 0.002 + 0.01 * f64::from(i)));
        unwrap_times(&mut times);
        assert!((times[1] - 4_294.969_296).abs() < 1e-9 && (times[20] - times[1] - 0.19).abs() < 1e-9, "{times:?}");
    }

    #[test]
    fn a_clock_that_was_set_back_stays_so() {
        let mut times = [4000.0, 4000.1, 4000.2, 10.0, 10.1, 10.0];
        let before = times;
        unwrap_times(&mut times);
        assert_eq!(times, before);
    }
}
