//! The mean force of a run over whole cycles, with its interval.
//!
//! Waves, the drift of the zero and the static cross-talk of pressure are subtracted; each cycle gives one mean. Cycles follow each other
//! with correlation, so that their number counts as n (1 − ρ)/(1 + ρ); the interval is Student's, with the uncertainties of the zero and of the
//! cross-talk.

use si::{Hertz, Newton, Second, Series};
use signal::crosstalk::CrossTalk;
use signal::resample::Samples;
use signal::wave::{self, Beat, Removal, Wave};
use signal::zero::{Zero, ZeroLine};

use super::page::{Recording, Settings};
use super::recorded::Recorded;
use diagnostics::{Diagnostic, Result};

/// What the other recordings gave.
pub(super) struct Corrections {
    pub waves: Vec<Wave>,
    pub talk: Option<CrossTalk>,
}

/// A run.
pub(super) struct Run {
    pub id: String,
    pub frequency: Hertz,
    /// First and last time of the cycles, s.
    pub within: [Second; 2],
    pub cycles: usize,
    /// Mean of the log over the cycles less its zero, N.
    pub raw: Newton,
    /// Mean of the cross-talk that is subtracted, N; none where no staircase gave it.
    pub crosstalk: Option<Newton>,
    /// Mean force, N.
    pub mean: Newton,
    /// Its 95 % interval, N.
    pub interval: [Newton; 2],
    /// Change of the zero over the run, N; none where it is known at one end alone.
    pub drift: Option<Newton>,
    /// Largest amplitude of the waves that are subtracted, N.
    pub waves: Newton,
    /// Harmonics of the beat in the line of a wave.
    pub warnings: Vec<String>,
    /// The corrected force.
    pub force: Series,
}

/// Parts into which a cycle is divided for its mean.
const PARTS: usize = 64;
/// Fewest cycles whose scatter gives an interval.
const FEWEST: usize = 3;

/// The run of a recording.
///
/// # Errors
/// A [`Diagnostic`] when it has too few whole cycles, or waves and beat cannot be separated.
pub(super) fn evaluated(one: &Recording, log: &Recorded, by: &Corrections, set: &Settings) -> Result<Run> {
    let frequency = one.frequency.unwrap_or(1.0);
    let [first, last] = one.seconds.or_else(|| log.pressed()).ok_or_else(|| silent(one))?;
    let first = first.max(log.force.start());
    let last = last.min(log.force.end());
    if first >= last {
        return Err(outside(one, log));
    }
    check_frequency(one, &log.pressures, [first, last])?;
    // A harmonic at half the sampling rate or beyond is another's alias.
    let resolved = (0.5 * log.force.rate() / frequency * (1.0 - 1e-9)) as usize;
    let beat = Beat { frequency, harmonics: set.harmonics.min(resolved), within: [first, last] };
    let removal = Removal { onsets: &[log.force.start()], beat: Some(beat), drift_degree: 2 };
    let parted = wave::remove(&log.force, &by.waves, &removal).map_err(|e| Diagnostic::from(e).while_doing(&one.id))?;
    let ZeroLine { values: zero, sigma, change } =
        Zero { moves: [first, last], settling: set.settling_time }.of(&parted.rest);
    let still = |i: usize| by.talk.as_ref().map_or(0.0, |talk| talk.of(&log.pressures, log.force.time(i)));
    let series = |value: &dyn Fn(usize) -> f64| {
        let values = (0..log.force.values().len()).map(value).collect();
        Series::new(log.force.start(), log.force.rate(), values)
    };
    let level = series(&|i| parted.rest.values()[i] - zero[i])?;
    let force = series(&|i| level.values()[i] - still(i))?;
    let begin = first + set.settling_cycles / frequency;
    let cycles = ((last - begin) * frequency + 1e-6).floor().max(0.0) as usize;
    if cycles < FEWEST {
        return Err(too_short(one, cycles));
    }
    let of = |signal: &Series| means(signal, begin, (frequency, cycles));
    let (means, raw) = (of(&force), average(&of(&level)));
    let length = log.force.end() - log.force.start();
    let crosstalk = by.talk.as_ref().map(|_| raw - average(&means));
    // The curve is uncertain by its noise at the last knot, and in proportion below.
    let part =
        |talk: &CrossTalk| talk.sigma * crosstalk.unwrap_or(0.0) / talk.forces.last().copied().unwrap_or(1.0).max(1e-9);
    let shared = sigma.hypot(by.talk.as_ref().map_or(0.0, part));
    let near = wave::close_harmonics(frequency, 4, &by.waves, length);
    Ok(Run {
        id: one.id.clone(),
        frequency,
        within: [begin, begin + cycles as f64 / frequency],
        cycles,
        raw,
        crosstalk,
        mean: average(&means),
        interval: interval(&means, shared),
        drift: change,
        waves: parted.waves.iter().fold(0.0, |most: f64, w| most.max(w.abs())),
        warnings: near.iter().map(ToString::to_string).collect(),
        force,
    })
}

