//! Evidence for a line in a spectrum: its power over that of the noise, as a probability.
//!
//! The noise has the spectrum S(f) = a + b/f + c/f² (white, flicker, random walk; those that a criterion keeps), fitted by Whittle's likelihood \[whittle1953\] to the tapered
//! periodogram P outside the searched bands. Under noise alone P/S is exponentially distributed, or F with (2, 2m) degrees of freedom where S
//! itself comes from m independent bins: P(P/S > z) = (1 + z/m)^(−m). The largest of M independent values in a band exceeds z with
//! probability 1 − (1 − (1 + z/m)^(−m))^M \[scargle1982\].

use nalgebra::{DMatrix, DVector};
use si::{Hertz, Series};
use std::f64::consts::{PI, TAU};

use super::DRIFT;
use crate::polynomial;
use crate::spectrum;
use optimize::linear;

/// Where a line was searched for, and how probable noise of the same power is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Lowest and highest frequency of the band, Hz.
    pub band: [Hertz; 2],
    /// Frequency of its highest peak over the noise, Hz.
    pub frequency: Hertz,
    /// Amplitude there, unit of the signal.
    pub amplitude: f64,
    /// Power over that of the noise, no unit.
    pub ratio: f64,
    /// Probability that noise alone has such a peak somewhere in the band.
    pub p_value: f64,
    /// Largest amplitude that the steps of a converter make of a drift: the fundamental of a saw tooth, step/π, unit of the signal.
    pub quantisation: f64,
}

impl Evidence {
    /// Whether the line rises over the noise at a level of significance, and over the converter's steps.
    pub(crate) fn is_found(&self, level: f64) -> bool {
        self.p_value <= level && self.amplitude > self.quantisation
    }
}

/// Padding of the spectrum in which peaks are searched for.
// A line half way between two bins loses 28 % of its power under Hann's window; with padding by eight it lies within
// 1/16 of a bin and loses 0.5 %.
const PADDING: usize = 8;
/// Bins from 0 that the removal of the drift empties.
const EMPTIED: usize = DRIFT + 1;
/// The noise is fitted up to this multiple of the highest searched frequency: beyond it the fixture rings.
const BEYOND: f64 = 4.0;
/// Neighbouring bins of a Hann taper that count as one independent value.
// The equivalent noise bandwidth of Hann's window is 1.5 bins.
const CORRELATED: f64 = 1.5;
/// A shape that contributes less than this share to the noise at a frequency is not counted among its parameters there.
const CONTRIBUTES: f64 = 0.02;
/// Independent values a bin that have the same tail as a maximum over a band of a tapered spectrum.
const VALUES: f64 = 1.5;
/// Multiplicative updates of the noise's coefficients: they settle to a hundredth within fifty.
const UPDATES: usize = 80;

/// The evidence for a line in each of `bands` (Hz), in their order.
pub(crate) fn band_evidence(signal: &Series, bands: &[[Hertz; 2]]) -> Vec<Evidence> {
    let tapered = Tapered::of(signal);
    let noise = Noise::fitted_noise(&tapered, bands);
    let quantisation = smallest_step(signal.values()) / PI;
    bands.iter().map(|band| tapered.band_peak(*band, &noise, quantisation)).collect()
}

/// The strongest line between the lowest resolved frequency and `highest` (Hz) outside of no band.
pub(crate) fn strongest_line(signal: &Series, highest: Hertz) -> Evidence {
    let length = signal.end() - signal.start();
    band_evidence(signal, &[[EMPTIED as f64 / length, highest.min(0.45 * signal.rate())]])[0]
}

/// The step of the converter, of which all differences between the values are whole multiples; 0 where there is none.
fn smallest_step(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let spread = sorted[sorted.len() - 1] - sorted[0];
    // Rounded decimals differ by less than a millionth of a step in binary.
    let steps: Vec<f64> = sorted.windows(2).map(|v| v[1] - v[0]).filter(|step| *step > 1e-6 * spread).collect();
    let smallest = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let is_multiple = |step: &f64| (step / smallest - (step / smallest).round()).abs() < 0.02;
    if smallest.is_finite() && steps.iter().all(is_multiple) { smallest } else { 0.0 }
}

