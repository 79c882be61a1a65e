//! Transfer function of the fixture from hammer taps, in the frequency domain with coherence and in the time domain.
//!
//! Frequency: Yᵢ(f) = g H(f) Xᵢ(f) of all taps i together, white noise in Y (so each frequency counts by |X|²).
//! Time: the simulated response to the hammer's force at the cell's own samples, plus a polynomial drift of the zero.

use si::{Hertz, Second, Series};

use super::Cell;
use crate::polynomial::{self, EstimationError};
use crate::spectrum::{self, Phasor};
use optimize::levenberg_marquardt::{self, Estimate as Fit, Regression};
use optimize::linear;

/// A tap begins where the hammer's force exceeds this share of its maximum.
const TAP: f64 = 0.2;
/// Least time between two taps, s.
const APART: Second = 0.5;
/// Time before a tap that its window includes, s.
const BEFORE: Second = 0.05;
/// Degree of the drift of the zero through a whole recording.
const DRIFT: usize = 5;
/// Least time that both logs must last after a tap begins, s: a fixture of 5 Hz then still has one period to ring.
const LEAST: Second = 0.2;
/// Frequency step of the response, Hz.
const STEP: Hertz = 0.25;

/// The measured response at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrequencyResponse {
    /// Hz.
    pub frequency: Hertz,
    /// Σ Y X* / Σ |X|² over the taps; no unit.
    pub transfer: Phasor,
    /// |Σ Y X*|² / (Σ |X|² Σ |Y|²), 0 to 1.
    pub coherence: f64,
}

/// A fixture as estimated in one domain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The fixture.
    pub cell: Cell,
    /// Standard deviation of the natural frequency, Hz.
    pub frequency_sigma: Hertz,
    /// Standard deviation of the damping ratio.
    pub damping_sigma: f64,
    /// Cell's newtons for a newton of the hammer's.
    pub gain: f64,
}

/// Result of a tap test.
#[derive(Debug, Clone, PartialEq)]
pub struct TapTest {
    /// From the time domain, where the noise is white: the one to use.
    pub in_time: Estimate,
    /// From the frequency domain.
    pub in_frequency: Estimate,
    /// The measured response, rising in frequency.
    pub response: Vec<FrequencyResponse>,
    /// Number of taps.
    pub taps: usize,
    /// Standard deviation of the log before the first tap about a line, or of the residuals where that is too short, N.
    pub noise: f64,
}

/// The fixture from the force of a hammer and the force that the cell measured, both in N and on one clock, between `low` and
/// `high` (Hz).
///
/// # Errors
/// [`EstimationError`] when there is no tap, the response has no peak in the band, or a fit does not converge.
pub fn identify_from_taps(
    hammer: &Series,
    measured: &Series,
    [low, high]: [Hertz; 2],
) -> Result<TapTest, EstimationError> {
    let starts = tap_starts(hammer);
    check_overlap(hammer, measured, &starts)?;
    let nyquist = 0.5 * measured.rate();
    if starts.is_empty() {
        return Err(estimation_error("no tap was found in the hammer's log".into()));
    }
    if !(0.0 < low && low < high && high < nyquist) {
        return Err(rate_error([low, high], measured.rate()));
    }
    let frequencies: Vec<Hertz> = (0..).map(|i| low + STEP * f64::from(i)).take_while(|f| *f <= high).collect();
    let pairs = tap_transforms(hammer, measured, &starts, &frequencies);
    let response = frequency_responses(&frequencies, &pairs);
    // Initial guess: at resonance |H| ≈ 1/(2ζ).
    let peak = response.iter().max_by(|a, b| a.transfer.norm().total_cmp(&b.transfer.norm()));
    let peak = peak.ok_or_else(|| estimation_error("the band contains no frequency".into()))?;
    let start = [peak.frequency, (0.5 / peak.transfer.norm()).clamp(5e-3, 0.3), 1.0];
    let in_frequency = fit_in_frequency(&frequencies, &pairs, &start).ok_or_else(|| convergence_error("frequency"))?;
    let start = [in_frequency.cell.natural_frequency, in_frequency.cell.damping_ratio, 1.0];
    let (in_time, noise) = fit_in_time(hammer, measured, &start).ok_or_else(|| convergence_error("time"))?;
    // Nothing rings before the first tap; the residuals of the fit hold what the model leaves of the ringing as well.
    let noise = noise_before(measured, starts[0]).unwrap_or(noise);
    Ok(TapTest { in_time, in_frequency, response, taps: starts.len(), noise })
}

