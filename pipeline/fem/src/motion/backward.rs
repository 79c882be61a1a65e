//! Gradients of a motion, backwards in time: one pass for all parameters.
//!
//! Step n balances r = M a + α M v + f(u) + β ḟ − loads(u) = 0 with v = γ u + Σ wⱼ uₙ₋ⱼ, a = γ v + Σ wⱼ vₙ₋ⱼ and
//! ḟ = γ f(u) + Σ wⱼ f(uₙ₋ⱼ). From the last step to the first, with ū and v̄ what the loss and later steps ask of a state:
//! ū ← ū + γ v̄ − K_f φ,  K λ = ū,  K = (γ² + αγ) M + (1 + βγ) K_f − loads';  then for each past state
//! ūₙ₋ⱼ += wⱼ (v̄ − (γ + α) M λ),  v̄ₙ₋ⱼ −= wⱼ M λ,  φₙ₋ⱼ += β wⱼ λ,
//! and dL/dθ −= λ · ∂r/∂θ, elastic parts with (1 + βγ) λ + φ in the place of λ. φ is kept as β ρ, ρₙ₋ⱼ += wⱼ λ: then
//! dL/dβ −= f(uₙ) · (γ λ + ρ), and one pass over the elements serves all constants.
//!
//! Stands on: `trajectory`, `tangent`, `gather`. Never knows: what the loss measures.

use crate::algebra::vectors::add;
use crate::descent::potential::Inertia;
use crate::descent::tangent::Demand;
use crate::motion::gather::{Behind, MotionGradient};
use crate::motion::march::{March, State};
use crate::motion::stencil::Stencil;
use crate::motion::trajectory::Trajectory;
use crate::motion::wear::Wear;
use crate::solver::Solver;
use crate::stall::SolveError;
use std::collections::VecDeque;

/// What a loss asks of one state; an empty list asks nothing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Slope {
    /// ∂L/∂u, 3 a node, unit of L per m.
    pub displacement: Vec<f64>,
    /// ∂L/∂v, 3 a node, unit of L per m/s.
    pub velocity: Vec<f64>,
}

/// What a factor costs, in iterations with it: from the timings of a 40k body.
const FACTOR_COST: f64 = 18.0;

/// How exactly a step is solved back: a tenth of what the step itself was, but no finer than rounding lets one see.
/// A motion's factor serves many steps.
pub(crate) fn demand(march: &March) -> Demand {
    Demand { tolerance: (0.1 * march.tolerance).clamp(1e-10, 1e-6), patience: 40 }
}

/// What later steps ask of a state: ū, v̄ and ρ.
#[derive(Debug, Clone)]
struct Asked {
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    rate: Vec<f64>,
}

impl Asked {
    fn nothing(full: usize) -> Self {
        Self { displacement: vec![0.0; full], velocity: vec![0.0; full], rate: vec![0.0; full] }
    }

    fn take_in(&mut self, slope: &Slope) {
        add(&mut self.displacement, 1.0, &slope.displacement);
        add(&mut self.velocity, 1.0, &slope.velocity);
    }
}

impl Solver {
    /// The gradient of a loss of a recorded motion. `slope` gives what the loss asks of the state after each step
    /// (counted from 1; 0 is the initial one).
    ///
    /// # Errors
    /// [`SolveError`] when a list has the wrong length or a step's tangent is not positive definite.
    pub fn backward(
        &mut self,
        trajectory: &Trajectory,
        slope: &mut dyn FnMut(usize, &State) -> Slope,
    ) -> Result<MotionGradient, SolveError> {
        let full = 3 * self.parts.mesh.nodes.len();
        let mut gradient = self.no_gradient(trajectory);
        let mut asked = VecDeque::from(vec![Asked::nothing(full); 3]);
        let mut wear = Wear::new(FACTOR_COST);
        for number in (0..trajectory.stretches()).rev() {
            let stretch = self.repeat(trajectory, number)?;
            let (first, last) = trajectory.bounds(number);
            for n in (first..=last).rev() {
                let asks = slope(n, stretch.state(n));
                self.check_slope(&asks)?;
                asked[0].take_in(&asks);
                let behind = Behind { n, stretch: &stretch, stencil: trajectory.stencil(n) };
                self.step_back(trajectory, &behind, &mut asked, &mut gradient, &mut wear)?;
                asked.pop_front();
                asked.push_back(Asked::nothing(full));
            }
            if number == 0 {
                let asks = slope(0, stretch.state(0));
                self.check_slope(&asks)?;
                asked[0].take_in(&asks);
                self.arrive(trajectory.march.stiffness_damping, stretch.state(0), &mut asked[0], &mut gradient);
            }
        }
        self.linearised = None;
        let Asked { displacement, velocity, .. } = asked.swap_remove_front(0).expect("three were put in");
        gradient.initial =
            State { displacement: self.with_held_at_rest(&displacement), velocity: self.with_held_at_rest(&velocity) };
        Ok(gradient)
    }

