//! An example of the inverse: a non-negative thrust whose measurement goes below zero through the fixture's ringing, and its deconvolution.

use si::{Hertz, Newton, Second, Series};

use super::{Cell, Regularisation};

/// Deconvolution of a synthetic thrust.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DeconvolutionExample {
    /// s.
    pub time: Vec<Second>,
    /// Never negative, N.
    pub thrust: Vec<Newton>,
    /// Simulated measurement: by the identified fixture, with the log's noise, N.
    pub measured: Vec<Newton>,
    /// After deconvolution, N.
    pub deconvolved: Vec<Newton>,
    /// Standard deviation of the deconvolved force due to noise, N.
    pub sigma: Newton,
    /// Root mean square error over the thrust's standard deviation: measured, deconvolved, and deconvolved where the
    /// noise is 40 dB below the signal.
    pub nrmse: [f64; 3],
}

/// Two pulses a cycle, each the square of a sine over a fraction of the period: never negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExampleThrust {
    /// Cycles a second, Hz.
    pub frequency: Hertz,
    /// Peak of a pulse, N.
    pub peak: Newton,
}

/// Samples of the fine thrust for one sample of the cell.
const FINE: usize = 25;
/// Fraction of its period for which a pulse lasts.
const PUSHES: f64 = 0.4;
/// Signal over noise at 40 dB, at which the inverse is evaluated independently of the log's own noise.
const FAINT: f64 = 100.0;
/// Duration of the example, s.
const LONG: Second = 8.0;
/// End of its pulses, s: as in a trial, the log continues until the ringing has decayed.
const PUSHED: Second = 6.0;
/// Duration of the ramps at both ends, s.
const RAMP: Second = 0.5;

impl ExampleThrust {
    fn thrust_at(&self, t: Second) -> Newton {
        let phase = (2.0 * self.frequency * t).fract();
        let ramp = (t / RAMP).clamp(0.0, 1.0) * ((PUSHED - t) / RAMP).clamp(0.0, 1.0);
        if phase < PUSHES { ramp * self.peak * (std::f64::consts::PI * phase / PUSHES).sin().powi(2) } else { 0.0 }
    }

    /// The thrust as a cell measures it at a rate (Hz) with noise (N), and its deconvolution.
    pub fn deconvolved(&self, cell: &Cell, (rate, noise): (Hertz, Newton), by: Regularisation) -> DeconvolutionExample {
        let samples = (LONG * rate) as usize;
        let series =
            |rate: Hertz, values: Vec<f64>| Series::new(0.0, rate, values).expect("finite values at a log's rate");
        let time: Vec<Second> = (0..samples).map(|i| i as f64 / rate).collect();
        let fine_rate = rate * FINE as f64;
        let fine_thrust =
            series(fine_rate, (0..samples * FINE).map(|i| self.thrust_at(i as f64 / fine_rate)).collect());
        let ideal = cell.simulate(&fine_thrust, &time);
        let noisy =
            |noise: Newton| ideal.iter().enumerate().map(|(i, f)| f + noise * pseudo_noise(i)).collect::<Vec<_>>();
        let faint_noise = root_mean_square(ideal.iter().copied()) / FAINT;
        let measured = noisy(noise);
        let deconvolved = cell.deconvolve(&series(rate, measured.clone()), noise, by);
        let nearly_noiseless = cell.deconvolve(&series(rate, noisy(faint_noise)), faint_noise, by);
        let thrust: Vec<Newton> = time.iter().map(|&t| self.thrust_at(t)).collect();
        let rms_error = |values: &[f64]| root_mean_square(values.iter().zip(&thrust).map(|(a, b)| a - b));
        let mean = thrust.iter().sum::<f64>() / samples as f64;
        let thrust_deviation = root_mean_square(thrust.iter().map(|t| t - mean));
        let nrmse = [&measured[..], deconvolved.force.values(), nearly_noiseless.force.values()]
            .map(|values| rms_error(values) / thrust_deviation);
        let (sigma, deconvolved) = (deconvolved.sigma, deconvolved.force.values().to_vec());
        DeconvolutionExample { time, thrust, measured, deconvolved, sigma, nrmse }
    }
}

/// Deterministic noise of unit size: the example needs no random numbers.
fn pseudo_noise(i: usize) -> f64 {
    1.4 * (((i * i) % 97) as f64 * 0.61 + i as f64 * 2.4).sin()
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), v| (sum + v * v, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deconvolved_thrust_is_nearer_to_the_true_one_than_the_measured() {
        let cell = Cell { natural_frequency: 14.0, damping_ratio: 0.03 };
        let by = Regularisation { weight: 1e-3, corner: 8.0 };
        let found = ExampleThrust { frequency: 2.0, peak: 0.15 }.deconvolved(&cell, (80.0, 1e-3), by);
        assert!(found.thrust.iter().all(|t| *t >= 0.0) && found.measured.iter().any(|m| *m < -0.01));
        assert!(found.nrmse[1] < 0.5 * found.nrmse[0] && found.nrmse[2] < 0.5 * found.nrmse[0], "{:?}", found.nrmse);
    }
}
