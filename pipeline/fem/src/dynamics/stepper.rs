//! One implicit time step of M a + α M v + f(u) + β ḟ(u) = pressure + dead forces, and steps of equal length.
//!
//! The stiffness part of Rayleigh damping is the rate of the elastic force, β ḟ = β K(u) v with the current tangent: a
//! rigid rotation of an unstrained body is not damped, whereas the tangent at rest would brake a stiff sheet that
//! rotates.
//!
//! Both schemes write v = γ u + v̂ and a = γ v + â, and ḟ = γ f + f̂, with v̂, â, f̂ from the past (see `stencil`).
//! A step is then the minimum of an incremental potential (see `newton::potential`) with
//! c = γ² + αγ,  û = −(γ v̂ + â + α v̂)/c,  h = β f̂,  the moduli multiplied by 1 + βγ, and what `viscoelastic` adds.

use crate::dynamics::refactorisation::RefactorisationPolicy;
use crate::dynamics::settings::{self, DynamicSettings, InitialValueProblem, Scheme, State};
use crate::dynamics::stencil::{Stencil, extrapolation_weights};
use crate::newton::options::{Globalisation, NewtonCounts, NewtonOptions, NonConvergence};
use crate::newton::potential::Inertia;
use crate::solve_error::SolveError;
use crate::solver_state::SolverState;
use crate::statics::equilibrium::StaticSettings;
use crate::viscoelastic::history::History;
use crate::viscoelastic::step;
use si::{Pascal, Second};
use std::collections::VecDeque;

/// Newton iterations at most in one time step.
const MAX_ITERATIONS: usize = 60;
/// Within a step, a lagged factor is replaced when it is predicted to need more iterations than this.
const MAX_PREDICTED: f64 = 10.0;
/// Iterations on a lagged factor before its rate is judged.
const MIN_STEPS: usize = 3;
/// Cost of a factorisation in Newton iterations, each with its energy: from the timings of a body of 40k dofs.
const FACTORISATION_COST: f64 = 8.0;
/// Past shapes from which the initial guess of a step is extrapolated.
const PAST: usize = 4;

/// State of the stepper: what the next step needs of the past.
#[derive(Debug, Clone)]
pub(crate) struct StepperState {
    /// Newest first.
    pub states: VecDeque<State>,
    /// The time of each, s.
    pub times: VecDeque<Second>,
    /// Elastic forces of the newest two, with stiffness damping.
    forces: VecDeque<Vec<f64>>,
    /// Of the newest state, where a region relaxes.
    pub history: Option<History>,
    // One factor serves many steps: L-BFGS pairs of the steps correct it, and the policy replaces it when that pays.
    policy: RefactorisationPolicy,
}

impl StepperState {
    /// From states (newest first) at their times, and the history of the newest; the first step begins with a new
    /// factorisation.
    pub fn new(states: Vec<State>, times: Vec<Second>, history: Option<History>) -> Self {
        let policy = RefactorisationPolicy::new(FACTORISATION_COST);
        Self { states: states.into(), times: times.into(), forces: VecDeque::new(), history, policy }
    }

    /// Restarts from the newest two states alone, as a checkpoint stores them: a stepper from these takes the same
    /// steps to the byte.
    pub(crate) fn restart(&mut self) {
        let states = self.states.iter().take(2).cloned();
        let times = self.times.iter().copied().take(2);
        *self = Self::new(states.collect(), times.collect(), self.history.take());
    }

    /// The stencil of a step to `time`.
    fn stencil_to(&self, settings: &DynamicSettings, time: Second) -> Stencil {
        let previous_step = self.times.get(1).map(|then| self.times[0] - then);
        Stencil::new(settings.scheme, time - self.times[0], previous_step)
    }

    fn past_displacements(&self) -> impl Iterator<Item = &[f64]> {
        self.states.iter().map(|state| state.displacement.as_slice())
    }