/// A signal without drift under Hann's window.
struct Tapered {
    values: Vec<f64>,
    rate: Hertz,
    /// Sums of the window and of its square.
    sums: [f64; 2],
}

impl Tapered {
    fn of(signal: &Series) -> Self {
        let count = signal.values().len();
        let columns = polynomial::basis_columns(count, DRIFT);
        let weights = linear::least_squares(&columns, signal.values());
        let drift = weights.map_or_else(|| vec![0.0; count], |w| linear::weighted_sum(&columns, &w));
        let window = |i: usize| (PI * (i as f64 + 0.5) / count as f64).sin().powi(2);
        let values = (0..count).map(|i| window(i) * (signal.values()[i] - drift[i])).collect();
        let sums = [1, 2].map(|power| (0..count).map(|i| window(i).powi(power)).sum());
        Self { values, rate: signal.rate(), sums }
    }

    /// Frequency of a bin of the spectrum padded to `padding` times its length.
    fn frequency(&self, bin: usize, padding: usize) -> Hertz {
        bin as f64 * self.rate / (padding * self.values.len()) as f64
    }

    /// |X|²/Σw² in every bin.
    fn padded_periodogram(&self, padding: usize) -> Vec<f64> {
        let mut padded = self.values.clone();
        padded.resize(padding * self.values.len(), 0.0);
        spectrum::forward(&padded).iter().map(|x| x.norm_sqr() / self.sums[1]).collect()
    }

    fn band_peak(&self, band: [Hertz; 2], noise: &Noise, quantisation: f64) -> Evidence {
        let power = self.padded_periodogram(PADDING);
        let frequency_of = |k: usize| self.frequency(k, PADDING);
        let bins_in_band = (1..power.len()).filter(|&k| (band[0]..=band[1]).contains(&frequency_of(k)));
        let ratio = |k: usize| power[k] / noise.density_at(frequency_of(k));
        let best = bins_in_band.max_by(|&a, &b| ratio(a).total_cmp(&ratio(b)));
        let Some(k) = best else {
            return Evidence { band, frequency: band[0], amplitude: 0.0, ratio: 0.0, p_value: 1.0, quantisation };
        };
        let length = self.values.len() as f64 / self.rate;
        let independent_values = VALUES * (band[1] - band[0]) * length + 1.0;
        let bins = noise.independent_bins(frequency_of(k));
        let tail_probability = (1.0 + ratio(k) / bins).powf(-bins);
        Evidence {
            band,
            frequency: frequency_of(k),
            amplitude: 2.0 * (power[k] * self.sums[1]).sqrt() / self.sums[0],
            ratio: ratio(k),
            // By `ln_1p` and `exp_m1`: 1 − (1 − p)^M written out is zero for every p below 1e-16, and strong lines
            // could not be told apart.
            p_value: -(independent_values * (-tail_probability.min(1.0 - 1e-16)).ln_1p()).exp_m1(),
            quantisation,
        }
    }
}

/// The spectrum of the noise.
struct Noise {
    /// Of 1, 1/f and 1/f².
    weights: [f64; 3],
    /// Fisher's information on the weights.
    information: [[f64; 3]; 3],
}

impl Noise {
    fn fitted_noise(tapered: &Tapered, bands: &[[Hertz; 2]]) -> Self {
        let power = tapered.padded_periodogram(1);
        let width = 2.0 * tapered.frequency(1, 1);
        let highest = BEYOND * bands.iter().map(|band| band[1]).fold(0.0, f64::max);
        let outside = |f: Hertz| bands.iter().all(|band| f < band[0] - width || f > band[1] + width);
        let is_in_range = |k: &usize| tapered.frequency(*k, 1) <= highest.min(0.47 * tapered.rate);
        let candidates: Vec<usize> = (EMPTIED..power.len()).filter(is_in_range).collect();
        let outside_bands: Vec<usize> =
            candidates.iter().copied().filter(|k| outside(tapered.frequency(*k, 1))).collect();
        // A band that leaves nothing else is its own noise, and a line in it raises the noise by a share of itself alone.
        let selected = if outside_bands.len() < 8 { candidates } else { outside_bands };
        let bins: Vec<[f64; 2]> = selected.iter().map(|k| [tapered.frequency(*k, 1), power[*k]]).collect();
        let mut noise = Self { weights: whittle_weights(&bins), information: [[0.0; 3]; 3] };
        for [frequency, _] in &bins {
            let (shape, density) = (spectral_shapes(*frequency), noise.density_at(*frequency));
            for (i, row) in noise.information.iter_mut().enumerate() {
                (0..3).for_each(|j| row[j] += shape[i] * shape[j] / (CORRELATED * density * density));
            }
        }
        noise
    }

