//! Features of a free vibration, of recorded and simulated displacements alike.

use si::{Metre, Second, Series};

use super::page::Page;
use super::recorded::{FreeVibration, vibration};
use diagnostics::Result;

/// What a recording is compared by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Features {
    /// Mean displacement over the last seconds, m.
    pub deflection: Metre,
    pub vibration: FreeVibration,
}

/// Name and unit of each feature.
pub(crate) const NAMES: [(&str, &str); 4] =
    [("frequency", "Hz"), ("static", "mm"), ("first_minimum", "mm"), ("decay", "1/s")];

impl Features {
    /// Of a displacement since the release.
    ///
    /// # Errors
    /// A diagnostic when there is no vibration in the window of the page.
    pub fn of(page: &Page, fall: &Series) -> Result<Self> {
        let settled_start =
            fall.values().len() - ((page.settled * fall.rate()).round() as usize).min(fall.values().len() - 1);
        let last = &fall.values()[settled_start..];
        let deflection = last.iter().sum::<f64>() / last.len() as f64;
        Ok(Self { deflection, vibration: vibration(page, fall)? })
    }

    /// In the units of [`NAMES`].
    pub fn to_array(self) -> [f64; 4] {
        let FreeVibration { frequency, decay, lowest, .. } = self.vibration;
        [frequency, 1e3 * self.deflection, 1e3 * lowest, decay]
    }

    /// Standard deviations of the measurement itself, in the same units: those of the wave, and of a displacement `sigma` (m).
    pub(super) fn measurement_sigma(self, sigma: Metre) -> [f64; 4] {
        [self.vibration.frequency_sigma, 1e3 * sigma, 1e3 * sigma, 0.0]
    }
}

/// Largest difference in time by which a prediction may be shifted onto its recording, s: releases are read off by eye.
const SHIFT: Second = 0.05;

/// Root mean square difference over the deflection `scale` (m) of two displacements, one of them shifted in time so that it is least.
pub(super) fn aligned_difference(predicted: &Series, recorded: &Series, scale: Metre) -> f64 {
    best_shift(predicted, recorded).1 / scale.abs()
}

/// The shift of a prediction onto its recording (s) with the least root mean square difference, and that difference, m.
pub(super) fn best_shift(predicted: &Series, recorded: &Series) -> (Second, f64) {
    let frames = (SHIFT * recorded.rate()).round() as i64;
    let shifted_difference = |shift: i64| {
        let pairs = recorded.values().iter().enumerate().map(|(i, measured)| {
            let frame = (i as i64 - shift).clamp(0, predicted.values().len() as i64 - 1) as usize;
            (predicted.values()[frame] - measured).powi(2)
        });
        (shift as f64 / recorded.rate(), (pairs.sum::<f64>() / recorded.values().len() as f64).sqrt())
    };
    let less = |best: (Second, f64), next: (Second, f64)| if next.1 < best.1 { next } else { best };
    (-frames..=frames).map(shifted_difference).fold((0.0, f64::INFINITY), less)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shifted_copy_does_not_differ() {
        let wave = |shift: f64| {
            let at = |i: i32| if f64::from(i) < shift { 0.0 } else { (0.3 * (f64::from(i) - shift)).sin() };
            Series::new(0.0, 100.0, (0..200).map(at).collect()).unwrap()
        };
        assert!(aligned_difference(&wave(3.0), &wave(0.0), 1.0) < 0.1);
        assert!(aligned_difference(&wave(10.0), &wave(0.0), 1.0) > 0.5, "further than a release can be misread");
    }

    #[test]
    fn features_and_their_deviations_are_in_the_units_of_their_names() {
        let vibration = FreeVibration { frequency: 7.7, frequency_sigma: 0.02, decay: 2.4, lowest: -0.011, when: 0.07 };
        let is = Features { deflection: -0.0064, vibration };
        let near = |found: [f64; 4], should: [f64; 4]| found.iter().zip(should).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(near(is.to_array(), [7.7, -6.4, -11.0, 2.4]), "Hz, mm, mm, 1/s");
        assert!(near(is.measurement_sigma(2e-4), [0.02, 0.2, 0.2, 0.0]));
    }

    #[test]
    fn the_static_deflection_is_the_mean_of_the_last_seconds_or_of_all_but_the_release() {
        let page = super::super::testing::page();
        let wave = |t: f64| 1.0 - (-2.0 * t).exp() * (std::f64::consts::TAU * 5.0 * t).cos();
        let of = |frames: i32, rate: f64| {
            Series::new(0.0, rate, (0..frames).map(|i| -0.01 * wave(f64::from(i) / rate)).collect()).unwrap()
        };
        let fall = of(250, 100.0);
        let last: f64 = fall.values()[200..].iter().sum::<f64>() / 50.0;
        let is = Features::of(&page, &fall).unwrap();
        assert!((is.deflection - last).abs() < 1e-15 && (is.vibration.frequency - 5.0).abs() < 0.01);
        let page = Page { settled: 10.0, ..page };
        let all: f64 = fall.values()[1..].iter().sum::<f64>() / 249.0;
        assert!((Features::of(&page, &fall).unwrap().deflection - all).abs() < 1e-15);
    }
}
