//! Taking the waves out of a run: beat, waves and drift are fitted together, and only the waves' part is subtracted.
//!
//! Each wave may begin anew at given times (the log's begin, the run's begin, its end); from then on it decays. Because the
//! beat's own harmonics stand in the same fit, they are neither shrunk nor shifted, and what is subtracted holds nothing
//! but sines at the waves' frequencies. A run's begin and end also look a little like waves; so each wave is expected to be about
//! as large as still water showed it, against what a free fit of everything leaves.
//!
//! Stands on: squares. Never knows: what beats.

use si::{Hertz, Second, Series};
use std::f64::consts::TAU;

use super::Wave;
use crate::squares::{self, FitFailed};

/// A regular motion within a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beat {
    /// Hz.
    pub frequency: Hertz,
    /// How many of its harmonics are fitted.
    pub harmonics: usize,
    /// First and last time of it, s.
    pub within: [Second; 2],
}

/// A signal parted.
#[derive(Debug, Clone, PartialEq)]
pub struct Parted {
    /// The signal without the waves.
    pub rest: Series,
    /// The waves, sample by sample.
    pub waves: Vec<f64>,
    /// The drift of the zero (polynomial) sample by sample; still within `rest`.
    pub drift: Vec<f64>,
}

/// Takes `waves`, which begin at times `onsets` (s), out of a signal that holds `beat`; the zero drifts by a polynomial of
/// `degree`.
///
/// # Errors
/// [`FitFailed`] when the columns cannot be told apart.
pub fn remove(
    signal: &Series,
    waves: &[Wave],
    onsets: &[Second],
    beat: Option<Beat>,
    degree: usize,
) -> Result<Parted, FitFailed> {
    let swings: Vec<Vec<f64>> =
        onsets.iter().flat_map(|&t| waves.iter().flat_map(move |w| swing(signal, w, t))).collect();
    let drift = squares::drift(signal.values().len(), degree);
    let beats = beat.map_or(Vec::new(), |b| harmonics(signal, &b));
    let (waving, drifting) = (swings.len(), swings.len() + drift.len());
    let columns = [swings, drift, beats].concat();
    let Some(weights) = weighted(signal, waves, &columns, waving) else {
        let why = "beat, waves and drift look alike over so short a recording".to_owned();
        let remedy = "record for longer, or keep the beat away from the tank's waves";
        return Err(FitFailed { what: "the standing wave in a run", why, remedy });
    };
    let zeros = || vec![0.0; signal.values().len()];
    let part = |range: std::ops::Range<usize>| match range.is_empty() {
        true => zeros(),
        false => squares::sum(&columns[range.clone()], &weights[range]),
    };
    let (waves, drift) = (part(0..waving), part(waving..drifting));
    let rest = signal.values().iter().zip(&waves).map(|(v, w)| v - w).collect();
    let rest = Series::new(signal.start(), signal.rate(), rest).expect("finite less finite");
    Ok(Parted { rest, waves, drift })
}

/// The weights of all columns, the first `waving` of them the waves'.
///
/// A wave's cosine and sine have the spread of its amplitude a; what a free fit leaves, of standard deviation σ, stays alike
/// for a quarter of the wave's period, n samples: n σ²/a² is added to each column's square (the most likely weights).
fn weighted(signal: &Series, waves: &[Wave], columns: &[Vec<f64>], waving: usize) -> Option<Vec<f64>> {
    let fitted = squares::sum(columns, &squares::linear(columns, signal.values())?);
    let square: f64 = signal.values().iter().zip(&fitted).map(|(v, w)| (v - w).powi(2)).sum();
    let variance = square / signal.values().len() as f64;
    let stiff = |i: usize| {
        let wave = &waves[(i / 2) % waves.len()];
        0.25 * signal.rate() / wave.frequency * variance / (wave.amplitude * wave.amplitude).max(1e-12)
    };
    squares::drawn_to_zero(columns, signal.values(), &(0..waving).map(stiff).collect::<Vec<f64>>())
}

