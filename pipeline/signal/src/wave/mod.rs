//! Standing waves in a tank: natural frequencies, identification in still water, and subtraction from a run.
//!
//! Mode n of a basin of length L and depth h has k = nπ/L and ω² = g k tanh(kh) [lamb1932, section 228]. A free wave is a decaying
//! sine, so it is fitted and only the fit is subtracted. A notch filter would attenuate and delay every component of the signal near
//! the wave's frequency. Paper, section IV, the standing wave.

mod evidence;
mod line_width;
mod remove;

use si::{Hertz, Metre, Series};
use std::f64::consts::{PI, TAU};

use crate::polynomial::{self, EstimationError};
use optimize::levenberg_marquardt::{self, Estimate, Regression};
use optimize::linear;

pub use evidence::Evidence;
pub use line_width::{CloseHarmonic, close_harmonics};
pub use remove::{Beat, Removal, Separated, remove};

/// m/s².
const GRAVITY: f64 = 9.81;
/// A wave is searched for within this share of its expected frequency.
const SEARCH_WIDTH: f64 = 0.15;
/// Degree of the polynomial drift of an amplifier's zero in a recording of ten seconds.
pub(crate) const DRIFT: usize = 4;

/// Frequency (Hz) of a mode (from 1) of a rectangular basin of `length` and `depth` (m).
pub fn natural_frequency(length: Metre, depth: Metre, mode: u32) -> Hertz {
    let k = f64::from(mode) * PI / length;
    (GRAVITY * k * (k * depth).tanh()).sqrt() / TAU
}

/// One identified standing wave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// Hz.
    pub frequency: Hertz,
    /// Its standard deviation, Hz.
    pub frequency_sigma: Hertz,
    /// Decay rate of the amplitude, 1/s.
    pub decay: f64,
    /// Its standard deviation, 1/s.
    pub decay_sigma: f64,
    /// Amplitude at the start of the recording, unit of the signal.
    pub amplitude: f64,
    /// Phase of a cosine at the start of the recording, rad.
    pub phase: f64,
}

impl Wave {
    /// Full width of its line at half power, Hz: decay / π.
    pub fn width(&self) -> Hertz {
        self.decay.abs() / PI
    }
}

/// What is looked for in a recording of still water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StillWater<'a> {
    /// Frequencies that the tank's size gives, Hz.
    pub expected: &'a [Hertz],
    /// Level of significance at which any wave is reported, no unit.
    pub level: f64,
    /// Largest amplitude of a line in water that is still, unit of the signal.
    pub limit: f64,
}

/// Waves identified in a recording of still water.
#[derive(Debug, Clone, PartialEq)]
pub struct WaveFit {
    /// Those that rise over the noise, in the order of the expected frequencies.
    pub waves: Vec<Wave>,
    /// The evidence for each expected wave.
    pub evidence: Vec<Evidence>,
    /// Standard deviation of the residuals, unit of the signal.
    pub noise: f64,
    /// Attenuation of the waves, dB: fitted on every second sample, evaluated on the others.
    pub suppression_db: f64,
}

/// The waves of `signal`, a recording of still water, near the expected frequencies: those that rise over the noise.
///
/// Σ e^(−δt)(A cos ωt + B sin ωt) + drift: ω and δ by Levenberg–Marquardt; A, B and drift are linear and eliminated (variable projection).
///
/// # Errors
/// [`EstimationError`] when the recording is shorter than four periods, the fit does not converge, or something moves in the water: a
/// line is larger than the limit, or does not decay.
pub fn identify(signal: &Series, still: &StillWater) -> Result<WaveFit, EstimationError> {
    let bands = search_bands(signal, still.expected)?;
    is_still(signal, still)?;
    let evidence = evidence::band_evidence(signal, &bands);
    // Bonferroni's correction: the level holds for all waves together.
    let level = still.level / bands.len() as f64;
    let frequencies: Vec<Hertz> = evidence.iter().filter(|e| e.is_found(level)).map(|e| e.frequency).collect();
    if frequencies.is_empty() {
        return Ok(WaveFit { waves: Vec::new(), evidence, noise: noise_about_drift(signal), suppression_db: 0.0 });
    }
    let fit = decaying_fit(signal, &frequencies, evidence)?;
    if let Some(driven) = fit.waves.iter().find(|wave| evidence::is_driven(wave)) {
        let [f, decay, sigma] = [driven.frequency, driven.decay, driven.decay_sigma];
        return Err(motion_error(format!(
            "the line at {f:.3} Hz decays by {decay:.4} ± {sigma:.4} 1/s, as no free wave does"
        )));
    }
    Ok(fit)
}

