//! Whether the samples of an uneven log were taken evenly and stamped late, or taken when their stamps say.
//!
//! A timer or a converter takes samples evenly, and the program that receives them stamps them when the system lets it run. A loop that
//! reads a sensor and a clock in turn takes them unevenly, and stamps them rightly. The signal itself parts the two: where it rises
//! or falls, it goes smoothly from sample to sample on the clock that is right, and zigzags on the other.

use si::Second;

use super::LogFormat;
use super::sampling::Stamps;

/// A residual that exceeds the column's median so many times is that of a signal that changes; smaller ones are noise.
const ABOVE_NOISE: f64 = 4.0;
/// A sample votes for the clock on which its residual is smaller so many times.
const CLEARLY: f64 = 2.0;
/// The fewest votes that decide: a valve that opens twice gives as many.
const FEWEST_VOTES: usize = 10;
/// And how many there must be for each against.
const MAJORITY: usize = 3;
/// A signal that moves all the time, such as the force of a flapping tail on a fixture that rings, has no quiet samples to compare with.
/// There the even clock is right where more than this share of the samples fits it better than the stamps, by so many deviations of
/// a fair coin.
const SHARE: f64 = 0.6;
const DEVIATIONS: f64 = 2.0;
/// The share of samples at which such a signal moves; a lamp that lights a few times gives no smooth curve to judge by.
const MOVING: f64 = 0.5;
/// Residuals that differ by less, relative to the column's range, differ by rounding: of a level that is held.
const ROUNDING: f64 = 1e-9;
/// Samples on either side through which the polynomial goes that a sample should fit: with one, the curvature of a ringing at a fifth of
/// the rate hides errors of time, with three it does not.
const BESIDE: usize = 3;
/// The share of such residuals that are independent: those of seven samples in a row share samples.
const INDEPENDENT: f64 = 0.3;
/// Samples over which the lateness of stamps is averaged, and the largest departure of such a mean from the clock, in steps: a
/// sample that was lost shifts the stamps behind it by a whole step.
const BLOCK: usize = 200;
const LOST: f64 = 0.2;

/// An even clock: the time of the first sample and the step to the next, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EvenClock {
    pub(super) start: Second,
    pub(super) step: Second,
}

impl EvenClock {
    /// The time of a sample, s.
    pub(super) fn sample_time(&self, sample: usize) -> Second {
        self.start + self.step * sample as f64
    }
}

/// The clock on which the samples were taken, later by the mean lateness of the stamps; none where the stamps are right, or where
/// nothing in the log decides.
pub(super) fn taken_evenly(rows: &[Vec<f64>], format: &LogFormat, stamps: &Stamps) -> Option<EvenClock> {
    let clock = fitted_clock(stamps.times);
    let continuous_columns = || (1..format.columns.len()).filter(|&k| !format.columns[k].held);
    let votes: Vec<Votes> = continuous_columns().map(|k| column_votes(rows, k)).collect();
    let [even, stamped] = [0, 1].map(|side| votes.iter().map(|v| v[side]).sum::<usize>());
    let has_majority = |count: usize, others: usize| count >= FEWEST_VOTES && count > MAJORITY * others;
    let decided = has_majority(even, stamped)
        || !has_majority(stamped, even) && continuous_columns().any(|k| fits_better(rows, k, clock));
    (decided && !loses_samples(stamps.times, clock)).then_some(clock)
}

/// The line through the stamps, by least squares.
fn fitted_clock(times: &[Second]) -> EvenClock {
    let middle = 0.5 * (times.len() - 1) as f64;
    let mean = times.iter().map(|t| t - times[0]).sum::<f64>() / times.len() as f64;
    let cross_moment = |(i, t): (usize, &Second)| (i as f64 - middle) * (t - times[0] - mean);
    let index_moment: f64 = (0..times.len()).map(|i| (i as f64 - middle).powi(2)).sum();
    let step = times.iter().enumerate().map(cross_moment).sum::<f64>() / index_moment;
    EvenClock { start: times[0] + mean - step * middle, step }
}

/// Samples that vote for the even clock, and for the stamps.
type Votes = [usize; 2];

/// Votes of one column: distance of each sample from the straight line between its neighbours, on either clock.
fn column_votes(rows: &[Vec<f64>], k: usize) -> Votes {
    let deviation = |samples: &[Vec<f64>], ratio: f64| {
        (samples[1][k] - samples[0][k] - ratio * (samples[2][k] - samples[0][k])).abs()
    };
    let deviations = |samples: &[Vec<f64>]| {
        let ratio = (samples[1][0] - samples[0][0]) / (samples[2][0] - samples[0][0]);
        [deviation(samples, 0.5), deviation(samples, ratio)]
    };
    let residuals: Vec<[f64; 2]> = rows.windows(3).map(deviations).collect();
    let mut magnitudes: Vec<f64> = residuals.iter().map(|r| r[0].max(r[1])).collect();
    magnitudes.sort_by(f64::total_cmp);
    let limit = ABOVE_NOISE * magnitudes.get(magnitudes.len() / 2).copied().unwrap_or_default();
    let is_clear = |side: usize| move |r: &&[f64; 2]| r[0].max(r[1]) > limit && CLEARLY * r[side] < r[1 - side];
    [0, 1].map(|side| residuals.iter().filter(is_clear(side)).count())
}

