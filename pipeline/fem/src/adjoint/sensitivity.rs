//! Forward sensitivity of a motion: the derivative of each state by a parameter, forwards in time.
//!
//! The derivative of step n (see `adjoint::dynamics`):
//! K δu = −∂r/∂θ − Σ wⱼ [(γ + α) M δuₙ₋ⱼ + M δvₙ₋ⱼ + β (K_f δu)ₙ₋ⱼ + β (∂f/∂θ)ₙ₋ⱼ].

use crate::adjoint::dynamics::pcg_options;
use crate::adjoint::parameter::Parameter;
use crate::dynamics::settings::{DynamicSettings, State};
use crate::dynamics::trajectory::{Trajectory, TrajectoryStep};
use crate::newton::potential::Inertia;
use crate::solve_error::SolveError;
use crate::solver_state::SolverState;
use crate::viscoelastic::sensitivity::{Direction, HistorySensitivity};
use crate::viscoelastic::step;
use sparse::add;
use std::collections::VecDeque;
use std::sync::Arc;

/// Derivatives by one parameter of the newest states, newest first.
struct Sensitivity {
    parameter: Parameter,
    states: VecDeque<State>,
    /// df/dθ = K_f δu + ∂f/∂θ of each, with stiffness damping.
    elastic: VecDeque<Vec<f64>>,
    /// What it changes of the materials.
    direction: Option<Direction>,
    /// Of the newest history, where a region relaxes.
    history: Option<HistorySensitivity>,
}

impl SolverState {
    /// See [`crate::Solver::trajectory_sensitivity`].
    pub(crate) fn trajectory_sensitivity(
        &mut self,
        trajectory: &Trajectory,
        parameters: &[Parameter],
        observe: &mut dyn FnMut(usize, &[&State]),
    ) -> Result<(), SolveError> {
        parameters.iter().try_for_each(|&parameter| self.check_parameter(parameter))?;
        let mut sensitivities: Vec<Sensitivity> =
            parameters.iter().map(|&parameter| self.of_initial_state(parameter)).collect();
        let mut report = |n: usize, sensitivities: &[Sensitivity]| {
            observe(n, &sensitivities.iter().map(|sensitivity| &sensitivity.states[0]).collect::<Vec<_>>());
        };
        report(0, &sensitivities);
        for number in 0..trajectory.segments() {
            let segment = self.segment(trajectory, number)?;
            let (first, last) = trajectory.segment_bounds(number);
            if number == 0 {
                let u = &segment.state(0).displacement;
                sensitivities.iter_mut().for_each(|sensitivity| self.start_history(u, sensitivity));
            }
            for n in first..=last {
                for sensitivity in &mut sensitivities {
                    if trajectory.settings.stiffness_damping > 0.0 && n == 1 {
                        let elastic = self.elastic_sensitivity(&segment.state(0).displacement, sensitivity);
                        sensitivity.elastic.push_front(elastic);
                    }
                    self.sensitivity_step(&TrajectoryStep::new(trajectory, &segment, n), sensitivity)?;
                }
                report(n, &sensitivities);
            }
        }
        self.linearised = None;
        Ok(())
    }

    /// The derivative of the initial state.
    fn of_initial_state(&self, parameter: Parameter) -> Sensitivity {
        let mut state = State::rest(self.data.mesh.nodes.len());
        match parameter {
            Parameter::InitialDisplacement { node, axis } => state.displacement[3 * node + axis] = 1.0,
            Parameter::InitialVelocity { node, axis } => state.velocity[3 * node + axis] = 1.0,
            _ => {}
        }
        let state = State {
            displacement: self.with_constraints(&state.displacement),
            velocity: self.with_constraints(&state.velocity),
        };
        let direction = Direction::of(parameter, &self.inputs.properties);
        Sensitivity { parameter, states: VecDeque::from([state]), elastic: VecDeque::new(), direction, history: None }
    }

    /// The derivative of the initial history at the displacement `u`.
    fn start_history(&self, u: &[f64], of: &mut Sensitivity) {
        let du = &of.states[0].displacement;
        let regions = step::region_steps(&self.inputs.properties, 0.0);
        of.history = regions.map(|regions| HistorySensitivity::relaxed(&self.data, &regions, (u, du)));
    }

    /// df/dθ = K_f δu + ∂f/∂θ at the newest state.
    fn elastic_sensitivity(&mut self, u: &[f64], sensitivity: &Sensitivity) -> Vec<f64> {
        let mut elastic = self.elastic_stiffness_times(u, &sensitivity.states[0].displacement);
        add(&mut elastic, 1.0, &self.elastic_residual_derivative(u, sensitivity.parameter));
        elastic
    }

