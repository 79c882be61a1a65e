//! Subtraction of standing waves from a run: beat, waves and drift are fitted together and only the waves are subtracted.
//!
//! Each wave may start at given times (start of the log, start and end of the run) and decays from there. Because the harmonics of the
//! beat are in the same fit, they are neither attenuated nor delayed. The start and end of a run resemble a wave; so the amplitudes
//! have a prior: as large as in still water, against the residuals of an unconstrained fit.

use si::{Hertz, Second, Series};
use std::f64::consts::TAU;

use super::Wave;
use crate::polynomial::{self, EstimationError};
use optimize::linear;

/// A periodic motion within a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beat {
    /// Hz.
    pub frequency: Hertz,
    /// Number of harmonics that are fitted.
    pub harmonics: usize,
    /// First and last time of it, s.
    pub within: [Second; 2],
}

/// A signal separated into waves and remainder.
#[derive(Debug, Clone, PartialEq)]
pub struct Separated {
    /// The signal without the waves.
    pub rest: Series,
    /// The waves, sample by sample.
    pub waves: Vec<f64>,
    /// The drift of the zero (polynomial) sample by sample; it remains within `rest`.
    pub drift: Vec<f64>,
}

/// What is fitted beside the waves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Removal<'a> {
    /// Times at which every wave may start, s.
    pub onsets: &'a [Second],
    /// The tail beat, if any.
    pub beat: Option<Beat>,
    /// Degree of the polynomial drift of the zero.
    pub drift_degree: usize,
}

/// Subtracts `waves` from a signal.
///
/// # Errors
/// [`EstimationError`] when the columns are linearly dependent.
pub fn remove(signal: &Series, waves: &[Wave], model: &Removal) -> Result<Separated, EstimationError> {
    let Removal { onsets, beat, drift_degree } = *model;
    let wave_columns: Vec<Vec<f64>> =
        onsets.iter().flat_map(|&t| waves.iter().flat_map(move |w| wave_columns_from(signal, w, t))).collect();
    let drift = polynomial::basis_columns(signal.values().len(), drift_degree);
    let harmonic_columns = beat.map_or(Vec::new(), |b| harmonic_columns_of(signal, &b));
    let (wave_count, fixed_count) = (wave_columns.len(), wave_columns.len() + drift.len());
    let columns = [wave_columns, drift, harmonic_columns].concat();
    let Some(weights) = ridge_weights(signal, waves, &columns, wave_count) else {
        let reason = "beat, waves and drift are linearly dependent over so short a recording".to_owned();
        let action = "record for longer, or keep the beat away from the tank's waves";
        return Err(EstimationError { what: "the standing wave in a run", why: reason, action });
    };
    let zeros = || vec![0.0; signal.values().len()];
    let component = |range: std::ops::Range<usize>| match range.is_empty() {
        true => zeros(),
        false => linear::weighted_sum(&columns[range.clone()], &weights[range]),
    };
    let (waves, drift) = (component(0..wave_count), component(wave_count..fixed_count));
    let remainder = signal.values().iter().zip(&waves).map(|(v, w)| v - w).collect();
    let remainder = Series::new(signal.start(), signal.rate(), remainder).expect("finite less finite");
    Ok(Separated { rest: remainder, waves, drift })
}

/// The weights of all columns, the first `wave_count` of them the waves'.
///
/// Maximum a posteriori: the prior deviation of cosine and sine is the wave's amplitude a. The residuals of an unconstrained fit, of
/// standard deviation σ, are taken as correlated over a quarter of the wave's period, n samples; so the penalty is n σ²/a².
fn ridge_weights(signal: &Series, waves: &[Wave], columns: &[Vec<f64>], wave_count: usize) -> Option<Vec<f64>> {
    let fitted = linear::weighted_sum(columns, &linear::least_squares(columns, signal.values())?);
    let sum_of_squares: f64 = signal.values().iter().zip(&fitted).map(|(v, w)| (v - w).powi(2)).sum();
    let variance = sum_of_squares / signal.values().len() as f64;
    let penalty = |i: usize| {
        let wave = &waves[(i / 2) % waves.len()];
        0.25 * signal.rate() / wave.frequency * variance / (wave.amplitude * wave.amplitude).max(1e-12)
    };
    linear::ridge(columns, signal.values(), &(0..wave_count).map(penalty).collect::<Vec<f64>>())
}

/// Cosine and sine of one wave from `onset` on.
fn wave_columns_from(signal: &Series, wave: &Wave, onset: Second) -> [Vec<f64>; 2] {
    let decaying_column = |oscillation: fn(f64) -> f64| {
        let value_at = |i: usize| match signal.time(i) - onset {
            elapsed if elapsed < 0.0 => 0.0,
            elapsed => (-wave.decay * elapsed).exp() * oscillation(TAU * wave.frequency * elapsed),
        };
        (0..signal.values().len()).map(value_at).collect()
    };
    [decaying_column(f64::cos), decaying_column(f64::sin)]
}

