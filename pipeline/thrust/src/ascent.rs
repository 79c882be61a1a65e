//! Projected gradient ascent: the square wave of greatest mean thrust within limits, for any objective with a gradient.
//!
//! Steps follow the gradient in units of the limits, projected onto them; a step without increase is halved.

use si::{Hertz, Newton, Pascal};

use crate::square_wave::SquareWave;
use diagnostics::Result;

/// Limits of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Highest amplitude, Pa.
    pub amplitude: Pascal,
    /// Lowest and highest frequency, Hz.
    pub frequency: [Hertz; 2],
    /// Number of iterations.
    pub iterations: usize,
}

/// Mean thrust as a function of the wave.
pub trait Objective {
    /// The mean thrust, N.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when the body finds no motion.
    fn value(&mut self, wave: &SquareWave) -> Result<Newton>;

    /// Its derivatives by amplitude (N/Pa) and frequency (N/Hz).
    ///
    /// # Errors
    /// As [`Objective::value`].
    fn gradient(&mut self, wave: &SquareWave) -> Result<[f64; 2]>;
}

/// The first step, relative to the width of the limits.
const STEP: f64 = 0.25;
/// Smallest step: below it waves differ by less than the predictions can resolve.
const SHORTEST: f64 = 2e-3;

impl Limits {
    /// The wave at normalised coordinates (0 to 1 along both limits), with the sharpness of `template`.
    pub fn wave(&self, coordinates: [f64; 2], template: SquareWave) -> SquareWave {
        let [low, high] = self.frequency;
        let [amplitude, frequency] = coordinates.map(|p| p.clamp(0.0, 1.0));
        SquareWave { amplitude: amplitude * self.amplitude, frequency: low + frequency * (high - low), ..template }
    }

    /// Normalised coordinates of a wave; one half along a limit of zero width.
    pub fn place(&self, wave: &SquareWave) -> [f64; 2] {
        let [low, high] = self.frequency;
        [wave.amplitude / self.amplitude, if high > low { (wave.frequency - low) / (high - low) } else { 0.5 }]
    }

    /// A gradient in units of the limits, projected onto them.
    fn projected_gradient(&self, coordinates: [f64; 2], gradient: [f64; 2]) -> [f64; 2] {
        let scaled = [gradient[0] * self.amplitude, gradient[1] * (self.frequency[1] - self.frequency[0])];
        let points_outside =
            |k: usize| (coordinates[k] >= 1.0 && scaled[k] > 0.0) || (coordinates[k] <= 0.0 && scaled[k] < 0.0);
        [0, 1].map(|k| if points_outside(k) { 0.0 } else { scaled[k] })
    }
}

/// The iterates with their thrust, from `start`, the best last.
///
/// # Errors
/// As [`Objective::value`].
pub fn ascend(objective: &mut dyn Objective, start: SquareWave, limits: &Limits) -> Result<Vec<(SquareWave, Newton)>> {
    let mut iterates = vec![(start, objective.value(&start)?)];
    let (mut coordinates, mut step) = (limits.place(&start), STEP);
    let mut projected_gradient = limits.projected_gradient(coordinates, objective.gradient(&start)?);
    for _ in 0..limits.iterations {
        let gradient_norm = projected_gradient[0].hypot(projected_gradient[1]);
        if gradient_norm == 0.0 || step < SHORTEST {
            break;
        }
        let next_coordinates =
            [0, 1].map(|k| (coordinates[k] + step * projected_gradient[k] / gradient_norm).clamp(0.0, 1.0));
        let wave = limits.wave(next_coordinates, start);
        let thrust = objective.value(&wave)?;
        if thrust > iterates[iterates.len() - 1].1 {
            iterates.push((wave, thrust));
            (coordinates, projected_gradient) =
                (next_coordinates, limits.projected_gradient(next_coordinates, objective.gradient(&wave)?));
        } else {
            step *= 0.5;
        }
    }
    Ok(iterates)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A concave paraboloid with its maximum at an amplitude (Pa) and a frequency (Hz).
    struct Dome([f64; 2]);

    impl Objective for Dome {
        fn value(&mut self, w: &SquareWave) -> Result<Newton> {
            Ok(1.0 - ((w.amplitude - self.0[0]) / 1e4).powi(2) - (w.frequency - self.0[1]).powi(2))
        }

        fn gradient(&mut self, w: &SquareWave) -> Result<[f64; 2]> {
            Ok([-2.0 * (w.amplitude - self.0[0]) / 1e8, -2.0 * (w.frequency - self.0[1])])
        }
    }

    const LIMITS: Limits = Limits { amplitude: 3e4, frequency: [1.0, 3.0], iterations: 60 };

    fn top(at: [f64; 2]) -> SquareWave {
        let start = SquareWave { amplitude: 1.5e4, frequency: 1.2, sharpness: 5.0 };
        let iterates = ascend(&mut Dome(at), start, &LIMITS).unwrap();
        assert!(iterates.windows(2).all(|w| w[1].1 > w[0].1));
        iterates[iterates.len() - 1].0
    }

    #[test]
    fn a_maximum_within_the_limits_is_found() {
        let found = top([2e4, 2.3]);
        // the last step is SHORTEST of the limits' width or less from the maximum
        assert!((found.amplitude - 2e4).abs() < 300.0 && (found.frequency - 2.3).abs() < 0.02, "{found:?}");
    }

    #[test]
    fn a_maximum_beyond_a_limit_is_found_along_it() {
        let found = top([9e4, 2.3]);
        assert!(found.amplitude == 3e4 && (found.frequency - 2.3).abs() < 0.02, "{found:?}");
    }

    #[test]
    fn a_gradient_is_measured_in_the_widths_of_the_limits_and_does_not_lead_out_of_them() {
        let along = |place: [f64; 2]| LIMITS.projected_gradient(place, [1e-4, -2.0]);
        assert_eq!(along([0.5, 0.5]), [3e4 * 1e-4, -4.0]);
        assert_eq!(along([1.0, 0.0]), [0.0, 0.0]);
        assert_eq!(along([0.0, 1.0]), [3e4 * 1e-4, -4.0]);
    }
}