    /// Advances the derivatives by one step.
    fn sensitivity_step(&mut self, step: &TrajectoryStep, of: &mut Sensitivity) -> Result<(), SolveError> {
        let regions = step::region_steps(&self.inputs.properties, step.length());
        let data = Arc::clone(&self.data);
        let past = step.history_step(&data, regions.as_deref());
        let mut derivative = self.step_residual_derivative(step, of);
        if let Some((history, past)) = of.history.as_ref().zip(past.as_ref()) {
            history.add_residual(past, of.direction.as_ref(), &mut derivative);
        }
        let scale = 1.0 + step.trajectory.settings.stiffness_damping * step.stencil.gamma;
        self.inputs.begin_step(&data, scale, past.map(|past| (past.regions, past.before)));
        let solved = self.solve_step(step, &derivative);
        self.inputs.end_step();
        let displacement = solved?;
        if let Some((history, past)) = of.history.as_mut().zip(past.as_ref()) {
            history.advance(past, &displacement, of.direction.as_ref());
        }
        let past = of.states.iter().map(|state| state.displacement.as_slice());
        let velocity = step.stencil.rate(&displacement, past);
        of.states.push_front(State { displacement, velocity });
        of.states.truncate(2);
        if step.trajectory.settings.stiffness_damping > 0.0 {
            let elastic = self.elastic_sensitivity(&step.state().displacement, of);
            of.elastic.push_front(elastic);
            of.elastic.truncate(2);
        }
        Ok(())
    }

    /// ∂r/∂θ of one step, with the derivatives of the past; 3 entries per node.
    fn step_residual_derivative(&self, step: &TrajectoryStep, of: &Sensitivity) -> Vec<f64> {
        let DynamicSettings { mass_damping: alpha, stiffness_damping: beta, .. } = step.trajectory.settings;
        let State { displacement: u, velocity: v } = step.state();
        let stencil = &step.stencil;
        let mut derivative = self.load_residual_derivative(u, step.pressures(), of.parameter);
        add(&mut derivative, 1.0 + beta * stencil.gamma, &self.elastic_residual_derivative(u, of.parameter));
        let mut inertial = stencil.history(of.states.iter().map(|state| state.displacement.as_slice()));
        inertial.resize(derivative.len(), 0.0);
        inertial.iter_mut().for_each(|entry| *entry *= stencil.gamma + alpha);
        add(&mut inertial, 1.0, &stencil.history(of.states.iter().map(|state| state.velocity.as_slice())));
        add(&mut derivative, 1.0, &self.mass_times(&inertial));
        add(&mut derivative, beta, &stencil.history(of.elastic.iter().map(Vec::as_slice)));
        match of.parameter {
            Parameter::Density(region) => {
                let mut rate = step.acceleration();
                add(&mut rate, alpha, v);
                self.data.products.add_product(&self.data.mesh, region, &rate, &mut derivative);
            }
            Parameter::MassDamping => add(&mut derivative, 1.0, &self.mass_times(v)),
            Parameter::StiffnessDamping => {
                let past: Vec<Vec<f64>> = step.past().map(|state| self.elastic_forces(&state.displacement)).collect();
                add(&mut derivative, 1.0, &stencil.rate(&self.elastic_forces(u), past.iter().map(Vec::as_slice)));
            }
            _ => {}
        }
        derivative
    }

    /// −K⁻¹ `derivative` with the tangent of one step, 3 entries per node.
    fn solve_step(&mut self, step: &TrajectoryStep, derivative: &[f64]) -> Result<Vec<f64>, SolveError> {
        let (settings, gamma) = (&step.trajectory.settings, step.stencil.gamma);
        let u = &step.state().displacement;
        let inertia = Inertia { rate: gamma * gamma + settings.mass_damping * gamma, ..Inertia::default() };
        self.couple_contact(u)?;
        let Self { data, inputs, newton, .. } = self;
        let potential = inputs.at_rest(data, step.pressures()).in_motion(&inertia);
        newton.linearise(&potential, u);
        let b = data.pattern.gather(derivative);
        let options = pcg_options(settings);
        let (free, _) = newton.tangent_solve(&potential, u, &b, options).ok_or(SolveError::NotStable)?;
        Ok(data.pattern.scattered(&free, -1.0, derivative.len()))
    }
}