/// Cosine and sine of one wave from `onset` on.
fn swing(signal: &Series, wave: &Wave, onset: Second) -> [Vec<f64>; 2] {
    let part = |turn: fn(f64) -> f64| {
        let at = |i: usize| match signal.time(i) - onset {
            since if since < 0.0 => 0.0,
            since => (-wave.decay * since).exp() * turn(TAU * wave.frequency * since),
        };
        (0..signal.values().len()).map(at).collect()
    };
    [part(f64::cos), part(f64::sin)]
}

/// Mean, cosines and sines of the beat while it lasts.
fn harmonics(signal: &Series, beat: &Beat) -> Vec<Vec<f64>> {
    let [first, last] = beat.within;
    let part = |turn: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let at = |i: usize| match signal.time(i) {
            t if (first..=last).contains(&t) => turn(t - first),
            _ => 0.0,
        };
        (0..signal.values().len()).map(at).collect()
    };
    let of = |n: usize| {
        let omega = TAU * beat.frequency * n as f64;
        [part(&|t| (omega * t).cos()), part(&|t| (omega * t).sin())]
    };
    std::iter::once(part(&|_| 1.0)).chain((1..=beat.harmonics).flat_map(of)).collect()
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

    fn waving(t: f64) -> f64 {
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
    fn waves_shrink_by_20_db_and_the_beat_keeps_amplitude_and_phase() {
        let waves = [wave(1.16), wave(1.84)];
        for (seed, beat) in [(1, 1.0), (2, 2.0), (3, 3.0), (4, 4.0)] {
            let mut noise = Noise::new(seed);
            let noisy: Vec<f64> = (0..800).map(|_| 1.5e-3 * noise.normal()).collect();
            let with = series(&|t| beating(t, beat) + waving(t) + noisy[(t * RATE).round() as usize]);
            let b = Beat { frequency: beat, harmonics: 6, within: WITHIN };
            let parted = remove(&with, &waves, &[0.0], Some(b), 1).unwrap();
            let left: Vec<f64> = parted.waves.iter().enumerate().map(|(i, w)| w - waving(i as f64 / RATE)).collect();
            let square = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
            let was: Vec<f64> = (0..800).map(|i| waving(i as f64 / RATE)).collect();
            let decibel = 10.0 * (square(&was) / square(&left)).log10();
            assert!(decibel > 20.0, "beat {beat} Hz: {decibel} dB");
            let pure = series(&|t| beating(t, beat) + noisy[(t * RATE).round() as usize]);
            let ratio = line(parted.rest.values(), beat) / line(pure.values(), beat);
            assert!((ratio.norm() - 1.0).abs() < 0.01 && ratio.arg().abs() < 0.01, "beat {beat} Hz: {ratio}");
        }
    }

    #[test]
    fn a_run_s_begin_is_hardly_taken_for_a_wave() {
        // a slow push at the begin that no harmonic holds, of 50 mN, and no wave at all
        let pushed = series(&|t| beating(t, 2.0) + if t > 1.0 { 0.05 * (-(t - 1.0) / 0.5).exp() } else { 0.0 });
        let b = Beat { frequency: 2.0, harmonics: 6, within: WITHIN };
        let parted = remove(&pushed, &[wave(1.16), wave(1.84)], &[0.0], Some(b), 1).unwrap();
        assert!(parted.waves.iter().all(|w| w.abs() < 3e-3));
    }

    #[test]
    fn a_run_without_waves_is_hardly_touched() {
        let pure = series(&|t| beating(t, 2.0));
        let b = Beat { frequency: 2.0, harmonics: 6, within: WITHIN };
        let parted = remove(&pure, &[wave(1.16)], &[0.0, 1.0], Some(b), 1).unwrap();
        assert!(parted.waves.iter().all(|w| w.abs() < 1e-6));
    }
}