/// Share by which the frequency on the page and that of the pressures may differ: over a run the cut of cycles stays within a tenth of one.
const FREQUENCY: f64 = 0.05;

/// Compares the frequency on the page with that of the pressures beside it.
fn check_frequency(one: &Recording, pressures: &[Samples], within: [Second; 2]) -> Result<()> {
    let (Some(declared), Some(found)) = (one.frequency, cycle_frequency(pressures, within)) else { return Ok(()) };
    if (declared / found - 1.0).abs() <= FREQUENCY {
        return Ok(());
    }
    let what =
        format!("recording `{}` has frequency = {declared} Hz, and its pressures repeat at {found:.3} Hz", one.id);
    let why = format!("means are taken over whole cycles; the two may differ by {:.0} %", 100.0 * FREQUENCY);
    Err(Diagnostic::new(what, why, format!("set frequency = {found:.3}, or name the pressure log of this run")))
}

/// Rises of a pressure that show a frequency, at least.
const RISES: usize = 2;

/// The frequency of the pressure that swings most, Hz, by the times at which it rises through the middle of its range; none where it rises too rarely or
/// unevenly.
fn cycle_frequency(pressures: &[Samples], [first, last]: [Second; 2]) -> Option<Hertz> {
    let span = |samples: &&Samples| {
        let fold = |by: fn(f64, f64) -> f64| samples.values().iter().copied().reduce(by);
        fold(f64::max).zip(fold(f64::min)).map_or(0.0, |(high, low)| high - low)
    };
    let most = pressures.iter().max_by(|a, b| span(a).total_cmp(&span(b)))?;
    let low = most.values().iter().copied().reduce(f64::min)?;
    // a rise counts from a third to two thirds of the range: noise about one level is none
    let (third, mut is_low, mut rises) = (span(&most) / 3.0, false, Vec::new());
    // length: a time for each value
    for (time, value) in most.times().iter().zip(most.values()) {
        if *value < low + third {
            is_low = true;
        } else if *value > low + 2.0 * third && is_low {
            is_low = false;
            rises.extend((first..=last).contains(time).then_some(*time));
        }
    }
    let mut steps: Vec<Second> = rises.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let (count, median) = (rises.len(), *steps.get(steps.len() / 2)?);
    let mean = (rises[count - 1] - rises[0]) / (count - 1) as f64;
    let is_even = steps.iter().all(|step| (0.5..1.5).contains(&(step / median)));
    (count >= RISES && is_even && mean > 0.0).then(|| 1.0 / mean)
}

fn silent(one: &Recording) -> Diagnostic {
    let what = format!("in recording `{}` no pressure rises", one.id);
    Diagnostic::new(what, "a run lasts while a pressure does", "name its seconds on the page, or its own pressure log")
}

fn outside(one: &Recording, log: &Recorded) -> Diagnostic {
    let what = format!("recording `{}` has no force while it flapped", one.id);
    let why = format!("its log of the force lasts from {:.3} to {:.3} s", log.force.start(), log.force.end());
    Diagnostic::new(what, why, "correct `seconds`, or name the logs of one run")
}

fn too_short(one: &Recording, cycles: usize) -> Diagnostic {
    let what = format!("recording `{}` has {cycles} whole cycles", one.id);
    Diagnostic::new(
        what,
        format!("an interval needs {FEWEST}, behind the settling cycles"),
        "record for longer, or correct its frequency",
    )
}

/// The mean of each of so many cycles from `begin` (s) on.
fn means(signal: &Series, begin: Second, (frequency, cycles): (Hertz, usize)) -> Vec<f64> {
    let at = |k: usize, part: usize| begin + (k as f64 + (part as f64 + 0.5) / PARTS as f64) / frequency;
    let mean = |k: usize| (0..PARTS).map(|part| signal.at(at(k, part))).sum::<f64>() / PARTS as f64;
    (0..cycles).map(mean).collect()
}

