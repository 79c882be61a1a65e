//! The response of a pressure to its command: dead times, time of filling and time constant of emptying, from a log.

use si::{MILLIBAR, Pascal, Second};

/// Least command that counts as above zero, Pa.
const ASKED: Pascal = 10.0 * MILLIBAR;
/// Fraction of the step that counts as the first movement; what is missing of it counts as full.
pub const MOVED: f64 = 0.05;
/// Interval at the end of a hold over which it counts as settled, s.
const SETTLED: Second = 0.5;

/// One filling of one chamber.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulse {
    /// Commanded pressure, Pa.
    pub asked: Pascal,
    /// Mean of the last half second, or of the last fifth of a short hold, Pa.
    pub held: Pascal,
    /// From the command to the first movement, s.
    pub fill_dead: Second,
    /// From the command until it is within 5 % of `held` for the first time, s.
    pub fill: Second,
    /// From the end of the command to the first movement, s.
    pub empty_dead: Second,
    /// From there until 1/e is left, s.
    pub empty: Second,
}

/// A gauge in a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gauge<'a> {
    /// Commanded, Pa: samples.
    pub command: &'a [Pascal],
    /// Measured, Pa: samples.
    pub measured: &'a [Pascal],
}

/// Every filling in a log whose begin and end it holds; `time` in s.
pub fn pulses(time: &[Second], gauge: Gauge) -> Vec<Pulse> {
    let is_commanded = |i: usize| gauge.command[i] > ASKED;
    let starts = (1..time.len()).filter(|&i| is_commanded(i) && !is_commanded(i - 1));
    starts
        .filter_map(|start| measured_pulse(time, gauge, start, (start..time.len()).find(|&i| !is_commanded(i))?))
        .collect()
}

fn measured_pulse(time: &[Second], gauge: Gauge, start: usize, end: usize) -> Option<Pulse> {
    let p = gauge.measured;
    let hold = time[end] - time[start];
    let settled_start = time[end] - SETTLED.min(0.2 * hold);
    let settled: Vec<f64> = (start..end).filter(|&i| time[i] >= settled_start).map(|i| p[i]).collect();
    let held = settled.iter().sum::<f64>() / settled.len().max(1) as f64;
    let next_start = (end..time.len()).find(|&i| gauge.command[i] > ASKED).unwrap_or(time.len());
    let empty_dead = level_crossing(time, p, end..next_start, (1.0 - MOVED) * held)? - time[end];
    let emptied_time = level_crossing(time, p, end..next_start, held / std::f64::consts::E)? - time[end];
    Some(Pulse {
        asked: gauge.command[start],
        held,
        fill_dead: level_crossing(time, p, start..end, MOVED * held)? - time[start],
        fill: level_crossing(time, p, start..end, (1.0 - MOVED) * held)? - time[start],
        empty_dead,
        // measured from the first 5 % of the fall on, the time to 1/e is shorter than the time constant by this
        empty: (emptied_time - empty_dead) / (1.0 + (1.0 - MOVED).ln()),
    })
}

/// When a log first crosses a level, between its samples, s.
fn level_crossing(time: &[Second], log: &[f64], range: std::ops::Range<usize>, level: f64) -> Option<Second> {
    let starts_below = log[range.start] < level;
    let i = range.into_iter().find(|&i| (log[i] < level) != starts_below)?;
    let fraction = (level - log[i - 1]) / (log[i] - log[i - 1]);
    Some(time[i - 1] + fraction * (time[i] - time[i - 1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 200 mbar from 1 s to 6 s: 40 ms dead, then full 100 ms later; 50 ms dead, then emptying with 40 ms.
    fn log() -> (Vec<f64>, [Vec<f64>; 2]) {
        let time: Vec<f64> = (0..2000).map(|i| 0.005 * f64::from(i)).collect();
        let level = 200.0 * MILLIBAR;
        let measured = |t: f64| match t {
            t if t < 1.04 => 0.0,
            t if t < 6.05 => level * ((t - 1.04) / 0.1).min(1.0),
            t => level * (-(t - 6.05) / 0.04).exp(),
        };
        let command = time.iter().map(|&t| if (1.0..6.0).contains(&t) { level } else { 0.0 }).collect();
        let measured = time.iter().map(|&t| measured(t)).collect();
        (time, [command, measured])
    }

    #[test]
    fn a_filling_is_read_off_its_log_to_a_fraction_of_a_sample() {
        let (time, [command, measured]) = log();
        let gauge = Gauge { command: &command, measured: &measured };
        let found = pulses(&time, gauge)[0];
        // 5 % of a filling takes 5 ms and of an emptying 2 ms; the corners are rounded by samples 5 ms apart
        assert!((found.fill_dead - 0.045).abs() < 2e-3 && (found.fill - 0.135).abs() < 2e-3, "{found:?}");
        assert!((found.empty_dead - 0.052).abs() < 2e-3 && (found.empty - 0.04).abs() < 2e-3, "{found:?}");
        assert!((found.held / MILLIBAR - 200.0).abs() < 1e-9);
    }

    #[test]
    fn a_filling_without_an_end_is_left_out() {
        let (time, [command, measured]) = log();
        let gauge = Gauge { command: &command, measured: &measured };
        assert!(pulses(&time[..600], gauge).is_empty());
    }
}
