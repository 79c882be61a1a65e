//! Time integration of a reduced model under pressures and external forces.
//!
//! VᵀMV q̈ + α VᵀMV q̇ + f(q) + β ḟ(q) = Σ p ∂V/∂q + Q, with the backward differences of the full model.

use std::collections::VecDeque;

use nalgebra::DVector;
use si::Second;

use super::elastic_forces::ActingRegion;
use super::error::ReducedError;
use super::model::ReducedModel;
use super::motion::{Actuation, ReducedMotion};
use super::relaxation::ReducedHistory;
use super::step::{ExternalForce, LaggedTangent, Step, StepState, no_convergence};
use crate::dynamics::settings::{self, DynamicSettings};
use crate::dynamics::stencil::{Stencil, extrapolation_weights};
use crate::solve_error::SolveError;
use materials::step::RegionStep;

/// What the next step needs of the past, newest first.
struct Past {
    times: VecDeque<Second>,
    coordinates: VecDeque<DVector<f64>>,
    velocities: VecDeque<DVector<f64>>,
    forces: VecDeque<DVector<f64>>,
}

/// Called with each new q and q̇ and their time, s.
type Observer<'a> = dyn FnMut(Second, &DVector<f64>, &DVector<f64>) + 'a;

impl ReducedModel {
    /// Integrates `motion` over `steps` equal steps; `observe` is called with each new q and q̇ and their time.
    ///
    /// # Errors
    /// [`ReducedError`] when a setting is out of range or a step does not converge.
    pub fn integrate(
        &self,
        motion: &ReducedMotion,
        external: &mut dyn ExternalForce,
        steps: usize,
        observe: &mut Observer<'_>,
    ) -> Result<(), ReducedError> {
        let times: Vec<Second> = (1..=steps).map(|step| step as f64 * motion.settings.step).collect();
        self.integrate_at(motion, external, &times, observe)
    }

    /// As [`ReducedModel::integrate`], with steps that end at the rising `times` (s after the start); the step of the
    /// settings is not used. BDF2 is stable while no step is longer than 2.4 times the one before.
    ///
    /// A step in which no shape is found, as where a wall snaps, is halved up to four times. `external` accepts every part of
    /// it, `observe` is called at `times` alone.
    ///
    /// # Errors
    /// As [`ReducedModel::integrate`]; also when the times do not rise.
    pub fn integrate_at(
        &self,
        motion: &ReducedMotion,
        external: &mut dyn ExternalForce,
        times: &[Second],
        observe: &mut Observer<'_>,
    ) -> Result<(), ReducedError> {
        settings::check_settings(motion.settings)?;
        let mut run = Run::from_rest(self, motion)?;
        for &time in times {
            // The last end is the next one. Only the step after a halved one may be more than twice as long as the one before: a single such
            // ratio multiplies the error that BDF2 carries by a bounded factor.
            let mut ends = vec![time];
            while let Some(&end) = ends.last() {
                match run.step_to(end, external) {
                    Ok(()) => drop(ends.pop()),
                    Err(ReducedError::NoConvergence { .. }) if ends.len() <= HALVINGS => {
                        ends.push(run.half_way_to(end))
                    }
                    Err(cause) => return Err(cause),
                }
            }
            observe(time, &run.past.coordinates[0], &run.past.velocities[0]);
        }
        Ok(())
    }
}

/// A motion up to the present.
struct Run<'a> {
    model: &'a ReducedModel,
    motion: &'a ReducedMotion<'a>,
    past: Past,
    /// The regions in a step of `length` (s).
    regions: Vec<RegionStep>,
    length: Second,
    /// The law of each region alone.
    law: Vec<ActingRegion>,
    /// What the relaxation of each region remembers.
    history: ReducedHistory,
    tangent: Option<LaggedTangent>,
}

impl<'a> Run<'a> {
    fn from_rest(model: &'a ReducedModel, motion: &'a ReducedMotion<'a>) -> Result<Self, ReducedError> {
        let past = Past::at_rest(model.coordinates());
        let length = motion.settings.step;
        let regions = model.region_steps(motion, length)?;
        let (law, history) = (without_history(&regions), model.relaxed(&regions, &past.coordinates[0]));
        Ok(Self { model, motion, past, regions, length, law, history, tangent: None })
    }