fn average(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The 95 % interval of the mean of correlated values, with the standard deviation of what all have in common.
fn interval(values: &[f64], shared: f64) -> [f64; 2] {
    let (count, mean) = (values.len() as f64, average(values));
    let off: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let square: f64 = off.iter().map(|v| v * v).sum();
    let next: f64 = off.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let correlation = (next / square.max(f64::MIN_POSITIVE)).clamp(0.0, 0.9);
    let independent = (count * (1.0 - correlation) / (1.0 + correlation)).max(2.0);
    let half = student(independent - 1.0) * (square / (count - 1.0) / independent).sqrt();
    let half = half.hypot(1.96 * shared);
    [mean - half, mean + half]
}

/// The 0.975 quantile of Student's t, by the expansion in 1/ν \[abramowitz1964, 26.7.5\]: 11 % low at ν = 1, 0.8 % at 2, 0.01 % from 5 on.
fn student(degrees: f64) -> f64 {
    const Z: f64 = 1.959_964;
    let g1 = (Z.powi(3) + Z) / 4.0;
    let g2 = (5.0 * Z.powi(5) + 16.0 * Z.powi(3) + 3.0 * Z) / 96.0;
    let g3 = (3.0 * Z.powi(7) + 19.0 * Z.powi(5) + 17.0 * Z.powi(3) - 15.0 * Z) / 384.0;
    let g4 = (79.0 * Z.powi(9) + 776.0 * Z.powi(7) + 1482.0 * Z.powi(5) - 1920.0 * Z.powi(3) - 945.0 * Z) / 92_160.0;
    Z + g1 / degrees + g2 / degrees.powi(2) + g3 / degrees.powi(3) + g4 / degrees.powi(4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quantile_of_student_is_that_of_the_tables() {
        for (degrees, truth, within) in [
            (1.0, 12.706_205, 0.12),
            (2.0, 4.302_653, 8e-3),
            (3.0, 3.182_446, 1.5e-3),
            (5.0, 2.570_582, 2e-4),
            (10.0, 2.228_139, 1e-5),
            (30.0, 2.042_272, 1e-6),
        ] {
            assert!((student(degrees) / truth - 1.0).abs() < within, "{degrees}: {}", student(degrees));
        }
    }

    /// Pressures at 100 Hz of a square wave of 2 Hz after a second of rest, with ripple.
    fn flaps() -> Samples {
        let pressure = |i: usize| {
            let phase = 2.0 * (0.01 * i as f64 - 1.0);
            let high = phase >= 0.0 && phase.fract() < 0.5;
            f64::from(u8::from(high)) * 2e4 + 300.0 * (1.7 * i as f64).sin()
        };
        Samples::new((0..1100).map(|i| 0.01 * i as f64).collect(), (0..1100).map(pressure).collect()).unwrap()
    }

    #[test]
    fn pressures_tell_their_frequency_where_they_have_one() {
        let frequency = |samples: &Samples| cycle_frequency(std::slice::from_ref(samples), [0.0, 11.0]);
        assert!((frequency(&flaps()).unwrap() - 2.0).abs() < 0.02);
        let still = Samples::new(vec![0.0, 1.0, 2.0], vec![5.0; 3]).unwrap();
        assert_eq!(frequency(&still), None);
        let stairs: Vec<f64> = (0..1100)
            .map(|i| if [150, 420, 500, 900].iter().any(|at| (0..60).contains(&(i - at))) { 2e4 } else { 0.0 })
            .collect();
        let stairs = Samples::new((0..1100).map(|i| 0.01 * f64::from(i)).collect(), stairs).unwrap();
        assert_eq!(frequency(&stairs), None, "levels at uneven times");
        assert_eq!(cycle_frequency(&[], [0.0, 1.0]), None);
    }

    #[test]
    fn the_interval_of_independent_values_is_the_textbook_one() {
        let values = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
        let [low, high] = interval(&values, 0.0);
        let expected = 2.571 * (6.0_f64 / 5.0 / 6.0).sqrt();
        assert!((high - expected).abs() < 0.01 && (low + expected).abs() < 0.01, "{low} {high}");
        assert!(interval(&values, 1.0)[1] > 1.96);
    }

    #[test]
    fn values_that_follow_each_other_count_as_fewer() {
        // Σ x² = 48 and Σ xᵢ xᵢ₊₁ = 16: correlated by a third, twelve count as six
        let values = [1.0, 3.0, -1.0, 1.0, -1.0, -1.0, 2.0, 2.0, 2.0, -2.0, -3.0, -3.0].map(|x| x + 7.0);
        let [low, high] = interval(&values, 0.0);
        let half = 2.5706 * (48.0_f64 / 11.0 / 6.0).sqrt();
        assert!((high - 7.0 - half).abs() < 1e-3 && (7.0 - low - half).abs() < 1e-3, "{low} {high} {half}");
        let [low, high] = interval(&values, 0.5);
        let both = half.hypot(1.96 * 0.5);
        assert!((0.5 * (high - low) - both).abs() < 1e-3, "{low} {high} {both}");
    }
}
