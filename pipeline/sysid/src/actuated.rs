//! Motion under measured pressures with identified moduli, by the reduced or by the full model, and as a camera films it.

use fem::{DynamicSettings, InitialValueProblem, Scheme, State};
use si::{Pascal, Point2, Second};
use signal::resample::Samples;

use crate::model::{Model, Viscoelastic};
use crate::reduced::{ForcedMotion, ReducedBody, even_times};
use diagnostics::{Diagnostic, Result};

/// A model with its silicone, and the observed marker.
pub struct MotionSimulation<'a> {
    /// The model, with its markers at their measured positions.
    pub model: &'a Model,
    /// The identified constants and the identified relaxation.
    pub silicone: Viscoelastic,
    /// Index of the observed marker.
    pub marker: usize,
}

/// The actuation of a motion from rest: its interval on the film's clock, and the pressures.
pub struct Actuation<'a> {
    /// s.
    pub begin: Second,
    /// s.
    pub end: Second,
    /// Ends of the time steps, rising, s after the begin; none: equal steps.
    pub steps: Option<&'a [Second]>,
    /// One a chamber, Pa.
    pub gauges: &'a [Samples],
}

impl Actuation<'_> {
    /// Pressures (Pa) `t` s after the begin.
    pub fn pressures(&self, t: Second) -> Vec<Pascal> {
        self.gauges.iter().map(|gauge| gauge.at(self.begin + t)).collect()
    }

    /// Ends of the time steps, s after the begin; equal ones have the length `step` (s).
    pub fn times(&self, step: Second) -> Vec<Second> {
        let even = || even_times(step, ((self.end - self.begin) / step).ceil() as usize);
        self.steps.map_or_else(even, <[Second]>::to_vec)
    }

    /// A path from rest, sampled at the ends of steps (s after the begin), as functions of the film's time.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the times do not rise.
    pub fn sample_path(&self, steps: &[Second], path: &[Point2]) -> Result<[Samples; 2]> {
        let times: Vec<Second> = std::iter::once(&0.0).chain(steps).map(|t| self.begin + t).collect();
        let axis = |k: usize| {
            let values = std::iter::once(0.0).chain(path.iter().map(|p| p[k])).collect();
            Samples::new(times.clone(), values).map_err(Diagnostic::from)
        };
        Ok([axis(0)?, axis(1)?])
    }
}

impl MotionSimulation<'_> {
    /// Displacement of the observed marker along x and y, m, by the reduced model.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a step finds no motion.
    pub fn run(
        &self,
        reduced_body: &ReducedBody,
        settings: &DynamicSettings,
        actuation: &Actuation,
    ) -> Result<[Samples; 2]> {
        let times = actuation.times(settings.step);
        let motion = ForcedMotion { settings, pressures: &|t| actuation.pressures(t), times: &times };
        let path = reduced_body.integrate(&motion, self.marker)?;
        actuation.sample_path(&times, &path)
    }

    /// The same by the full model.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a step finds no motion.
    pub fn run_full_model(&self, settings: &DynamicSettings, actuation: &Actuation) -> Result<[Samples; 2]> {
        let mut solver = self.model.system.solver();
        self.silicone.apply(&mut solver)?;
        let initial = State::rest(self.model.system.mesh().nodes.len());
        let (spot, mut path) = (&self.model.markers[self.marker], Vec::new());
        let mut observe = |_: Second, state: &State| path.push(Model::in_plane(spot, &state.displacement));
        let times = actuation.times(settings.step);
        solver.integrate(
            &InitialValueProblem { settings, initial: &initial, pressures: &|t| actuation.pressures(t) },
            times.len(),
            &mut observe,
        )?;
        actuation.sample_path(&times, &path)
    }
}

/// Settings of a fixed step: what dissipates is the silicone's relaxation alone.
pub fn dynamic_settings(scheme: Scheme, step: Second) -> DynamicSettings {
    DynamicSettings { step, scheme, ..DynamicSettings::default() }
}

/// Mean time between frames, s.
pub fn frame_interval(times: &[Second]) -> Second {
    let last = times.len().max(2) - 1;
    times.get(last).map_or(0.0, |end| (end - times[0]) / last as f64)
}

/// A path as a camera sees it at the times of its frames, whose shutter is open for `exposure` of the time between them.
pub fn exposed_path([x, y]: &[Samples; 2], times: &[Second], exposure: f64) -> Vec<Point2> {
    let width = exposure * frame_interval(times);
    times.iter().map(|&t| [x.mean_at(t, width), y.mean_at(t, width)]).collect()
}

/// A path at other times.
pub fn resample_path([x, y]: &[Samples; 2], times: &[Second]) -> Vec<Point2> {
    times.iter().map(|&t| [x.at(t), y.at(t)]).collect()
}

/// Lag of the simulated lateral motion behind the measured one at a `frequency`, s.
pub fn lateral_lag(time: &[Second], measured: &[Point2], simulated: &[Point2], frequency: si::Hertz) -> Second {
    let turn = std::f64::consts::TAU * frequency;
    let phase = |path: &[Point2]| {
        let part =
            |harmonic: fn(f64) -> f64| time.iter().zip(path).map(|(t, p)| p[1] * harmonic(turn * t)).sum::<f64>();
        part(f64::sin).atan2(part(f64::cos))
    };
    let phase_lag = phase(simulated) - phase(measured);
    let half = std::f64::consts::PI;
    // The shortest lag of those that differ by whole periods, which a phase does not tell apart.
    ((phase_lag + half).rem_euclid(2.0 * half) - half) / turn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_equal_unless_they_are_given() {
        let gauge = Samples::new(vec![0.0, 10.0], vec![0.0, 2e4]).unwrap();
        let even = Actuation { begin: 1.0, end: 2.0, steps: None, gauges: &[gauge] };
        assert_eq!(even.times(0.25), [0.25, 0.5, 0.75, 1.0]);
        assert_eq!(Actuation { steps: Some(&[0.1, 1.0]), ..even }.times(0.25), [0.1, 1.0]);
        assert!((even.pressures(0.5)[0] - 3e3).abs() < 1e-9);
    }

    #[test]
    fn an_open_shutter_averages_the_path() {
        let times: Vec<f64> = (0..=100).map(|i| 0.01 * f64::from(i)).collect();
        let squares = times.iter().map(|t| t * t).collect();
        let path = [Samples::new(times.clone(), times.clone()).unwrap(), Samples::new(times, squares).unwrap()];
        let filmed = exposed_path(&path, &[0.3, 0.5, 0.7], 1.0);
        // the mean of t² over a width w about t is t² + w²/12
        assert!((filmed[1][0] - 0.5).abs() < 1e-9 && (filmed[1][1] - (0.25 + 0.04 / 12.0)).abs() < 1e-4, "{filmed:?}");
    }

    #[test]
    fn a_lag_of_ten_milliseconds_is_measured() {
        let time: Vec<f64> = (0..120).map(|i| f64::from(i) / 60.0).collect();
        let path = |late: f64| -> Vec<Point2> {
            time.iter().map(|t| [0.0, (std::f64::consts::TAU * 2.0 * (t - late)).sin()]).collect()
        };
        // two seconds at 2 Hz are whole cycles: no spectral leakage
        assert!((lateral_lag(&time, &path(0.0), &path(0.01), 2.0) - 0.01).abs() < 1e-9);
    }
}