    /// Initial guess at `time`: the polynomial through the newest `count` shapes, or along the velocity from a single
    /// one.
    pub(crate) fn initial_guess(&self, count: usize, time: Second) -> Vec<f64> {
        let count = count.min(self.states.len());
        if count == 1 {
            let State { displacement, velocity } = &self.states[0];
            let step = time - self.times[0];
            return displacement.iter().zip(velocity).map(|(u, v)| u + step * v).collect();
        }
        let times: Vec<Second> = self.times.iter().copied().take(count).collect();
        let mut guess = vec![0.0; self.states[0].displacement.len()];
        for (weight, shape) in extrapolation_weights(&times, time).iter().zip(self.past_displacements()) {
            guess.iter_mut().zip(shape).for_each(|(guess, u)| *guess += weight * u);
        }
        guess
    }

    /// The newest state.
    pub(crate) fn into_newest(mut self) -> State {
        self.states.swap_remove_front(0).expect("a stepper holds at least the initial state")
    }
}

impl SolverState {
    /// See [`crate::Solver::integrate`].
    pub(crate) fn integrate(
        &mut self,
        problem: &InitialValueProblem,
        steps: usize,
        observe: &mut dyn FnMut(Second, &State),
    ) -> Result<State, SolveError> {
        let mut stepper = self.start(problem.settings, problem.initial)?;
        for step in 1..=steps {
            let time = step as f64 * problem.settings.step;
            self.step_to(problem.settings, &mut stepper, time, &(problem.pressures)(time))?;
            observe(time, &stepper.states[0]);
        }
        Ok(stepper.into_newest())
    }

    /// A stepper at `initial` at time 0.
    pub(crate) fn start(&mut self, settings: &DynamicSettings, initial: &State) -> Result<StepperState, SolveError> {
        settings::check_settings(settings)?;
        self.check_field("the initial displacement", &initial.displacement)?;
        self.check_field("the initial velocity", &initial.velocity)?;
        self.linearised = None;
        let first = State {
            displacement: self.with_clamps_at(&initial.displacement, 1.0),
            velocity: self.with_constraints(&initial.velocity),
        };
        let history = self.relaxed_history(&first.displacement);
        Ok(StepperState::new(vec![first], vec![0.0], history))
    }

    /// The history of a body that has been held at `u` for ever; none when no region relaxes.
    fn relaxed_history(&self, u: &[f64]) -> Option<History> {
        let regions = step::region_steps(&self.inputs.properties, 0.0)?;
        Some(History::relaxed(&self.data, &regions, u))
    }

    /// One step to `time`; the stepper is unchanged when it fails.
    pub(crate) fn step_to(
        &mut self,
        settings: &DynamicSettings,
        stepper: &mut StepperState,
        time: Second,
        pressures: &[Pascal],
    ) -> Result<(), SolveError> {
        self.check_pressures(pressures)?;
        let regions = step::region_steps(&self.inputs.properties, time - stepper.times[0]);
        let past = regions.as_deref().zip(stepper.history.as_ref());
        let stencil = stepper.stencil_to(settings, time);
        self.inputs.begin_step(&self.data, 1.0 + settings.stiffness_damping * stencil.gamma, past);
        let result = self.step(settings, stepper, time, pressures);
        self.inputs.end_step();
        let (state, counts) = result?;
        if let Some((regions, history)) = regions.as_deref().zip(stepper.history.as_mut()) {
            *history = history.advanced(&self.data, regions, &state.displacement);
        }
        if settings.stiffness_damping > 0.0 {
            stepper.forces.push_front(self.elastic_forces(&state.displacement));
            stepper.forces.truncate(2);
        }
        stepper.policy.count_step(counts.iterations, counts.factorisations > 0);
        stepper.states.push_front(state);
        stepper.states.truncate(PAST);
        stepper.times.push_front(time);
        stepper.times.truncate(PAST);
        Ok(())
    }