    fn half_way_to(&self, end: Second) -> Second {
        0.5 * (self.past.times[0] + end)
    }

    /// One step to the time `end`; where it fails the motion is as before.
    fn step_to(&mut self, end: Second, external: &mut dyn ExternalForce) -> Result<(), ReducedError> {
        let ReducedMotion { settings, actuation, .. } = *self.motion;
        self.set_length(end)?;
        let Self { model, past, regions, tangent, .. } = self;
        let stencil = past.stencil_to(settings, end);
        let Actuation { pressures } = actuation(end);
        let acting = model.acting(regions, 1.0 + settings.stiffness_damping * stencil.gamma, &self.history);
        let equations = Step {
            model,
            settings,
            stencil: &stencil,
            pressures: &pressures,
            acting: &acting,
            external: &*external,
            contact: None,
            time: end,
            past: past.weighted_history(&stencil),
        };
        let previous = &past.coordinates[0];
        let q = equations
            .solve(&past.initial_guess(end), previous, tangent)
            .map_err(|change| no_convergence(past.times[0], change))?;
        let velocity = equations.velocity(&q);
        let (gamma, weights) = (stencil.gamma, &stencil.weights);
        external.accept(&StepState { time: end, coordinates: &q, velocity: &velocity, gamma, weights });
        model.advance(regions, &q, &mut self.history);
        // only stiffness damping asks for past forces
        let damped = settings.stiffness_damping > 0.0;
        let force = if damped { model.acting_forces(&q, &self.law) } else { DVector::zeros(q.len()) };
        past.push_state(end, q, velocity, force);
        Ok(())
    }

    /// Makes the regions those of a step to `end`.
    fn set_length(&mut self, end: Second) -> Result<(), ReducedError> {
        let step = end - self.past.times[0];
        if step.is_nan() || step <= 0.0 {
            let (what, range) = ("a time", "above the time before it");
            return Err(SolveError::Setting { what, value: end, range }.into());
        }
        if (step / self.length - 1.0).abs() > SAME_STEP {
            (self.regions, self.length) = (self.model.region_steps(self.motion, step)?, step);
        }
        Ok(())
    }
}

/// Halvings of a step at most.
const HALVINGS: usize = 4;
/// Steps whose lengths differ by less than this, relative, are equal: times are sums that round.
const SAME_STEP: f64 = 1e-9;

/// The law of each region alone.
fn without_history(regions: &[RegionStep]) -> Vec<ActingRegion> {
    regions.iter().map(|region| ActingRegion { moduli: region.moduli, held: Vec::new() }).collect()
}

impl Past {
    fn at_rest(r: usize) -> Self {
        let zero = || VecDeque::from([DVector::zeros(r)]);
        Self { times: VecDeque::from([0.0]), coordinates: zero(), velocities: zero(), forces: zero() }
    }

    fn stencil_to(&self, settings: &DynamicSettings, time: Second) -> Stencil {
        Stencil::new(settings.scheme, time - self.times[0], self.times.get(1).map(|then| self.times[0] - then))
    }

    fn weighted_history(&self, stencil: &Stencil) -> [DVector<f64>; 3] {
        [&self.coordinates, &self.velocities, &self.forces]
            .map(|past| DVector::from_vec(stencil.history(past.iter().map(|x| x.as_slice()))))
    }

    /// The polynomial through the past coordinates.
    fn initial_guess(&self, time: Second) -> DVector<f64> {
        let times: Vec<Second> = self.times.iter().copied().collect();
        let weights = extrapolation_weights(&times, time);
        let zero = DVector::zeros(self.coordinates[0].len());
        self.coordinates.iter().zip(weights).fold(zero, |sum, (q, w)| sum + q * w)
    }

    fn push_state(&mut self, time: Second, q: DVector<f64>, velocity: DVector<f64>, force: DVector<f64>) {
        self.forces.push_front(force);
        self.coordinates.push_front(q);
        self.velocities.push_front(velocity);
        self.times.push_front(time);
        // BDF2 needs two; through the third the guess is a parabola, whose error is of the order of the scheme's own.
        [&mut self.coordinates, &mut self.velocities, &mut self.forces].into_iter().for_each(|past| past.truncate(3));
        self.times.truncate(3);
    }
}
