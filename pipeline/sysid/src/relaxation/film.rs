//! A film of transients: its windows between two changes of the command, and their simulation with uneven time steps.

use fem::{DynamicSettings, Scheme};
use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Point2, Second};
use signal::resample::Samples;

use crate::reduced::{ForcedMotion, ReducedBody};
use crate::time_steps::TimeSteps;
use diagnostics::{Diagnostic, Result};

/// The frames between two changes of the command.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// The change, s on the film's clock.
    pub begin: Second,
    /// Of the frames, rising, s on the film's clock.
    pub times: Vec<Second>,
    /// Displacement of the marker, m.
    pub seen: Vec<Point2>,
    /// The highest command, Pa.
    pub command: Pascal,
}

/// A window as it is shown: lateral displacement of the marker about its mean, m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Transient {
    /// Frames, s after the change of the command.
    pub time_s: Vec<Second>,
    /// Measured, m.
    pub measured_m: Vec<Metre>,
    /// Simulated, m.
    pub simulated_m: Vec<Metre>,
    /// The highest command, Pa.
    pub command_pa: Pascal,
}

/// What a camera saw of one marker.
#[derive(Debug, Clone, PartialEq)]
pub struct Footage {
    /// In the order of time.
    pub windows: Vec<Window>,
    /// Index of the marker.
    pub marker: usize,
    /// How long the shutter is open, its middle at the frame's time, s.
    pub exposure: Second,
}

/// A film of transients.
pub struct Film {
    gauges: Vec<Samples>,
    footage: Footage,
    step: Second,
    /// Ends of the time steps, s after the first change.
    steps: Vec<Second>,
}

impl Film {
    /// The `footage` of a body under the pressures of its chambers (`gauges`, Pa over s on the film's clock).
    ///
    /// # Errors
    /// A [`Diagnostic`] when there is no window with three frames.
    pub fn new(footage: Footage, gauges: Vec<Samples>, steps: TimeSteps) -> Result<Self> {
        let windows: Vec<Window> = footage.windows.into_iter().filter(|w| w.times.len() > 2).collect();
        let Some(begin) = windows.first().map(|w| w.begin) else {
            return Err(Diagnostic::new(
                "the film shows no transient",
                "its command never changes while it is filmed",
                "film a staircase from before its first level on",
            ));
        };
        if windows.iter().all(Window::is_still) {
            return Err(Diagnostic::new(
                "the film shows no transient",
                "between two changes of the command its marker stays exactly where it is",
                "film the motion itself, in enough frames a second, instead of the places that it reaches",
            ));
        }
        let last = windows.iter().flat_map(|w| w.times.last()).copied().fold(begin, f64::max);
        let events: Vec<Second> = windows.iter().map(|w| w.begin - begin).collect();
        let ends = steps.ends(&events, last - begin);
        let footage = Footage { windows, ..footage };
        Ok(Self { gauges, footage, step: steps.step, steps: ends })
    }

    /// Number of frames of each window.
    pub(super) fn frames(&self) -> impl Iterator<Item = usize> + '_ {
        self.footage.windows.iter().map(|window| window.times.len())
    }

    /// Mean time between two frames, s.
    pub(super) fn frame_interval(&self) -> Second {
        let times = &self.footage.windows[0].times;
        (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64
    }

    /// Simulated minus measured displacement of each window, both about their means and the simulated one to the scale that fits best, m:
    /// window after window, x before y.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a step finds no motion.
    pub(super) fn residuals(&self, body: &ReducedBody) -> Result<Vec<f64>> {
        let path = self.simulate_path(body)?;
        let residuals = |window: &Window| {
            let (simulated, measured) = window.compared(&path, self.footage.exposure);
            simulated.into_iter().zip(measured).map(|(s, m)| s - m).collect::<Vec<f64>>()
        };
        Ok(self.footage.windows.iter().flat_map(residuals).collect())
    }

    /// Every window with its simulation.
    ///
    /// # Errors
    /// As [`Film::residuals`].
    pub(super) fn transients(&self, body: &ReducedBody) -> Result<Vec<Transient>> {
        let path = self.simulate_path(body)?;
        let shown = |window: &Window| {
            let (simulated, measured) = window.compared(&path, self.footage.exposure);
            let lateral = |displacement: Vec<f64>| displacement[window.times.len()..].to_vec();
            Transient {
                time_s: window.times.iter().map(|t| t - window.begin).collect(),
                measured_m: lateral(measured),
                simulated_m: lateral(simulated),
                command_pa: window.command,
            }
        };
        Ok(self.footage.windows.iter().map(shown).collect())
    }

    /// Displacement of the marker along x and y, m, as functions of the film's time.
    fn simulate_path(&self, body: &ReducedBody) -> Result<[Samples; 2]> {
        let begin = self.footage.windows[0].begin;
        let settings = DynamicSettings { step: self.step, scheme: Scheme::Bdf2, ..DynamicSettings::default() };
        let pressures = |t: Second| self.gauges.iter().map(|gauge| gauge.at(begin + t)).collect();
        let motion = ForcedMotion { settings: &settings, pressures: &pressures, times: &self.steps };
        let path = body.integrate(&motion, self.footage.marker)?;
        let times: Vec<Second> = std::iter::once(&0.0).chain(&self.steps).map(|t| begin + t).collect();
        let axis = |k: usize| {
            let places = std::iter::once(0.0).chain(path.iter().map(|p| p[k])).collect();
            Samples::new(times.clone(), places).map_err(Diagnostic::from)
        };
        Ok([axis(0)?, axis(1)?])
    }
}

