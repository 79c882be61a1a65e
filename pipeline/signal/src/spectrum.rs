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
    // The sum and not a bin of a fast transform: two logs of different rates are compared at the same frequencies,
    // which are bins of neither.
    let rotation = |n: usize| Phasor::from_polar(1.0 / rate, -TAU * frequency * (start + n as f64 / rate));
    values.iter().enumerate().map(|(n, x)| rotation(n) * x).sum()
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
}
