//! Dynamics: how a body moves under pressures that change in time.
//!
//! M a + α M v + f(u) + β ḟ(u) = pressure + dead forces. The stiffness part of Rayleigh's damping is the rate of the
//! elastic force, β ḟ = β K(u) v with the tangent of the present shape: a rigid turn of a relaxed body is not damped,
//! whereas the tangent at rest would brake a stiff sheet that turns.
//!
//! Both schemes write v = γ u + v̂ and a = γ v + â, and ḟ = γ f + f̂, with v̂, â, f̂ from the past:
//! implicit Euler: γ = 1/h, x̂ = −xₙ/h; BDF2: γ = 3/2h, x̂ = (−4 xₙ + xₙ₋₁)/2h     [hairer1996], section V.1
//! A step is then the minimum of a potential (see `potential`) with
//! s = 1 + βγ,  c = γ² + αγ,  û = −(γ v̂ + â + α v̂)/c,  h = β f̂.
//!
//! One factor serves many steps: past steps correct it (`memory`), and it is renewed when that costs less than it saves.
//!
//! Stands on: `solver`, `newton`, `potential`. Never knows: where pressures come from.

use crate::potential::{Inertia, Potential};
use crate::search::{Found, Gait, Rule, Stall};
use crate::solver::{SolveError, Solver};
use si::{Hertz, Pascal, Second};
use std::collections::VecDeque;

/// How a step is taken from the past.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// First order; damps every motion, the faster the more.
    ImplicitEuler,
    /// Second order; damps only motions that the step cannot resolve. Its first step is one of implicit Euler.
    Bdf2,
}

/// The settings of a march through time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct March {
    /// Time step.
    pub step: Second,
    /// How a step is taken.
    pub scheme: Scheme,
    /// α of Rayleigh's damping, 1/s: slow motions. A mode of angular frequency ω gets the ratio α/2ω + βω/2.
    pub mass_damping: Hertz,
    /// β of Rayleigh's damping, s: fast motions.
    pub stiffness_damping: Second,
}

/// A shape in motion.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// 3 a node, m.
    pub displacement: Vec<f64>,
    /// 3 a node, m/s.
    pub velocity: Vec<f64>,
}

impl State {
    /// `nodes` nodes at rest.
    pub fn rest(nodes: usize) -> Self {
        Self { displacement: vec![0.0; 3 * nodes], velocity: vec![0.0; 3 * nodes] }
    }
}

/// The last correction of a time step moves no node further than this part of the body's size: a tenth of a micrometre
/// on a tail, a hundredth of what a camera resolves.
const TOLERANCE: f64 = 1e-6;
/// Directions at most in one time step.
const LIMIT: usize = 60;
/// Within a step, a factor is renewed when it promises to need more directions than this.
const PATIENCE: f64 = 10.0;
/// Directions of an old factor before it is judged.
const TRIALS: usize = 3;
/// What a factor costs, in directions: from the timings of a 40k body.
const FACTOR_COST: f64 = 8.0;
/// Past shapes that extrapolate to the first guess of a step.
const PAST: usize = 4;

/// What a step needs from the past.
struct Past {
    /// Newest first.
    states: VecDeque<State>,
    /// Elastic forces of the newest two, when they damp.
    forces: VecDeque<Vec<f64>>,
}

/// When the factor of an earlier step has paid for itself.
#[derive(Debug, Default)]
struct Wear {
    steps: f64,
    spent: f64,
    renew: bool,
}

impl Wear {
    /// After a step: renew when this one cost more than the average since the last factor, its own cost counted in.
    fn count(&mut self, found: Found) {
        if found.factorisations > 0 {
            *self = Self { steps: 0.0, spent: FACTOR_COST, renew: false };
        }
        self.steps += 1.0;
        self.spent += found.iterations as f64;
        self.renew = found.iterations as f64 > self.spent / self.steps;
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
        check_march(march)?;
        self.check_field("the initial displacement", &initial.displacement)?;
        self.check_field("the initial velocity", &initial.velocity)?;
        self.linearised = None;
        let first = State {
            displacement: self.with_held_at_rest(&initial.displacement),
            velocity: self.with_held_at_rest(&initial.velocity),
        };
        let mut past = Past { states: VecDeque::from([first]), forces: VecDeque::new() };
        let mut wear = Wear { renew: true, ..Wear::default() };
        for step in 1..=steps {
            let time = step as f64 * march.step;
            let pressures = pressures(time);
            self.check_pressures(&pressures)?;
            let found = self
                .time_step(march, &mut past, &pressures, wear.renew)
                .map_err(|stall| SolveError::NoMotion { time: time - march.step, step: march.step, stall })?;
            wear.count(found);
            observe(time, &past.states[0]);
        }
        Ok(past.states.swap_remove_front(0).expect("the past holds at least the initial state"))
    }