impl Window {
    /// Whether the marker does not move at all, or is hardly seen: residuals would vanish at any scale, and nothing would be identified.
    pub fn is_still(&self) -> bool {
        self.seen.len() < 3 || self.seen.iter().all(|position| *position == self.seen[0])
    }

    /// Measured displacement along x and y, each about its mean, m.
    pub fn about_mean(&self) -> [Vec<Metre>; 2] {
        [0, 1].map(|k| about_mean(self.seen.iter().map(|p| p[k]).collect()))
    }

    /// Simulated and measured displacement, x before y, each about its mean; the simulated one to the scale that fits best. What a hold
    /// reaches is a matter of the elastic law, whose stiffening with strain is not the silicone's: a spectrum that had to make up for it
    /// would be biased.
    pub fn compared(&self, path: &[Samples; 2], exposure: Second) -> (Vec<f64>, Vec<f64>) {
        let axis = |k: usize| about_mean(self.times.iter().map(|t| path[k].mean_at(*t, exposure)).collect());
        let simulated = [axis(0), axis(1)].concat();
        let measured = self.about_mean().concat();
        let product = |a: &[f64]| a.iter().zip(&simulated).map(|(a, s)| a * s).sum::<f64>();
        let scale = product(&measured) / product(&simulated).max(f64::MIN_POSITIVE);
        (simulated.iter().map(|s| scale * s).collect(), measured)
    }
}

fn about_mean(values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.into_iter().map(|v| v - mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_of_a_marker_that_jumps_from_place_to_place_is_refused() {
        let film = |seen: Vec<Point2>| {
            let window = Window { begin: 0.0, times: vec![0.0, 0.1, 0.2], seen, command: 1e4 };
            let footage = Footage { windows: vec![window], marker: 0, exposure: 0.0 };
            Film::new(footage, Vec::new(), TimeSteps { step: 0.01, vibration: 0.1, longest: 0.05 })
        };
        let refused = film(vec![[1e-3, 0.0]; 3]).err().unwrap();
        assert!(refused.why.contains("stays exactly where it is"), "{refused}");
        assert!(film(vec![[1e-3, 0.0], [1e-3, 0.0], [1.1e-3, 0.0]]).is_ok());
    }

    #[test]
    fn a_path_is_compared_axis_after_axis_about_its_mean_and_to_scale() {
        let seen = vec![[0.0, 1.0], [1.0, 4.0], [2.0, 1.0]];
        let window = Window { begin: 0.0, times: vec![0.0, 1.0, 2.0], seen: seen.clone(), command: 0.0 };
        // twice as far, and elsewhere
        let axis =
            |k: usize| Samples::new(window.times.clone(), seen.iter().map(|at| 7.0 + 2.0 * at[k]).collect()).unwrap();
        let (simulated, measured) = window.compared(&[axis(0), axis(1)], 0.0);
        assert_eq!(measured, [-1.0, 0.0, 1.0, -1.0, 2.0, -1.0]);
        assert!(simulated.iter().zip(&measured).all(|(s, m)| (s - m).abs() < 1e-12), "{simulated:?}");
    }
}
