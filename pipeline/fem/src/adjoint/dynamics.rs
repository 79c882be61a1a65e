//! Adjoint of a motion: one pass backwards in time for all parameters.
//!
//! Step n satisfies r = M a + α M v + f(u) + β ḟ − loads(u) = 0 with v = γ u + Σ wⱼ uₙ₋ⱼ, a = γ v + Σ wⱼ vₙ₋ⱼ and
//! ḟ = γ f(u) + Σ wⱼ f(uₙ₋ⱼ). From the last step to the first, with ū and v̄ the derivatives of the loss and of later
//! steps by a state:
//! ū ← ū + γ v̄ − K_f φ,  K λ = ū,  K = (γ² + αγ) M + (1 + βγ) K_f − loads';  then for each past state
//! ūₙ₋ⱼ += wⱼ (v̄ − (γ + α) M λ),  v̄ₙ₋ⱼ −= wⱼ M λ,  φₙ₋ⱼ += β wⱼ λ,
//! and dL/dθ −= λ · ∂r/∂θ, elastic parts with (1 + βγ) λ + φ in the place of λ. φ is stored as β ρ, ρₙ₋ⱼ += wⱼ λ: then
//! dL/dβ −= f(uₙ) · (γ λ + ρ), and one pass over the elements serves all constants.

use crate::adjoint::gradient::MotionGradient;
use crate::adjoint::parameter::Parameter;
use crate::dynamics::refactorisation::RefactorisationPolicy;
use crate::dynamics::settings::{DynamicSettings, State};
use crate::dynamics::stencil::Stencil;
use crate::dynamics::trajectory::{Trajectory, TrajectoryStep};
use crate::newton::potential::Inertia;
use crate::solve_error::SolveError;
use crate::solver_state::SolverState;
use crate::system_data::SystemData;
use crate::viscoelastic::adjoint::{AdjointHistory, RelaxationSums};
use crate::viscoelastic::step;
use materials::material::Moduli;
use materials::step::RegionStep;
use sparse::{PcgOptions, add, dot};
use std::collections::VecDeque;
use std::sync::Arc;

/// Derivative of a loss by one state; an empty list stands for zeros.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LossGradient {
    /// ∂L/∂u, 3 entries per node, unit of L per m.
    pub displacement: Vec<f64>,
    /// ∂L/∂v, 3 entries per node, unit of L per m/s.
    pub velocity: Vec<f64>,
}

/// Cost of a factorisation in PCG iterations: from the timings of a body of 40k dofs.
const FACTORISATION_COST: f64 = 18.0;

/// Accuracy of the adjoint and sensitivity solves: a tenth of the tolerance of the step itself, but no finer than
/// rounding allows.
pub(crate) fn pcg_options(settings: &DynamicSettings) -> PcgOptions {
    PcgOptions { tolerance: (0.1 * settings.tolerance).clamp(1e-10, 1e-6), max_iterations: 40 }
}

/// Derivatives by a state, of the loss and of later steps: ū, v̄ and ρ.
#[derive(Debug, Clone)]
struct AdjointState {
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    rate: Vec<f64>,
}

impl AdjointState {
    fn zero(full: usize) -> Self {
        Self { displacement: vec![0.0; full], velocity: vec![0.0; full], rate: vec![0.0; full] }
    }

    fn add_loss(&mut self, loss: &LossGradient) {
        add(&mut self.displacement, 1.0, &loss.displacement);
        add(&mut self.velocity, 1.0, &loss.velocity);
    }
}

/// The adjoint of the histories, and the sums of the gradient through them.
struct PastAdjoint {
    /// The regions, without a step.
    regions: Vec<RegionStep>,
    history: AdjointHistory,
    sums: Vec<RelaxationSums>,
}

impl PastAdjoint {
    /// Adds what the first step hands back to the initial state at `u`, to `right` (3 entries per node).
    fn add_initial_history(&self, data: &SystemData, u: &[f64], right: &mut [f64]) {
        self.history.add_right_side((data, &self.regions), false, u, right);
    }
}

impl SolverState {
    /// See [`crate::Solver::trajectory_adjoint`].
    pub(crate) fn trajectory_adjoint(
        &mut self,
        trajectory: &Trajectory,
        loss_gradient: &mut dyn FnMut(usize, &State) -> LossGradient,
    ) -> Result<MotionGradient, SolveError> {
        let mut gradient = self.zero_gradient(trajectory.steps());
        let full = self.data.full_length();
        let mut states = VecDeque::from(vec![AdjointState::zero(full); 3]);
        let mut policy = RefactorisationPolicy::new(FACTORISATION_COST);
        let mut past = self.adjoint_of_histories();
        for number in (0..trajectory.segments()).rev() {
            let segment = self.segment(trajectory, number)?;
            let (first, last) = trajectory.segment_bounds(number);
            for n in (first..=last).rev() {
                self.add_checked_loss(&loss_gradient(n, segment.state(n)), &mut states[0])?;
                let step = TrajectoryStep::new(trajectory, &segment, n);
                self.adjoint_step(&step, (&mut states, past.as_mut()), &mut gradient, &mut policy)?;
                states.pop_front();
                states.push_back(AdjointState::zero(full));
            }
            if number == 0 {
                self.add_checked_loss(&loss_gradient(0, segment.state(0)), &mut states[0])?;
                let beta = trajectory.settings.stiffness_damping;
                self.adjoint_of_initial_force(beta, segment.state(0), &mut states[0], &mut gradient);
                if let Some(past) = &past {
                    past.add_initial_history(&self.data, &segment.state(0).displacement, &mut states[0].displacement);
                    self.add_relaxation_gradient(&past.sums, &mut gradient);
                }
            }
        }
        self.linearised = None;
        let AdjointState { displacement, velocity, .. } = &states[0];
        gradient.initial =
            State { displacement: self.with_constraints(displacement), velocity: self.with_constraints(velocity) };
        Ok(gradient)
    }