/// The decaying vibration of `signal` near the frequency `expected` (Hz), of a body that is known to vibrate: nothing is tested.
///
/// # Errors
/// [`EstimationError`] when the recording is shorter than four periods, or the fit does not converge.
pub fn free_vibration(signal: &Series, expected: Hertz) -> Result<WaveFit, EstimationError> {
    let evidence = evidence::band_evidence(signal, &search_bands(signal, &[expected])?);
    decaying_fit(signal, &[evidence[0].frequency], evidence)
}

/// The searched band around each expected frequency (Hz).
fn search_bands(signal: &Series, expected: &[Hertz]) -> Result<Vec<[Hertz; 2]>, EstimationError> {
    let periods = (signal.end() - signal.start()) * expected.iter().copied().fold(f64::INFINITY, f64::min);
    if expected.is_empty() || periods < 4.0 {
        let reason = format!("the recording has {periods:.1} periods of the slowest wave; at least 4 are needed");
        return Err(estimation_error(reason));
    }
    Ok(expected.iter().map(|f| [f * (1.0 - SEARCH_WIDTH), f * (1.0 + SEARCH_WIDTH)]).collect())
}

/// The decaying waves that begin at these frequencies (Hz).
fn decaying_fit(signal: &Series, frequencies: &[Hertz], evidence: Vec<Evidence>) -> Result<WaveFit, EstimationError> {
    let start: Vec<f64> = frequencies.iter().flat_map(|f| [*f, INITIAL_DAMPING * TAU * f]).collect();
    let indices: Vec<usize> = (0..signal.values().len()).collect();
    let (fit, weights) =
        regression_fit(signal, &indices, &start).ok_or_else(|| estimation_error("the fit does not converge".into()))?;
    let wave = |(n, pair): (usize, &[f64])| Wave {
        frequency: fit.at[2 * n],
        frequency_sigma: fit.sigma[2 * n],
        decay: fit.at[2 * n + 1],
        decay_sigma: fit.sigma[2 * n + 1],
        amplitude: pair[0].hypot(pair[1]),
        phase: (-pair[1]).atan2(pair[0]),
    };
    let waves = weights.chunks_exact(2).take(frequencies.len()).enumerate().map(wave).collect();
    Ok(WaveFit { waves, evidence, noise: fit.noise, suppression_db: suppression_db(signal, &fit.at) })
}

/// Standard deviation of a signal about its drift.
fn noise_about_drift(signal: &Series) -> f64 {
    let (values, columns) = (signal.values(), polynomial::basis_columns(signal.values().len(), DRIFT));
    let drift = linear::least_squares(&columns, values).map(|w| linear::weighted_sum(&columns, &w));
    let drift = drift.unwrap_or_else(|| vec![0.0; values.len()]);
    let sum_of_squares: f64 = values.iter().zip(drift).map(|(v, d)| (v - d).powi(2)).sum();
    (sum_of_squares / (values.len() - DRIFT - 1) as f64).sqrt()
}

/// Initial guess of the damping ratio: water in a tank rings for some ten seconds.
const INITIAL_DAMPING: f64 = 0.01;
/// Lines are looked for up to this multiple of the highest expected frequency.
const LINES: f64 = 5.0;

/// Holds that no line is larger than in still water.
fn is_still(signal: &Series, still: &StillWater) -> Result<(), EstimationError> {
    let highest = LINES * still.expected.iter().copied().fold(0.0, f64::max);
    let line = evidence::strongest_line(signal, highest);
    if line.amplitude <= still.limit || line.p_value > still.level {
        return Ok(());
    }
    let (f, amplitude, limit) = (line.frequency, 1e3 * line.amplitude, 1e3 * still.limit);
    Err(motion_error(format!(
        "a line at {f:.2} Hz has an amplitude of {amplitude:.1} mN; in still water it is under {limit:.1} mN"
    )))
}

