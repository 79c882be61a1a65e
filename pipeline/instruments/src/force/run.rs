//! The mean force of a run over whole cycles, with its interval.
//!
//! Waves, the drift of the zero and the static cross-talk of pressure are subtracted; each cycle gives one mean. Cycles follow each other
//! with correlation, so that their number counts as n (1 − ρ)/(1 + ρ); the interval is Student's, with the uncertainties of the zero and of the
//! cross-talk.

use si::{Hertz, Newton, Second, Series};
use signal::crosstalk::CrossTalk;
use signal::resample::Samples;
use signal::wave::{self, Beat, Removal, Separated, Wave};
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
pub(super) fn evaluate_run(
    recording: &Recording,
    log: &Recorded,
    corrections: &Corrections,
    settings: &Settings,
) -> Result<Run> {
    let frequency = recording.frequency.unwrap_or(1.0);
    check_rate(recording, log.force.rate())?;
    let [first, last] = run_interval(recording, log)?;
    check_frequency(recording, &log.pressures, [first, last])?;
    // A harmonic at half the sampling rate or beyond is another's alias.
    let resolved = (0.5 * log.force.rate() / frequency * (1.0 - 1e-9)) as usize;
    let beat = Beat { frequency, harmonics: settings.harmonics.min(resolved), within: [first, last] };
    let separated = separate_waves(recording, log, &corrections.waves, beat)?;
    let ZeroLine { values: zero, sigma, change } =
        Zero { moves: [first, last], settling: settings.settling_time }.of(&separated.rest);
    let talk = corrections.talk.as_ref();
    let [level, force] = corrected_series(log, (&separated.rest, &zero), talk)?;
    let start = first + settings.settling_cycles / frequency;
    let cycles = whole_cycles(recording, (last - start) * frequency)?;
    let means_of = |signal: &Series| cycle_means(signal, start, (frequency, cycles));
    let (means, raw) = (means_of(&force), mean_value(&means_of(&level)));
    let crosstalk = talk.map(|_| raw - mean_value(&means));
    let common_sigma = sigma.hypot(talk.map_or(0.0, |talk| talk_sigma(talk, crosstalk.unwrap_or(0.0))));
    let close = wave::close_harmonics(frequency, 4, &corrections.waves, log.force.end() - log.force.start());
    Ok(Run {
        id: recording.id.clone(),
        frequency,
        within: [start, start + cycles as f64 / frequency],
        cycles,
        raw,
        crosstalk,
        mean: mean_value(&means),
        interval: mean_interval(&means, common_sigma),
        drift: change,
        waves: separated.waves.iter().fold(0.0, |largest: f64, w| largest.max(w.abs())),
        warnings: close.iter().map(ToString::to_string).collect(),
        force,
    })
}

/// First and last time of the run within its log, s.
fn run_interval(recording: &Recording, log: &Recorded) -> Result<[Second; 2]> {
    let [first, last] = recording.seconds.or_else(|| log.pressed_interval()).ok_or_else(|| no_pressure(recording))?;
    let missing = (log.force.start() - first).max(last - log.force.end());
    // Less than a cycle is cut off anyway; of fewer cycles than named the mean is another. A pressure log may go on after the cell's.
    if recording.seconds.is_some() && missing * recording.frequency.unwrap_or(1.0) > 1.0 {
        return Err(outside_log(recording, log));
    }
    let first = first.max(log.force.start());
    let last = last.min(log.force.end());
    if first >= last { Err(outside_log(recording, log)) } else { Ok([first, last]) }
}

/// The waves of a run, and the rest of its log, in which the `beat` stays.
fn separate_waves(recording: &Recording, log: &Recorded, waves: &[Wave], beat: Beat) -> Result<Separated> {
    let removal = Removal { onsets: &[log.force.start()], beat: Some(beat), drift_degree: 2 };
    wave::remove(&log.force, waves, &removal).map_err(|e| Diagnostic::from(e).while_doing(&recording.id))
}