/// Holds that both logs cover every tap, from before it begins until its ringing can be seen.
fn check_overlap(hammer: &Series, measured: &Series, starts: &[Second]) -> Result<(), EstimationError> {
    let (Some(first), Some(last)) = (starts.first(), starts.last()) else { return Ok(()) };
    let (start, end) = (hammer.start().max(measured.start()), hammer.end().min(measured.end()));
    let overlap_error = |number: usize, time: f64| {
        estimation_error(format!(
            "tap {number} begins at {time:.3} s; the logs overlap from {start:.3} to {end:.3} s, and a tap needs {LEAST} s"
        ))
    };
    match () {
        () if *first < start => Err(overlap_error(1, *first)),
        () if last + LEAST > end => Err(overlap_error(starts.len(), *last)),
        () => Ok(()),
    }
}

fn estimation_error(reason: String) -> EstimationError {
    EstimationError {
        what: "the load cell's fixture",
        why: reason,
        action: "tap the fixture five times, two seconds apart, and record both logs on one clock",
    }
}

/// A band that the cell's log does not resolve.
fn rate_error([low, high]: [Hertz; 2], rate: Hertz) -> EstimationError {
    EstimationError {
        what: "the load cell's fixture",
        why: format!(
            "the cell was sampled at {rate:.2} Hz, which resolves frequencies under {:.2} Hz; the band is {low} to {high} Hz",
            0.5 * rate
        ),
        action: "record the taps at the amplifier's fast setting (80 Hz or more), or set [load_cell] band below that in study.toml",
    }
}

fn convergence_error(domain: &str) -> EstimationError {
    estimation_error(format!("the fit in the {domain} domain does not converge"))
}

/// Standard deviation of a log about a line until shortly before `first_tap` (s); none of fewer than 20 samples.
fn noise_before(measured: &Series, first_tap: Second) -> Option<f64> {
    let count = ((first_tap - BEFORE - measured.start()) * measured.rate()).max(0.0) as usize;
    let values = measured.values().get(..count).filter(|v| v.len() >= 20)?;
    let line = polynomial::basis_columns(count, 1);
    let trend = linear::weighted_sum(&line, &linear::least_squares(&line, values)?);
    let sum_of_squares: f64 = values.iter().zip(trend).map(|(v, f)| (v - f).powi(2)).sum();
    Some((sum_of_squares / (count - 2) as f64).sqrt())
}

/// When each tap begins, s.
fn tap_starts(hammer: &Series) -> Vec<Second> {
    let peak_force = hammer.values().iter().copied().fold(0.0, f64::max);
    let mut starts: Vec<Second> = Vec::new();
    for (i, force) in hammer.values().iter().enumerate() {
        let is_new = starts.last().is_none_or(|last| hammer.time(i) - last > APART);
        if *force > TAP * peak_force && peak_force > 0.0 && is_new {
            starts.push(hammer.time(i));
        }
    }
    starts
}

/// X and Y of each tap at each frequency, from a tap's begin to the next one's: taps × frequencies.
fn tap_transforms(
    hammer: &Series,
    measured: &Series,
    starts: &[Second],
    frequencies: &[Hertz],
) -> Vec<Vec<[Phasor; 2]>> {
    let shortest = starts.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    let length = shortest.min(measured.end() - starts[starts.len() - 1]).min(4.0) - BEFORE;
    let transforms_of = |start: &Second| {
        let (x, y) = (tap_window(hammer, start - BEFORE, length), tap_window(measured, start - BEFORE, length));
        let transform_pair = |f: &Hertz| [&x, &y].map(|s| spectrum::at(s.values(), s.start() - start, s.rate(), *f));
        frequencies.iter().map(transform_pair).collect()
    };
    starts.iter().map(transforms_of).collect()
}

/// A piece of a series less the mean of its last fifth, where the ringing has decayed.
fn tap_window(series: &Series, start: Second, length: Second) -> Series {
    let index =
        |t: Second| (((t - series.start()) * series.rate()).ceil().max(0.0) as usize).min(series.values().len() - 1);
    let (first, last) = (index(start), index(start + length));
    let values = &series.values()[first..=last];
    let tail = &values[values.len() - values.len().div_ceil(5)..];
    let rest_value = tail.iter().sum::<f64>() / tail.len() as f64;
    // The amplifier's zero must go: a constant cut to the window leaks into every frequency. The mean over the whole
    // window would hold a part of the tap.
    let values = values.iter().map(|v| v - rest_value).collect();
    Series::new(series.time(first), series.rate(), values).expect("finite values less a finite mean")
}