fn estimation_error(reason: String) -> EstimationError {
    EstimationError {
        what: "the standing wave",
        why: reason,
        action: "record still water for longer, soon after a run",
    }
}

fn motion_error(reason: String) -> EstimationError {
    let action = "name a log of water at rest: this one holds a motion (study.toml, [tank] still_limit)";
    EstimationError { what: "the standing wave", why: reason, action }
}

/// The columns of waves (frequency and decay each) at samples `indices` a signal, then the drift's.
fn fit_columns(signal: &Series, indices: &[usize], waves: &[f64]) -> Vec<Vec<f64>> {
    let elapsed = |i: &usize| signal.time(*i) - signal.start();
    let wave = |pair: &[f64]| {
        let (omega, decay) = (TAU * pair[0], pair[1]);
        let decaying_column = |oscillation: fn(f64) -> f64| {
            indices.iter().map(|i| (-decay * elapsed(i)).exp() * oscillation(omega * elapsed(i))).collect()
        };
        [decaying_column(f64::cos), decaying_column(f64::sin)]
    };
    let drift = polynomial::basis_columns(signal.values().len(), DRIFT);
    let drift = drift.into_iter().map(|column| indices.iter().map(|&i| column[i]).collect());
    waves.chunks_exact(2).flat_map(wave).chain(drift).collect()
}

fn regression_fit(signal: &Series, indices: &[usize], start: &[f64]) -> Option<(Estimate, Vec<f64>)> {
    let target: Vec<f64> = indices.iter().map(|&i| signal.values()[i]).collect();
    let weights = |p: &[f64]| linear::least_squares(&fit_columns(signal, indices, p), &target);
    let residuals = |p: &[f64]| {
        let sum = linear::weighted_sum(&fit_columns(signal, indices, p), &weights(p)?);
        Some(sum.iter().zip(&target).map(|(s, t)| s - t).collect())
    };
    let differences: Vec<f64> = start.iter().map(|p| 1e-5 * p.abs()).collect();
    let eliminated = start.len() + DRIFT + 1;
    let regression = Regression { residuals: &residuals, differences: &differences, eliminated };
    let fit = levenberg_marquardt::fit(&regression, start)?;
    let weights = weights(&fit.at)?;
    Some((fit, weights))
}