    /// m, the number of independent bins of which S has the uncertainty at a frequency: 1/var(ln S), by Fisher's information on the shapes
    /// that contribute there.
    fn independent_bins(&self, frequency: Hertz) -> f64 {
        let (shape, density) = (spectral_shapes(frequency), self.density_at(frequency));
        let active: Vec<usize> = (0..3).filter(|&k| self.weights[k] * shape[k] > CONTRIBUTES * density).collect();
        let count = active.len();
        let matrix = DMatrix::from_fn(count, count, |i, j| self.information[active[i]][active[j]]);
        let relative_shapes = DVector::from_fn(count, |i, _| shape[active[i]] / density);
        let variance = matrix.cholesky().map(|factor| relative_shapes.dot(&factor.solve(&relative_shapes)));
        variance.map_or(2.0, |variance| (1.0 / variance).max(2.0))
    }

    fn density_at(&self, frequency: Hertz) -> f64 {
        spectrum_at(&self.weights, frequency)
    }
}

fn spectral_shapes(frequency: Hertz) -> [f64; 3] {
    [1.0, 1.0 / frequency, 1.0 / (frequency * frequency)]
}

/// Sets of shapes: white noise alone, with a random walk, with flicker, with both.
const MODELS: [[bool; 3]; 4] = [[true, false, false], [true, false, true], [true, true, false], [true, true, true]];

/// The weights of the set of shapes with the least information criterion \[akaike1974\] over bins of frequency and power: shapes that the
/// bins do not ask for would only add to the uncertainty.
fn whittle_weights(bins: &[[f64; 2]]) -> [f64; 3] {
    let models = MODELS.map(|model| {
        let weights = fitted_weights(bins, model);
        let bin_misfit = |[f, p]: &[f64; 2]| {
            let density = spectrum_at(&weights, *f);
            density.ln() + p / density
        };
        let misfit: f64 = bins.iter().map(bin_misfit).sum::<f64>() / CORRELATED;
        (misfit + model.iter().filter(|used| **used).count() as f64, weights)
    });
    let best = models.iter().min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or([0.0; 3], |(_, weights)| *weights)
}

/// The non-negative weights of a set of shapes that minimise Σ ln S + P/S, by multiplicative updates \[fevotte2009\]: they keep the signs and
/// never increase the sum.
fn fitted_weights(bins: &[[f64; 2]], model: [bool; 3]) -> [f64; 3] {
    let used = model.iter().filter(|used| **used).count() as f64;
    let mean = |k: usize| {
        bins.iter().map(|[f, p]| p / spectral_shapes(*f)[k]).sum::<f64>() / (used * bins.len().max(1) as f64)
    };
    let mut weights = [0, 1, 2].map(|k| if model[k] { mean(k) } else { 0.0 });
    for _ in 0..UPDATES {
        let (mut numerators, mut denominators) = ([0.0; 3], [0.0; 3]);
        for [frequency, power] in bins {
            let (shape, density) = (spectral_shapes(*frequency), spectrum_at(&weights, *frequency));
            (0..3).for_each(|k| {
                numerators[k] += shape[k] * power / (density * density);
                denominators[k] += shape[k] / density;
            });
        }
        (0..3).for_each(|k| weights[k] *= (numerators[k] / denominators[k].max(f64::MIN_POSITIVE)).sqrt());
    }
    weights
}

