//! Discrete Fourier transforms of real signals.

use realfft::RealFftPlanner;
use si::{Hertz, Second};
use std::f64::consts::TAU;

pub use realfft::num_complex::Complex;

/// A complex amplitude.
pub type Phasor = Complex<f64>;

/// X_k = Σ x_n e^(−2πi kn/N), k = 0 … N/2: `values.len() / 2 + 1` bins.
pub fn forward(values: &[f64]) -> Vec<Phasor> {
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(values.len());
    let (mut input, mut output) = (values.to_vec(), plan.make_output_vec());
    plan.process(&mut input, &mut output).expect("buffers come from the plan");
    output
}

/// The `samples` values whose spectrum is `bins`, divided by N so that it inverts [`forward`].
pub fn inverse(mut bins: Vec<Phasor>, samples: usize) -> Vec<f64> {
    let plan = RealFftPlanner::<f64>::new().plan_fft_inverse(samples);
    // the first bin and, of an even number, the last have no imaginary part in a real signal
    bins[0].im = 0.0;
    if samples.is_multiple_of(2) {
        bins[samples / 2].im = 0.0;
    }
    let mut output = plan.make_output_vec();
    plan.process(&mut bins, &mut output).expect("as many bins as the plan asks for");
    output.iter().map(|v| v / samples as f64).collect()
}

/// Σ x_n e^(−iω t_n) Δt at one frequency (Hz), of samples at `rate` (Hz) of which the first was taken at `start` (s).
pub fn at(values: &[f64], start: Second, rate: Hertz, frequency: Hertz) -> Phasor {
    let rotation = |n: usize| Phasor::from_polar(1.0 / rate, -TAU * frequency * (start + n as f64 / rate));
    values.iter().enumerate().map(|(n, x)| rotation(n) * x).sum()
}

/// The frequency (Hz) between `low` and `high` of the highest peak of `values` (at `rate`, Hz), from a spectrum padded eightfold.
pub fn peak(values: &[f64], rate: Hertz, [low, high]: [Hertz; 2]) -> Hertz {
    let n = (8 * values.len()).next_power_of_two();
    let mut padded = values.to_vec();
    padded.resize(n, 0.0);
    let bins = forward(&padded);
    let of = |k: usize| k as f64 * rate / n as f64;
    let within = (0..bins.len()).filter(|&k| (low..=high).contains(&of(k)));
    within.max_by(|&a, &b| bins[a].norm_sqr().total_cmp(&bins[b].norm_sqr())).map_or(0.5 * (low + high), of)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_is_recovered_from_its_spectrum() {
        for n in [7, 8, 100, 101] {
            let values: Vec<f64> = (0..n).map(|i| (0.7 * f64::from(i)).sin() + 0.2 * f64::from(i)).collect();
            let again = inverse(forward(&values), values.len());
            assert!(values.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-10));
        }
    }

    #[test]
    fn a_bin_is_the_sum_of_its_definition() {
        let values: Vec<f64> = (0..64).map(|i| (0.3 * f64::from(i)).cos()).collect();
        let (bins, rate) = (forward(&values), 80.0);
        for k in [0, 3, 17] {
            let one = at(&values, 0.0, rate, k as f64 * rate / 64.0) * rate;
            assert!((one - bins[k]).norm() < 1e-10);
        }
    }

    #[test]
    fn the_peak_of_a_sine_is_its_frequency() {
        let sine: Vec<f64> = (0..800).map(|i| (TAU * 1.16 * f64::from(i) / 80.0).sin()).collect();
        // a spectrum padded eightfold has bins of 0.01 Hz
        assert!((peak(&sine, 80.0, [0.8, 1.5]) - 1.16).abs() < 0.01);
    }
}
