//! Zero-phase low-pass filtering: a Butterworth filter run forwards and backwards.
//!
//! Second-order sections; the ends are continued by point reflection; each pass starts in the steady state of its first value: the
//! conventions of SciPy's `sosfiltfilt`, so that numbers can be compared.

use si::{Hertz, Series};
use std::f64::consts::PI;

/// Why a signal cannot be filtered.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SmoothError {
    /// A cutoff at or above the Nyquist frequency.
    #[error(
        "a cutoff of {cutoff} Hz cannot be used\n  why: the signal has {rate} samples a second; the cutoff must lie between 0 and {half} Hz\n  do:  lower the cutoff"
    )]
    Cutoff {
        /// Asked for, Hz.
        cutoff: Hertz,
        /// Of the signal, Hz.
        rate: Hertz,
        /// Half of that, Hz.
        half: Hertz,
    },
    /// A signal shorter than its continuation.
    #[error(
        "{samples} samples are too few to smooth\n  why: {needed} are needed for {sections} sections\n  do:  give a longer signal or fewer sections"
    )]
    Short {
        /// Samples given.
        samples: usize,
        /// Samples needed.
        needed: usize,
        /// Sections asked for.
        sections: usize,
    },
}

/// One second-order section: (b₀ + b₁z⁻¹ + b₂z⁻²) / (1 + a₁z⁻¹ + a₂z⁻²).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

/// Low-pass filter with `cutoff` (Hz): Butterworth of order 2 × `sections`, forwards and backwards.
///
/// |H|² of each pass: 1 / (1 + (tan(πf/r) / tan(πf꜀/r))^(4n)), n sections, so one half is left at the cutoff and nothing
/// is delayed.
///
/// # Errors
/// [`SmoothError`] when the cutoff is not within 0 … half the rate, or the signal is too short.
pub fn low_pass(signal: &Series, cutoff: Hertz, sections: usize) -> Result<Series, SmoothError> {
    let half = 0.5 * signal.rate();
    if !(cutoff > 0.0 && cutoff < half) {
        return Err(SmoothError::Cutoff { cutoff, rate: signal.rate(), half });
    }
    // Three times the taps of the filter, SciPy's default: the continuation's length shows in the values at the ends.
    let (samples, pad) = (signal.values().len(), 3 * (2 * sections + 1));
    if samples <= pad {
        return Err(SmoothError::Short { samples, needed: pad + 1, sections });
    }
    let filter = butterworth_sections(cutoff / signal.rate(), sections);
    let mut values = reflected_values(signal.values(), pad);
    for _ in 0..2 {
        filter_in_place(&filter, &mut values);
        values.reverse();
    }
    let smoothed = values[pad..pad + samples].to_vec();
    Ok(Series::new(signal.start(), signal.rate(), smoothed).expect("as many finite values as the signal had"))
}

/// Sections of a Butterworth low-pass by the bilinear transform; `cutoff` in cycles a sample.
fn butterworth_sections(cutoff: f64, sections: usize) -> Vec<Section> {
    // Prewarped: without the tangent the bilinear transform puts the half-power point below the cutoff by (πf꜀/r)²/3 of
    // it.
    let w = (PI * cutoff).tan();
    let section = |k: usize| {
        let damping = 2.0 * (PI * (2 * k + 1) as f64 / (4 * sections) as f64).sin();
        let scale = 1.0 / (1.0 + damping * w + w * w);
        let b = w * w * scale;
        Section { b: [b, 2.0 * b, b], a: [2.0 * (w * w - 1.0) * scale, (1.0 - damping * w + w * w) * scale] }
    };
    (0..sections).map(section).collect()
}

/// The values with `pad` more on each side, by point reflection.
fn reflected_values(values: &[f64], pad: usize) -> Vec<f64> {
    let (first, last, n) = (values[0], values[values.len() - 1], values.len());
    // Point reflection continues value and slope. An even reflection would put a kink at the end, which the filter
    // rounds off.
    let leading = (1..=pad).rev().map(|i| 2.0 * first - values[i]);
    let trailing = (1..=pad).map(|i| 2.0 * last - values[n - 1 - i]);
    leading.chain(values.iter().copied()).chain(trailing).collect()
}

/// One pass of all sections in place (transposed direct form II), started in the steady state of the first value.
fn filter_in_place(sections: &[Section], values: &mut [f64]) {
    // A cascade and not one polynomial: its roots crowd at z = 1 for a low cutoff, where coefficients in double
    // precision no longer place them.
    for Section { b, a } in sections {
        let steady = values[0]; // each section has unit gain at rest
        let mut states = [(1.0 - b[0]) * steady, (b[2] - a[1]) * steady];
        for value in values.iter_mut() {
            let input = *value;
            let output = b[0] * input + states[0];
            states = [b[1] * input - a[0] * output + states[1], b[2] * input - a[1] * output];
            *value = output;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(rate: f64, count: usize, value: impl Fn(f64) -> f64) -> Series {
        Series::new(0.0, rate, (0..count).map(|i| value(i as f64 / rate)).collect()).unwrap()
    }

    #[test]
    fn a_constant_passes_unchanged() {
        let smooth = low_pass(&sampled(200.0, 100, |_| 3.5), 8.0, 2).unwrap();
        assert!(smooth.values().iter().all(|v| (v - 3.5).abs() < 1e-12));
    }

    #[test]
    fn a_wave_keeps_its_phase_and_has_the_gain_of_the_formula() {
        for (frequency, sections) in [(2.0, 2), (8.0, 2), (20.0, 1), (20.0, 3)] {
            let (rate, cutoff) = (200.0, 8.0);
            let wave = |t: f64| (2.0 * PI * frequency * t).sin();
            let smooth = low_pass(&sampled(rate, 2000, wave), cutoff, sections).unwrap();
            let ratio = (PI * frequency / rate).tan() / (PI * cutoff / rate).tan();
            let gain = 1.0 / (1.0 + ratio.powi(4 * sections as i32));
            for i in 800..1200 {
                let expected = gain * wave(smooth.time(i));
                assert!(
                    (smooth.values()[i] - expected).abs() < 1e-9,
                    "{frequency} Hz: {} {expected}",
                    smooth.values()[i]
                );
            }
        }
    }

    #[test]
    fn the_ends_are_treated_as_scipy_does() {
        // SciPy 1.17.1: sosfiltfilt(butter(4, 6, fs=60, output="sos"), x), samples 0, 1, 5, 30, 58, 59
        let x = |t: f64| (18.0 * t).sin() + 0.5 * (102.0 * t).cos() + 0.6 * t * t;
        let smooth = low_pass(&sampled(60.0, 60, x), 6.0, 2).unwrap();
        let scipy = [
            (0, 0.504352452930949),
            (1, 0.5889608066597174),
            (5, 0.9164102789909799),
            (30, 0.5612055436731054),
            (58, -0.08575123355036891),
            (59, 0.1612042644987951),
        ];
        for (i, value) in scipy {
            assert!((smooth.values()[i] - value).abs() < 1e-12, "sample {i}: {} {value}", smooth.values()[i]);
        }
    }

    #[test]
    fn a_cutoff_above_half_the_rate_is_refused() {
        let signal = sampled(10.0, 100, |t| t);
        assert!(matches!(low_pass(&signal, 5.0, 2), Err(SmoothError::Cutoff { .. })));
        assert!(matches!(low_pass(&sampled(10.0, 15, |t| t), 1.0, 2), Err(SmoothError::Short { needed: 16, .. })));
    }
}