/// Mean, cosines and sines of the beat while it lasts.
fn harmonic_columns_of(signal: &Series, beat: &Beat) -> Vec<Vec<f64>> {
    let [first, last] = beat.within;
    let windowed_column = |oscillation: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let value_at = |i: usize| match signal.time(i) {
            t if (first..=last).contains(&t) => oscillation(t - first),
            _ => 0.0,
        };
        (0..signal.values().len()).map(value_at).collect()
    };
    let harmonic_pair = |n: usize| {
        let omega = TAU * beat.frequency * n as f64;
        [windowed_column(&|t| (omega * t).cos()), windowed_column(&|t| (omega * t).sin())]
    };
    // The beat's mean has a column of its own: the step of mean thrust at the begin and end of a run would otherwise go
    // into drift and waves.
    std::iter::once(windowed_column(&|_| 1.0)).chain((1..=beat.harmonics).flat_map(harmonic_pair)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum;
    use crate::testing::Noise;

    const RATE: f64 = 80.0;
    const WITHIN: [f64; 2] = [1.0, 8.5];

    fn wave(frequency: f64) -> Wave {
        let (frequency_sigma, decay_sigma, amplitude, phase) = (1e-3, 1e-2, 3e-3, 0.0);
        Wave { frequency, frequency_sigma, decay: 0.0754 * frequency, decay_sigma, amplitude, phase }
    }

    fn beating(t: f64, beat: f64) -> f64 {
        let angle = TAU * beat * (t - WITHIN[0]);
        if (WITHIN[0]..=WITHIN[1]).contains(&t) {
            0.05 + 0.1 * angle.sin() + 0.03 * (2.0 * angle + 0.5).cos()
        } else {
            0.0
        }
    }

    fn wave_count(t: f64) -> f64 {
        let one = |a: f64, f: f64, p: f64| a * (-0.0754 * f * t).exp() * (TAU * f * t + p).cos();
        one(3e-3, 1.16, 0.7) + one(2e-3, 1.84, -1.0)
    }

    fn series(value: &dyn Fn(f64) -> f64) -> Series {
        Series::new(0.0, RATE, (0..800).map(|i| value(i as f64 / RATE)).collect()).unwrap()
    }

    fn line(values: &[f64], frequency: f64) -> spectrum::Phasor {
        // over whole beats of the run: from 1.0 s to 8.0 s
        spectrum::at(&values[80..640], 1.0, RATE, frequency)
    }

    #[test]
    fn waves_are_attenuated_by_20_db_and_the_beat_keeps_amplitude_and_phase() {
        let waves = [wave(1.16), wave(1.84)];
        for (seed, beat) in [(1, 1.0), (2, 2.0), (3, 3.0), (4, 4.0)] {
            let mut noise = Noise::new(seed);
            let noisy: Vec<f64> = (0..800).map(|_| 1.5e-3 * noise.normal()).collect();
            let with = series(&|t| beating(t, beat) + wave_count(t) + noisy[(t * RATE).round() as usize]);
            let b = Beat { frequency: beat, harmonics: 6, within: WITHIN };
            let separated = remove(&with, &waves, &Removal { onsets: &[0.0], beat: Some(b), drift_degree: 1 }).unwrap();
            let left: Vec<f64> =
                separated.waves.iter().enumerate().map(|(i, w)| w - wave_count(i as f64 / RATE)).collect();
            let square = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
            let was: Vec<f64> = (0..800).map(|i| wave_count(i as f64 / RATE)).collect();
            let decibel = 10.0 * (square(&was) / square(&left)).log10();
            assert!(decibel > 20.0, "beat {beat} Hz: {decibel} dB");
            let pure = series(&|t| beating(t, beat) + noisy[(t * RATE).round() as usize]);
            let ratio = line(separated.rest.values(), beat) / line(pure.values(), beat);
            assert!((ratio.norm() - 1.0).abs() < 0.01 && ratio.arg().abs() < 0.01, "beat {beat} Hz: {ratio}");
        }
    }

    #[test]
    fn the_start_of_a_run_is_hardly_taken_for_a_wave() {
        // a slow push at the begin that no harmonic holds, of 50 mN, and no wave at all
        let pushed = series(&|t| beating(t, 2.0) + if t > 1.0 { 0.05 * (-(t - 1.0) / 0.5).exp() } else { 0.0 });
        let b = Beat { frequency: 2.0, harmonics: 6, within: WITHIN };
        let separated =
            remove(&pushed, &[wave(1.16), wave(1.84)], &Removal { onsets: &[0.0], beat: Some(b), drift_degree: 1 })
                .unwrap();
        assert!(separated.waves.iter().all(|w| w.abs() < 3e-3));
    }

    #[test]
    fn a_run_without_waves_is_hardly_changed() {
        let pure = series(&|t| beating(t, 2.0));
        let b = Beat { frequency: 2.0, harmonics: 6, within: WITHIN };
        let separated =
            remove(&pure, &[wave(1.16)], &Removal { onsets: &[0.0, 1.0], beat: Some(b), drift_degree: 1 }).unwrap();
        assert!(separated.waves.iter().all(|w| w.abs() < 1e-6));
    }
}
