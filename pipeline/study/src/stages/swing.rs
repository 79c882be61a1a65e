//! Swing: a motion under measured pressures, simulated with identified moduli: in reduced coordinates, or by the whole model.
//!
//! Stands on: the model, fem. Never knows: what is done with it.

use fem::{March, Scheme, State};
use si::{Pascal, Point2, Second};
use signal::resample::Samples;

use crate::fault::{Fault, Outcome};
use crate::model::{Elastic, Model, Small};
use crate::records::{Identified, Motion};

/// A model with its moduli, and the marker that is watched.
pub struct Swing<'a> {
    /// The model, its markers where films saw them.
    pub model: &'a Model,
    /// The identified constants.
    pub elastic: Elastic,
    /// Which marker is watched.
    pub marker: usize,
}

/// What drives a motion from rest: from when to when on the film's clock, and pressures there.
pub struct Drive<'a> {
    /// s.
    pub begin: Second,
    /// s.
    pub end: Second,
    /// How long the pressures take to rise from nothing to what was measured, s: a shape held at `begin` is come to gently.
    pub eased: Second,
    /// One a chamber, Pa.
    pub gauges: &'a [Samples],
}

impl Drive<'_> {
    /// Pressures (Pa) `t` s after the begin.
    pub(super) fn pressures(&self, t: Second) -> Vec<Pascal> {
        let part = if self.eased > 0.0 { (t / self.eased).clamp(0.0, 1.0) } else { 1.0 };
        let ease = part * part * (3.0 - 2.0 * part);
        self.gauges.iter().map(|g| ease * g.at(self.begin + t)).collect()
    }

    pub(super) fn steps(&self, step: Second) -> usize {
        ((self.end - self.begin) / step).ceil() as usize
    }

    /// A path by steps of `step` s, as functions of the film's time.
    pub(super) fn told(&self, step: Second, path: &[Point2]) -> Outcome<[Samples; 2]> {
        let times: Vec<Second> = (0..=path.len()).map(|i| self.begin + i as f64 * step).collect();
        let axis = |k: usize| {
            let at = std::iter::once(0.0).chain(path.iter().map(|p| p[k])).collect();
            Samples::new(times.clone(), at).map_err(Fault::from_tool)
        };
        Ok([axis(0)?, axis(1)?])
    }
}

impl Swing<'_> {
    /// Displacement of the watched marker, m, along x and y: in reduced coordinates.
    ///
    /// # Errors
    /// A [`Fault`] when a step finds no motion.
    pub fn run(&self, small: &Small, march: &March, drive: &Drive) -> Outcome<[Samples; 2]> {
        let steps = drive.steps(march.step);
        let path = small.march(march, self.marker, &|t| drive.pressures(t), steps)?;
        drive.told(march.step, &path)
    }

    /// The same by the whole model.
    ///
    /// # Errors
    /// A [`Fault`] when a step finds no motion.
    pub fn whole(&self, march: &March, drive: &Drive) -> Outcome<[Samples; 2]> {
        let mut solver = self.model.system.solver();
        self.elastic.give(&mut solver)?;
        let rest = State::rest(self.model.system.mesh().nodes.len());
        let (spot, mut path) = (&self.model.markers[self.marker], Vec::new());
        let mut observe = |_: Second, state: &State| path.push(Model::in_plane(spot, &state.displacement));
        let steps = drive.steps(march.step);
        solver.march(march, &rest, &|t| drive.pressures(t), steps, &mut observe).map_err(Fault::from_tool)?;
        drive.told(march.step, &path)
    }
}

/// A march of fixed steps, damped by stiffness alone.
pub fn march(scheme: Scheme, step: Second, stiffness_damping: Second) -> March {
    March { step, scheme, stiffness_damping, ..March::default() }
}

/// The identified constants of a model.
pub fn identified(model: &Model, found: &Identified) -> Elastic {
    Elastic { youngs_moduli: [found.best.body_e_pa, found.best.spine_e_pa], ..model.nominal }
}

/// The measured pressures of a film.
///
/// # Errors
/// A [`Fault`] when the log's times do not rise.
pub fn gauges(motion: &Motion) -> Outcome<Vec<Samples>> {
    let samples = motion.gauges.iter().map(|g| Samples::new(motion.log_time.clone(), g.measured.clone()));
    samples.collect::<Result<_, _>>().map_err(Fault::from_tool)
}

/// A path at other times.
pub fn onto([x, y]: &[Samples; 2], times: &[Second]) -> Vec<Point2> {
    times.iter().map(|&t| [x.at(t), y.at(t)]).collect()
}
