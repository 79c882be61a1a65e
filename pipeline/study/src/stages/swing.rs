//! Swing: a motion under measured pressures, simulated with identified moduli.
//!
//! Stands on: the model, fem. Never knows: what is done with it.

use fem::{March, Scheme, State};
use si::{Pascal, Point2, Second};
use signal::resample::Samples;

use crate::fault::{Fault, Outcome};
use crate::model::{Elastic, Model};
use crate::records::{Identified, Motion};

/// A model with its moduli, and how it is stepped.
pub struct Swing<'a> {
    /// The model, its markers where films saw them.
    pub model: &'a Model,
    /// The identified constants.
    pub elastic: Elastic,
    /// Which marker is watched.
    pub marker: usize,
}

/// What drives a motion: from when to when on the film's clock, pressures there, and the shape that it starts from.
pub struct Drive<'a> {
    /// s.
    pub begin: Second,
    /// s.
    pub end: Second,
    /// One a chamber, Pa.
    pub gauges: &'a [Samples],
    /// At rest where there is none.
    pub start: Option<State>,
}

impl Swing<'_> {
    /// Displacement of the watched marker, m, as functions of the film's time: along x and y.
    ///
    /// # Errors
    /// A [`Fault`] when the solver finds no motion.
    pub fn run(&self, march: &March, drive: &Drive, said: &dyn Fn(f64)) -> Outcome<[Samples; 2]> {
        let mut solver = self.model.system.solver();
        self.elastic.give(&mut solver)?;
        let (begin, length) = (drive.begin, drive.end - drive.begin);
        let steps = (length / march.step).ceil() as usize;
        let rest = State::rest(self.model.system.mesh().nodes.len());
        let start = drive.start.as_ref().unwrap_or(&rest);
        let spot = &self.model.markers[self.marker];
        let (mut times, mut path) = (vec![begin], vec![Model::in_plane(spot, &start.displacement)]);
        let pressures = |t: Second| -> Vec<Pascal> { drive.gauges.iter().map(|g| g.at(begin + t)).collect() };
        let mut observe = |t: Second, state: &State| {
            times.push(begin + t);
            path.push(Model::in_plane(spot, &state.displacement));
            said(t / length);
        };
        solver.march(march, start, &pressures, steps, &mut observe).map_err(Fault::from_tool)?;
        let axis = |k: usize| Samples::new(times.clone(), path.iter().map(|p| p[k]).collect());
        Ok([axis(0).map_err(Fault::from_tool)?, axis(1).map_err(Fault::from_tool)?])
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
