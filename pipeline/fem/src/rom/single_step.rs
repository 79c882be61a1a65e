//! One step of a reduced model from any state, and its gradient: the interface of controllers and of training.
//!
//! Implicit Euler with γ = 1/Δt: q̇⁺ = γ (q⁺ − q), and q⁺ solves
//! r = M [(γ + α) γ (q⁺ − q) − γ q̇] + (1 + βγ) f(q⁺) − βγ f(q) − Σ p ∂V(q⁺) = 0.
//! For a loss of (q⁺, q̇⁺) with derivatives a and b: K λ = a + γ b with the symmetric K = ∂r/∂q⁺, and every derivative is
//! −λ · ∂r, that by q with −γ b more.

use nalgebra::DVector;
use si::Pascal;

use super::elastic_forces::{ActingRegion, ReducedTangent};
use super::error::ReducedError;
use super::model::ReducedModel;
use super::step::{NoForce, Step, no_convergence};
use crate::dynamics::settings::{self, DynamicSettings};
use crate::dynamics::stencil::Stencil;
use crate::solve_error::SolveError;

/// State of a reduced model.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedState {
    /// q
    pub coordinates: DVector<f64>,
    /// q̇, 1/s.
    pub velocity: DVector<f64>,
}

/// What one step depends on beside the state.
#[derive(Debug, Clone, Copy)]
pub struct ReducedStep<'a> {
    /// Step and dampings; the scheme is implicit Euler, the tolerance the reduced model's own.
    pub settings: &'a DynamicSettings,
    /// One per chamber, Pa.
    pub pressures: &'a [Pascal],
    /// Factor of the moduli, one per region.
    pub modulus_scale: &'a [f64],
}

/// The gradient of a loss of the state after a step.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedStepGradient {
    /// By q and q̇ before the step.
    pub state: ReducedState,
    /// One per chamber, unit of L per Pa.
    pub pressures: Vec<f64>,
    /// By the factor of the moduli, one per region, unit of L.
    pub modulus_scale: Vec<f64>,
}

impl ReducedModel {
    /// The state after a step from `state`; regions that relax do so as their long-term law.
    ///
    /// # Errors
    /// [`ReducedError`] when a list has the wrong length, a setting is out of range, or the step does not converge.
    pub fn step(&self, state: &ReducedState, given: &ReducedStep) -> Result<ReducedState, ReducedError> {
        self.check_step(state, given)?;
        let (gamma, q) = (1.0 / given.settings.step, &state.coordinates);
        let [acting, law] =
            [1.0 + given.settings.stiffness_damping * gamma, 1.0].map(|factor| self.scaled_regions(given, factor));
        let stencil = Stencil { gamma, weights: vec![-gamma] };
        let past = [-gamma * q, -gamma * &state.velocity, -gamma * self.acting_forces(q, &law)];
        let equations = Step {
            model: self,
            settings: given.settings,
            stencil: &stencil,
            pressures: given.pressures,
            acting: &acting,
            external: &NoForce,
            contact: None,
            time: given.settings.step,
            past,
        };
        let guess = q + &state.velocity * given.settings.step;
        let solution = equations.solve(&guess, q, &mut None);
        let coordinates = solution.map_err(|change| no_convergence(0.0, change))?;
        Ok(ReducedState { velocity: (&coordinates - q) * gamma, coordinates })
    }

    /// The gradient of a loss of the state `after` the step from `state`, from the derivatives `loss` of it.
    ///
    /// # Errors
    /// [`ReducedError`] as [`ReducedModel::step`]; also when the tangent at `after` is singular.
    pub fn step_gradient(
        &self,
        (state, after): (&ReducedState, &ReducedState),
        given: &ReducedStep,
        loss: &ReducedState,
    ) -> Result<ReducedStepGradient, ReducedError> {
        [state, after, loss].iter().try_for_each(|of| self.check_step(of, given))?;
        let DynamicSettings { step, mass_damping: alpha, stiffness_damping: beta, .. } = *given.settings;
        let (gamma, q, next) = (1.0 / step, &state.coordinates, &after.coordinates);
        let [acting, law] = [1.0 + beta * gamma, 1.0].map(|by| self.scaled_regions(given, by));
        let mut tangent = &self.mass * (gamma * (gamma + alpha));
        tangent += self.acting_stiffness(next, ReducedTangent::Exact, &acting);
        for (chamber, pressure) in self.chambers.iter().zip(given.pressures) {
            chamber.add_hessian(next, -pressure, &mut tangent);
        }
        let right = &loss.coordinates + &loss.velocity * gamma;
        let lambda = tangent.lu().solve(&right).ok_or(SolveError::NotStable)?;
        let momentum = &self.mass * &lambda;
        let mut by_q = &momentum * (gamma * (gamma + alpha)) - &loss.velocity * gamma;
        if beta > 0.0 {
            by_q += self.acting_stiffness(q, ReducedTangent::Exact, &law) * &lambda * (beta * gamma);
        }
        let by_pressure = |chamber: &super::chamber_volume::CubicVolume| {
            let mut gradient = DVector::zeros(q.len());
            chamber.add_gradient(next, 1.0, &mut gradient);
            gradient.dot(&lambda)
        };
        let by_scale = |region: usize| {
            let work = |at: &DVector<f64>| self.region_forces(region, at).dot(&lambda);
            beta * gamma * work(q) - (1.0 + beta * gamma) * work(next)
        };
        Ok(ReducedStepGradient {
            pressures: self.chambers.iter().map(by_pressure).collect(),
            modulus_scale: (0..self.regions).map(by_scale).collect(),
            state: ReducedState { coordinates: by_q, velocity: momentum * gamma },
        })
    }

    /// The elastic forces of one region at `q`, by its moduli alone.
    fn region_forces(&self, region: usize, q: &DVector<f64>) -> DVector<f64> {
        let mut forces = DVector::zeros(q.len());
        for points in self.points.iter().filter(|points| points.region == region) {
            let moduli = points.elastic().moduli;
            points.add_forces(q, &ActingRegion { moduli, held: Vec::new() }, &mut forces);
        }
        forces
    }

    /// The law of each region, its moduli multiplied by its scale and by `factor`.
    fn scaled_regions(&self, given: &ReducedStep, factor: f64) -> Vec<ActingRegion> {
        self.elastic(&given.modulus_scale.iter().map(|scale| factor * scale).collect::<Vec<_>>())
    }

    fn check_step(&self, state: &ReducedState, given: &ReducedStep) -> Result<(), ReducedError> {
        settings::check_settings(given.settings)?;
        let lists = [
            ("the coordinates of a state", state.coordinates.as_slice(), self.coordinates()),
            ("the velocity of a state", state.velocity.as_slice(), self.coordinates()),
            ("a list of pressures", given.pressures, self.chambers.len()),
            ("a list of scales of the moduli", given.modulus_scale, self.regions),
        ];
        lists
            .into_iter()
            .try_for_each(|(what, values, required)| crate::solver_state::check_values(what, values, required))?;
        Ok(())
    }
}
