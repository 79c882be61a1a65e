//! Time integration of a reduced model under pressures and external forces.
//!
//! VᵀMV q̈ + α VᵀMV q̇ + f(q) + β ḟ(q) = Σ p ∂V/∂q + Q, with the backward differences of the full model.

use std::collections::VecDeque;

use nalgebra::DVector;
use si::{Pascal, Second};

use super::acting::ActingRegion;
use super::error::ReducedError;
use super::model::ReducedModel;
use super::step::{ExternalForce, Step, StepState, no_convergence};
use crate::dynamics::settings::{self, DynamicSettings};
use crate::dynamics::stencil::{Stencil, extrapolation};
use crate::solve_error::SolveError;
use materials::Relaxation;
use materials::step::RegionStep;

/// Actuation at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuation {
    /// One per chamber, Pa.
    pub pressures: Vec<Pascal>,
}

/// A motion of a reduced model from rest.
#[derive(Clone, Copy)]
pub struct ReducedMotion<'a> {
    /// How it is integrated; the tolerance is the reduced model's own.
    pub settings: &'a DynamicSettings,
    /// Factor of the moduli, one per region.
    pub modulus_scale: &'a [f64],
    /// Relaxation of the shear part, one per region; empty: none.
    pub relaxation: &'a [Relaxation],
    /// C₂₀/C₁₀ and C₃₀/C₁₀, one pair per region; empty: those of the system that was reduced.
    pub stiffening: &'a [[f64; 2]],
    /// Actuation at a time (s from the start).
    pub actuation: &'a dyn Fn(Second) -> Actuation,
}

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
    /// # Errors
    /// As [`ReducedModel::integrate`]; also when the times do not rise.
    pub fn integrate_at(
        &self,
        motion: &ReducedMotion,
        external: &mut dyn ExternalForce,
        times: &[Second],
        observe: &mut Observer<'_>,
    ) -> Result<(), ReducedError> {
        let ReducedMotion { settings, actuation, .. } = *motion;
        settings::check(settings)?;
        let mut past = Past::at_rest(self.coordinates());
        let mut regions = self.region_steps(motion, settings.step)?;
        let law = bare(&regions);
        let mut history = self.relaxed(&regions, &past.coordinates[0]);
        let (mut tangent, mut length) = (None, settings.step);
        for &time in times {
            let step = time - past.times[0];
            if step.is_nan() || step <= 0.0 {
                let (what, range) = ("a time", "above the time before it");
                return Err(SolveError::Setting { what, value: time, range }.into());
            }
            if (step / length - 1.0).abs() > SAME_STEP {
                (regions, length) = (self.region_steps(motion, step)?, step);
            }
            let stencil = past.stencil(settings, time);
            let Actuation { pressures } = actuation(time);
            let acting = self.acting(&regions, 1.0 + settings.stiffness_damping * stencil.gamma, &history);
            let equations = Step {
                model: self,
                settings,
                stencil: &stencil,
                pressures: &pressures,
                acting: &acting,
                external: &*external,
                past: past.history(&stencil),
            };
            let previous = &past.coordinates[0];
            let q = equations
                .solve(&past.initial_guess(time), previous, &mut tangent)
                .map_err(|change| no_convergence(past.times[0], change))?;
            let velocity = equations.velocity(&q);
            let (gamma, weights) = (stencil.gamma, &stencil.weights);
            external.accept(&StepState { coordinates: &q, velocity: &velocity, gamma, weights });
            observe(time, &q, &velocity);
            self.advance(&regions, &q, &mut history);
            // only stiffness damping asks for past forces
            let damped = settings.stiffness_damping > 0.0;
            let force = if damped { self.acting_forces(&q, &law) } else { DVector::zeros(q.len()) };
            past.push(time, q, velocity, force);
        }
        Ok(())
    }
}

/// Steps whose lengths differ by less than this, relative, are equal: times are sums that round.
const SAME_STEP: f64 = 1e-9;

/// The law of each region alone.
fn bare(regions: &[RegionStep]) -> Vec<ActingRegion> {
    regions.iter().map(|region| ActingRegion { moduli: region.moduli, held: Vec::new() }).collect()
}

impl Past {
    fn at_rest(r: usize) -> Self {
        let zero = || VecDeque::from([DVector::zeros(r)]);
        Self { times: VecDeque::from([0.0]), coordinates: zero(), velocities: zero(), forces: zero() }
    }

    fn stencil(&self, settings: &DynamicSettings, time: Second) -> Stencil {
        Stencil::new(settings.scheme, time - self.times[0], self.times.get(1).map(|then| self.times[0] - then))
    }

    fn history(&self, stencil: &Stencil) -> [DVector<f64>; 3] {
        [&self.coordinates, &self.velocities, &self.forces]
            .map(|past| DVector::from_vec(stencil.history(past.iter().map(|x| x.as_slice()))))
    }

    /// The polynomial through the past coordinates.
    fn initial_guess(&self, time: Second) -> DVector<f64> {
        let times: Vec<Second> = self.times.iter().copied().collect();
        let weights = extrapolation(&times, time);
        let zero = DVector::zeros(self.coordinates[0].len());
        self.coordinates.iter().zip(weights).fold(zero, |sum, (q, w)| sum + q * w)
    }

    fn push(&mut self, time: Second, q: DVector<f64>, velocity: DVector<f64>, force: DVector<f64>) {
        self.forces.push_front(force);
        self.coordinates.push_front(q);
        self.velocities.push_front(velocity);
        self.times.push_front(time);
        [&mut self.coordinates, &mut self.velocities, &mut self.forces].into_iter().for_each(|past| past.truncate(3));
        self.times.truncate(3);
    }
}
