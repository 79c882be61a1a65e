//! Dynamics: how a body moves under pressures that change in time.
//!
//! M a + α M v + f(u) + β ḟ(u) = pressure + dead forces. The stiffness part of Rayleigh's damping is the rate of the
//! elastic force, β ḟ = β K(u) v with the tangent of the present shape: a rigid turn of a relaxed body is not damped,
//! whereas the tangent at rest would brake a stiff sheet that turns.
//!
//! Both schemes write v = γ u + v̂ and a = γ v + â, and ḟ = γ f + f̂, with v̂, â, f̂ from the past (see `stencil`).
//! A step is then the minimum of a potential (see `potential`) with
//! s = 1 + βγ,  c = γ² + αγ,  û = −(γ v̂ + â + α v̂)/c,  h = β f̂.
//!
//! One factor serves many steps: past steps correct it (`memory`), and it is renewed when that costs less than it saves.
//!
//! Stands on: `solver`, `newton`, `potential`, `stencil`. Never knows: where pressures come from.

use crate::descent::potential::Inertia;
use crate::descent::search::{Found, Gait, Rule, Stall};
use crate::motion::march::{self, March, State};
use crate::motion::stencil::{Stencil, extrapolation};
use crate::motion::wear::Wear;
use crate::solver::Solver;
use crate::stall::SolveError;
use si::{Pascal, Second};
use std::collections::VecDeque;

/// Directions at most in one time step.
const LIMIT: usize = 60;
/// Within a step, a factor is renewed when it promises to need more directions than this.
const PATIENCE: f64 = 10.0;
/// Directions of an old factor before it is judged.
const TRIALS: usize = 3;
/// What a factor costs, in directions, each with its energy: from the timings of a 40k body.
const FACTOR_COST: f64 = 8.0;
/// Past shapes that extrapolate to the first guess of a step.
const PAST: usize = 4;

/// Where a march stands: what the next step needs from the past.
#[derive(Debug, Clone)]
pub(crate) struct Walk {
    /// Newest first.
    pub states: VecDeque<State>,
    /// The time of each, s.
    pub times: VecDeque<Second>,
    /// Elastic forces of the newest two, when they damp.
    forces: VecDeque<Vec<f64>>,
    wear: Wear,
}

impl Walk {
    /// From states (newest first) at their times; the first step will make a factor of its own.
    pub fn new(states: Vec<State>, times: Vec<Second>) -> Self {
        Self { states: states.into(), times: times.into(), forces: VecDeque::new(), wear: Wear::new(FACTOR_COST) }
    }

    /// Forgets all that the states it needs do not hold, so that a walk from them alone takes the same steps.
    pub fn begin_anew(&mut self) {
        let keep = |at: usize| at < 2;
        let states = self.states.iter().enumerate().filter(|(at, _)| keep(*at)).map(|(_, state)| state.clone());
        let times = self.times.iter().copied().take(2);
        *self = Self::new(states.collect(), times.collect());
    }

    /// The stencil of a step to `time`.
    fn stencil(&self, march: &March, time: Second) -> Stencil {
        let before = self.times.get(1).map(|then| self.times[0] - then);
        Stencil::new(march.scheme, time - self.times[0], before)
    }

    fn shapes(&self) -> impl Iterator<Item = &[f64]> {
        self.states.iter().map(|state| state.displacement.as_slice())
    }

    /// The polynomial through the newest `count` shapes, at `time`; from one shape alone, along its velocity.
    pub fn guess(&self, count: usize, time: Second) -> Vec<f64> {
        let count = count.min(self.states.len());
        if count == 1 {
            let State { displacement, velocity } = &self.states[0];
            let step = time - self.times[0];
            return displacement.iter().zip(velocity).map(|(u, v)| u + step * v).collect();
        }
        let times: Vec<Second> = self.times.iter().copied().take(count).collect();
        let mut guess = vec![0.0; self.states[0].displacement.len()];
        for (weight, shape) in extrapolation(&times, time).iter().zip(self.shapes()) {
            guess.iter_mut().zip(shape).for_each(|(guess, u)| *guess += weight * u);
        }
        guess
    }
}