    /// A gradient of zeros; moduli by element only where nothing relaxes.
    fn zero_gradient(&self, steps: usize) -> MotionGradient {
        let (nodes, chambers) = (self.data.mesh.nodes.len(), self.data.chambers.len());
        let mut gradient = MotionGradient::zero(nodes, self.inputs.properties.len(), chambers, steps);
        if step::region_steps(&self.inputs.properties, 0.0).is_none() {
            gradient.elements = vec![0.0; self.data.mesh.elements.len()];
        }
        gradient
    }

    fn add_checked_loss(&self, loss: &LossGradient, adjoint: &mut AdjointState) -> Result<(), SolveError> {
        self.check_loss_gradient(loss)?;
        adjoint.add_loss(loss);
        Ok(())
    }

    /// One step backwards; `states` holds the adjoint states n, n−1 and n−2.
    fn adjoint_step(
        &mut self,
        step: &TrajectoryStep,
        (states, past): (&mut VecDeque<AdjointState>, Option<&mut PastAdjoint>),
        gradient: &mut MotionGradient,
        policy: &mut RefactorisationPolicy,
    ) -> Result<(), SolveError> {
        let regions = step::region_steps(&self.inputs.properties, step.length());
        let Stencil { gamma, weights } = &step.stencil;
        let (alpha, beta) = (step.trajectory.settings.mass_damping, step.trajectory.settings.stiffness_damping);
        let AdjointState { displacement: mut right, velocity, rate } = states[0].clone();
        add(&mut right, *gamma, &velocity);
        if let Some((past, regions)) = past.as_deref().zip(regions.as_deref()) {
            past.history.add_right_side((&self.data, regions), true, &step.state().displacement, &mut right);
        }
        let data = Arc::clone(&self.data);
        let histories = step.history_step(&data, regions.as_deref());
        self.inputs.begin_step(&data, 1.0 + beta * gamma, histories.map(|of| (of.regions, of.before)));
        let solved = self.adjoint_solve(step, &right, &rate, policy);
        self.inputs.end_step();
        let lambda = solved?;
        if let Some((past, histories)) = past.zip(histories) {
            past.history.step_back(&histories, &lambda, &mut past.sums);
        }
        let mass_lambda = self.mass_times(&lambda);
        for (weight, past) in weights.iter().zip(states.iter_mut().skip(1)) {
            add(&mut past.displacement, *weight, &velocity);
            add(&mut past.displacement, -weight * (gamma + alpha), &mass_lambda);
            add(&mut past.velocity, -weight, &mass_lambda);
            add(&mut past.rate, *weight, &lambda);
        }
        let mut on_rate = rate;
        add(&mut on_rate, *gamma, &lambda);
        let mut on_elastic = lambda.clone();
        add(&mut on_elastic, beta, &on_rate);
        self.add_elastic_gradient(&step.state().displacement, &on_elastic, &on_rate, gradient);
        self.add_other_gradient(step, &lambda, gradient);
        Ok(())
    }

    /// λ of one step, 3 entries per node.
    fn adjoint_solve(
        &mut self,
        step: &TrajectoryStep,
        right: &[f64],
        rate: &[f64],
        policy: &mut RefactorisationPolicy,
    ) -> Result<Vec<f64>, SolveError> {
        let settings = &step.trajectory.settings;
        let gamma = step.stencil.gamma;
        let inertia = Inertia { rate: gamma * gamma + settings.mass_damping * gamma, ..Inertia::default() };
        let u = &step.state().displacement;
        self.couple_contact(u)?;
        let mut b = self.data.pattern.gather(right);
        if settings.stiffness_damping > 0.0 {
            let image = self.elastic_stiffness_times(u, rate);
            add(&mut b, -settings.stiffness_damping, &self.data.pattern.gather(&image));
        }
        let Self { data, inputs, newton, .. } = self;
        let potential = inputs.at_rest(data, step.pressures()).in_motion(&inertia);
        potential.elastic_stiffness(u, &mut newton.tangent);
        newton.complete_tangent(&potential, u);
        if policy.refactorise {
            newton.factorise(&potential, u, &b).map_err(|_| SolveError::NotStable)?;
        }
        let options = pcg_options(settings);
        let (free, iterations) = newton.tangent_solve(&potential, u, &b, options).ok_or(SolveError::NotStable)?;
        let lambda = data.pattern.scattered(&free, 1.0, right.len());
        policy.count_step(iterations, policy.refactorise);
        Ok(lambda)
    }