/// Attenuation of the waves when the fit of every second sample is subtracted from the others, dB. The difference of the two halves
/// has four times the variance of a fit to all samples, whose error is what the subtraction leaves.
fn suppression_db(signal: &Series, waves: &[f64]) -> f64 {
    let every_second = |odd: usize| (odd..signal.values().len()).step_by(2).collect::<Vec<usize>>();
    let amplitudes = |indices: &[usize], target: &[f64]| {
        let weights = linear::least_squares(&fit_columns(signal, indices, waves), target)?;
        Some(weights[..waves.len()].to_vec())
    };
    let values_at = |indices: &[usize]| indices.iter().map(|&i| signal.values()[i]).collect::<Vec<f64>>();
    let (even, odd) = (every_second(0), every_second(1));
    let (Some(fitted_amplitudes), Some(amplitudes_before)) =
        (amplitudes(&even, &values_at(&even)), amplitudes(&odd, &values_at(&odd)))
    else {
        return 0.0;
    };
    let square = |w: &mut dyn Iterator<Item = f64>| w.map(|v| v * v).sum::<f64>();
    let residual_square = square(&mut amplitudes_before.iter().zip(&fitted_amplitudes).map(|(b, f)| b - f));
    10.0 * (4.0 * square(&mut amplitudes_before.iter().copied()) / residual_square.max(f64::MIN_POSITIVE)).log10()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Noise;

    const STILL: StillWater = StillWater { expected: &[1.2, 1.8], level: 0.005, limit: 0.02 };

    fn recorded(seed: u64) -> Series {
        let mut noise = Noise::new(seed);
        let value = |i: usize, n: &mut Noise| {
            let t = i as f64 / 80.0;
            let wave = |a: f64, f: f64, phase: f64| a * (-0.012 * TAU * f * t).exp() * (TAU * f * t + phase).cos();
            wave(2.5e-3, 1.163, 0.4) + wave(1.8e-3, 1.842, -2.0) + 2e-3 * n.normal() + 0.01 + 0.003 * t
        };
        Series::new(0.0, 80.0, (0..800).map(|i| value(i, &mut noise)).collect()).unwrap()
    }

    #[test]
    fn a_shallow_and_a_deep_basin_have_the_limiting_frequencies() {
        assert!((natural_frequency(10.0, 1e-3, 1) / ((GRAVITY * 1e-3).sqrt() / 20.0) - 1.0).abs() < 1e-6);
        assert!((natural_frequency(0.45, 10.0, 1) / ((GRAVITY * PI / 0.45).sqrt() / TAU) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn waves_in_noise_are_identified_within_their_uncertainty() {
        let mut total = 0.0;
        for seed in 0..10 {
            let found = identify(&recorded(seed), &STILL).unwrap();
            assert!(found.evidence.iter().all(|e| e.p_value < 1e-3), "seed {seed}: {:?}", found.evidence);
            for (wave, (f, a)) in found.waves.iter().zip([(1.163, 2.5e-3), (1.842, 1.8e-3)]) {
                // four standard deviations, of which one in 16 000 is exceeded
                assert!((wave.frequency - f).abs() < 4.0 * wave.frequency_sigma, "seed {seed}: {wave:?}");
                assert!((wave.decay - 0.012 * TAU * f).abs() < 4.0 * wave.decay_sigma, "seed {seed}: {wave:?}");
                // the initial amplitude is known to 12 %: it is correlated with the decay
                assert!((wave.amplitude - a).abs() < 0.36 * a, "seed {seed}: {wave:?}");
            }
            total += found.suppression_db;
        }
        // amplitudes of 2 mN against errors of 0.15 mN each: 20 dB on the mean, a few less or more for a seed
        assert!(total > 200.0, "{} dB", 0.1 * total);
    }

    #[test]
    fn waves_are_found_under_a_strong_drift() {
        let calm = recorded(1);
        let drifting = calm.values().iter().enumerate().map(|(i, v)| v + 1.0 - 0.02 * i as f64).collect();
        let found = identify(&Series::new(0.0, 80.0, drifting).unwrap(), &STILL).unwrap();
        assert!((found.waves[0].frequency - 1.163).abs() < 0.02 && (found.waves[1].frequency - 1.842).abs() < 0.02);
    }

    #[test]
    fn noise_alone_has_no_wave() {
        let mut noise = Noise::new(5);
        let air = Series::new(0.0, 80.0, (0..800).map(|_| 1e-3 * noise.normal()).collect()).unwrap();
        let found = identify(&air, &STILL).unwrap();
        assert!(found.waves.is_empty() && found.suppression_db == 0.0);
        assert!(found.evidence.iter().all(|e| e.p_value > 0.01) && (found.noise - 1e-3).abs() < 1e-4, "{found:?}");
    }

    #[test]
    fn a_log_in_which_something_flaps_is_not_taken_for_still_water() {
        let calm = recorded(1);
        let flapping = |amplitude: f64, f: f64| {
            let value = |(i, v): (usize, &f64)| v + amplitude * (TAU * f * i as f64 / 80.0).sin();
            let values = calm.values().iter().enumerate().map(value).collect();
            identify(&Series::new(0.0, 80.0, values).unwrap(), &STILL).unwrap_err().why
        };
        assert!(flapping(0.1, 2.0).contains("in still water it is under 20.0 mN"));
        assert!(flapping(0.1, 4.0).contains("a line at 4.0"));
        // a small tail that moves as little as water does, at the frequency of a wave
        let said = flapping(0.015, 1.9);
        assert!(said.contains("as no free wave does"), "{said}");
    }

    #[test]
    fn a_recording_of_three_periods_is_refused() {
        let short = Series::new(0.0, 80.0, vec![0.0; 160]).unwrap();
        assert!(identify(&short, &STILL).unwrap_err().why.contains("at least 4"));
    }
}
