//! Sensitivities of a motion, forwards in time: how each state changes with a parameter.
//!
//! The derivative of step n (see `backward`): K δu = −∂r/∂θ − Σ wⱼ [(γ + α) M δuₙ₋ⱼ + M δvₙ₋ⱼ + β (K_f δu)ₙ₋ⱼ + β (∂f/∂θ)ₙ₋ⱼ].
//!
//! Stands on: `trajectory`, `tangent`, `parameter`, `products`. Never knows: a loss.

use crate::algebra::vectors::add;
use crate::descent::potential::Inertia;
use crate::motion::backward::demand;
use crate::motion::march::{March, State};
use crate::motion::stencil::Stencil;
use crate::motion::trajectory::{Stretch, Trajectory};
use crate::parameter::Parameter;
use crate::solver::Solver;
use crate::stall::SolveError;
use std::collections::VecDeque;

/// One parameter on its way: derivatives of the newest states, newest first.
struct Change {
    parameter: Parameter,
    states: VecDeque<State>,
    /// K_f δu + ∂f/∂θ of each, when it damps.
    pulls: VecDeque<Vec<f64>>,
}

impl Solver {
    /// du/dθ and dv/dθ of every state of a recorded motion for each of `parameters`; `observe` sees the step (0 for the
    /// initial state) and one pair for each parameter, 3 a node, per unit of the parameter.
    ///
    /// # Errors
    /// [`SolveError`] when a parameter names what does not exist, or a step's tangent is not positive definite.
    pub fn sensitivities(
        &mut self,
        trajectory: &Trajectory,
        parameters: &[Parameter],
        observe: &mut dyn FnMut(usize, &[&State]),
    ) -> Result<(), SolveError> {
        parameters.iter().try_for_each(|&parameter| self.check_parameter(parameter))?;
        let mut changes: Vec<Change> = parameters.iter().map(|&parameter| self.first_change(parameter)).collect();
        let tell = |n: usize, changes: &[Change], observe: &mut dyn FnMut(usize, &[&State])| {
            observe(n, &changes.iter().map(|change| &change.states[0]).collect::<Vec<_>>());
        };
        tell(0, &changes, observe);
        for number in 0..trajectory.stretches() {
            let stretch = self.repeat(trajectory, number)?;
            let (first, last) = trajectory.bounds(number);
            for n in first..=last {
                for change in &mut changes {
                    if trajectory.march.stiffness_damping > 0.0 && n == 1 {
                        let pull = self.pull(&stretch.state(0).displacement, change);
                        change.pulls.push_front(pull);
                    }
                    self.carry(trajectory, &stretch, n, change)?;
                }
                tell(n, &changes, observe);
            }
        }
        self.linearised = None;
        Ok(())
    }

    /// The derivative of the initial state.
    fn first_change(&self, parameter: Parameter) -> Change {
        let mut state = State::rest(self.parts.mesh.nodes.len());
        match parameter {
            Parameter::InitialDisplacement { node, axis } => state.displacement[3 * node + axis] = 1.0,
            Parameter::InitialVelocity { node, axis } => state.velocity[3 * node + axis] = 1.0,
            _ => {}
        }
        let state = State {
            displacement: self.with_held_at_rest(&state.displacement),
            velocity: self.with_held_at_rest(&state.velocity),
        };
        Change { parameter, states: VecDeque::from([state]), pulls: VecDeque::new() }
    }

    /// K_f δu + ∂f/∂θ at the newest state.
    fn pull(&mut self, u: &[f64], change: &Change) -> Vec<f64> {
        let mut pull = self.elastic_stiffness_times(u, &change.states[0].displacement);
        add(&mut pull, 1.0, &self.elastic_push(u, change.parameter));
        pull
    }

    /// One parameter one step on.
    fn carry(
        &mut self,
        trajectory: &Trajectory,
        stretch: &Stretch,
        n: usize,
        change: &mut Change,
    ) -> Result<(), SolveError> {
        let march = &trajectory.march;
        let stencil = trajectory.stencil(n);
        let push = self.balance_push(trajectory, stretch, n, change, &stencil);
        let u = &stretch.state(n).displacement;
        let displacement = self.solve_on(march, trajectory.pressures(n), &stencil, u, &push)?;
        let past = change.states.iter().map(|state| state.displacement.as_slice());
        let velocity = stencil.rate(&displacement, past);
        change.states.push_front(State { displacement, velocity });
        change.states.truncate(2);
        if march.stiffness_damping > 0.0 {
            let pull = self.pull(u, change);
            change.pulls.push_front(pull);
            change.pulls.truncate(2);
        }
        Ok(())
    }

    /// The right-hand side without its sign, 3 a node.
    fn balance_push(
        &self,
        trajectory: &Trajectory,
        stretch: &Stretch,
        n: usize,
        change: &Change,
        stencil: &Stencil,
    ) -> Vec<f64> {
        let March { mass_damping: alpha, stiffness_damping: beta, .. } = trajectory.march;
        let State { displacement: u, velocity: v } = stretch.state(n);
        let mut push = self.load_push(u, trajectory.pressures(n), change.parameter);
        add(&mut push, 1.0 + beta * stencil.gamma, &self.elastic_push(u, change.parameter));
        let mut moved = stencil.history(change.states.iter().map(|state| state.displacement.as_slice()));
        moved.iter_mut().for_each(|entry| *entry *= stencil.gamma + alpha);
        add(&mut moved, 1.0, &stencil.history(change.states.iter().map(|state| state.velocity.as_slice())));
        add(&mut push, 1.0, &self.mass_times(&moved));
        add(&mut push, beta, &stencil.history(change.pulls.iter().map(Vec::as_slice)));
        let shape = |j: usize| stretch.state(n - j);
        match change.parameter {
            Parameter::Density(region) => {
                let past = (1..=stencil.weights.len()).map(|j| shape(j).velocity.as_slice());
                let mut moved = stencil.rate(v, past);
                add(&mut moved, alpha, v);
                self.parts.overlaps.add_product(&self.parts.mesh, region, &moved, &mut push);
            }
            Parameter::MassDamping => add(&mut push, 1.0, &self.mass_times(v)),
            Parameter::StiffnessDamping => {
                let past: Vec<Vec<f64>> =
                    (1..=stencil.weights.len()).map(|j| self.elastic_forces(&shape(j).displacement)).collect();
                add(&mut push, 1.0, &stencil.rate(&self.elastic_forces(u), past.iter().map(Vec::as_slice)));
            }
            _ => {}
        }
        push
    }

    /// −K⁻¹ push with the tangent of one step, 3 a node.
    fn solve_on(
        &mut self,
        march: &March,
        pressures: &[f64],
        stencil: &Stencil,
        u: &[f64],
        push: &[f64],
    ) -> Result<Vec<f64>, SolveError> {
        let gamma = stencil.gamma;
        let inertia = Inertia { rate: gamma * gamma + march.mass_damping * gamma, ..Inertia::default() };
        let Self { parts, given, newton, .. } = self;
        let potential = given.in_motion(parts, pressures, 1.0 + march.stiffness_damping * gamma, &inertia);
        newton.linearise(&potential, u);
        let mut b = Vec::new();
        parts.pattern.gather(push, &mut b);
        let (free, _) = newton.solve_exactly(&potential, u, &b, demand(march)).ok_or(SolveError::NotStable)?;
        let mut change = vec![0.0; push.len()];
        parts.pattern.spread(&free, -1.0, &mut change);
        Ok(change)
    }
}