/// Whether more samples of a column fit the polynomial through their neighbours on the even clock than on that of the stamps: a sign test.
fn fits_better(rows: &[Vec<f64>], k: usize, clock: EvenClock) -> bool {
    let window = |i: usize| i - BESIDE..=i + BESIDE;
    let misfits = |i: usize| {
        let values: Vec<f64> = window(i).map(|j| rows[j][k]).collect();
        let evenly: Vec<Second> = window(i).map(|j| clock.sample_time(j)).collect();
        let stamped: Vec<Second> = window(i).map(|j| rows[j][0]).collect();
        [polynomial_misfit(&evenly, &values), polynomial_misfit(&stamped, &values)]
    };
    let inside = BESIDE..rows.len().saturating_sub(BESIDE).max(BESIDE);
    let (mut even_votes, mut decided, total) = (0.0, 0.0, inside.len() as f64);
    let column = || rows.iter().map(|row| row[k]);
    let range = column().fold(f64::MIN, f64::max) - column().fold(f64::MAX, f64::min);
    for [evenly, stamped] in inside.map(misfits).filter(|[a, b]| (a - b).abs() > ROUNDING * range) {
        decided += 1.0;
        even_votes += f64::from(u8::from(evenly < stamped));
    }
    decided > MOVING * total
        && even_votes > SHARE * decided
        && even_votes - 0.5 * decided > DEVIATIONS * (0.25 * decided / INDEPENDENT).sqrt()
}

/// Distance of the middle value from the polynomial through the others (Lagrange's), over what independent noise of one unit would make it.
fn polynomial_misfit(times: &[Second], values: &[f64]) -> f64 {
    let centre = times.len() / 2;
    let neighbours = || (0..times.len()).filter(|&i| i != centre);
    let weight = |a: usize| -> f64 {
        neighbours().filter(|&b| b != a).map(|b| (times[centre] - times[b]) / (times[a] - times[b])).product()
    };
    let (mut residual, mut variance) = (values[centre], 1.0);
    for (a, weight) in neighbours().map(|a| (a, weight(a))) {
        residual -= weight * values[a];
        variance += weight * weight;
    }
    residual.abs() / variance.sqrt()
}