    /// The state at the end of a step that has begun.
    fn step(
        &mut self,
        settings: &DynamicSettings,
        stepper: &mut StepperState,
        time: Second,
        pressures: &[Pascal],
    ) -> Result<(State, NewtonCounts), SolveError> {
        if settings.scheme == Scheme::QuasiStatic {
            return self.quasi_static_step(settings, &stepper.states[0].displacement, pressures);
        }
        self.implicit_step(settings, stepper, time, pressures).map_err(|cause| {
            let reached = stepper.times[0];
            SolveError::TimeStep { time: reached, step: time - reached, cause }
        })
    }

    /// The equilibrium after the history until then, from the shape before.
    fn quasi_static_step(
        &mut self,
        settings: &DynamicSettings,
        previous: &[f64],
        pressures: &[Pascal],
    ) -> Result<(State, NewtonCounts), SolveError> {
        let settings = StaticSettings { tolerance: settings.tolerance, ..StaticSettings::default() };
        // The first step from rest may carry the whole load: without a guess it is applied in steps, with zeros at
        // once.
        let guess = previous.iter().any(|u| *u != 0.0).then_some(previous);
        let equilibrium = self.equilibrium(pressures, guess, &settings)?;
        let counts = NewtonCounts {
            iterations: equilibrium.iterations,
            factorisations: equilibrium.factorisations,
            ..NewtonCounts::default()
        };
        Ok((State { velocity: vec![0.0; previous.len()], displacement: equilibrium.displacement }, counts))
    }

    fn implicit_step(
        &mut self,
        settings: &DynamicSettings,
        stepper: &mut StepperState,
        time: Second,
        pressures: &[Pascal],
    ) -> Result<(State, NewtonCounts), NonConvergence> {
        if settings.stiffness_damping > 0.0 && stepper.forces.is_empty() {
            stepper.forces = stepper.past_displacements().take(2).map(|u| self.elastic_forces(u)).collect();
        }
        let mut displacement =
            self.admissible_shape(&stepper.states[0].displacement, stepper.initial_guess(PAST, time));
        self.couple_contact(&displacement)?;
        let stencil = stepper.stencil_to(settings, time);
        let inertia = self.step_inertia(settings, &stencil, stepper);
        let potential = self.inputs.at_rest(&self.data, pressures).in_motion(&inertia);
        // Inertia keeps the minimum close to the initial guess; the line search keeps the iteration safe where a
        // pressure jumps.
        let options = NewtonOptions {
            tolerance: settings.tolerance * self.data.size,
            max_iterations: MAX_ITERATIONS,
            max_predicted: MAX_PREDICTED,
            min_steps: MIN_STEPS,
            refactorise: stepper.policy.refactorise,
            predicted: false,
            globalisation: Globalisation::LineSearch,
        };
        // Extrapolation may invert an element after a jump of the pressure; the last shape does not.
        let counts = self.newton.minimise(&potential, &mut displacement, None, &options).or_else(|_| {
            displacement.clone_from(&stepper.states[0].displacement);
            let options = NewtonOptions { refactorise: true, ..options };
            self.newton.minimise(&potential, &mut displacement, None, &options)
        })?;
        let velocity = stencil.rate(&displacement, stepper.past_displacements());
        Ok((State { displacement, velocity }, counts))
    }

    /// c, û and h of one step.
    fn step_inertia(&self, settings: &DynamicSettings, stencil: &Stencil, stepper: &StepperState) -> Inertia {
        let (alpha, beta, gamma) = (settings.mass_damping, settings.stiffness_damping, stencil.gamma);
        let rate = gamma * gamma + alpha * gamma;
        let v = stencil.history(stepper.past_displacements());
        let a = stencil.history(stepper.states.iter().map(|state| state.velocity.as_slice()));
        let centre: Vec<f64> = v.iter().zip(&a).map(|(v, a)| -((gamma + alpha) * v + a) / rate).collect();
        let free = self.data.pattern.gather(&centre);
        let mut history = Vec::new();
        if beta > 0.0 {
            history = stencil.history(stepper.forces.iter().map(Vec::as_slice));
            history.iter_mut().for_each(|force| *force *= beta);
        }
        Inertia { rate, centre: free, history }
    }
}
