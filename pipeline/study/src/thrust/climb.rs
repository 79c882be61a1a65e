//! Climbing: the wave of pressure with the most thrust within limits, uphill along a gradient, whoever tells height and slope.
//!
//! Steps go along the gradient in units of the limits, less what would leave them; one that does not climb is halved.
//!
//! Stands on: the wave. Never knows: a body, a model of thrust.

use si::{Hertz, Newton, Pascal};

use super::simulated::Wave;
use crate::fault::Outcome;

/// What a search for the best wave may choose from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Highest amplitude, Pa.
    pub amplitude: Pascal,
    /// Lowest and highest frequency, Hz.
    pub frequency: [Hertz; 2],
    /// Steps tried.
    pub rounds: usize,
}

/// Thrust over waves.
pub trait Hill {
    /// The mean thrust, N.
    ///
    /// # Errors
    /// A [`crate::fault::Fault`] when the body finds no motion.
    fn height(&mut self, wave: &Wave) -> Outcome<Newton>;

    /// Its derivatives by amplitude (N/Pa) and frequency (N/Hz).
    ///
    /// # Errors
    /// As [`Hill::height`].
    fn slope(&mut self, wave: &Wave) -> Outcome<[f64; 2]>;
}

/// The first step, of the limits' width.
const STRIDE: f64 = 0.25;
/// A step shorter than this moves no wave that could be told from the last.
const SHORTEST: f64 = 2e-3;

impl Limits {
    /// A wave of `like`'s kind at a place between 0 and 1 along both limits.
    pub fn wave(&self, place: [f64; 2], like: Wave) -> Wave {
        let [low, high] = self.frequency;
        let [amplitude, frequency] = place.map(|p| p.clamp(0.0, 1.0));
        Wave { amplitude: amplitude * self.amplitude, frequency: low + frequency * (high - low), ..like }
    }

    /// Where a wave stands along both limits; halfway where they leave no choice.
    pub fn place(&self, wave: &Wave) -> [f64; 2] {
        let [low, high] = self.frequency;
        [wave.amplitude / self.amplitude, if high > low { (wave.frequency - low) / (high - low) } else { 0.5 }]
    }

    /// A slope in units of the limits, less what leads out of them.
    fn uphill(&self, place: [f64; 2], slope: [f64; 2]) -> [f64; 2] {
        let scaled = [slope[0] * self.amplitude, slope[1] * (self.frequency[1] - self.frequency[0])];
        let leaves = |k: usize| (place[k] >= 1.0 && scaled[k] > 0.0) || (place[k] <= 0.0 && scaled[k] < 0.0);
        [0, 1].map(|k| if leaves(k) { 0.0 } else { scaled[k] })
    }
}

/// Every wave that climbed with its thrust, from `start`, the best last.
///
/// # Errors
/// As [`Hill::height`].
pub fn climb(hill: &mut dyn Hill, start: Wave, limits: &Limits) -> Outcome<Vec<(Wave, Newton)>> {
    let mut way = vec![(start, hill.height(&start)?)];
    let (mut place, mut stride) = (limits.place(&start), STRIDE);
    let mut uphill = limits.uphill(place, hill.slope(&start)?);
    for _ in 0..limits.rounds {
        let size = uphill[0].hypot(uphill[1]);
        if size == 0.0 || stride < SHORTEST {
            break;
        }
        let next = [0, 1].map(|k| (place[k] + stride * uphill[k] / size).clamp(0.0, 1.0));
        let wave = limits.wave(next, start);
        let found = hill.height(&wave)?;
        if found > way[way.len() - 1].1 {
            way.push((wave, found));
            (place, uphill) = (next, limits.uphill(next, hill.slope(&wave)?));
        } else {
            stride *= 0.5;
        }
    }
    Ok(way)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bowl turned over, with its top at an amplitude (Pa) and a frequency (Hz).
    struct Dome([f64; 2]);

    impl Hill for Dome {
        fn height(&mut self, w: &Wave) -> Outcome<Newton> {
            Ok(1.0 - ((w.amplitude - self.0[0]) / 1e4).powi(2) - (w.frequency - self.0[1]).powi(2))
        }

        fn slope(&mut self, w: &Wave) -> Outcome<[f64; 2]> {
            Ok([-2.0 * (w.amplitude - self.0[0]) / 1e8, -2.0 * (w.frequency - self.0[1])])
        }
    }

    const LIMITS: Limits = Limits { amplitude: 3e4, frequency: [1.0, 3.0], rounds: 60 };

    fn top(at: [f64; 2]) -> Wave {
        let start = Wave { amplitude: 1.5e4, frequency: 1.2, sharpness: 5.0 };
        let way = climb(&mut Dome(at), start, &LIMITS).unwrap();
        assert!(way.windows(2).all(|w| w[1].1 > w[0].1));
        way[way.len() - 1].0
    }

    #[test]
    fn a_top_within_the_limits_is_climbed() {
        let found = top([2e4, 2.3]);
        // the last step is SHORTEST of the limits' width or less from being uphill
        assert!((found.amplitude - 2e4).abs() < 300.0 && (found.frequency - 2.3).abs() < 0.02, "{found:?}");
    }

    #[test]
    fn a_top_beyond_a_limit_is_climbed_along_it() {
        let found = top([9e4, 2.3]);
        assert!(found.amplitude == 3e4 && (found.frequency - 2.3).abs() < 0.02, "{found:?}");
    }
}