    /// The contribution of the initial elastic force, which enters the stiffness damping of the first steps.
    fn adjoint_of_initial_force(
        &mut self,
        beta: f64,
        initial: &State,
        state: &mut AdjointState,
        gradient: &mut MotionGradient,
    ) {
        let on_elastic: Vec<f64> = state.rate.iter().map(|rate| beta * rate).collect();
        self.add_elastic_gradient(&initial.displacement, &on_elastic, &state.rate, gradient);
        if beta > 0.0 {
            let image = self.elastic_stiffness_times(&initial.displacement, &on_elastic);
            add(&mut state.displacement, -1.0, &image);
        }
    }

    /// Adds −λ · ∂r/∂θ of the elastic forces at `u` for E, ν and β.
    fn add_elastic_gradient(&self, u: &[f64], on_elastic: &[f64], on_rate: &[f64], gradient: &mut MotionGradient) {
        let body = self.inputs.body(&self.data);
        if !gradient.elements.is_empty() {
            add(&mut gradient.elements, 1.0, &self.element_gradients(&body.element_work(u, on_elastic)));
        }
        let work = body.virtual_work(u, on_elastic, on_rate);
        for ((region, properties), (by_moduli, rate)) in
            gradient.regions.iter_mut().zip(&self.inputs.properties).zip(work)
        {
            let work_by_change = |change: Moduli| {
                change.to_array().iter().zip(by_moduli).map(|(change, product)| change * product).sum::<f64>()
            };
            region.youngs_modulus -= work_by_change(properties.moduli_by_youngs_modulus());
            region.poissons_ratio -= work_by_change(properties.moduli_by_poissons_ratio());
            region
                .stiffening
                .iter_mut()
                .enumerate()
                .for_each(|(term, derivative)| *derivative -= work_by_change(properties.moduli_by_stiffening(term)));
            gradient.stiffness_damping -= rate;
        }
    }

    /// The adjoint of the histories after the last step; none when no region relaxes.
    fn adjoint_of_histories(&self) -> Option<PastAdjoint> {
        let regions = step::region_steps(&self.inputs.properties, 0.0)?;
        let sums = regions.iter().map(|region| RelaxationSums {
            by_branch: vec![[0.0; 2]; region.branches.len()],
            ..RelaxationSums::default()
        });
        let (sums, history) = (sums.collect(), AdjointHistory::zero(&self.data, &regions));
        Some(PastAdjoint { regions, history, sums })
    }

    /// Adds the gradient through the branches.
    fn add_relaxation_gradient(&self, sums: &[RelaxationSums], gradient: &mut MotionGradient) {
        for ((of, is), sums) in gradient.regions.iter_mut().zip(&self.inputs.properties).zip(sums) {
            of.youngs_modulus += sums.by_mu * is.moduli_by_youngs_modulus().mu;
            of.poissons_ratio += sums.by_mu * is.moduli_by_poissons_ratio().mu;
        }
        gradient.relaxation = sums.iter().map(|sums| sums.by_branch.clone()).collect();
    }

    /// Adds −λ · ∂r/∂θ of one step for all other parameters.
    fn add_other_gradient(&self, step: &TrajectoryStep, lambda: &[f64], gradient: &mut MotionGradient) {
        let State { displacement, velocity } = step.state();
        let pressures = step.pressures();
        let mut rate = step.acceleration();
        add(&mut rate, step.trajectory.settings.mass_damping, velocity);
        let regions = gradient.regions.len();
        let products = self.data.products.region_products(&self.data.mesh, regions, lambda, &rate);
        let load_derivative =
            |parameter| dot(lambda, &self.load_residual_derivative(displacement, pressures, parameter));
        for (region, (region_gradient, product)) in gradient.regions.iter_mut().zip(products).enumerate() {
            region_gradient.density -= product;
            if self.inputs.gravity != [0.0; 3] {
                region_gradient.density -= load_derivative(Parameter::Density(region));
            }
        }
        gradient.mass_damping -= dot(lambda, &self.mass_times(velocity));
        for (chamber, derivative) in gradient.pressures[step.n - 1].iter_mut().enumerate() {
            *derivative = -load_derivative(Parameter::Pressure(chamber));
            gradient.pressure_gains[chamber] += pressures[chamber] * *derivative;
        }
        add(&mut gradient.forces, 1.0, lambda);
    }

    fn check_loss_gradient(&self, loss: &LossGradient) -> Result<(), SolveError> {
        let by_displacement = ("the loss gradient by displacement", &loss.displacement);
        for (what, list) in [by_displacement, ("the loss gradient by velocity", &loss.velocity)] {
            if !list.is_empty() {
                self.check_field(what, list)?;
            }
        }
        Ok(())
    }
}