impl Solver {
    /// Moves from `initial` through `steps` time steps; `pressures` gives one pressure a chamber (Pa) at a time (s from
    /// the start), and `observe` sees each new state with its time. Returns the last state.
    ///
    /// # Errors
    /// [`SolveError`] when a list has the wrong length, a setting is out of range, or a step finds no motion.
    pub fn march(
        &mut self,
        march: &March,
        initial: &State,
        pressures: &dyn Fn(Second) -> Vec<Pascal>,
        steps: usize,
        observe: &mut dyn FnMut(Second, &State),
    ) -> Result<State, SolveError> {
        let mut walk = self.set_out(march, initial)?;
        for step in 1..=steps {
            let time = step as f64 * march.step;
            self.step_to(march, &mut walk, time, &pressures(time))?;
            observe(time, &walk.states[0]);
        }
        Ok(walk.states.swap_remove_front(0).expect("a walk holds at least the initial state"))
    }

    /// A walk from `initial` at time 0.
    pub(crate) fn set_out(&mut self, march: &March, initial: &State) -> Result<Walk, SolveError> {
        march::check(march)?;
        self.check_field("the initial displacement", &initial.displacement)?;
        self.check_field("the initial velocity", &initial.velocity)?;
        self.linearised = None;
        let first = State {
            displacement: self.with_held_at_rest(&initial.displacement),
            velocity: self.with_held_at_rest(&initial.velocity),
        };
        Ok(Walk::new(vec![first], vec![0.0]))
    }

    /// One step of a walk; the walk is unchanged when none is found.
    pub(crate) fn step_to(
        &mut self,
        march: &March,
        walk: &mut Walk,
        time: Second,
        pressures: &[Pascal],
    ) -> Result<(), SolveError> {
        self.check_pressures(pressures)?;
        let lost = |walk: &Walk, stall| {
            let reached = walk.times[0];
            SolveError::NoMotion { time: reached, step: time - reached, stall }
        };
        let (state, found) = self.step(march, walk, time, pressures).map_err(|stall| lost(walk, stall))?;
        if march.stiffness_damping > 0.0 {
            walk.forces.push_front(self.elastic_forces(&state.displacement));
            walk.forces.truncate(2);
        }
        walk.wear.count(found.iterations, found.factorisations > 0);
        walk.states.push_front(state);
        walk.states.truncate(PAST);
        walk.times.push_front(time);
        walk.times.truncate(PAST);
        Ok(())
    }

    fn step(
        &mut self,
        march: &March,
        walk: &mut Walk,
        time: Second,
        pressures: &[Pascal],
    ) -> Result<(State, Found), Stall> {
        if march.stiffness_damping > 0.0 && walk.forces.is_empty() {
            walk.forces = walk.shapes().take(2).map(|u| self.elastic_forces(u)).collect();
        }
        let stencil = walk.stencil(march, time);
        let (inertia, stiffening) = self.inertia(march, &stencil, walk);
        let potential = self.given.in_motion(&self.parts, pressures, stiffening, &inertia);
        let tolerance = march.tolerance * self.parts.size;
        let fresh = walk.wear.renew;
        let rule = Rule { tolerance, limit: LIMIT, patience: PATIENCE, trials: TRIALS, fresh, gait: Gait::Careful };
        let mut displacement = walk.guess(PAST, time);
        let found = self.newton.minimise(&potential, &mut displacement, None, &rule).or_else(|_| {
            displacement.clone_from(&walk.states[0].displacement);
            self.newton.minimise(&potential, &mut displacement, None, &Rule { fresh: true, ..rule })
        })?;
        let velocity = stencil.rate(&displacement, walk.shapes());
        Ok((State { displacement, velocity }, found))
    }

    /// c, û and h of one step, and s.
    fn inertia(&self, march: &March, stencil: &Stencil, walk: &Walk) -> (Inertia, f64) {
        let (alpha, beta, gamma) = (march.mass_damping, march.stiffness_damping, stencil.gamma);
        let rate = gamma * gamma + alpha * gamma;
        let v = stencil.history(walk.shapes());
        let a = stencil.history(walk.states.iter().map(|state| state.velocity.as_slice()));
        let centre: Vec<f64> = v.iter().zip(&a).map(|(v, a)| -((gamma + alpha) * v + a) / rate).collect();
        let mut free = Vec::new();
        self.parts.pattern.gather(&centre, &mut free);
        let mut history = Vec::new();
        if beta > 0.0 {
            history = stencil.history(walk.forces.iter().map(Vec::as_slice));
            history.iter_mut().for_each(|force| *force *= beta);
        }
        (Inertia { rate, centre: free, history }, 1.0 + beta * gamma)
    }

    /// f(u), 3 a node, N.
    pub(crate) fn elastic_forces(&self, u: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; u.len()];
        self.parts.body().energy(&self.given.elastic, u, 1.0, &mut forces);
        forces
    }
}