/// The whole cycles of some that have begun, enough for an interval.
fn whole_cycles(recording: &Recording, begun: f64) -> Result<usize> {
    let cycles = (begun + 1e-6).floor().max(0.0) as usize;
    if cycles < FEWEST { Err(too_short(recording, cycles)) } else { Ok(cycles) }
}

/// The force without waves (`rest`, N) less its zero, and less the cross-talk too.
fn corrected_series(log: &Recorded, (rest, zero): (&Series, &[f64]), talk: Option<&CrossTalk>) -> Result<[Series; 2]> {
    let crosstalk_at = |i: usize| talk.map_or(0.0, |talk| talk.of(&log.pressures, log.force.time(i)));
    let series = |value: &dyn Fn(usize) -> f64| {
        let values = (0..log.force.values().len()).map(value).collect();
        Series::new(log.force.start(), log.force.rate(), values)
    };
    let level = series(&|i| rest.values()[i] - zero[i])?;
    let force = series(&|i| level.values()[i] - crosstalk_at(i))?;
    Ok([level, force])
}

/// Standard deviation of a mean cross-talk, N: the curve is uncertain by its noise at the last knot, and in proportion
/// below.
fn talk_sigma(talk: &CrossTalk, crosstalk: Newton) -> Newton {
    talk.sigma * crosstalk / talk.forces.last().copied().unwrap_or(1.0).max(1e-9)
}

/// Share by which the frequency on the page and that of the pressures may differ: over a run the cut of cycles stays within a tenth of one.
const FREQUENCY: f64 = 0.05;

/// Compares the frequency on the page with that of the pressures beside it.
fn check_frequency(recording: &Recording, pressures: &[Samples], within: [Second; 2]) -> Result<()> {
    let (Some(declared), Some(measured)) = (recording.frequency, cycle_frequency(pressures, within)) else {
        return Ok(());
    };
    if (declared / measured - 1.0).abs() <= FREQUENCY {
        return Ok(());
    }
    let defect = format!(
        "recording `{}` has frequency = {declared} Hz, and its pressures repeat at {measured:.3} Hz",
        recording.id
    );
    let reason = format!("means are taken over whole cycles; the two may differ by {:.0} %", 100.0 * FREQUENCY);
    Err(Diagnostic::new(defect, reason, format!("set frequency = {measured:.3}, or name the pressure log of this run")))
}

/// Rises of a pressure that show a frequency, at least.
const RISES: usize = 2;