fn frequency_responses(frequencies: &[Hertz], pairs: &[Vec<[Phasor; 2]>]) -> Vec<FrequencyResponse> {
    let response_at = |(k, &frequency): (usize, &Hertz)| {
        // The estimator H₁: the noise is in Y. The alternative Σ |Y|²/Σ X Y* would count its power into the response,
        // the more so away from the peak.
        let cross: Phasor = pairs.iter().map(|tap| tap[k][1] * tap[k][0].conj()).sum();
        let [xx, yy] = [0, 1].map(|channel| pairs.iter().map(|tap| tap[k][channel].norm_sqr()).sum::<f64>());
        FrequencyResponse { frequency, transfer: cross / xx, coherence: cross.norm_sqr() / (xx * yy) }
    };
    frequencies.iter().enumerate().map(response_at).collect()
}

fn cell_estimate(fit: &Fit) -> Estimate {
    let cell = Cell { natural_frequency: fit.at[0], damping_ratio: fit.at[1] };
    Estimate { cell, frequency_sigma: fit.sigma[0], damping_sigma: fit.sigma[1], gain: fit.at[2] }
}

/// Half widths of the central differences by frequency (Hz), damping ratio and gain.
const DIFFERENCES: [f64; 3] = [1e-4, 1e-6, 1e-5];

fn cell_of(p: &[f64]) -> Option<Cell> {
    let plausible = p[0] > 0.0 && p[1] > 0.0 && p[1] < 0.9;
    plausible.then_some(Cell { natural_frequency: p[0], damping_ratio: p[1] })
}

fn fit_in_frequency(frequencies: &[Hertz], pairs: &[Vec<[Phasor; 2]>], start: &[f64; 3]) -> Option<Estimate> {
    let residuals = |p: &[f64]| {
        let cell = cell_of(p)?;
        let transfer: Vec<Phasor> = frequencies.iter().map(|f| p[2] * cell.transfer(*f)).collect();
        let errors = pairs.iter().flat_map(|tap| tap.iter().zip(&transfer).map(|([x, y], h)| h * x - y));
        Some(errors.flat_map(|d| [d.re, d.im]).collect())
    };
    let regression = Regression { residuals: &residuals, differences: &DIFFERENCES, eliminated: 0 };
    levenberg_marquardt::fit(&regression, start).map(|fit| cell_estimate(&fit))
}