fn spectrum_at(weights: &[f64; 3], frequency: Hertz) -> f64 {
    spectral_shapes(frequency).iter().zip(weights).map(|(s, w)| s * w).sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Least damping ratio of a free wave: bottom and walls of a clean tank of a metre take more.
const LEAST_DAMPING: f64 = 0.002;

/// Whether a fitted wave certainly does not decay, as a driven motion does not.
pub(super) fn is_driven(wave: &super::Wave) -> bool {
    wave.decay + 4.0 * wave.decay_sigma < LEAST_DAMPING * TAU * wave.frequency
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Noise as Random;

    const BANDS: [[f64; 2]; 2] = [[0.95, 1.29], [1.55, 2.1]];
    const LEVEL: f64 = 0.005;
    const DRAWS: u64 = 1000;

    /// One kind of noise: white of 1, with a random walk, flicker, or steps of a converter (each in units of the white part).
    #[derive(Debug, Clone, Copy)]
    struct Kind {
        rate: f64,
        walk: f64,
        line: f64,
        step: f64,
    }

    const KINDS: [Kind; 7] = [
        Kind { rate: 80.0, walk: 0.0, line: 0.0, step: 0.0 },
        Kind { rate: 10.47, walk: 0.0, line: 0.0, step: 0.0 },
        Kind { rate: 80.0, walk: 0.3, line: 20.0, step: 0.0 },
        Kind { rate: 10.47, walk: 0.5, line: 20.0, step: 0.0 },
        Kind { rate: 80.0, walk: 0.05, line: 10.0, step: 1.0 },
        Kind { rate: 10.47, walk: 0.05, line: 10.0, step: 1.0 },
        Kind { rate: 10.47, walk: 0.0, line: 10.0, step: 4.0 },
    ];

    impl Kind {
        /// Ten seconds of noise, with a decaying wave of this amplitude at 1.16 Hz.
        fn drawn(&self, seed: u64, amplitude: f64) -> Series {
            let mut random = Random::new(seed);
            let (phase, mut walk) = (TAU * random.unit(), 0.0);
            let value = |i: usize| {
                let t = i as f64 / self.rate;
                walk += self.walk * random.normal();
                let wave = amplitude * (-0.0875 * t).exp() * (TAU * 1.16 * t + phase).cos();
                let sum = wave + walk + self.line * (0.1 * t).powi(2) + random.normal();
                if self.step > 0.0 { self.step * (sum / self.step).round() } else { sum }
            };
            Series::new(0.0, self.rate, (0..(10.0 * self.rate) as usize).map(value).collect()).unwrap()
        }

        /// Draws of `DRAWS` in which a wave is found.
        fn found(&self, amplitude: f64, bands: &[[f64; 2]]) -> usize {
            let level = LEVEL / bands.len() as f64;
            let has =
                |seed: &u64| band_evidence(&self.drawn(*seed, amplitude), bands).iter().any(|e| e.is_found(level));
            (0..DRAWS).filter(has).count()
        }
    }

    #[test]
    fn in_white_drifting_and_quantised_noise_a_wave_is_found_in_at_most_a_hundredth_of_the_draws() {
        for kind in KINDS {
            let found = kind.found(0.0, &BANDS);
            assert!(found <= 10, "{found} of {DRAWS}: {kind:?}");
        }
    }

    #[test]
    fn a_wave_of_twice_the_noise_is_found_in_at_least_95_of_a_hundred_draws() {
        for kind in KINDS {
            // at the wave's frequency, the root of the spectrum
            let walk = kind.walk * kind.rate / (TAU * 1.16);
            let noise = (1.0 + kind.step * kind.step / 12.0 + walk * walk).sqrt();
            let found = kind.found(2.0 * noise, &BANDS[..1]);
            assert!(found >= 950, "{found} of {DRAWS}: {kind:?}");
        }
    }

    #[test]
    fn the_spectrum_of_the_noise_is_recovered() {
        let kind = Kind { rate: 80.0, walk: 0.0, line: 0.0, step: 0.0 };
        let at = |seed: u64| Noise::fitted_noise(&Tapered::of(&kind.drawn(seed, 0.0)), &BANDS).density_at(1.2);
        let mean = (0..100).map(at).sum::<f64>() / 100.0;
        // a shape too many, which some draws keep, cannot be negative
        assert!((mean - 1.0).abs() < 0.15, "{mean}");
    }

    #[test]
    fn the_smallest_step_is_that_of_the_converter() {
        assert!((smallest_step(&[0.003, 0.001, 0.004, 0.001]) - 0.001).abs() < 1e-12);
        assert_eq!(smallest_step(&[0.5; 4]), 0.0);
        assert_eq!(smallest_step(&[0.5, 0.61, 0.75, 0.83]), 0.0);
    }
}