/// Whether the stamps leave the clock for longer than lateness explains.
fn loses_samples(times: &[Second], clock: EvenClock) -> bool {
    let lateness: Vec<Second> = times.iter().enumerate().map(|(i, t)| t - clock.sample_time(i)).collect();
    let block_mean = |block: &[Second]| block.iter().sum::<f64>() / block.len() as f64;
    lateness.chunks_exact(BLOCK).any(|block| block_mean(block).abs() > LOST * clock.step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::card::LogKind;
    use crate::log::{ColumnFormat, Spikes};

    fn form() -> LogFormat {
        let columns = vec![ColumnFormat::time(), ColumnFormat::measured("left_mbar", (-1e3, 1e4, "mbar"))];
        LogFormat { kind: "pressure log", instrument: LogKind::Pressure, columns, spikes: Spikes::None }
    }

    /// Uniform between −1 and 1.
    fn uneven(i: usize) -> f64 {
        let mixed = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        ((mixed ^ mixed >> 31).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A valve that opens and closes every second, with noise: (stamp, reading) of 1,200 samples at 200 Hz, which are taken `taken` and
    /// stamped `stamped` after the even clock's time.
    fn log(taken: impl Fn(usize) -> f64, stamped: impl Fn(usize) -> f64) -> Vec<Vec<f64>> {
        let pressure = |t: f64| {
            let (open, since) = (t.rem_euclid(2.0) < 1.0, t.rem_euclid(1.0));
            let rest = (-since / 0.04).exp();
            200.0 * if open { 1.0 - rest } else { rest }
        };
        let time = |i: usize| 2.0 + 0.005 * i as f64;
        let row = |i: usize| vec![time(i) + stamped(i), pressure(time(i) + taken(i)) + 0.3 * uneven(7 * i + 3)];
        (0..1200).map(row).collect()
    }

    fn clock(rows: &[Vec<f64>]) -> Option<EvenClock> {
        let times: Vec<Second> = rows.iter().map(|row| row[0]).collect();
        taken_evenly(rows, &form(), &Stamps { times: &times, lines: &[] })
    }

    #[test]
    fn samples_that_were_stamped_late_are_put_back_onto_their_clock() {
        let found = clock(&log(|_| 0.0, |i| 2e-3 * (1.0 + uneven(i)))).unwrap();
        assert!((found.step / 0.005 - 1.0).abs() < 1e-4, "{found:?}");
        // late by 2 ms in the mean
        assert!((found.start - 2.002).abs() < 2e-4, "{found:?}");
    }

    #[test]
    fn samples_that_were_taken_when_they_were_stamped_stay_there() {
        let late = |i: usize| 2e-3 * (1.0 + uneven(i));
        assert_eq!(clock(&log(late, late)), None);
    }

    /// A force that swings three times a second on a fixture that rings at 15 Hz, with noise, at 80 Hz.
    fn swinging(taken: impl Fn(usize) -> f64, stamped: impl Fn(usize) -> f64) -> Vec<Vec<f64>> {
        let sine = |t: f64, frequency: f64| (std::f64::consts::TAU * frequency * t).sin();
        let force = |t: f64| 0.2 * sine(t, 3.0) + 0.1 * sine(t, 15.0);
        let time = |i: usize| 0.0125 * i as f64;
        let row = |i: usize| vec![time(i) + stamped(i), force(time(i) + taken(i)) + 0.002 * uneven(7 * i + 3)];
        (0..400).map(row).collect()
    }

    #[test]
    fn a_signal_that_moves_all_the_time_decides_by_the_number_of_samples() {
        let late = |i: usize| 4e-3 * (1.0 + uneven(i));
        assert!(clock(&swinging(|_| 0.0, late)).is_some());
        assert_eq!(clock(&swinging(late, late)), None);
    }

    #[test]
    fn a_log_in_which_nothing_moves_decides_nothing() {
        let rows: Vec<Vec<f64>> =
            (0..1200).map(|i| vec![0.005 * i as f64 + 2e-3 * uneven(i), 100.0 + uneven(3 * i)]).collect();
        assert_eq!(clock(&rows), None);
    }

    #[test]
    fn where_a_sample_is_missing_the_stamps_are_kept() {
        let mut rows = log(|_| 0.0, |i| 2e-3 * (1.0 + uneven(i)));
        rows.remove(700);
        assert_eq!(clock(&rows), None);
    }

    #[test]
    fn the_line_through_the_stamps_is_that_of_least_squares() {
        let found = fitted_clock(&[10.0, 11.0, 13.0]);
        assert!((found.step - 1.5).abs() < 1e-12 && (found.start - (34.0 / 3.0 - 1.5)).abs() < 1e-12, "{found:?}");
        // stamps since 1970 keep all their digits: the step is a power of two
        let since: Vec<Second> = (0..1200).map(|i| 1.75e9 + f64::from(i) / 256.0).collect();
        assert!(
            (fitted_clock(&since).step * 256.0 - 1.0).abs() < 1e-13,
            "{:e}",
            fitted_clock(&since).step * 256.0 - 1.0
        );
    }

    #[test]
    fn a_polynomial_of_the_fifth_degree_through_seven_samples_fits_on_its_clock() {
        let uneven = [0.0, 0.9, 2.1, 3.0, 4.2, 4.9, 6.0];
        let of = |times: &[f64]| -> Vec<f64> { times.iter().map(|t| t.powi(5) - 3.0 * t * t + 2.0).collect() };
        assert!(polynomial_misfit(&uneven, &of(&uneven)) < 1e-9);
        let even: Vec<f64> = (0..7).map(f64::from).collect();
        assert!(polynomial_misfit(&even, &of(&uneven)) > 1.0);
        // weights −3/4, 3/10, −1/20 on either side: noise of one unit makes it √(1 + 2 (0.5625 + 0.09 + 0.0025)) units
        let alone = polynomial_misfit(&even, &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0]);
        assert!((alone - 2.0 / 2.31_f64.sqrt()).abs() < 1e-12, "{alone}");
    }

    /// Without noise each sample fits its own clock. Of seven in a row, 30 % are independent: two deviations of a fair coin take
    /// 13.3 samples that all agree.
    #[test]
    fn so_few_samples_that_chance_explains_them_decide_nothing() {
        let rows = |count: usize| -> Vec<Vec<f64>> {
            let time = |i: usize| 0.0125 * i as f64;
            let force = |t: f64| (std::f64::consts::TAU * 3.0 * t).sin();
            (0..count).map(|i| vec![time(i) + 4e-3 * uneven(i), force(time(i))]).collect()
        };
        let clock = EvenClock { start: 0.0, step: 0.0125 };
        let decides = |count: usize| fits_better(&rows(count + 2 * BESIDE), 1, clock);
        assert_eq!([6, 13, 14, 30].map(decides), [false, false, true, true]);
    }

    /// It moves during four of ten samples, at which the even clock is right: a lamp that lights gives as many.
    #[test]
    fn a_signal_that_is_held_most_of_the_time_is_not_judged_by_the_number_of_samples() {
        let time = |i: usize| 0.0125 * i as f64;
        let moves = |from: usize| -> Vec<Vec<f64>> {
            let force = |i: usize| (std::f64::consts::TAU * 3.0 * time(i.max(from) - from)).sin();
            (0..200).map(|i| vec![time(i) + 4e-3 * uneven(i), force(i)]).collect()
        };
        let clock = EvenClock { start: 0.0, step: 0.0125 };
        assert_eq!([120, 80].map(|from| fits_better(&moves(from), 1, clock)), [false, true]);
    }
}