    fn time_step(&mut self, march: &March, past: &mut Past, pressures: &[Pascal], fresh: bool) -> Result<Found, Stall> {
        let damped = march.stiffness_damping > 0.0;
        if damped && past.forces.is_empty() {
            past.forces.push_front(self.elastic_forces(&past.states[0].displacement));
        }
        let back = Backward::new(march, past.states.len());
        let (inertia, stiffening) = self.inertia(march, &back, past);
        let potential = Potential {
            parts: &self.parts,
            elastic: &self.elastic,
            stiffening,
            pressures,
            dead: &self.dead,
            dead_strength: 1.0,
            inertia: Some(&inertia),
        };
        let tolerance = TOLERANCE * self.parts.size;
        let rule = Rule { tolerance, limit: LIMIT, patience: PATIENCE, trials: TRIALS, fresh, gait: Gait::Careful };
        let mut displacement = guess(march, past);
        let found = self.newton.minimise(&potential, &mut displacement, None, &rule).or_else(|_| {
            displacement.clone_from(&past.states[0].displacement);
            self.newton.minimise(&potential, &mut displacement, None, &Rule { fresh: true, ..rule })
        })?;
        let velocity = back.rate(&displacement, past.states.iter().map(|state| state.displacement.as_slice()));
        if damped {
            past.forces.push_front(self.elastic_forces(&displacement));
            past.forces.truncate(2);
        }
        past.states.push_front(State { displacement, velocity });
        past.states.truncate(PAST);
        Ok(found)
    }

    /// c, û and h of one step, and s.
    fn inertia(&self, march: &March, back: &Backward, past: &Past) -> (Inertia, f64) {
        let (alpha, beta, gamma) = (march.mass_damping, march.stiffness_damping, back.gamma);
        let rate = gamma * gamma + alpha * gamma;
        let v = back.history(past.states.iter().map(|state| state.displacement.as_slice()));
        let a = back.history(past.states.iter().map(|state| state.velocity.as_slice()));
        let centre: Vec<f64> = v.iter().zip(&a).map(|(v, a)| -((gamma + alpha) * v + a) / rate).collect();
        let mut free = Vec::new();
        self.parts.pattern.gather(&centre, &mut free);
        let mut history = Vec::new();
        if beta > 0.0 {
            history = back.history(past.forces.iter().map(Vec::as_slice));
            history.iter_mut().for_each(|force| *force *= beta);
        }
        (Inertia { rate, centre: free, history }, 1.0 + beta * gamma)
    }

    fn elastic_forces(&self, u: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; u.len()];
        self.parts.body().energy(&self.elastic, u, 1.0, &mut forces);
        forces
    }
}

/// The rate of a quantity now: γ x + Σ weights · past.
struct Backward {
    gamma: f64,
    weights: Vec<f64>,
}

impl Backward {
    fn new(march: &March, known: usize) -> Self {
        let h = march.step;
        match march.scheme {
            Scheme::Bdf2 if known > 1 => Self { gamma: 1.5 / h, weights: vec![-2.0 / h, 0.5 / h] },
            _ => Self { gamma: 1.0 / h, weights: vec![-1.0 / h] },
        }
    }

    fn history<'a>(&self, past: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
        let mut sum = Vec::new();
        for (weight, values) in self.weights.iter().zip(past) {
            sum.resize(values.len(), 0.0);
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
        }
        sum
    }

    fn rate<'a>(&self, now: &[f64], past: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
        let mut rate = self.history(past);
        rate.iter_mut().zip(now).for_each(|(rate, now)| *rate += self.gamma * now);
        rate
    }
}

/// The polynomial through the past shapes, one step ahead; from one shape alone, along its velocity.
fn guess(march: &March, past: &Past) -> Vec<f64> {
    let states = &past.states;
    let weights: &[f64] = match states.len() {
        1 => return ahead(&states[0], march.step),
        2 => &[2.0, -1.0],
        3 => &[3.0, -3.0, 1.0],
        _ => &[4.0, -6.0, 4.0, -1.0],
    };
    let mut guess = vec![0.0; states[0].displacement.len()];
    for (weight, state) in weights.iter().zip(states) {
        guess.iter_mut().zip(&state.displacement).for_each(|(guess, u)| *guess += weight * u);
    }
    guess
}

fn ahead(state: &State, step: Second) -> Vec<f64> {
    state.displacement.iter().zip(&state.velocity).map(|(u, v)| u + step * v).collect()
}

fn check_march(march: &March) -> Result<(), SolveError> {
    let positive = |what, value: f64| SolveError::Setting { what, value, range: "a finite number, not below 0" };
    if !(march.step > 0.0 && march.step.is_finite()) {
        return Err(SolveError::Setting { what: "the time step", value: march.step, range: "above 0 s" });
    }
    if !(march.mass_damping >= 0.0 && march.mass_damping.is_finite()) {
        return Err(positive("the mass damping", march.mass_damping));
    }
    if !(march.stiffness_damping >= 0.0 && march.stiffness_damping.is_finite()) {
        return Err(positive("the stiffness damping", march.stiffness_damping));
    }
    Ok(())
}