/// The frequency of the pressure that swings most, Hz, by the times at which it rises through the middle of its range; none where it rises too rarely or
/// unevenly.
fn cycle_frequency(pressures: &[Samples], [first, last]: [Second; 2]) -> Option<Hertz> {
    let span = |samples: &&Samples| {
        let fold = |extremum: fn(f64, f64) -> f64| samples.values().iter().copied().reduce(extremum);
        fold(f64::max).zip(fold(f64::min)).map_or(0.0, |(high, low)| high - low)
    };
    let strongest = pressures.iter().max_by(|a, b| span(a).total_cmp(&span(b)))?;
    let low = strongest.values().iter().copied().reduce(f64::min)?;
    // a rise counts from a third to two thirds of the range: noise about one level is none
    let (third, mut is_low, mut rises) = (span(&strongest) / 3.0, false, Vec::new());
    // length: a time for each value
    for (time, value) in strongest.times().iter().zip(strongest.values()) {
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

/// Samples of a cycle, at least: with fewer, whole cycles have no mean.
const SAMPLES: f64 = 2.0;

/// Refuses a log that samples a cycle too rarely: a clock in another unit than the card says looks so.
fn check_rate(recording: &Recording, rate: Hertz) -> Result<()> {
    let frequency = recording.frequency.unwrap_or_default();
    if rate >= SAMPLES * frequency {
        return Ok(());
    }
    let defect =
        format!("recording `{}` flaps at {frequency} Hz, and its force has {rate:.4} samples a second", recording.id);
    let action = "set the unit of time_s in [[log.columns]], correct its frequency, or log the force faster";
    Err(Diagnostic::new(defect, format!("a mean over cycles needs {SAMPLES} samples in each"), action))
}

fn no_pressure(recording: &Recording) -> Diagnostic {
    let defect = format!("in recording `{}` no pressure rises", recording.id);
    Diagnostic::new(
        defect,
        "a run lasts while a pressure does",
        "name its seconds on the page, or its own pressure log",
    )
}

fn outside_log(recording: &Recording, log: &Recorded) -> Diagnostic {
    let defect = format!("recording `{}` has no force for a part of its run", recording.id);
    let reason = format!("its log of the force lasts from {:.3} to {:.3} s", log.force.start(), log.force.end());
    Diagnostic::new(defect, reason, "correct `seconds`, or name the logs of one run")
}

fn too_short(recording: &Recording, cycles: usize) -> Diagnostic {
    let defect = format!("recording `{}` has {cycles} whole cycles", recording.id);
    Diagnostic::new(
        defect,
        format!("an interval needs {FEWEST}, behind the settling cycles"),
        "record for longer, or correct its frequency",
    )
}

/// The mean of each of so many cycles from `start` (s) on.
fn cycle_means(signal: &Series, start: Second, (frequency, cycles): (Hertz, usize)) -> Vec<f64> {
    let sample_time = |k: usize, part: usize| start + (k as f64 + (part as f64 + 0.5) / PARTS as f64) / frequency;
    let cycle_mean = |k: usize| (0..PARTS).map(|part| signal.at(sample_time(k, part))).sum::<f64>() / PARTS as f64;
    (0..cycles).map(cycle_mean).collect()
}

fn mean_value(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The 95 % interval of the mean of correlated values, with the standard deviation of what all have in common.
fn mean_interval(values: &[f64], common_sigma: f64) -> [f64; 2] {
    let (count, mean) = (values.len() as f64, mean_value(values));
    let deviations: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let sum_of_squares: f64 = deviations.iter().map(|v| v * v).sum();
    let lagged_products: f64 = deviations.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let correlation = (lagged_products / sum_of_squares.max(f64::MIN_POSITIVE)).clamp(0.0, 0.9);
    let independent = (count * (1.0 - correlation) / (1.0 + correlation)).max(2.0);
    let half_width = student_quantile(independent - 1.0) * (sum_of_squares / (count - 1.0) / independent).sqrt();
    let half_width = half_width.hypot(1.96 * common_sigma);
    [mean - half_width, mean + half_width]
}

/// The 0.975 quantile of Student's t, by the expansion in 1/ν \[abramowitz1964, 26.7.5\]: 11 % low at ν = 1, 0.8 % at 2, 0.01 % from 5 on.
fn student_quantile(degrees: f64) -> f64 {
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
            assert!(
                (student_quantile(degrees) / truth - 1.0).abs() < within,
                "{degrees}: {}",
                student_quantile(degrees)
            );
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
        let [low, high] = mean_interval(&values, 0.0);
        let expected = 2.571 * (6.0_f64 / 5.0 / 6.0).sqrt();
        assert!((high - expected).abs() < 0.01 && (low + expected).abs() < 0.01, "{low} {high}");
        assert!(mean_interval(&values, 1.0)[1] > 1.96);
    }

    #[test]
    fn values_that_follow_each_other_count_as_fewer() {
        // Σ x² = 48 and Σ xᵢ xᵢ₊₁ = 16: correlated by a third, twelve count as six
        let values = [1.0, 3.0, -1.0, 1.0, -1.0, -1.0, 2.0, 2.0, 2.0, -2.0, -3.0, -3.0].map(|x| x + 7.0);
        let [low, high] = mean_interval(&values, 0.0);
        let half = 2.5706 * (48.0_f64 / 11.0 / 6.0).sqrt();
        assert!((high - 7.0 - half).abs() < 1e-3 && (7.0 - low - half).abs() < 1e-3, "{low} {high} {half}");
        let [low, high] = mean_interval(&values, 0.5);
        let both = half.hypot(1.96 * 0.5);
        assert!((0.5 * (high - low) - both).abs() < 1e-3, "{low} {high} {both}");
    }
}
