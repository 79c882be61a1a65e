//! Simulation of a motion under measured pressures with identified moduli: by the reduced or by the full model.

use fem::{DynamicSettings, InitialValueProblem, Scheme, State};
use si::{Pascal, Point2, Second};
use signal::resample::Samples;

use crate::records::{Identified, Motion};
use diagnostics::{Diagnostic, Result};
use sysid::{Elastic, ForcedMotion, Model, ReducedBody, Viscoelastic, even_times};

/// A model with its silicone, and the observed marker.
pub(crate) struct MotionSimulation<'a> {
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
    /// Duration of the ramp from zero to the measured pressures, s.
    pub ramp: Second,
    /// One a chamber, Pa.
    pub gauges: &'a [Samples],
}

impl Actuation<'_> {
    /// Pressures (Pa) `t` s after the begin.
    pub(super) fn pressures(&self, t: Second) -> Vec<Pascal> {
        let part = if self.ramp > 0.0 { (t / self.ramp).clamp(0.0, 1.0) } else { 1.0 };
        let ease = part * part * (3.0 - 2.0 * part);
        self.gauges.iter().map(|g| ease * g.at(self.begin + t)).collect()
    }

    /// Ends of equal steps, s after the begin.
    pub(super) fn times(&self, step: Second) -> Vec<Second> {
        even_times(step, ((self.end - self.begin) / step).ceil() as usize)
    }

    /// A path from rest, sampled at the ends of steps (s after the begin), as functions of the film's time.
    pub(super) fn sampled(&self, steps: &[Second], path: &[Point2]) -> Result<[Samples; 2]> {
        let times: Vec<Second> = std::iter::once(&0.0).chain(steps).map(|t| self.begin + t).collect();
        let axis = |k: usize| {
            let at = std::iter::once(0.0).chain(path.iter().map(|p| p[k])).collect();
            Samples::new(times.clone(), at).map_err(Diagnostic::from)
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
        actuation.sampled(&times, &path)
    }

    /// The same by the full model.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a step finds no motion.
    pub fn whole(&self, settings: &DynamicSettings, actuation: &Actuation) -> Result<[Samples; 2]> {
        let mut solver = self.model.system.solver();
        self.silicone.apply(&mut solver)?;
        let rest = State::rest(self.model.system.mesh().nodes.len());
        let (spot, mut path) = (&self.model.markers[self.marker], Vec::new());
        let mut observe = |_: Second, state: &State| path.push(Model::in_plane(spot, &state.displacement));
        let times = actuation.times(settings.step);
        solver.integrate(
            &InitialValueProblem { settings, initial: &rest, pressures: &|t| actuation.pressures(t) },
            times.len(),
            &mut observe,
        )?;
        actuation.sampled(&times, &path)
    }
}

/// Settings of a fixed step: what dissipates is the silicone's relaxation alone.
pub(crate) fn dynamic_settings(scheme: Scheme, step: Second) -> DynamicSettings {
    DynamicSettings { step, scheme, ..DynamicSettings::default() }
}

/// The identified constants of a model, at the time to which they belong.
pub(crate) fn identified(model: &Model, found: &Identified) -> Elastic {
    Elastic { youngs_moduli: found.best.youngs_moduli(), ..model.nominal }
}

/// The measured pressures of a film.
///
/// # Errors
/// A [`Diagnostic`] when the log's times do not rise.
pub(crate) fn gauges(motion: &Motion) -> Result<Vec<Samples>> {
    let samples = motion.gauges.iter().map(|g| Samples::new(motion.log_time.clone(), g.measured.clone()));
    samples.collect::<Result<_, _>>().map_err(Diagnostic::from)
}

/// Mean time between frames, s.
pub(crate) fn frame_interval(times: &[Second]) -> Second {
    let last = times.len().max(2) - 1;
    times.get(last).map_or(0.0, |end| (end - times[0]) / last as f64)
}

/// A path as a camera sees it at the times of its frames, whose shutter is open for `exposure` of the time between them.
pub(crate) fn filmed([x, y]: &[Samples; 2], times: &[Second], exposure: f64) -> Vec<Point2> {
    let width = exposure * frame_interval(times);
    times.iter().map(|&t| [x.mean_at(t, width), y.mean_at(t, width)]).collect()
}

/// A path at other times.
pub fn onto([x, y]: &[Samples; 2], times: &[Second]) -> Vec<Point2> {
    times.iter().map(|&t| [x.at(t), y.at(t)]).collect()
}
