//! What the trials of one specimen share, and one trial once its motion is known.

use lab::card::{Experiment, Trial};
use si::Pascal;

use crate::physics::{Body, FlappingModel, Fluid, Motion, PressureSweep, SoftenedModel};
use crate::progress::Progress;
use crate::renderer::{Renderer, Subject};
use crate::script::Pneumatics;
use crate::settings::{Profile, Settings};

/// What all trials of a specimen share.
pub(crate) struct Bench<'a> {
    /// The settings.
    pub(crate) set: &'a Settings,
    /// Extent and resolution of the recording.
    pub(crate) profile: &'a Profile,
    /// The specimen's name.
    pub(crate) name: &'a str,
    /// The specimen's seed.
    pub(crate) seed: u64,
    /// The specimen as a finite-element system.
    pub(crate) body: &'a Body,
    /// Its equilibria by pressure, left and right.
    pub(crate) sweeps: &'a [PressureSweep; 2],
    /// Its reduced model for motions.
    pub(crate) flapping_model: &'a FlappingModel<'a>,
    /// The same after cycles, by their amplitude, Pa.
    pub(crate) softened: &'a [(Pascal, SoftenedModel)],
    /// The water around it.
    pub(crate) fluid: Fluid,
    /// The camera and its surroundings.
    pub(crate) renderer: &'a Renderer,
    /// What is filmed.
    pub(crate) subject: &'a Subject,
    /// Names of the marks.
    pub(crate) marks: &'a [String],
    /// Where progress is reported.
    pub(crate) progress: &'a Progress,
}

impl Bench<'_> {
    /// The model that `trial` softens by its cycles; none where it has none.
    pub(crate) fn softened_model(&self, trial: &Trial) -> Option<&SoftenedModel> {
        let Experiment::Flapping { amplitude, .. } = trial.experiment else { return None };
        self.softened
            .iter()
            .find(|(amplitude_of_model, _)| *amplitude_of_model == amplitude)
            .map(|(_, softened)| softened)
    }
}

/// One trial whose motion is known.
pub(crate) struct TrialRun<'a> {
    /// Its entry on the card.
    pub(crate) trial: &'a Trial,
    /// Commands and chamber pressures.
    pub(crate) pneumatics: &'a Pneumatics,
    /// The motion of the body.
    pub(crate) motion: &'a dyn Motion,
}