    /// One step back; `asked` holds what is asked of states n, n−1 and n−2.
    fn step_back(
        &mut self,
        trajectory: &Trajectory,
        behind: &Behind,
        asked: &mut VecDeque<Asked>,
        gradient: &mut MotionGradient,
        wear: &mut Wear,
    ) -> Result<(), SolveError> {
        let Stencil { gamma, weights } = &behind.stencil;
        let (alpha, beta) = (trajectory.march.mass_damping, trajectory.march.stiffness_damping);
        let Asked { displacement: mut wanted, velocity, rate } = asked[0].clone();
        add(&mut wanted, *gamma, &velocity);
        let lambda = self.solve_back(trajectory, behind, &wanted, &rate, wear)?;
        let mass_lambda = self.mass_times(&lambda);
        for (weight, past) in weights.iter().zip(asked.iter_mut().skip(1)) {
            add(&mut past.displacement, *weight, &velocity);
            add(&mut past.displacement, -weight * (gamma + alpha), &mass_lambda);
            add(&mut past.velocity, -weight, &mass_lambda);
            add(&mut past.rate, *weight, &lambda);
        }
        let mut on_rate = rate;
        add(&mut on_rate, *gamma, &lambda);
        let mut on_elastic = lambda.clone();
        add(&mut on_elastic, beta, &on_rate);
        self.gather_elastic(&behind.stretch.state(behind.n).displacement, &on_elastic, &on_rate, gradient);
        self.gather_other(trajectory, behind, &lambda, gradient);
        Ok(())
    }

    /// λ of one step, 3 a node.
    fn solve_back(
        &mut self,
        trajectory: &Trajectory,
        behind: &Behind,
        wanted: &[f64],
        rate: &[f64],
        wear: &mut Wear,
    ) -> Result<Vec<f64>, SolveError> {
        let march = &trajectory.march;
        let gamma = behind.stencil.gamma;
        let inertia = Inertia { rate: gamma * gamma + march.mass_damping * gamma, ..Inertia::default() };
        let stiffening = 1.0 + march.stiffness_damping * gamma;
        let Self { parts, given, newton, .. } = self;
        let potential = given.in_motion(parts, trajectory.pressures(behind.n), stiffening, &inertia);
        let u = &behind.stretch.state(behind.n).displacement;
        let (mut b, mut along) = (Vec::new(), Vec::new());
        parts.pattern.gather(wanted, &mut b);
        potential.stiffness(u, &mut newton.values);
        if march.stiffness_damping > 0.0 {
            parts.pattern.gather(rate, &mut along);
            let mut pull = vec![0.0; b.len()];
            parts.pattern.multiply(&newton.values, &along, &mut pull);
            add(&mut b, -march.stiffness_damping / stiffening, &pull);
        }
        newton.complete(&potential, u);
        if wear.renew {
            newton.factorise(&potential, u, &b).map_err(|_| SolveError::NotStable)?;
        }
        let (free, iterations) = newton.solve_exactly(&potential, u, &b, demand(march)).ok_or(SolveError::NotStable)?;
        let mut lambda = vec![0.0; wanted.len()];
        parts.pattern.spread(&free, 1.0, &mut lambda);
        wear.count(iterations, wear.renew);
        Ok(lambda)
    }

    /// What is asked of the initial state through the elastic forces that damp.
    fn arrive(&mut self, beta: f64, initial: &State, asked: &mut Asked, gradient: &mut MotionGradient) {
        let on_elastic: Vec<f64> = asked.rate.iter().map(|rate| beta * rate).collect();
        self.gather_elastic(&initial.displacement, &on_elastic, &asked.rate, gradient);
        if beta > 0.0 {
            let pull = self.elastic_stiffness_times(&initial.displacement, &on_elastic);
            add(&mut asked.displacement, -1.0, &pull);
        }
    }

    fn check_slope(&self, slope: &Slope) -> Result<(), SolveError> {
        for (what, list) in
            [("the slope by displacement", &slope.displacement), ("the slope by velocity", &slope.velocity)]
        {
            if !list.is_empty() {
                self.check_field(what, list)?;
            }
        }
        Ok(())
    }
}