fn fit_in_time(hammer: &Series, measured: &Series, start: &[f64; 3]) -> Option<(Estimate, f64)> {
    let times: Vec<Second> = (0..measured.values().len()).map(|i| measured.time(i)).collect();
    let drift = polynomial::basis_columns(times.len(), DRIFT);
    // The drift is linear in its coefficients and is eliminated inside of the residuals (variable projection): three parameters are left.
    let residuals = |p: &[f64]| {
        let simulated = cell_of(p)?.simulate(hammer, &times);
        let unexplained: Vec<f64> = simulated.iter().zip(measured.values()).map(|(r, f)| f - p[2] * r).collect();
        let zero = linear::weighted_sum(&drift, &linear::least_squares(&drift, &unexplained)?);
        Some(unexplained.iter().zip(zero).map(|(o, z)| o - z).collect())
    };
    let regression = Regression { residuals: &residuals, differences: &DIFFERENCES, eliminated: DRIFT + 1 };
    let fit = levenberg_marquardt::fit(&regression, start)?;
    Some((cell_estimate(&fit), fit.noise))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Noise;
    use std::f64::consts::PI;

    /// Six half-sines of 6 ms and 3 to 6 N, and what a cell at 80 Hz measures of them with noise at `decibel` under its ring.
    fn tapped(cell: Cell, decibel: f64, seed: u64) -> (Series, Series) {
        let mut noise = Noise::new(seed);
        let taps: Vec<(f64, f64)> =
            (1..=6).map(|i| (2.0 * f64::from(i) + 0.1 * noise.unit(), 3.0 + 3.0 * noise.unit())).collect();
        let force = |t: f64| {
            taps.iter()
                .filter(|(b, _)| (0.0..6e-3).contains(&(t - b)))
                .map(|(b, p)| p * (PI * (t - b) / 6e-3).sin())
                .sum()
        };
        // four times as fine as the hammer's log: the response is not simulated from the log itself
        let fine = Series::new(0.0, 4000.0, (0..56_000).map(|i| force(f64::from(i) / 4000.0)).collect()).unwrap();
        let times: Vec<f64> = (0..1120).map(|i| f64::from(i) / 80.0).collect();
        let clean = cell.simulate(&fine, &times);
        let rms = (clean.iter().map(|v| v * v).sum::<f64>() / clean.len() as f64).sqrt();
        let sigma = rms * 10f64.powf(-decibel / 20.0);
        let measured = clean.iter().zip(&times).map(|(v, t)| v + 0.01 + 2e-3 * t + sigma * noise.normal()).collect();
        let hammer = (0..14_000).map(|i| force(f64::from(i) * 1e-3)).collect();
        (Series::new(0.0, 1000.0, hammer).unwrap(), Series::new(0.0, 80.0, measured).unwrap())
    }

    #[test]
    fn frequency_and_damping_are_recovered_at_40_decibel_over_a_hundred_seeds() {
        let (mut worst, mut outside) = ([0.0_f64; 4], 0);
        for seed in 0..100 {
            let mut draw = Noise::new(seed + 1000);
            let cell = Cell { natural_frequency: 12.0 + 5.0 * draw.unit(), damping_ratio: 0.02 + 0.02 * draw.unit() };
            let (hammer, measured) = tapped(cell, 40.0, seed);
            let found = identify_from_taps(&hammer, &measured, [3.0, 30.0]).unwrap();
            for (i, it) in [found.in_time, found.in_frequency].iter().enumerate() {
                let frequency = (it.cell.natural_frequency / cell.natural_frequency - 1.0).abs();
                let damping = (it.cell.damping_ratio / cell.damping_ratio - 1.0).abs();
                worst[2 * i] = worst[2 * i].max(frequency);
                worst[2 * i + 1] = worst[2 * i + 1].max(damping);
            }
            let off = (found.in_time.cell.natural_frequency - cell.natural_frequency).abs();
            outside += usize::from(off > 3.0 * found.in_time.frequency_sigma + 1e-3);
        }
        assert!(worst[0] < 0.005 && worst[2] < 0.005, "frequencies in time and frequency: {worst:?}");
        assert!(worst[1] < 0.05 && worst[3] < 0.05, "damping in time and frequency: {worst:?}");
        // 0.3 % lie beyond three standard deviations; a millihertz is what half-sines between samples of 1 ms cost
        assert!(outside <= 3, "{outside} of 100 beyond three standard deviations");
    }

    #[test]
    fn coherence_is_near_one_at_resonance_and_falls_with_noise() {
        let cell = Cell { natural_frequency: 14.0, damping_ratio: 0.03 };
        let at_peak = |decibel: f64| {
            let (hammer, measured) = tapped(cell, decibel, 5);
            let found = identify_from_taps(&hammer, &measured, [3.0, 30.0]).unwrap();
            found.response.iter().find(|r| r.frequency == 14.0).unwrap().coherence
        };
        let (hammer, measured) = tapped(cell, 40.0, 5);
        let found = identify_from_taps(&hammer, &measured, [3.0, 30.0]).unwrap();
        let ring = measured.values().iter().map(|v| v * v).sum::<f64>() / measured.values().len() as f64;
        // 40 dB under the ring; 150 samples give a standard deviation to 6 %
        assert!((found.noise / (0.01 * ring.sqrt()) - 1.0).abs() < 0.25, "{}", found.noise);
        assert!(at_peak(60.0) > 0.999 && at_peak(0.0) < at_peak(60.0));
    }

    #[test]
    fn a_cell_rings_with_a_frequency_and_a_damping_below_the_critical_one() {
        let plausible = |frequency: f64, damping: f64| cell_of(&[frequency, damping, 1.0]).is_some();
        assert!(plausible(15.0, 0.03));
        assert!([(-15.0, 0.03), (15.0, -0.03), (15.0, 0.95)].iter().all(|&(f, d)| !plausible(f, d)));
    }

    #[test]
    fn a_log_without_a_tap_is_refused() {
        let none = Series::new(0.0, 100.0, vec![0.0; 100]).unwrap();
        assert!(identify_from_taps(&none, &none, [3.0, 30.0]).unwrap_err().why.starts_with("no tap"));
    }

    #[test]
    fn a_cell_that_is_too_slow_for_the_band_is_refused_by_its_rate() {
        let (hammer, measured) = tapped(Cell { natural_frequency: 14.0, damping_ratio: 0.03 }, 40.0, 5);
        let slow = (0..140).map(|i| measured.at(f64::from(i) / 10.47)).collect();
        let error = identify_from_taps(&hammer, &Series::new(0.0, 10.47, slow).unwrap(), [3.0, 30.0]).unwrap_err();
        assert!(error.why.contains("sampled at 10.47 Hz") && !error.why.contains("taps"), "{}", error.why);
        assert!(error.action.contains("80 Hz or more"));
    }
}
